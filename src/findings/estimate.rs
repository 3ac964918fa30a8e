//! Holds a number with its standard error and interval, or the reason why there is none.

use std::ops::Index;

use schemars::JsonSchema;
use serde::Serialize;

use crate::distributions::{normal_quantile, student_t_quantile};
use crate::inference::delta::{interval, log_interval, Interval, Uncertain, DELTA, DELTA_LOG, LEVELS, PROFILE};
use crate::inference::profile::Limits;
use crate::physics::Quantity;
use crate::rounding::{significant, with_error};
use crate::scene::Scene;

/// How intervals are quoted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quoting {
    /// probability the quoted interval is made for
    pub level: f64,
}

/// A number with its uncertainty. Field names are those of `findings.json`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Estimate {
    /// its value: the mean of a posterior, the estimate of a fit
    pub value: Option<f64>,
    /// its uncertainty: the sd of a posterior, the standard error of a fit; of a fit with fewer than ten degrees of freedom
    /// the half-width of Student's interval over the normal quantile, of a bootstrap's interval its own, so that ± and interval
    /// agree
    pub se: Option<f64>,
    /// the standard error of a fit even where its curvature forbids to quote it: where a search starts, never an uncertainty
    #[serde(skip)]
    pub(super) delta_se: Option<f64>,
    /// its central interval
    pub interval: Option<[f64; 2]>,
    /// the probability the interval was made for
    pub level: f64,
    /// how the interval was made
    pub method: &'static str,
    /// Monte Carlo error of the value; of a posterior only
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse: Option<f64>,
    /// why there is no uncertainty; stands exactly then
    #[serde(rename = "reason")]
    pub why_none: Option<String>,
    /// every interval that was made, by other methods and at other levels too; of least squares only
    // beside a bootstrap's, of the delta method's only the one at `level`
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<Interval>,
    /// what the replicates say; `None` where there are none
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Bootstrapped>,
}

/// What the replicates of a quantity say.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Bootstrapped {
    /// standard deviation of the replicates, or by the sandwich that they tend to; `None` where `fallback` says why there are
    /// none
    pub se: Option<f64>,
    /// their mean minus the estimate
    pub bias: Option<f64>,
    /// replicates without a number
    pub failed: usize,
    /// the same by reason
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<Failed>,
    /// replicates asked for; 0 where the sandwich stands for them
    pub replicates: usize,
    /// why another interval stands in for the scene's: the percentile one, without replicates the delta method's
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback: Option<&'static str>,
}

/// Replicates that gave no number.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Failed {
    /// why, in words
    pub reason: &'static str,
    /// how many
    pub replicates: usize,
}

/// The estimates of a fit, each with its quantity, in the order in which they are told. One that the fit does not give has no
/// value.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QuantityEstimates(Vec<(Quantity, Estimate)>);

impl QuantityEstimates {
    pub(super) fn of(
        quantities: impl IntoIterator<Item = Quantity>,
        estimate: impl Fn(Quantity) -> Estimate,
    ) -> QuantityEstimates {
        let each = quantities.into_iter().map(|quantity| (quantity, estimate(quantity)));
        QuantityEstimates(each.collect())
    }

    /// Each with its quantity.
    pub fn iter(&self) -> impl Iterator<Item = (Quantity, &Estimate)> {
        self.0.iter().map(|(quantity, estimate)| (*quantity, estimate))
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = (Quantity, &mut Estimate)> {
        self.0.iter_mut().map(|(quantity, estimate)| (*quantity, estimate))
    }

    pub(super) fn extend(&mut self, more: impl IntoIterator<Item = (Quantity, Estimate)>) {
        self.0.extend(more);
    }

    /// Takes them all back.
    pub(super) fn withhold(&mut self, why: &str, quoting: Quoting) {
        for (_, estimate) in &mut self.0 {
            *estimate = quoting.none(why);
        }
    }
}

impl Index<Quantity> for QuantityEstimates {
    type Output = Estimate;

