//! Judges a fit: whether its numbers may be quoted, and why not.

use super::Verdict;
use crate::inference::delta::Uncertain;
use crate::inference::least_squares::{Fit, Stop};
use crate::inference::nested::Spread;

pub(super) const ALPHA_NOT_POSITIVE: &str = "α is not positive: the runs do not reach e_inf";
pub(super) const BETA_NOT_NEGATIVE: &str = "β is not negative: the restitution does not fall towards low speeds";

/// A fall of e² this small beside α, over all of the runs' x, is rounding.
const NO_FALL: f64 = 1e-12;

/// Whether the fitted restitution falls towards low speeds; x of each run, in whatever unit β takes it.
pub(super) fn falls(fit: &Fit, x: &[f64]) -> bool {
    let largest = x.iter().copied().fold(0.0, f64::max);
    matches!(fit.parameters.as_slice(), [alpha, beta] if beta * largest < -NO_FALL * alpha.abs())
}

/// Whether a two-parameter law of e may be quoted.
pub(super) fn judge_square_root(fit: &Fit, x: &[f64]) -> Verdict {
    if fit.stop != Stop::Converged {
        Verdict::failed(why_stopped(fit))
    } else if fit.parameters.first().is_none_or(|alpha| *alpha <= 0.0) {
        Verdict::failed(ALPHA_NOT_POSITIVE)
    } else if !falls(fit, x) {
        Verdict::failed(BETA_NOT_NEGATIVE)
    } else if let (None, Some(why)) = (&fit.covariance, &fit.why_no_covariance) {
        Verdict::failed(why.clone())
    } else {
        Verdict::passed("converged")
    }
}

/// Why a fit that did not converge gives no numbers.
pub(super) fn why_stopped(fit: &Fit) -> String {
    let reason = fit.why_no_covariance.clone();
    reason.unwrap_or_else(|| format!("the fit ended with {}", fit.stop.as_str()))
}

/// What a fit knows of its parameters, for the delta method.
pub(super) fn uncertain(fit: &Fit) -> Uncertain {
    let why = || {
        fit.why_no_covariance
            .clone()
            .unwrap_or_else(|| "the fit has no covariance".to_owned())
    };
    Uncertain {
        covariance: fit.covariance.clone().ok_or_else(why),
        degrees_of_freedom: fit.degrees_of_freedom,
    }
}

/// What a fit leaves unexplained, for a comparison of nested fits.
pub(super) fn spread(fit: &Fit) -> Spread {
    let parameters = fit.parameters.len();
    Spread {
        sum_of_squares: fit.residual_sum_of_squares,
        runs: fit.degrees_of_freedom + parameters,
        parameters,
    }
}
