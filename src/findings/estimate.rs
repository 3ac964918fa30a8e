//! Holds a number with its standard error and interval, or the reason why there is none.

use serde::Serialize;

use crate::inference::delta::{interval, log_interval, Interval, Uncertain, LEVELS};

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
    /// standard error by least squares and the delta method
    pub se: Option<f64>,
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
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bootstrapped {
    /// standard deviation of the replicates; `None` where `fallback` says why there are none
    pub se: Option<f64>,
    /// their mean minus the estimate
    pub bias: Option<f64>,
    /// replicates without a number
    pub failed: usize,
    /// the same by reason
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<Failed>,
    /// replicates asked for
    pub replicates: usize,
    /// why another interval stands in for the scene's: the percentile one, without replicates the delta method's
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fallback: Option<&'static str>,
}

/// Replicates that gave no number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failed {
    /// why, in words
    pub reason: &'static str,
    /// how many
    pub replicates: usize,
}

impl Bootstrapped {
    pub(super) fn none(why: &'static str) -> Bootstrapped {
        Bootstrapped {
            se: None,
            bias: None,
            failed: 0,
            failures: vec![],
            replicates: 0,
            fallback: Some(why),
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
    /// A number that the runs do not give.
    pub fn none(self, why: impl Into<String>) -> Estimate {
        self.without_se(None, why)
    }

    /// A number without an uncertainty.
    pub fn without_se(self, value: Option<f64>, why: impl Into<String>) -> Estimate {
        Estimate {
            value,
            se: None,
            interval: None,
            level: self.level,
            method: IntervalScale::Plain.method(),
            intervals: vec![],
            bootstrap: None,
            why_none: Some(why.into()),
        }
    }

    /// A function of uncertain parameters, from its value and its gradient in them.
    pub fn of(self, uncertain: &Uncertain, value: f64, gradient: &[f64], scale: IntervalScale) -> Estimate {
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
            value: Some(value),
            se: Some(se),
            interval: quoted.map(|made| [made.lo, made.hi]),
            level: self.level,
            method: scale.method(),
            intervals,
            bootstrap: None,
            why_none: quoted.is_none().then(|| "its interval is not finite".to_owned()),
        }
    }
}

impl Estimate {
    /// Value and standard error, where both are there.
    pub fn pair(&self) -> Option<(f64, f64)> {
        self.value.zip(self.se)
    }
}
