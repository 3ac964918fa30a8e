//! Takes estimates of quantities from a least-squares fit, by the delta method and, where it is too curved, the profile.

use nalgebra::DVector;

use super::estimate::{Estimate, Quoting};
use super::fit_verdict::{ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE, NO_FALL};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::law_squares::{self, Held};
use crate::inference::least_squares::Fit;
use crate::inference::profile::{first_parameter, Limits, Region, AGREES};
use crate::inference::regression::Regression;
use crate::physics::jet::{Jet, Number};
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::Coefficient;
use crate::runs::Runs;
use crate::scene::WetLaw;

/// Most parameters a quantity of a law depends on: the law's two, and k.
pub(super) const PARAMETERS: usize = 3;

/// The parameters of a law, each with its slope in itself.
pub(super) fn variables([a, b]: [f64; 2]) -> [Jet<PARAMETERS>; 2] {
    [Jet::variable(a, 0), Jet::variable(b, 1)]
}

/// What the two parameters of a wet law are those of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LawOver {
    /// the square root over 1/v
    Speed,
    /// a law over 1/St
    Stokes(WetLaw),
}

impl LawOver {
    /// The form of the law.
    pub fn law(self) -> WetLaw {
        match self {
            LawOver::Speed => WetLaw::Sqrt,
            LawOver::Stokes(law) => law,
        }
    }

    /// The abscissa of a run.
    pub fn abscissa(self, runs: &Runs, run: usize) -> f64 {
        match self {
            LawOver::Speed => 1.0 / runs.impact_speed[run],
            LawOver::Stokes(_) => runs.inverse_stokes(run),
        }
    }

    /// What its fit estimates by itself.
    pub fn estimated(self) -> &'static [Quantity] {
        use Quantity::{Alpha, Beta, EInf, StC, StNoRebound, ThresholdSpeed};
        match self {
            LawOver::Speed => &[Alpha, Beta, EInf, ThresholdSpeed],
            LawOver::Stokes(WetLaw::Sqrt) => &[EInf, StC, StNoRebound],
            LawOver::Stokes(WetLaw::Linear) => &[EInf, StC],
        }
    }

    /// The quantities whose numbers are profiled.
    pub fn profiled(self) -> &'static [Quantity] {
        match self {
            LawOver::Speed => self.estimated(),
            LawOver::Stokes(_) => &[Quantity::EInf, Quantity::StC, Quantity::StCEInf2],
        }
    }

    /// Why there is none of a quantity that is not defined: without e_inf, and with it.
    pub fn undefined(self) -> [&'static str; 2] {
        match self {
            LawOver::Speed => [ALPHA_NOT_POSITIVE, BETA_NOT_NEGATIVE],
            LawOver::Stokes(_) => [NO_FALL; 2],
        }
    }

    /// What the law says with these parameters.
    pub fn wetted<T: Number>(self, [a, b]: [T; 2]) -> Wetted<T> {
        match self {
            LawOver::Speed => Wetted::of_speed(a, b),
            LawOver::Stokes(WetLaw::Sqrt) => Wetted::of_square_root(a, b),
            LawOver::Stokes(WetLaw::Linear) => Wetted::of_line(a, b),
        }
    }

    /// The number of its parameters that a quantity is a function of.
    fn held(self, quantity: Quantity) -> Held {
        match quantity {
            Quantity::EInf | Quantity::InertialLoss | Quantity::Alpha | Quantity::DryK => Held::First,
            Quantity::StC | Quantity::StNoRebound | Quantity::ThresholdSpeed => Held::Ratio,
            Quantity::Beta => Held::Second,
            Quantity::Shared(Coefficient::LubricationLog)
            | Quantity::StCEInf2
            | Quantity::DeltaC
            | Quantity::DeltaCOverRoughness => match self {
                LawOver::Stokes(WetLaw::Linear) => Held::Product,
                _ => Held::Second,
            },
            // no law of one film ratio knows another
            Quantity::Shared(_) => Held::Second,
        }
    }
}

/// The profile limits of a fitted law, where the delta method's are others.
#[derive(Debug)]
pub(super) struct LawLimits {
    law: LawOver,
    parameters: [f64; 2],
    /// where the limits lie by the fit alone
    region: Region,
    /// in the order of [`Held::ALL`]; `None` where the delta method agrees
    limits: [Option<Limits>; Held::ALL.len()],
}

