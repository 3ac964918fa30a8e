//! Fits a curve to runs by least squares, with the covariance of its parameters and the reason why it stopped.
//!
//! A problem brings its residuals and their slopes ([`ResidualProblem`]); [`fit`] runs
//! Levenberg–Marquardt on it and returns a [`Fit`]. A poor fit is a value with a reason, not an
//! error: read [`Fit::stop`] first. Standard errors exist only where the fit converged on a
//! minimum that the runs determine and scatter about; otherwise they are `None` and
//! [`Fit::covariance`] gives the reason.
//!
//! | file | job |
//! |---|---|
//! | `problem.rs` | what is fitted, and why a fit may stop |
//! | `linearised.rs` | residuals and Jacobian at one point, as a triangle |
//! | `levenberg_marquardt.rs` | the steps from point to point |
//! | `solver.rs` | one attempt, driven by argmin |
//! | `fit_end.rs` | the end of a fit |
//! | `covariance.rs` | whether an end point has standard errors, and which |
//!
//! Sources: Moré (1978) for the scaling, Nielsen (1999) for the damping, Transtrum and Sethna
//! (2012) for the acceleration, Bates and Watts (1981) for the test of convergence.

mod covariance;
mod fit_end;
mod levenberg_marquardt;
mod linearised;
mod problem;
mod solver;
#[cfg(test)]
mod tests;

use nalgebra::DVector;

use covariance::fit_of;
pub use fit_end::{no_scatter_left, Fit};
use levenberg_marquardt::{Model, Variant};
pub use problem::{OutOfDomain, ResidualProblem, Stop};
use solver::attempt;

use crate::rounding::counted;

/// Fits `problem` from `start`, always in a bounded number of evaluations.
///
/// An attempt that does not converge is followed by one that keeps clear of the edge of the
/// domain, if that was met, and by one that scales the parameters differently. The first to converge
/// is returned; if none does, the one with the lowest sum of squares.
pub fn fit<P: ResidualProblem>(problem: &P, start: &[f64]) -> Fit {
    fit_weighted(problem, &[], start)
}

/// The same with each residual times the root of its weight; without roots all weigh the same.
pub fn fit_weighted<P: ResidualProblem>(problem: &P, roots: &[f64], start: &[f64]) -> Fit {
    let (n, p) = (problem.runs(), problem.parameters());
    if p == 0 || start.len() != p {
        let (given, wanted) = (counted(start.len(), "start value"), counted(p, "parameter"));
        return Fit::not_begun(start, Stop::Degenerate, format!("{given} given for {wanted}"));
    }
    if n < p {
        // even where nothing can be fitted, how well the start does is known
        let mut model = Model::new(problem, roots);
        let squares = model.residuals(&DVector::from_column_slice(start), &mut DVector::zeros(n));
        return Fit {
            residual_sum_of_squares: squares.unwrap_or(f64::INFINITY),
            ..Fit::without_enough_runs(start, n, p)
        };
    }
    let mut best: Option<Fit> = None;
    let mut met_edge = false;
    for variant in [Variant::LargestScale, Variant::ShortenedSteps, Variant::CurrentScale] {
        if variant == Variant::ShortenedSteps && !met_edge {
            continue;
        }
        let Some(attempt) = attempt(Model::new(problem, roots), start, variant) else {
            break;
        };
        met_edge |= attempt.model.met_edge;
        let Some(other) = fit_of(attempt, met_edge) else {
            break;
        };
        let is_better = |best: &Fit| other.converged() || other.residual_sum_of_squares < best.residual_sum_of_squares;
        if best.as_ref().is_none_or(is_better) {
            best = Some(other);
        }
        if best.as_ref().is_some_and(Fit::converged) {
            break;
        }
    }
    best.unwrap_or_else(|| Fit {
        degrees_of_freedom: n - p,
        ..Fit::not_begun(
            start,
            Stop::OutOfDomain,
            "the law is undefined at the starting values".to_owned(),
        )
    })
}
