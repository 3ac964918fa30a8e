//! Reads how a scene has its intervals made.

use crate::scene::expect::INSIDE_ONE;
use crate::scene::table::values::{count, number, one_of};
use crate::scene::table::SceneTable;

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
    /// Every one with its word in scenes.
    const NAMED: [(&str, ResamplingScheme); 2] =
        [("cases", ResamplingScheme::Cases), ("series", ResamplingScheme::Series)];

    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
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
    /// Every one with its word in scenes.
    const NAMED: [(&str, IntervalMethod); 3] = [
        ("bca", IntervalMethod::Bca),
        ("percentile", IntervalMethod::Percentile),
        ("delta", IntervalMethod::Delta),
    ];

    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }
}

/// Most replicates: more than any interval needs. What they take also depends on the number of fits, and is checked when
/// these are listed.
pub const MOST_REPLICATES: u64 = 1_000_000;

pub fn bootstrap(table: &SceneTable) -> Bootstrap {
    let schemes = one_of(ResamplingScheme::NAMED).replacing(&[("residuals", "cases"), ("parametric", "cases")]);
    let methods = one_of(IntervalMethod::NAMED).replacing(&[("studentized", "bca")]);
    let bootstrap = Bootstrap {
        replicates: table.read_or("replicates", count(1, MOST_REPLICATES), 10_000),
        scheme: table.read_or("scheme", schemes, ResamplingScheme::Cases),
        interval: table.read("interval", methods),
        level: table.read_or("level", number(INSIDE_ONE), 0.95),
    };
    table.finish();
    bootstrap
}
