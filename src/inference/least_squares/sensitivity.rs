//! Computes where the minimum of a fit goes when its problem changes a little, without fitting again.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};
use rayon::prelude::*;

use super::problem::ResidualProblem;
use super::Fit;

/// Share of a parameter, or of its standard error where that is larger, over which the slope of the sum of squares is
/// differenced: the curves this is for turn within 1e-4 of their values, and slopes are known to 1e-16 of theirs.
const APART: f64 = 1e-7;

/// The minimum of a fit, and how the sum of squares curves there.
///
/// Where the slope g(b, c) of the sum of squares in the parameters b vanishes for every value of a constant c, db/dc is
/// −(∂g/∂b)⁻¹ ∂g/∂c. Both are central differences of g, so that nothing is derived by hand.
pub struct Minimum {
    parameters: DVector<f64>,
    /// standard errors of the parameters, the units of the curvature
    units: DVector<f64>,
    curvature: Cholesky<f64, Dyn>,
}

impl Minimum {
    /// `None` where the fit has no standard errors, or the sum of squares has no proper minimum there.
    pub fn new<P: ResidualProblem + Sync>(problem: &P, fit: &Fit) -> Option<Minimum> {
        let covariance = fit.covariance.as_ref().filter(|_| fit.converged())?;
        let units = covariance.diagonal().map(f64::sqrt);
        let parameters = DVector::from_column_slice(&fit.parameters);
        let p = parameters.len();
        let column = |j: usize| -> Option<DVector<f64>> {
            let apart = APART * parameters[j].abs().max(units[j]);
            let at = |step: f64| {
                let mut there = parameters.clone();
                there[j] += step;
                slope(problem, &there)
            };
            Some((at(apart)? - at(-apart)?).component_mul(&units) * (0.5 * units[j] / apart))
        };
        let columns: Option<Vec<DVector<f64>>> = (0..p).into_par_iter().map(column).collect();
        let curvature = DMatrix::from_columns(&columns?);
        let curvature = Cholesky::new((&curvature + curvature.transpose()) * 0.5)?;
        Some(Minimum {
            parameters,
            units,
            curvature,
        })
    }

    /// The minima of two problems that lie as far on either side of the fitted one; `None` where the model is undefined.
    pub fn of_neighbours<P: ResidualProblem>(&self, less: &P, more: &P) -> Option<[Vec<f64>; 2]> {
        let lean = slope(more, &self.parameters)? - slope(less, &self.parameters)?;
        let there = self.curvature.solve(&lean.component_mul(&self.units));
        let half = there.component_mul(&self.units) * 0.5;
        let minima = [&self.parameters + &half, &self.parameters - half];
        Some(minima.map(|minimum| minimum.as_slice().to_vec()))
    }
}

/// Slope of half the sum of squares in the parameters.
fn slope<P: ResidualProblem>(problem: &P, parameters: &DVector<f64>) -> Option<DVector<f64>> {
    let (n, p) = (problem.runs(), problem.parameters());
    let mut residuals = DVector::zeros(n);
    problem
        .residuals(parameters.as_slice(), residuals.as_mut_slice())
        .ok()?;
    let mut jacobian = DMatrix::zeros(n, p);
    problem.jacobian(parameters.as_slice(), &mut jacobian).ok()?;
    let slope = jacobian.tr_mul(&residuals);
    slope.iter().all(|x| x.is_finite()).then_some(slope)
}
