//! Says when a form of the law stands in for the default one, and holds what was chosen.

use serde::Serialize;

use crate::inference::diagnostics::loo::Difference;
use crate::physics::Inertia;

/// A form is better than another if it gains more than this in log density, and this many standard errors.
pub const GAIN: f64 = 4.0;

/// Whether what one form gains over another in log density is more than chance.
pub fn is_gain(gain: Difference) -> bool {
    gain.value > GAIN && gain.se.is_some_and(|se| gain.value > GAIN * se)
}

/// By what a form was chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ChosenBy {
    /// the squares that each form leaves
    LeastSquares,
    /// how each form predicts runs that it has not seen
    LeaveOneOut,
}

/// A form that was not chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OtherForm {
    /// the form of the inertial loss
    pub inertia: &'static str,
    /// its log density over all runs minus that of the chosen form
    pub difference: f64,
    /// standard error of that; `None` where the chosen form is not the one that others are held against
    pub se: Option<f64>,
}

/// The form of the inertial loss that the runs chose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InertiaChoice {
    /// the chosen one
    pub inertia: &'static str,
    /// by what
    pub by: ChosenBy,
    /// the others
    pub others: Vec<OtherForm>,
}

impl InertiaChoice {
    /// Chooses among forms, each with what it gains over the default one and whether that may be trusted; `None` without
    /// the default one.
    pub(super) fn among(forms: &[(Inertia, Difference, bool)], by: ChosenBy) -> Option<(Inertia, InertiaChoice)> {
        forms.iter().find(|(inertia, ..)| *inertia == Inertia::DEFAULT)?;
        let clear = forms.iter().filter(|(_, gain, trusted)| *trusted && is_gain(*gain));
        let best = clear.max_by(|a, b| a.1.value.total_cmp(&b.1.value));
        let chosen = best.map_or(Inertia::DEFAULT, |(inertia, ..)| *inertia);
        let of_chosen = best.map_or(0.0, |(_, gain, _)| gain.value);
        let others = forms.iter().filter(|(inertia, ..)| *inertia != chosen);
        let others = others.map(|(inertia, gain, _)| OtherForm {
            inertia: inertia.name(),
            difference: rounded(gain.value - of_chosen),
            se: gain.se.filter(|_| chosen == Inertia::DEFAULT).map(rounded),
        });
        let choice = InertiaChoice {
            inertia: chosen.name(),
            by,
            others: others.collect(),
        };
        Some((chosen, choice))
    }
}

/// To four decimals: beyond them a difference of sums over runs is rounding.
fn rounded(difference: f64) -> f64 {
    (difference * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_is_chosen_where_its_gain_is_clear_and_trusted() {
        let gain = |value: f64, se: f64| Difference { value, se: Some(se) };
        let forms = |of_cap: Difference, trusted| {
            [
                (Inertia::Stepwise, gain(0.0, 0.0), true),
                (Inertia::Cap, of_cap, trusted),
                (Inertia::Saturating, gain(6.0, 1.0), true),
            ]
        };
        let chosen = |of_cap, trusted| {
            let (chosen, choice) = InertiaChoice::among(&forms(of_cap, trusted), ChosenBy::LeaveOneOut).expect("forms");
            (chosen, choice.others[0].difference)
        };
        assert_eq!(chosen(gain(9.0, 2.0), true), (Inertia::Cap, -9.0));
        // not four of its errors, or not trusted: the next one
        assert_eq!(chosen(gain(9.0, 3.0), true), (Inertia::Saturating, -6.0));
        assert_eq!(chosen(gain(9.0, 2.0), false), (Inertia::Saturating, -6.0));
        let none = [
            (Inertia::Stepwise, gain(0.0, 0.0), true),
            (Inertia::Cap, gain(3.9, 0.1), true),
        ];
        let (chosen, choice) = InertiaChoice::among(&none, ChosenBy::LeastSquares).expect("forms");
        assert_eq!((chosen, choice.others[0].difference), (Inertia::Stepwise, 3.9));
        assert!(InertiaChoice::among(&none[1..], ChosenBy::LeastSquares).is_none());
    }
}
