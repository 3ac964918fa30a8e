//! The polynomial nearest to values at weighted points, where few of them have the moments of all.

use nalgebra::{DMatrix, DVector};

use super::polynomials::Polynomials;
use super::recombination::Kept;

/// The polynomial nearest to values.
pub(crate) struct Nearest {
    coefficients: DVector<f64>,
}

impl Nearest {
    /// Of values at all points with their weights; `kept` have the moments of these up to twice the degree. `None` where a
    /// value is none.
    pub fn new(polynomials: &Polynomials, kept: &[Kept], weights: &[f64], values: &[f64]) -> Option<Nearest> {
        /// directions in which the polynomials hardly differ on the points
        const NOTHING: f64 = 1e-12;
        let functions = polynomials.len();
        let mut products = DMatrix::zeros(functions, functions);
        for (point, weight) in kept {
            let row = DVector::from_vec(polynomials.at(*point));
            products.ger(*weight, &row, &row, 1.0);
        }
        let mut cross = DVector::zeros(functions);
        for (point, (value, weight)) in values.iter().zip(weights).enumerate() {
            let weighted = weight * value;
            let sums = cross.iter_mut().zip(polynomials.at(point));
            sums.for_each(|(sum, of_point)| *sum += weighted * of_point);
        }
        let eigen = products.symmetric_eigen();
        let told = NOTHING * eigen.eigenvalues.max();
        let over = eigen.eigenvalues.map(|own| if own > told { 1.0 / own } else { 0.0 });
        let coefficients = &eigen.eigenvectors * eigen.eigenvectors.tr_mul(&cross).component_mul(&over);
        let is_finite = coefficients.iter().all(|c| c.is_finite());
        is_finite.then_some(Nearest { coefficients })
    }

    /// Its values at some points.
    pub fn at<'p>(
        &'p self,
        polynomials: &'p Polynomials,
        points: impl Iterator<Item = usize> + 'p,
    ) -> impl Iterator<Item = f64> + 'p {
        points.map(move |point| {
            let each = self.coefficients.iter().zip(polynomials.at(point));
            each.map(|(c, of_point)| c * of_point).sum()
        })
    }
}
