//! Holds a number with its standard error and interval, or the reason why there is none.

use schemars::JsonSchema;
use serde::Serialize;

use crate::distributions::normal_quantile;
use crate::inference::delta::{interval, log_interval, Interval, Uncertain, LEVELS, PROFILE};
use crate::inference::profile::Limits;
use crate::rounding::significant;
use crate::scene::Scene;

/// How intervals are quoted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quoting {
    /// probability the quoted interval is made for
    pub level: f64,
}

/// A number with its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// its value; `None` where the runs give none
    pub value: Option<f64>,
    /// standard error by least squares and the delta method; `None`, too, where the curvature of the fit forbids it
    pub se: Option<f64>,
    /// the same even where the curvature forbids to quote it: where a search starts, never an uncertainty
    #[serde(skip)]
    pub(super) delta_se: Option<f64>,
    /// the interval to quote
    pub interval: Option<[f64; 2]>,
    /// the probability it was made for
    pub level: f64,
    /// how it was made
    pub method: &'static str,
    /// every interval that was made; beside a bootstrap's, of the delta method's only the one at `level`
    pub intervals: Vec<Interval>,
    /// what the replicates say; `None` where there are none
    pub bootstrap: Option<Bootstrapped>,
    /// why there is no standard error or no interval; stands exactly then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
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

impl Bootstrapped {
    /// The spread that replicates tend to, where none are made.
    pub(super) fn of_limit(se: f64) -> Bootstrapped {
        Bootstrapped {
            se: Some(se),
            ..Bootstrapped::default()
        }
    }

    pub(super) fn none(why: &'static str) -> Bootstrapped {
        Bootstrapped {
            fallback: Some(why),
            ..Bootstrapped::default()
        }
    }
}

/// On which scale an interval is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalScale {
    /// value ± t · se
    Plain,
    /// the same on the logarithm, for quantities that are an exponential
    Log,
}

impl IntervalScale {
    fn method(self) -> &'static str {
        match self {
            IntervalScale::Plain => "delta",
            IntervalScale::Log => "delta_log",
        }
    }
}

const NOT_FINITE: &str = "it is not finite at the fit";

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
            se: None,
            delta_se: None,
            interval: None,
            level: self.level,
            method: IntervalScale::Plain.method(),
            intervals: vec![],
            bootstrap: None,
            why_none: Some(why.into()),
        }
    }

    /// A function of uncertain parameters, from its value and its gradient in them.
    pub fn of_function(self, uncertain: &Uncertain, value: f64, gradient: &[f64], scale: IntervalScale) -> Estimate {
        if !value.is_finite() {
            return self.none(NOT_FINITE);
        }
        let se = match uncertain.se(gradient) {
            Ok(se) => se,
            Err(why) => return self.without_se(Some(value), why),
        };
        self.with_se(value, se, uncertain.degrees_of_freedom, scale)
    }

    /// A number with a standard error; none where either is beyond what a number can hold, as exp(L) may be.
    pub fn with_se(self, value: f64, se: f64, degrees_of_freedom: usize, scale: IntervalScale) -> Estimate {
        if !value.is_finite() {
            return self.none(NOT_FINITE);
        }
        if !se.is_finite() {
            return self.without_se(Some(value), "its standard error is not finite");
        }
        let make = |level| match scale {
            IntervalScale::Plain => interval(value, se, degrees_of_freedom, level),
            IntervalScale::Log => log_interval(value, se, degrees_of_freedom, level),
        };
        let quoted = make(self.level);
        let mut intervals: Vec<Interval> = LEVELS.into_iter().filter_map(make).collect();
        if !LEVELS.contains(&self.level) {
            intervals.extend(quoted);
        }
        Estimate {
            se: Some(se),
            delta_se: Some(se),
            interval: quoted.map(|made| [made.lo, made.hi]),
            method: scale.method(),
            intervals,
            why_none: quoted.is_none().then(|| "its interval is not finite".to_owned()),
            ..self.without_se(Some(value), "")
        }
    }
}

/// Share of the delta interval's width by which an end of the profile's must differ for the delta method to be given up.
pub const CURVED: f64 = 0.1;

/// Why a curved fit has no ±.
const WHY_CURVED: &str = "the curvature of the fit forbids a ±: the interval is the profile's, between the limits at \
                          which the weighted squares have risen by t²s²";

impl Estimate {
    /// The levels that intervals are made for.
    pub(super) fn levels(&self) -> Vec<f64> {
        let own = Some(self.level).filter(|level| !LEVELS.contains(level));
        LEVELS.into_iter().chain(own).collect()
    }

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

    /// Adds the limits of the profile, and quotes them where an end of the delta method's interval is off by more than
    /// [`CURVED`] of its width; on the logarithm where that is made there.
    pub(super) fn with_profile(mut self, limits: Limits) -> Estimate {
        let Some(delta) = self.interval else {
            return self;
        };
        let both = limits.both().filter(|ends| ends.iter().all(|end| end.is_finite()));
        self.intervals.extend(both.map(|[lo, hi]| Interval {
            method: PROFILE,
            level: self.level,
            lo,
            hi,
        }));
        let on_scale = |x: f64| match self.method == IntervalScale::Log.method() {
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
