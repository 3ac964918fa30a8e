//! Says when a form of the law stands in for the default one, and holds what was chosen.

use schemars::JsonSchema;
use serde::Serialize;

use crate::inference::diagnostics::loo::Difference;
use crate::model::parameters::{prior_of, ParameterKind};
use crate::physics::loss::Loss;
use crate::physics::{Form, Inertia};
use crate::runs::Runs;
use crate::scene::Scene;

/// A form is clearly better than another if it gains more than this in log density.
pub const GAIN: f64 = 4.0;

/// And if it gains more than so many standard errors of that. The standard error grows as the root of the gain, so that the
/// clear gain of a small table is only a few of its errors: four would keep the wrong form of 135 runs.
pub const GAIN_IN_SE: f64 = 2.0;

/// A form with a further parameter stands in for one without if it gains more than this by leave-one-out, which has charged it
/// for the parameter: its numbers hold where the other form is right, too, with intervals some 5 % wider. By squares alone it
/// wants a clear gain, since there no prior holds a parameter that the runs do not tell.
const GAIN_OF_MORE: f64 = 1.0;

/// Whether what one form gains over another in log density, with this standard error, is more than chance.
pub fn is_gain(gain: f64, se: Option<f64>) -> bool {
    gain > GAIN && se.is_some_and(|se| gain > GAIN_IN_SE * se)
}

/// By what a form was chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChosenBy {
    /// the squares that each form leaves
    LeastSquares,
    /// how each form predicts runs that it has not seen
    LeaveOneOut,
}

/// A form that was not chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct OtherForm {
    /// the form of the inertial loss
    pub inertia: Inertia,
    /// its log density over all runs minus that of the chosen form; of a form with more or fewer parameters over those whose
    /// leave-one-out weights can be trusted under both
    pub difference: f64,
    /// standard error of that, run by run; `None` for fewer than two runs
    pub se: Option<f64>,
    /// how much more the prior of C says of its C than of that of the chosen form, in log density; `None` of a form with
    /// more or fewer parameters
    pub prior_difference: Option<f64>,
}

/// A form that may be chosen.
#[derive(Debug)]
pub(super) struct Candidate {
    /// the form of the inertial loss
    pub inertia: Inertia,
    /// log density of each run; what its parameters fit of their own accord is taken off
    pub log_densities: Vec<f64>,
    /// log density of the prior of ln C at the estimate of C
    pub ln_prior: f64,
    /// the runs of which these cannot be trusted
    pub untrusted: Vec<usize>,
}

/// Log density of the prior of ln C at a C, in the logarithm so that C may be in any unit; 0 where it is held or outside.
pub(super) fn ln_prior_of_prefactor(scene: &Scene, runs: &Runs, form: Form, c: f64) -> f64 {
    let (prior, _) = prior_of(scene, runs, ParameterKind::INERTIAL_PREFACTOR, form);
    let inside = (c > 0.0).then(|| prior.ln_density(c)).flatten();
    inside.map_or(0.0, |(ln_density, _)| ln_density + c.ln())
}

impl Candidate {
    fn parameters(&self) -> usize {
        self.inertia.coefficients().len()
    }

    /// What it gains over another in log density: over all runs where both have as many parameters, since weights that cannot be
    /// trusted favour neither of these; else over the runs that can be trusted in both.
    fn gain_over(&self, other: &Candidate) -> Difference {
        let is_alike = self.parameters() == other.parameters();
        let is_told = |run: usize| is_alike || !self.untrusted.contains(&run) && !other.untrusted.contains(&run);
        let runs = self.log_densities.iter().zip(&other.log_densities).enumerate();
        let told = runs.filter(|(run, _)| is_told(*run));
        Difference::over_runs(&told.map(|(_, (own, other))| own - other).collect::<Vec<_>>())
    }

    /// What the prior of C adds to that, where both have as many parameters.
    fn prior_gain_over(&self, other: &Candidate) -> Option<f64> {
        (self.parameters() == other.parameters()).then_some(self.ln_prior - other.ln_prior)
    }

    /// By how much it is to be preferred to a form that stands; `None` where it is not.
    ///
    /// Between forms of as many parameters the more probable one is taken: neither can feign a better fit, and where their
    /// shapes are so near that runs hardly tell them apart, what tells is which of them needs a C that was to be expected.
    /// One of more or fewer parameters wants a gain by the runs
    /// whose weights can be trusted in both; one of fewer a clear one: where it is wrong, so are its numbers.
    fn preferred_to(&self, standing: &Candidate, by: ChosenBy) -> Option<f64> {
        let gain = self.gain_over(standing);
        if let Some(of_prior) = self.prior_gain_over(standing) {
            return Some(gain.value + of_prior).filter(|both| *both > 0.0);
        }
        let holds_more = self.parameters() > standing.parameters();
        let is_enough = match holds_more && by == ChosenBy::LeaveOneOut {
            true => gain.value > GAIN_OF_MORE,
            false => is_gain(gain.value, gain.se),
        };
        is_enough.then_some(gain.value)
    }
}

/// The form of the inertial loss that the runs chose.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct InertiaChoice {
    /// the chosen one
    pub inertia: Inertia,
    /// by what
    pub by: ChosenBy,
    /// the others
    pub others: Vec<OtherForm>,
}

impl InertiaChoice {
    /// Whether the chosen form gains clearly over every other.
    pub(super) fn is_clear(&self) -> bool {
        let falls_short = |other: &OtherForm| is_gain(-other.difference, other.se);
        self.others.iter().all(falls_short)
    }

