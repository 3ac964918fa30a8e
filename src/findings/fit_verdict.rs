//! Judges a fit: whether its numbers may be quoted, and why not.

use schemars::JsonSchema;
use serde::Serialize;

use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::{ErrorColumns, ErrorWeights};
use crate::inference::least_squares::Fit;
use crate::inference::nested::{one_law_for_all, FTest, Spread};
use crate::inference::regression::Regression;

/// Whether a result may be quoted, and why or why not.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
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

pub(super) const NO_FALL: &str = "the restitution does not fall with 1/St: there is no St_c";

/// A fall of e² this small beside α, over all of the runs' x, is rounding.
const ROUNDING: f64 = 1e-12;

/// Whether the fitted restitution falls towards low speeds; x of each run, in whatever unit β takes it.
pub(super) fn falls(fit: &Fit, x: &[f64]) -> bool {
    let largest = x.iter().copied().fold(0.0, f64::max);
    matches!(fit.parameters.as_slice(), [alpha, beta] if beta * largest < -ROUNDING * alpha.abs())
}

/// Whether a line of e over 1/St may be quoted.
pub(super) fn linear_verdict(fit: &Fit) -> Verdict {
    let falls = matches!(fit.parameters.as_slice(), [a, b] if *a > 0.0 && *b > 0.0);
    if fit.converged() && !falls {
        Verdict::failed(NO_FALL)
    } else if !fit.converged() || fit.covariance.is_err() {
        Verdict::failed(why_stopped(fit))
    } else {
        Verdict::passed("converged")
    }
}

/// Whether a square root may be quoted.
pub(super) fn square_root_verdict(fit: &Fit, x: &[f64]) -> Verdict {
    if !fit.converged() {
        Verdict::failed(why_stopped(fit))
    } else if fit.parameters.first().is_none_or(|alpha| *alpha <= 0.0) {
        Verdict::failed(ALPHA_NOT_POSITIVE)
    } else if !falls(fit, x) {
        Verdict::failed(BETA_NOT_NEGATIVE)
    } else if let Err(why) = &fit.covariance {
        Verdict::failed(why.as_str())
    } else {
        Verdict::passed("converged")
    }
}

/// Why a fit that did not converge gives no numbers.
pub(super) fn why_stopped(fit: &Fit) -> String {
    let why = fit.covariance.as_ref().err().cloned();
    why.unwrap_or_else(|| format!("the fit ended with {}", fit.stop.as_str()))
}

/// What a fit knows of its parameters, for the delta method.
pub(super) fn uncertain(fit: &Fit) -> Uncertain {
    Uncertain {
        covariance: fit.covariance.clone(),
        degrees_of_freedom: fit.degrees_of_freedom,
    }
}

/// F with its degrees of freedom, as sentences have it.
pub(super) fn f_words(test: &FTest, decimals: usize) -> String {
    let FTest {
        df_between,
        df_within,
        f,
        ..
    } = test;
    format!("F({df_between}, {df_within}) = {f:.decimals$}")
}

/// Whether a run of this spread is expected so far above sticking that this does not cut it off: a lucky rebound nearer to
/// it has no fair residual.
pub(super) fn is_clear(expected: f64, sticks_at: f64, sd: f64) -> bool {
    /// in spreads
    const CLEAR: f64 = 3.0;
    expected - sticks_at > CLEAR * sd
}

/// A law fitted to the runs of one group, which one law for all is held against.
pub(super) struct OwnLaw<'a> {
    regression: Regression<'a>,
    pub fit: Fit,
    /// weights of the runs, where they carry measurement errors
    pub weights: Option<ErrorWeights>,
}

impl<'a> OwnLaw<'a> {
    /// Fits it.
    pub fn new(regression: Regression<'a>, errors: Option<&ErrorColumns>) -> OwnLaw<'a> {
        let (fit, weights) = regression.fit_with_errors(errors);
        OwnLaw {
            regression,
            fit,
            weights,
        }
    }

    /// Variances of the runs that are expected clear above sticking, infinite for the others; and how many runs those are.
    fn told(&self, expected: &[f64], sticks_at: f64, variance: impl Fn(usize) -> f64) -> (Vec<f64>, usize) {
        let is_told = |run: usize| {
            let sd = match &self.weights {
                Some(weights) => weights.variance[run].sqrt(),
                None => self.fit.residual_sd.unwrap_or(f64::NAN),
            };
            is_clear(expected[run], sticks_at, sd)
        };
        let told = (0..expected.len()).map(|run| if is_told(run) { variance(run) } else { f64::INFINITY });
        let told: Vec<f64> = told.collect();
        let finite = told.iter().enumerate().filter(|(_, variance)| variance.is_finite());
        let runs: f64 = finite.map(|(run, _)| self.regression.count(run)).sum();
        (told, runs.round() as usize)
    }
}

/// One law for all groups against a law each, by F, of runs that the one law expects more than three spreads above
/// sticking: a lucky rebound near it has no fair residual, which the law of a group follows and one for all cannot.
///
/// The one law has so many parameters and expects these restitutions, group by group; a restitution no larger than `sticks_at`
/// is none. `squares` gives its weighted squares, fitted again with these variances of all runs, which scatter so much about
/// the groups' laws in these units. Where runs are weighed, both sides have the weights of the groups.
pub(super) fn one_against(
    parameters: usize,
    expected: &[f64],
    sticks_at: f64,
    groups: &[OwnLaw],
    squares: impl Fn(Vec<f64>, f64) -> f64,
) -> Option<FTest> {
    let is_weighed = groups.iter().any(|own| own.weights.is_some());
    let (mut spreads, mut variances) = (vec![], vec![]);
    for own in groups {
        let first = variances.len();
        let expected = &expected[first..first + own.regression.x.len()];
        let of_group = own.fit.parameters.len();
        let each = own.fit.residual_sd.filter(|_| is_weighed).map_or(1.0, |sd| sd * sd);
        let of_run = |run: usize| own.weights.as_ref().map_or(each, |weights| weights.variance[run]);
        let (variance, told) = own.told(expected, sticks_at, of_run);
        if told > of_group {
            spreads.push(Spread {
                sum_of_squares: own.regression.chi_squared(&variance, &own.fit.parameters),
                runs: told,
                parameters: of_group,
            });
            variances.extend(variance);
        } else {
            variances.extend(variance.iter().map(|_| f64::INFINITY));
        }
    }
    let within: f64 = spreads.iter().map(|own| own.sum_of_squares).sum();
    let freedom: usize = spreads.iter().map(|own| own.runs - own.parameters).sum();
    let scatter = if is_weighed {
        1.0
    } else {
        (within / freedom as f64).sqrt()
    };
    let one = Spread {
        sum_of_squares: squares(variances, scatter),
        runs: spreads.iter().map(|own| own.runs).sum(),
        parameters,
    };
    one_law_for_all(one, &spreads)
}
