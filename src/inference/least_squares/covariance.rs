//! Judges whether an end point may carry standard errors, and computes them from R.

use nalgebra::{DMatrix, DVector};

use super::linearised::Linearised;
use super::problem::Stop;

/// Residuals below this many rounding errors of the model's values are not scatter. The
/// hardest certified problem (Lanczos1) scatters by 400.
const SCATTER_ROUNDINGS: f64 = 64.0;

/// The uncertainty of a fit, or why there is none.
pub(super) struct Uncertainty {
    pub(super) stop: Stop,
    pub(super) condition: f64,
    pub(super) residual_sd: Option<f64>,
    pub(super) covariance: Option<DMatrix<f64>>,
    pub(super) why_none: Option<String>,
}

/// The uncertainty at the `end` of an attempt that stopped for the reason `stop`; `inside` is whether
/// the model is defined at a point.
pub(super) fn uncertainty(
    end: &Linearised,
    runs: usize,
    stop: Stop,
    inside: impl Fn(&DVector<f64>) -> bool,
) -> Uncertainty {
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
                Stop::OutOfDomain => "the fit is held at the edge of the values for which the law is defined",
                _ => "the fit did not settle on a minimum",
            }
            .to_owned(),
        );
    } else {
        match residual_sd {
            None => {
                answer.why_none = Some(no_scatter_left(p));
            }
            Some(sd) if sd <= SCATTER_ROUNDINGS * f64::EPSILON * end.scale => {
                answer.why_none = Some("the runs show no scatter: the curve meets them to rounding error".to_owned());
            }
            Some(sd) => match error_directions(end, sd) {
                None => {
                    answer.why_none = Some("the standard errors are too large or small to compute".to_owned());
                }
                Some(directions) if on_edge(end, &directions, inside) => {
                    answer.stop = Stop::OutOfDomain;
                    answer.why_none =
                        Some("the best fit lies on the edge of the values for which the law is defined".to_owned());
                }
                Some(directions) => answer.covariance = Some(&directions * directions.transpose()),
            },
        }
    }
    answer
}

/// Largest over smallest singular value of the slopes in columns of unit length.
fn condition(end: &Linearised) -> f64 {
    match end.extreme_singular_values() {
        Some([largest, smallest]) if smallest > 0.0 => largest / smallest,
        _ => f64::INFINITY,
    }
}

/// From here on the smallest singular value is rounding error of the largest.
fn largest_condition(runs: usize) -> f64 {
    1.0 / (f64::EPSILON * runs.max(100) as f64)
}

/// Whether a hundredth of a standard error leads out of the domain. On the edge of a square root
/// the slopes are so steep that the test of convergence is met there, minimum or not.
fn on_edge(end: &Linearised, directions: &DMatrix<f64>, inside: impl Fn(&DVector<f64>) -> bool) -> bool {
    directions.column_iter().any(|direction| {
        [0.01, -0.01]
            .iter()
            .any(|part| !inside(&(&end.parameters + direction * *part)))
    })
}

/// C = sd D⁻¹R⁻¹, so that sd² (JᵀJ)⁻¹ = C Cᵀ; `None` if that over- or underflows.
fn error_directions(end: &Linearised, sd: f64) -> Option<DMatrix<f64>> {
    let directions = end.axes()? * sd;
    let usable = directions.row_iter().all(|row| row.norm_squared().is_normal());
    usable.then_some(directions)
}

/// Why so many parameters of as many runs have no standard errors.
pub fn no_scatter_left(parameters: usize) -> String {
    format!("as many parameters as runs ({parameters}): no run is left to show the scatter")
}