    fn index(&self, quantity: Quantity) -> &Estimate {
        static ABSENT: Estimate = Estimate::NOTHING;
        let own = self.iter().find(|(own, _)| *own == quantity);
        own.map_or(&ABSENT, |(_, estimate)| estimate)
    }
}

impl Bootstrapped {
    pub(super) fn none(why: &'static str) -> Bootstrapped {
        Bootstrapped {
            fallback: Some(why),
            ..Bootstrapped::default()
        }
    }
}

impl Quoting {
    /// As a scene asks for it.
    pub fn of(scene: &Scene) -> Quoting {
        Quoting {
            level: scene.bootstrap.level,
        }
    }

    /// A number that the runs do not give.
    pub fn none(self, why: impl Into<String>) -> Estimate {
        self.without_se(None, why)
    }

    /// A number without an uncertainty.
    pub fn without_se(self, value: Option<f64>, why: impl Into<String>) -> Estimate {
        Estimate {
            value,
            level: self.level,
            why_none: Some(why.into()),
            ..Estimate::NOTHING
        }
    }

    /// A quantity that is a function of uncertain parameters, from its value and its gradient in them; on the logarithm where
    /// it is an exponential. None where that is beyond what a number can hold, as exp(L) may be.
    pub fn of_function(self, uncertain: &Uncertain, value: f64, gradient: &[f64], quantity: Quantity) -> Estimate {
        if !value.is_finite() {
            return self.none("it is not finite at the fit");
        }
        let se = match uncertain.se(gradient) {
            Ok(se) => se,
            Err(why) => return self.without_se(Some(value), why),
        };
        let is_log = quantity.describe().log;
        let make = |level| match is_log {
            true => log_interval(value, se, uncertain.degrees_of_freedom, level),
            false => interval(value, se, uncertain.degrees_of_freedom, level),
        };
        let quoted = make(self.level);
        Estimate {
            se: Some(se),
            delta_se: Some(se),
            interval: quoted.map(|made| [made.lo, made.hi]),
            method: if is_log { DELTA_LOG } else { DELTA },
            intervals: levels(self.level).filter_map(make).collect(),
            why_none: quoted.is_none().then(|| "its interval is not finite".to_owned()),
            ..self.without_se(Some(value), "")
        }
    }
}

/// The levels that intervals are made for, beside the one that is quoted.
pub(super) fn levels(quoted: f64) -> impl Iterator<Item = f64> {
    let own = Some(quoted).filter(|level| !LEVELS.contains(level));
    LEVELS.into_iter().chain(own)
}

/// Fewest degrees of freedom with which a law tells its own spread: on one, ±1.96 of its standard errors covered 76 % (82
/// simulated sets).
pub const FEWEST_DEGREES: usize = 10;

/// Share of the delta interval's width by which an end of the profile's must differ for the delta method to be given up.
pub const CURVED: f64 = 0.1;

/// Why a curved fit has no ±.
const WHY_CURVED: &str = "the curvature of the fit forbids a ±: the interval is the profile's, between the limits at \
                          which the weighted squares have risen by t²s²";

impl Estimate {
    /// Neither a value nor a reason.
    const NOTHING: Estimate = Estimate {
        value: None,
        se: None,
        delta_se: None,
        interval: None,
        level: 0.0,
        method: DELTA,
        mcse: None,
        why_none: None,
        intervals: vec![],
        bootstrap: None,
    };

    /// Adds a bootstrap's intervals, which stand for the delta method's at other levels than the scene's: these say nothing
    /// that its se and its interval at that level do not.
    pub(super) fn add_bootstrap_intervals(&mut self, made: Vec<Interval>) {
        if !made.is_empty() {
            let level = self.level;
            self.intervals.retain(|made| !made.is_delta() || made.level == level);
            self.intervals.extend(made);
        }
    }

    /// Takes back the uncertainty of least squares, which does not hold; the limits of a profile stay.
    pub(super) fn withhold_uncertainty(&mut self, why: &str) {
        if !self.is_curved() {
            (self.se, self.delta_se, self.interval) = (None, None, None);
            self.intervals.clear();
            self.why_none = Some(why.to_owned());
        }
    }

    /// The number with its uncertainty, or the value alone where there is none.
    pub fn rounded(&self) -> String {
        with_error(self.value, self.se, self.mcse)
    }

