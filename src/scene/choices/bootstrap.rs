//! Reads how a scene has its intervals made.

use super::unused::note_unused;
use crate::scene::expect::INSIDE_ONE;
use crate::scene::keys::{guides, DefaultsTo, Key, Optional, Section};
use crate::scene::table::{Count, Number, OneOf, OneOfToday, SceneTable};
use crate::units::Dimension;

/// How intervals are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// replicates
    pub replicates: u64,
    /// what is resampled
    pub scheme: ResamplingScheme,
    /// the interval to quote; absent: the default
    pub interval: Option<IntervalMethod>,
    /// probability an interval is made for
    pub level: f64,
}

/// What a bootstrap resamples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResamplingScheme {
    /// runs
    Cases,
    /// whole series
    Series,
}

impl ResamplingScheme {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            ResamplingScheme::Cases => "cases",
            ResamplingScheme::Series => "series",
        }
    }
}

/// How an interval is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalMethod {
    /// bias-corrected and accelerated
    Bca,
    /// percentiles of the replicates
    Percentile,
    /// estimate ± t · se
    Delta,
}

impl IntervalMethod {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            IntervalMethod::Bca => "bca",
            IntervalMethod::Percentile => "percentile",
            IntervalMethod::Delta => "delta",
        }
    }
}

/// Most replicates: more than any interval needs. What they take also depends on the number of fits, and is checked when
/// these are listed.
pub const MOST_REPLICATES: u64 = 1_000_000;

const REPLICATES: Key<Count, DefaultsTo<u64>> = Key {
    base: "replicates",
    takes: Count(1, MOST_REPLICATES),
    absent: DefaultsTo(10_000),
    meaning: "how many times the runs are resampled",
    example: "2000",
};

const SCHEME: Key<OneOfToday<ResamplingScheme>, DefaultsTo<ResamplingScheme>> = Key {
    base: "scheme",
    takes: OneOfToday {
        words: OneOf(|| {
            let all = [ResamplingScheme::Cases, ResamplingScheme::Series];
            all.map(|scheme| (scheme.name(), scheme)).to_vec()
        }),
        replaced: &[("residuals", "cases"), ("parametric", "cases")],
    },
    absent: DefaultsTo(ResamplingScheme::Cases),
    meaning: "what is resampled: runs, or whole series",
    example: "\"series\"",
};

const INTERVAL: Key<OneOfToday<IntervalMethod>, Optional> = Key {
    base: "interval",
    takes: OneOfToday {
        words: OneOf(|| {
            let all = [IntervalMethod::Bca, IntervalMethod::Percentile, IntervalMethod::Delta];
            all.map(|method| (method.name(), method)).to_vec()
        }),
        replaced: &[("studentized", "bca")],
    },
    absent: Optional("percentile; of few runs that of least squares"),
    meaning: "the interval to quote",
    example: "\"bca\"",
};

const LEVEL: Key<Number, DefaultsTo<f64>> = Key {
    base: "level",
    takes: Number(Dimension::One, INSIDE_ONE),
    absent: DefaultsTo(0.95),
    meaning: "probability of the intervals",
    example: "0.9",
};

/// What is to be said of the table of the bootstrap.
pub(in crate::scene) fn guide() -> Section {
    Section {
        head: "[bootstrap]",
        may_be_empty: true,
        about: "How the intervals of least squares are made".to_owned(),
        keys: guides(&[&REPLICATES, &SCHEME, &INTERVAL, &LEVEL]),
    }
}

pub fn bootstrap(root: &SceneTable, unused: &mut Vec<String>) -> Bootstrap {
    let table = root.table_or_empty("bootstrap");
    let bootstrap = Bootstrap {
        replicates: table.read(&REPLICATES),
        scheme: table.read(&SCHEME),
        interval: table.read(&INTERVAL),
        level: table.read(&LEVEL),
    };
    table.finish();
    note_unused("bootstrap", &table, &[REPLICATES.base, SCHEME.base], unused);
    if bootstrap.interval.is_some_and(|method| method != IntervalMethod::Delta) {
        unused.push("bootstrap.interval".to_owned());
    }
    bootstrap
}
