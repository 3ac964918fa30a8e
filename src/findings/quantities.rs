//! Takes estimates of quantities from a least-squares fit, by the delta method.

use super::estimate::{Estimate, IntervalScale, Quoting};
use crate::inference::delta::Uncertain;
use crate::physics::jet::Jet;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::scene::WetLaw;

/// Most parameters a quantity of a law depends on: the law's two, and k.
pub(super) const PARAMETERS: usize = 3;

/// What a law over 1/St with these parameters says, in whatever they are: numbers, or numbers with slopes.
pub(super) fn wetted_of<T: crate::physics::jet::Number>(law: WetLaw, [a, b]: [T; 2]) -> Wetted<T> {
    match law {
        WetLaw::Sqrt => Wetted::of_square_root(a, b),
        WetLaw::Linear => Wetted::of_line(a, b),
    }
}

/// The parameters of a law, each with its slope in itself.
pub(super) fn variables([a, b]: [f64; 2]) -> [Jet<PARAMETERS>; 2] {
    [Jet::variable(a, 0), Jet::variable(b, 1)]
}

/// How a quantity's interval is made.
pub(super) fn scale_of(quantity: Quantity) -> IntervalScale {
    if quantity.describe().log {
        IntervalScale::Log
    } else {
        IntervalScale::Plain
    }
}

/// A fitted law as a source of estimates.
pub(super) struct FittedLaw<'a> {
    /// what it says, with slopes in the law's parameters and then in k
    pub wetted: Wetted<Jet<PARAMETERS>>,
    /// covariance of as many of these as the quantities asked for depend on
    pub uncertain: &'a Uncertain,
    /// why the fit gives no numbers; `None` if it does
    pub why_none: Option<String>,
    /// why there is none of a quantity that is not defined: without e_inf, and with it
    pub undefined: [&'static str; 2],
    /// how estimates are quoted
    pub quoting: Quoting,
}

impl FittedLaw<'_> {
    /// The estimate of a quantity.
    pub fn estimate(&self, quantity: Quantity, at: &Place) -> Estimate {
        if let Some(why) = &self.why_none {
            return self.quoting.none(why.clone());
        }
        let Jet { value, slopes } = quantity.value(at, &self.wetted);
        if value.is_nan() {
            let has_e_inf = self.wetted.e_inf.value.is_finite();
            return self.quoting.none(self.undefined[usize::from(has_e_inf)]);
        }
        let used = self
            .uncertain
            .covariance
            .as_ref()
            .map_or(0, |covariance| covariance.nrows());
        self.quoting
            .of(self.uncertain, value, &slopes[..used], scale_of(quantity))
    }

    /// Correlation of two quantities; `None` where either has no standard error.
    pub fn correlation(&self, first: Quantity, second: Quantity) -> Option<f64> {
        let slopes = |quantity: Quantity| {
            let jet = quantity.value(&Place::NONE, &self.wetted);
            jet.value.is_finite().then_some(jet.slopes)
        };
        let used = self.uncertain.covariance.as_ref().ok()?.nrows();
        let (first, second) = (slopes(first)?, slopes(second)?);
        self.uncertain.correlation(&first[..used], &second[..used])
    }
}