impl LawLimits {
    /// Those of the numbers that the profiled quantities are functions of; `None` where a fit has no covariance or is curved
    /// in none.
    pub fn find(
        law: LawOver,
        regression: &Regression,
        (fit, errors): (&Fit, Option<&ErrorWeights>),
        quoting: Quoting,
    ) -> Option<LawLimits> {
        let region = Region::of(fit, errors, quoting.level)?;
        let parameters = <[f64; 2]>::try_from(fit.parameters.as_slice()).ok()?;
        let has_straight = |quantity: &Quantity| *quantity != Quantity::EInf || has_straight_root(&region);
        let limits = Held::ALL.map(|held| {
            let is_of_held = |quantity: &&Quantity| law.held(**quantity) == held;
            let mut of_held = law.profiled().iter().filter(is_of_held).peekable();
            of_held.peek()?;
            let profile = law_squares::profile(regression, errors, &region, held)?;
            if profile.is_straight(first_parameter) && of_held.all(has_straight) {
                None
            } else {
                profile.limits(first_parameter)
            }
        });
        limits.iter().any(Option::is_some).then_some(LawLimits {
            law,
            parameters,
            region,
            limits,
        })
    }
}

/// Whether the root of the first parameter is as good as straight to the limits: its bend moves both by a quarter of its
/// relative half width.
fn has_straight_root(region: &Region) -> bool {
    let half = region.t * region.covariance[(0, 0)].sqrt();
    0.25 * half <= AGREES * region.minimum[0].abs()
}

/// A fitted law as a source of estimates.
pub(super) struct FittedLaw<'a> {
    /// what it says, with slopes in the law's parameters and then in k
    pub wetted: Wetted<Jet<PARAMETERS>>,
    /// covariance of as many of these as the quantities asked for depend on
    pub uncertain: &'a Uncertain,
    /// limits of its profiles, where it is curved
    pub limits: Option<&'a LawLimits>,
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
        let covariance = self.uncertain.covariance.as_ref();
        let used = covariance.map_or(0, |covariance| covariance.nrows());
        let estimate = self
            .quoting
            .of_function(self.uncertain, value, &slopes[..used], quantity);
        let limits = self.limits_of(quantity, at, &estimate);
        estimate.with_profile(limits)
    }

    /// The profile limits of a quantity, with what k adds to its variance; `None` where the delta method agrees.
    fn limits_of(&self, quantity: Quantity, at: &Place, estimate: &Estimate) -> Option<Limits> {
        let profile = self.limits?;
        let held = profile.law.held(quantity);
        let limits = profile.limits[held as usize]?;
        let (value, se) = estimate.pair()?;
        let [of_a, of_b, _] = quantity.value(at, &self.wetted).slopes;
        let of_number = held.of(variables(profile.parameters));
        // the quantity's slopes are those of the number times its own in that
        let [by_a, by_b, _] = of_number.slopes;
        let slope = (of_a * by_a + of_b * by_b) / (by_a * by_a + by_b * by_b);
        let (se_of_fit, _) = profile.region.along(&DVector::from_vec(vec![of_a, of_b]))?;
        let is_log = quantity.describe().log;
        let beyond_fit = profile.region.t.powi(2) * (se * se - se_of_fit * se_of_fit).max(0.0);
        let at_limit = |limit: f64| {
            let there = held.at([limit, profile.parameters[held.free()]]);
            let wetted = profile.law.wetted(there).with_e_dry(self.wetted.e_dry.value);
            let found = quantity.value(at, &wetted);
            // without a fall no law gives these, which go on straight, some on the logarithm
            let straight = slope * (limit - of_number.value);
            let found = match (found.is_finite(), there[0] > 0.0) {
                (true, _) => found,
                (false, true) if is_log => value * (straight / value).exp(),
                (false, true) => value + straight,
                (false, false) => return None,
            };
            let (apart, beyond) = match is_log {
                true => ((found / value).ln(), beyond_fit.sqrt() / value),
                false => (found - value, beyond_fit.sqrt()),
            };
            let apart = apart.hypot(beyond).copysign(apart);
            let limit = if is_log { value * apart.exp() } else { value + apart };
            Some(limit).filter(|limit| limit.is_finite())
        };
        Some(limits.map(at_limit, slope > 0.0))
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