    /// Chooses among forms: the best of those with as many parameters as the default one, then whatever gains most of those
    /// that are to be preferred to it; `None` without the default one.
    pub(super) fn among(forms: &[Candidate], by: ChosenBy) -> Option<InertiaChoice> {
        let usual = forms.iter().find(|form| form.inertia == Inertia::DEFAULT)?;
        let best_that_replaces = |standing: &Candidate, as_many: bool| {
            forms
                .iter()
                .filter(|form| (form.parameters() == usual.parameters()) == as_many)
                .filter_map(|form| Some((form, form.preferred_to(standing, by)?)))
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(form, _)| form)
        };
        let twin = best_that_replaces(usual, true).unwrap_or(usual);
        let chosen = best_that_replaces(twin, false).unwrap_or(twin);
        let others = forms.iter().filter(|form| form.inertia != chosen.inertia).map(|form| {
            let gain = form.gain_over(chosen);
            OtherForm {
                inertia: form.inertia,
                difference: rounded(gain.value),
                se: gain.se.map(rounded),
                prior_difference: form.prior_gain_over(chosen).map(rounded),
            }
        });
        Some(InertiaChoice {
            inertia: chosen.inertia,
            by,
            others: others.collect(),
        })
    }
}

/// To four decimals: beyond them a difference of sums over runs is rounding.
fn rounded(difference: f64) -> f64 {
    (difference * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A form whose gain over a density of 0 at each of four runs is this, with this standard error.
    fn form(inertia: Inertia, gain: f64, se: f64) -> Candidate {
        // the variance of these over n − 1 = 3 is 4/3 of the square, and the sum of four has four times that
        let off = se * 0.75_f64.sqrt() / 2.0;
        Candidate {
            inertia,
            log_densities: [off, -off, off, -off].map(|own| gain / 4.0 + own).to_vec(),
            ln_prior: 0.0,
            untrusted: vec![],
        }
    }

    fn chosen(forms: &[Candidate]) -> Option<Inertia> {
        InertiaChoice::among(forms, ChosenBy::LeaveOneOut).map(|choice| choice.inertia)
    }

    #[test]
    fn of_forms_with_as_many_parameters_the_more_probable_stands() {
        let stepwise = || form(Inertia::Stepwise, 0.0, 0.0);
        let cap = |gain, ln_prior| Candidate {
            ln_prior,
            ..form(Inertia::Cap, gain, 2.0)
        };
        assert_eq!(chosen(&[stepwise(), cap(0.3, 0.0)]), Some(Inertia::Cap));
        assert_eq!(chosen(&[stepwise(), cap(-0.3, 0.0)]), Some(Inertia::Stepwise));
        assert_eq!(chosen(&[stepwise(), cap(0.3, -0.5)]), Some(Inertia::Stepwise));
        assert_eq!(chosen(&[stepwise(), cap(-0.3, 0.5)]), Some(Inertia::Cap));
        assert_eq!(chosen(&[cap(9.0, 0.0)]), None);
    }

    #[test]
    fn another_number_of_parameters_wants_a_gain_over_the_better_of_these() {
        let forms = |cap: f64, gain: f64, se: f64| {
            [
                form(Inertia::Stepwise, 0.0, 0.0),
                form(Inertia::Cap, cap, 0.0),
                Candidate {
                    // says nothing between forms of unlike C
                    ln_prior: 50.0,
                    ..form(Inertia::Saturating, gain, se)
                },
            ]
        };
        assert_eq!(chosen(&forms(-1.0, 1.1, 4.0)), Some(Inertia::Saturating));
        assert_eq!(chosen(&forms(-1.0, 0.9, 0.1)), Some(Inertia::Stepwise));
        assert_eq!(chosen(&forms(3.0, 3.9, 0.1)), Some(Inertia::Cap));
        assert_eq!(chosen(&forms(3.0, 4.1, 1.0)), Some(Inertia::Saturating));
        let by_squares = |gain: f64| InertiaChoice::among(&forms(-1.0, gain, 1.0), ChosenBy::LeastSquares);
        let by_squares = |gain: f64| by_squares(gain).map(|choice| choice.inertia);
        assert_eq!(by_squares(3.9), Some(Inertia::Stepwise));
        assert_eq!(by_squares(4.1), Some(Inertia::Saturating));
        // what a form gains by runs that cannot be trusted does not count, and what it gains by the others does
        let untrusted = |run: usize, gains: [f64; 4]| {
            let mut forms = forms(-1.0, 0.0, 0.0);
            forms[2].log_densities = gains.to_vec();
            forms[2].untrusted = vec![run];
            chosen(&forms)
        };
        assert_eq!(untrusted(0, [6.0, 2.0, 2.1, 2.0]), Some(Inertia::Saturating));
        assert_eq!(untrusted(0, [6.0, 0.0, 0.1, 0.0]), Some(Inertia::Stepwise));
        // the loss is left out only where that is clear
        let none = |gain: f64, se: f64| chosen(&[form(Inertia::Stepwise, 0.0, 0.0), form(Inertia::None, gain, se)]);
        assert_eq!(none(3.9, 0.1), Some(Inertia::Stepwise));
        assert_eq!(none(6.0, 4.0), Some(Inertia::Stepwise));
        assert_eq!(none(6.0, 1.0), Some(Inertia::None));
    }
}
