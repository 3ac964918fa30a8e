//! Fits a curve to runs by least squares, with the covariance of its parameters and the reason why it stopped.
//!
//! A problem brings its residuals and their slopes ([`ResidualProblem`]); [`fit`] runs
//! Levenberg–Marquardt on it and returns a [`Fit`]. A poor fit is a value with a reason, not an
//! error: read [`Fit::stop`] first. Standard errors exist only where the fit converged on a
//! minimum that the runs determine and scatter about; otherwise they are `None` and
//! [`Fit::why_no_covariance`] gives the reason.
//!
//! | file | job |
//! |---|---|
//! | `problem.rs` | what is fitted, and why a fit may stop |
//! | `linearised.rs` | residuals and Jacobian at one point, as a triangle |
//! | `levenberg_marquardt.rs` | the steps from point to point |
//! | `solver.rs` | one attempt, driven by argmin |
//! | `covariance.rs` | whether an end point has standard errors, and which |
//!
//! Sources: Moré (1978) for the scaling, Nielsen (1999) for the damping, Transtrum and Sethna
//! (2012) for the acceleration, Bates and Watts (1981) for the test of convergence.

mod covariance;
mod levenberg_marquardt;
mod linearised;
mod problem;
mod solver;
#[cfg(test)]
mod tests;

use nalgebra::DMatrix;

use covariance::fit_of;
pub use covariance::no_scatter_left;
use levenberg_marquardt::Variant;
pub use problem::{OutOfDomain, ResidualProblem, Stop};
use solver::attempt;

/// The end of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The parameters where the fit ended; the start, if it could not begin.
    pub parameters: Vec<f64>,
    /// Σ residual² there; infinite if the model is undefined at the start.
    pub residual_sum_of_squares: f64,
    /// Standard deviation of the residuals, √(sum of squares / degrees of freedom); `None`
    /// without degrees of freedom or sum of squares.
    pub residual_sd: Option<f64>,
    /// Runs less parameters; 0 where there are fewer runs than parameters.
    pub degrees_of_freedom: usize,
    /// Covariance of the parameters, p × p: residual_sd² (JᵀJ)⁻¹, computed without forming JᵀJ.
    pub covariance: Option<DMatrix<f64>>,
    /// Why the fit stopped.
    pub stop: Stop,
    /// Condition number of the slopes in columns of unit length; infinite if singular.
    pub condition: f64,
    /// How often residuals or slopes were computed, over all attempts.
    pub evaluations: usize,
    /// Why there is no covariance; `None` exactly where there is one.
    pub why_no_covariance: Option<String>,
}

impl Fit {
    /// Standard error of parameter `j`; `None` without a covariance or such a parameter.
    pub fn se(&self, j: usize) -> Option<f64> {
        let covariance = self.covariance.as_ref()?;
        covariance.get((j, j)).map(|variance| variance.sqrt())
    }

    /// Correlation of parameters `i` and `j`; `None` as for [`Fit::se`].
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let covariance = self.covariance.as_ref()?.get((i, j))?;
        Some(covariance / (self.se(i)? * self.se(j)?))
    }

    /// Whether the fit ended at a minimum.
    pub fn converged(&self) -> bool {
        self.stop == Stop::Converged
    }

    /// The same fit where those it was made to stand for so many runs, and were weighed by how many each: these tell what scatters.
    pub fn of_runs(self, runs: f64) -> Fit {
        let freedom = (runs.round() as usize).saturating_sub(self.parameters.len());
        let Some(was) = self.residual_sd.filter(|was| *was > 0.0 && freedom > 0) else {
            return self;
        };
        let sd = (self.residual_sum_of_squares / freedom as f64).sqrt();
        Fit {
            covariance: self.covariance.map(|covariance| covariance * (sd / was).powi(2)),
            residual_sd: Some(sd),
            degrees_of_freedom: freedom,
            ..self
        }
    }

    /// A fit that could not begin, since there are fewer runs than parameters they alone determine.
    pub fn without_enough_runs(start: &[f64], runs: usize, parameters: usize) -> Fit {
        let why = format!(
            "{} cannot determine {}",
            counted(runs, "run"),
            counted(parameters, "parameter")
        );
        Fit::not_begun(start, Stop::Degenerate, why)
    }

    fn not_begun(start: &[f64], stop: Stop, why: String) -> Fit {
        Fit {
            parameters: start.to_vec(),
            residual_sum_of_squares: f64::INFINITY,
            residual_sd: None,
            degrees_of_freedom: 0,
            covariance: None,
            stop,
            condition: f64::INFINITY,
            evaluations: 0,
            why_no_covariance: Some(why),
        }
    }
}

/// Fits `problem` from `start`, always in a bounded number of evaluations.
///
/// An attempt that does not converge is followed by one that keeps clear of the edge of the
/// domain, if that was met, and by one that scales the parameters differently. The first to converge
/// is returned; if none does, the one with the lowest sum of squares.
pub fn fit<P: ResidualProblem>(problem: &P, start: &[f64]) -> Fit {
    let (n, p) = (problem.runs(), problem.parameters());
    if p == 0 || start.len() != p {
        let (given, wanted) = (counted(start.len(), "start value"), counted(p, "parameter"));
        return Fit::not_begun(start, Stop::Degenerate, format!("{given} given for {wanted}"));
    }
    if n < p {
        // even where nothing can be fitted, how well the start does is known
        let mut residuals = vec![0.0; n];
        let inside = problem.residuals(start, &mut residuals).is_ok();
        let squares = residuals.iter().map(|r| r * r).sum();
        let known = Some(squares).filter(|squares: &f64| inside && squares.is_finite());
        return Fit {
            residual_sum_of_squares: known.unwrap_or(f64::INFINITY),
            evaluations: 1,
            ..Fit::without_enough_runs(start, n, p)
        };
    }
    let mut best: Option<Fit> = None;
    let mut evaluations = 0;
    let mut met_edge = false;
    for variant in [Variant::LargestScale, Variant::ShortenedSteps, Variant::CurrentScale] {
        if variant == Variant::ShortenedSteps && !met_edge {
            continue;
        }
        let Some(attempt) = attempt(problem, start, variant) else {
            break;
        };
        evaluations += attempt.model.evaluations;
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
    let Some(best) = best else {
        let why = "the law is undefined at the starting values".to_owned();
        return Fit {
            degrees_of_freedom: n - p,
            ..Fit::not_begun(start, Stop::OutOfDomain, why)
        };
    };
    Fit { evaluations, ..best }
}

fn counted(count: usize, one: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        _ => format!("{count} {one}s"),
    }
}
