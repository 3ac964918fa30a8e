//! Judges a fit: whether its numbers may be quoted, and why not.

use serde::Serialize;

use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::least_squares::{Fit, Stop};
use crate::inference::nested::{one_law_for_all, FTest, Spread};

/// Whether a result may be quoted, and why or why not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// whether it may be quoted
    pub passed: bool,
    /// why, in words
    pub reason: String,
}

impl Verdict {
    /// Passed, with a remark.
    pub fn passed(reason: impl Into<String>) -> Verdict {
        Verdict {
            passed: true,
            reason: reason.into(),
        }
    }

    /// Failed, with the reason.
    pub fn failed(reason: impl Into<String>) -> Verdict {
        Verdict {
            passed: false,
            reason: reason.into(),
        }
    }
}

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
pub(super) fn square_root_verdict(fit: &Fit, x: &[f64]) -> Verdict {
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

/// One law for all groups against a law each, by F. Where runs are weighed, both sides have the weights of the groups:
/// `one` gives the weighted squares of the one law, fitted again with these variances of all runs.
pub(super) fn one_against<'w>(
    of_all: Spread,
    groups: impl Iterator<Item = (Spread, Option<&'w ErrorWeights>)> + Clone,
    one: impl Fn(Vec<f64>) -> f64,
) -> Option<FTest> {
    if groups.clone().all(|(_, weights)| weights.is_none()) {
        let spreads: Vec<Spread> = groups.map(|(spread, _)| spread).collect();
        return one_law_for_all(of_all, &spreads);
    }
    let (mut spreads, mut variance) = (vec![], vec![]);
    for (own, weights) in groups {
        let (sum_of_squares, of_runs) = match weights {
            Some(weights) => (weights.squares, weights.variance.clone()),
            None => {
                let each = own.sum_of_squares / own.runs.checked_sub(own.parameters)? as f64;
                let each = Some(each).filter(|each| *each > 0.0 && each.is_finite())?;
                (own.sum_of_squares / each, vec![each; own.runs])
            }
        };
        variance.extend(of_runs);
        spreads.push(Spread { sum_of_squares, ..own });
    }
    let sum_of_squares = one(variance);
    let one = Spread {
        sum_of_squares,
        // a run left out of its own group is left out here, too
        runs: spreads.iter().map(|own| own.runs).sum(),
        ..of_all
    };
    one_law_for_all(one, &spreads)
}
