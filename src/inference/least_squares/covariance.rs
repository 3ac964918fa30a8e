//! Judges whether an end point may carry standard errors, and computes them from R.

use nalgebra::{DMatrix, DVector};

use super::fit_end::{no_scatter_left, Fit};
use super::levenberg_marquardt::LevenbergMarquardt;
use super::linearised::Linearised;
use super::problem::{ResidualProblem, Stop};

/// Residuals below this many rounding errors of the model's values are not scatter. The
/// hardest certified problem (Lanczos1) scatters by 400.
const SCATTER_ROUNDINGS: f64 = 64.0;

/// The fit an attempt ended in; `None` if it could not begin. `met_edge` is whether this attempt or one before it has led
/// out of the domain.
pub(super) fn fit_of<P: ResidualProblem>(attempt: LevenbergMarquardt<P>, met_edge: bool) -> Option<Fit> {
    let LevenbergMarquardt {
        current,
        mut model,
        mut residuals,
        stop,
        ..
    } = attempt;
    let (end, runs) = (current?, residuals.len());
    let freedom = runs - end.parameters.len();
    let residual_sd = (freedom > 0).then(|| (end.residual_sum_of_squares / freedom as f64).sqrt());
    let condition = condition(&end);
    // an end on the edge is only reached by trying to cross it
    let inside = |b: &DVector<f64>| !met_edge || model.residuals(b, &mut residuals).is_some();
    let stop = stop.unwrap_or(Stop::MaxIterations);
    let found = if condition >= largest_condition(runs) {
        Err((Stop::Degenerate, why_singular(&end)))
    } else {
        error_directions(&end, stop, residual_sd, inside)
    };
    let (stop, covariance) = match found {
        Ok(directions) => (stop, Ok(&directions * directions.transpose())),
        Err((stop, why)) => (stop, Err(why)),
    };
    Some(Fit {
        parameters: end.parameters.as_slice().to_vec(),
        residual_sum_of_squares: end.residual_sum_of_squares,
        residual_sd,
        degrees_of_freedom: freedom,
        covariance,
        stop,
        condition,
    })
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

fn why_singular(end: &Linearised) -> String {
    match end.lengths.iter().position(|&length| length == 0.0) {
        Some(j) => format!(
            "the fitted curve does not change with parameter {} of {} at any of the runs",
            j + 1,
            end.lengths.len()
        ),
        None => "the runs cannot tell the parameters apart: a change of one is undone by another \
                 (are all runs at one speed?)"
            .to_owned(),
    }
}

/// C = sd D⁻¹R⁻¹, so that sd² (JᵀJ)⁻¹ = C Cᵀ; or why an attempt stopped after all, and why it has no standard errors.
fn error_directions(
    end: &Linearised,
    stop: Stop,
    residual_sd: Option<f64>,
    inside: impl FnMut(&DVector<f64>) -> bool,
) -> Result<DMatrix<f64>, (Stop, String)> {
    let none = |stop: Stop, why: &str| Err((stop, why.to_owned()));
    match stop {
        Stop::Converged => {}
        Stop::OutOfDomain => {
            return none(
                stop,
                "the fit is held at the edge of the values for which the law is defined",
            )
        }
        _ => return none(stop, "the fit did not settle on a minimum"),
    }
    let Some(sd) = residual_sd else {
        return Err((stop, no_scatter_left(end.parameters.len())));
    };
    if sd <= SCATTER_ROUNDINGS * f64::EPSILON * end.scale {
        return none(stop, "the runs show no scatter: the curve meets them to rounding error");
    }
    let directions = end.axes().map(|axes| axes * sd);
    match directions.filter(|of| of.row_iter().all(|row| row.norm_squared().is_normal())) {
        None => none(stop, "the standard errors are too large or small to compute"),
        Some(directions) if on_edge(end, &directions, inside) => none(
            Stop::OutOfDomain,
            "the best fit lies on the edge of the values for which the law is defined",
        ),
        Some(directions) => Ok(directions),
    }
}

/// Whether a hundredth of a standard error leads out of the domain. On the edge of a square root
/// the slopes are so steep that the test of convergence is met there, minimum or not.
fn on_edge(end: &Linearised, directions: &DMatrix<f64>, mut inside: impl FnMut(&DVector<f64>) -> bool) -> bool {
    directions.column_iter().any(|direction| {
        [0.01, -0.01]
            .iter()
            .any(|part| !inside(&(&end.parameters + direction * *part)))
    })
}
