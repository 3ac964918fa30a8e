//! Finds the mode of a log density and the normal distribution that has its curvature there.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::descent::descend;
use super::information::axes;
use super::sums::Sums;
use crate::model::likelihood::OutsideDomain;
use crate::model::posterior::LogDensity;

/// The normal distribution with the mode and the curvature of a log density.
#[derive(Debug, Clone, PartialEq)]
pub struct Laplace {
    /// the mode
    pub mode: Vec<f64>,
    /// log density there
    pub ln_density: f64,
    /// S with covariance S Sᵀ: a standard normal z becomes mode + S z
    pub scale: DMatrix<f64>,
    /// whether the slopes vanish there, to a millionth of a standard deviation
    pub converged: bool,
    /// whether the log density falls in every direction; if not, S is the best that can be had
    pub peaked: bool,
}

impl Laplace {
    /// Whether the search ended at a peak, about which a normal may be laid.
    pub fn is_at_peak(&self) -> bool {
        self.converged && self.peaked
    }

    /// The point at a standard normal z.
    pub fn point(&self, z: &[f64], point: &mut [f64]) {
        point.fill(0.0);
        for (column, z) in self.columns().zip(z) {
            for (x, s) in point.iter_mut().zip(column) {
                *x += s * z;
            }
        }
        for (x, mode) in point.iter_mut().zip(&self.mode) {
            *x += mode;
        }
    }

    /// Slopes in z, from those in the point.
    pub fn slopes(&self, of_point: &[f64], slopes: &mut [f64]) {
        for (slope, column) in slopes.iter_mut().zip(self.columns()) {
            *slope = column.iter().zip(of_point).map(|(s, g)| s * g).sum();
        }
    }

    /// The columns of S, as they lie in memory: a step of a sampler takes hardly longer than reading them.
    fn columns(&self) -> std::slice::ChunksExact<'_, f64> {
        self.scale.as_slice().chunks_exact(self.mode.len().max(1))
    }
}

/// Steps from a start uphill to the mode by damped Newton steps, with the curvature by differences of the slopes.
///
/// Fails where the start has no density.
pub fn laplace<T: LogDensity + ?Sized>(target: &T, start: &[f64]) -> Result<Laplace, OutsideDomain> {
    /// twice the gain of the log density that a step must promise, or the mode is found
    const GAIN: f64 = 2e-12;
    /// the same where no step however short goes up: rounding has the last word
    const ROUNDING: f64 = 2e-6;
    let mut slopes = vec![0.0; start.len()];
    let mut widths = vec![1e-3; start.len()];
    let mut least = f64::INFINITY;
    let end = descend(start, GAIN, |point| {
        let squares = -2.0 * target.ln_density(point, &mut slopes).ok()?;
        // where it is not gone to it needs no curvature, which takes two slopes for every dimension
        let is_lower = squares < least;
        let information = is_lower.then(|| curvature(target, point, &widths).ok()).flatten()?;
        least = squares;
        for (width, strength) in widths.iter_mut().zip(&information.diagonal()) {
            // a hundredth of a standard deviation: the third derivative does not show, nor does rounding
            *width = 0.01 / strength.abs().sqrt().clamp(1e-2, 1e8);
        }
        Some(Sums {
            squares,
            gradient: -DVector::from_column_slice(&slopes),
            information,
            ..Sums::new(0)
        })
    });
    let end = end.ok_or(OutsideDomain)?;
    let (scale, peaked) = scale(&end.sums.information);
    Ok(Laplace {
        ln_density: -0.5 * end.sums.squares,
        converged: end.converged || end.promised < ROUNDING,
        mode: end.point,
        scale,
        peaked,
    })
}