    /// The standard error of a fit, made to agree with its interval where that is a bootstrap's, or Student's on few degrees of
    /// freedom.
    pub(super) fn se_of_interval(&self) -> Option<f64> {
        let (value, se) = self.pair()?;
        let probability = 0.5 + 0.5 * self.level;
        let normal = normal_quantile(probability);
        let half = match (self.interval, self.method) {
            (Some([lo, hi]), DELTA) => 0.5 * (hi - lo),
            (Some([lo, hi]), DELTA_LOG) => 0.5 * value * (hi / lo).ln(),
            (Some([lo, hi]), _) => return Some(0.5 * (hi - lo) / normal),
            (None, _) => return Some(se),
        };
        let few = student_t_quantile(probability, FEWEST_DEGREES as f64)?;
        // at the very number of degrees that is enough, rounding decides nothing
        const ROUNDING: f64 = 1e-6;
        Some(if half > few * se * (1.0 + ROUNDING) {
            half / normal
        } else {
            se
        })
    }

    /// Share of its replicates that gave no number; `None` where it has no replicates.
    pub(super) fn failed_replicates(&self) -> Option<f64> {
        let boot = self.bootstrap.as_ref().filter(|boot| boot.replicates > 0)?;
        Some(boot.failed as f64 / boot.replicates as f64)
    }

    /// Value and standard error, where both are there.
    pub fn pair(&self) -> Option<(f64, f64)> {
        self.value.zip(self.se)
    }

    /// Whether a ± is withheld since the profile's limits are not the delta method's.
    pub fn is_curved(&self) -> bool {
        self.se.is_none() && self.delta_se.is_some()
    }

    /// The standard error; where the curvature forbids one, that of which the quoted interval would be ± t. For shares of
    /// the uncertainty, not to be printed as a ±. `None` without either.
    pub fn scale(&self) -> Option<f64> {
        let half = self.interval.map(|[lo, hi]| 0.5 * (hi - lo));
        self.se
            .or(half.map(|half| half / normal_quantile(0.5 + 0.5 * self.level)))
    }

    /// Value and [`Estimate::scale`], where both are there: for weights and starts.
    pub fn value_and_scale(&self) -> Option<(f64, f64)> {
        self.value.zip(self.scale())
    }

    /// Adds the limits of the profile, where the delta method does not agree, and quotes them where an end of the delta method's interval is off by more than
    /// [`CURVED`] of its width; on the logarithm where that is made there.
    pub(super) fn with_profile(mut self, limits: Option<Limits>) -> Estimate {
        let (Some(limits), Some(delta)) = (limits, self.interval) else {
            return self;
        };
        let both = limits.both().filter(|ends| ends.iter().all(|end| end.is_finite()));
        self.intervals.extend(both.map(|[lo, hi]| Interval {
            method: PROFILE,
            level: self.level,
            lo,
            hi,
        }));
        let on_scale = |x: f64| match self.method == DELTA_LOG {
            true => x.ln(),
            false => x,
        };
        let [lo, hi] = delta.map(on_scale);
        let is_near = |ends: [f64; 2]| {
            let off = [on_scale(ends[0]) - lo, on_scale(ends[1]) - hi];
            off.iter().all(|off| off.abs() <= CURVED * (hi - lo))
        };
        if both.is_some_and(is_near) {
            return self;
        }
        self.se = None;
        self.method = PROFILE;
        self.interval = both;
        self.why_none = Some(match both {
            Some(_) => WHY_CURVED.to_owned(),
            None => why_half_open(limits),
        });
        self
    }
}

/// Why a profile gives no interval.
fn why_half_open(Limits { lo, hi }: Limits) -> String {
    let finite = |limit: Option<f64>| limit.filter(|limit| limit.is_finite());
    let sides = match (finite(lo), finite(hi)) {
        (Some(lo), _) => format!("the runs set a lower limit, {}, and no upper one", significant(lo, 4)),
        (None, Some(hi)) => format!("the runs set an upper limit, {}, and no lower one", significant(hi, 4)),
        (None, None) => "the runs set no limit on either side".to_owned(),
    };
    format!("the curvature of the fit forbids a ±, and the weighted squares do not rise by t²s² on both sides: {sides}")
}
