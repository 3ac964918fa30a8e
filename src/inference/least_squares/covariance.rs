//! Judges whether an end point may carry standard errors, and computes them from R.

use nalgebra::DMatrix;

use super::linearised::Linearised;
use super::Stop;

/// Residuals below this many rounding errors of the model's values are not scatter. The
/// hardest certified problem (Lanczos1) scatters by 400.
const SCATTER_ROUNDINGS: f64 = 64.0;

/// What can be said about the uncertainty of a fit.
pub(super) struct Uncertainty {
    pub(super) stop: Stop,
    pub(super) condition: f64,
    pub(super) residual_sd: Option<f64>,
    pub(super) covariance: Option<DMatrix<f64>>,
    pub(super) why_none: Option<String>,
}

/// Judges the `end` of an attempt that stopped for the reason `stop`.
pub(super) fn judge(end: &Linearised, runs: usize, stop: Stop) -> Uncertainty {
    let p = end.parameters.len();
    let condition = condition(end);
    let freedom = runs.saturating_sub(p);
    let residual_sd = (freedom > 0).then(|| (end.residual_sum_of_squares / freedom as f64).sqrt());
    let mut answer = Uncertainty {
        stop,
        condition,
        residual_sd,
        covariance: None,
        why_none: None,
    };

    if let Some(j) = end.lengths.iter().position(|&length| length == 0.0) {
        answer.stop = Stop::Degenerate;
        answer.why_none = Some(format!(
            "the fitted curve does not change with parameter {} of {p} at any of the runs",
            j + 1
        ));
    } else if condition >= largest_condition(runs) {
        answer.stop = Stop::Degenerate;
        answer.why_none = Some(
            "the runs cannot tell the parameters apart: a change of one is undone by another \
             (are all runs at one speed?)"
                .to_owned(),
        );
    } else if stop != Stop::Converged {
        answer.why_none = Some(
            match stop {
                Stop::OutOfDomain => "the fit ran into values for which the law is undefined",
                _ => "the fit did not settle on a minimum",
            }
            .to_owned(),
        );
    } else {
        match residual_sd {
            None => {
                answer.why_none = Some(format!(
                    "as many parameters as runs ({p}): no run is left to show the scatter"
                ));
            }
            Some(sd) if sd <= SCATTER_ROUNDINGS * f64::EPSILON * end.scale => {
                answer.why_none = Some("the runs show no scatter: the curve meets them to rounding error".to_owned());
            }
            Some(sd) => {
                answer.covariance = from_triangle(end, sd);
                if answer.covariance.is_none() {
                    answer.why_none = Some("the standard errors are too large or small to compute".to_owned());
                }
            }
        }
    }
    answer
}

/// Largest over smallest singular value of the slopes in columns of unit length.
fn condition(end: &Linearised) -> f64 {
    let Some(values) = end.singular_values() else {
        return f64::INFINITY;
    };
    let smallest = values.min();
    if smallest > 0.0 {
        values.max() / smallest
    } else {
        f64::INFINITY
    }
}

/// From here on the smallest singular value is rounding error of the largest.
fn largest_condition(runs: usize) -> f64 {
    1.0 / (f64::EPSILON * runs.max(100) as f64)
}

/// sd² (JᵀJ)⁻¹ = (sd D⁻¹R⁻¹)(sd D⁻¹R⁻¹)ᵀ; `None` if it over- or underflows.
fn from_triangle(end: &Linearised, sd: f64) -> Option<DMatrix<f64>> {
    let p = end.parameters.len();
    let mut root = end.triangle.solve_upper_triangular(&DMatrix::identity(p, p))?;
    for (mut row, length) in root.row_iter_mut().zip(end.lengths.iter()) {
        row *= sd / length;
    }
    let covariance = &root * root.transpose();
    let usable = covariance.iter().all(|c| c.is_finite()) && covariance.diagonal().iter().all(|&c| c > 0.0);
    usable.then_some(covariance)
}