/// −d²/du² of the log density, symmetric.
fn curvature<T: LogDensity + ?Sized>(target: &T, point: &[f64], widths: &[f64]) -> Result<DMatrix<f64>, OutsideDomain> {
    let dimension = point.len();
    let column = |j: usize| {
        let mut shifted = point.to_vec();
        let (mut above, mut below) = (vec![0.0; dimension], vec![0.0; dimension]);
        let mut width = widths[j];
        // near an edge of the domain the difference is taken closer in
        loop {
            shifted[j] = point[j] + width;
            let up = target.ln_density(&shifted, &mut above);
            shifted[j] = point[j] - width;
            let down = target.ln_density(&shifted, &mut below);
            if up.is_ok() && down.is_ok() {
                break;
            }
            width *= 0.1;
            if width < 1e-12 {
                return Err(OutsideDomain);
            }
        }
        let ends = below.iter().zip(&above);
        Ok(ends.map(|(below, above)| (below - above) / (2.0 * width)).collect())
    };
    let columns: Result<Vec<Vec<f64>>, OutsideDomain> = (0..dimension).into_par_iter().map(column).collect();
    let rows = DMatrix::from_vec(dimension, dimension, columns?.concat());
    Ok(0.5 * (&rows + rows.transpose()))
}

/// S with S Sᵀ the inverse of the curvature, and whether the curvature is positive in every direction.
fn scale(curvature: &DMatrix<f64>) -> (DMatrix<f64>, bool) {
    if let Some(factor) = curvature.clone().cholesky() {
        if let Some(inverse) = factor.l().try_inverse() {
            return (inverse.transpose(), true);
        }
    }
    /// A direction in which the density does not fall is given this spread.
    const WIDE: f64 = 1.0;
    // with a slope that overflowed no rotation would be the last
    let finite = curvature.iter().all(|strength| strength.is_finite());
    let Some(eigen) = finite.then(|| axes(curvature.clone())).flatten() else {
        return (DMatrix::identity(curvature.nrows(), curvature.ncols()), false);
    };
    let mut scale = eigen.eigenvectors;
    for (mut column, strength) in scale.column_iter_mut().zip(eigen.eigenvalues.iter()) {
        let spread = if *strength > 1e-6 { 1.0 / strength.sqrt() } else { WIDE };
        column *= spread;
    }
    (scale, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::nuts::tests::Target;

    /// A normal with covariance [[4, 1.9], [1.9, 1]] about (3, −1), in a domain that ends at x = −20.
    #[test]
    fn a_normal_is_found_as_it_is_and_a_start_outside_is_told() {
        let normal = Target(2, |point: &[f64], slopes: &mut [f64]| {
            if point[0] < -20.0 {
                return Err(OutsideDomain);
            }
            let (x, y) = (point[0] - 3.0, point[1] + 1.0);
            let determinant = 4.0 - 1.9 * 1.9;
            slopes[0] = -(x - 1.9 * y) / determinant;
            slopes[1] = -(4.0 * y - 1.9 * x) / determinant;
            Ok(0.5 * (x * slopes[0] + y * slopes[1]))
        });
        let found = laplace(&normal, &[-15.0, 8.0]).expect("the start is inside");
        assert!(found.converged && found.peaked);
        assert!((found.mode[0] - 3.0).abs() < 1e-5 && (found.mode[1] + 1.0).abs() < 1e-5);
        let covariance = &found.scale * found.scale.transpose();
        let expected = DMatrix::from_row_slice(2, 2, &[4.0, 1.9, 1.9, 1.0]);
        assert!((covariance - expected).amax() < 1e-5);
        assert_eq!(laplace(&normal, &[-30.0, 0.0]), Err(OutsideDomain));
    }

    /// ln p = −y²/2 says nothing of x.
    #[test]
    fn a_ridge_is_no_peak() {
        let ridge = Target(2, |point: &[f64], slopes: &mut [f64]| {
            slopes.copy_from_slice(&[0.0, -point[1]]);
            Ok(-0.5 * point[1] * point[1])
        });
        let found = laplace(&ridge, &[1.0, 2.0]).expect("the start is inside");
        assert!(!found.peaked && found.scale.iter().all(|s| s.is_finite()));
    }
}
