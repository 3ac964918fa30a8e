//! Reads how a scene has its intervals made.

use crate::scene::expect::INSIDE_ONE;
use crate::scene::keys::{Key, Section};
use crate::scene::table::{read_nothing, Count, Number, OneOf, SceneTable};

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

const REPLICATES: Key<Count, u64> = Key::new("replicates", Count(1, MOST_REPLICATES))
    .means("how many times the runs are resampled")
    .example("2000")
    .defaults_to(10_000);

const SCHEME: Key<OneOf<ResamplingScheme>, ResamplingScheme> = Key::new(
    "scheme",
    OneOf::of(|| ResamplingScheme::NAMED.to_vec()).replacing(&[("residuals", "cases"), ("parametric", "cases")]),
)
.means("what is resampled: runs, or whole series")
.example("\"series\"")
.defaults_to(ResamplingScheme::Cases);

const INTERVAL: Key<OneOf<IntervalMethod>> = Key::new(
    "interval",
    OneOf::of(|| IntervalMethod::NAMED.to_vec()).replacing(&[("studentized", "bca")]),
)
.means("the interval to quote")
.example("\"bca\"")
.optional("percentile; of few runs that of least squares");

const LEVEL: Key<Number, f64> = Key::new("level", Number(INSIDE_ONE))
    .means("probability of the intervals")
    .example("0.9")
    .defaults_to(0.95);

/// What is to be said of the table of the bootstrap.
pub(in crate::scene) fn guide() -> Section {
    let (_, keys) = read_nothing(bootstrap);
    Section::new("[bootstrap]", "How the intervals of least squares are made", keys).that_may_be_empty()
}

pub fn bootstrap(table: &SceneTable) -> Bootstrap {
    let bootstrap = Bootstrap {
        replicates: table.read_or(&REPLICATES),
        scheme: table.read_or(&SCHEME),
        interval: table.read(&INTERVAL),
        level: table.read_or(&LEVEL),
    };
    table.finish();
    bootstrap
}
