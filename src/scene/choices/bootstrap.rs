//! Reads how a scene has its intervals made.

use super::unused::note_unused;
use crate::scene::expect::INSIDE_ONE;
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
    /// residuals of the fit
    Residuals,
    /// new noise about the fit
    Parametric,
    /// whole series
    Series,
}

impl ResamplingScheme {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            ResamplingScheme::Cases => "cases",
            ResamplingScheme::Residuals => "residuals",
            ResamplingScheme::Parametric => "parametric",
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
    /// studentized
    Studentized,
    /// estimate ± t · se
    Delta,
}

impl IntervalMethod {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            IntervalMethod::Bca => "bca",
            IntervalMethod::Percentile => "percentile",
            IntervalMethod::Studentized => "studentized",
            IntervalMethod::Delta => "delta",
        }
    }
}

/// Most replicates: more than any interval needs. What they take also depends on the number of fits, and is checked when
/// these are listed.
pub const MOST_REPLICATES: u64 = 1_000_000;

pub fn bootstrap(root: &SceneTable, unused: &mut Vec<String>) -> Bootstrap {
    let mut bootstrap = Bootstrap {
        replicates: 10_000,
        scheme: ResamplingScheme::Cases,
        interval: None,
        level: 0.95,
    };
    let Some(table) = root.table("bootstrap") else {
        return bootstrap;
    };
    let schemes = [
        ResamplingScheme::Cases,
        ResamplingScheme::Residuals,
        ResamplingScheme::Parametric,
        ResamplingScheme::Series,
    ]
    .map(|scheme| (scheme.name(), scheme));
    let methods = [
        IntervalMethod::Bca,
        IntervalMethod::Percentile,
        IntervalMethod::Studentized,
        IntervalMethod::Delta,
    ]
    .map(|method| (method.name(), method));
    bootstrap.replicates = table
        .count_to("replicates", 1, MOST_REPLICATES)
        .unwrap_or(bootstrap.replicates);
    bootstrap.scheme = table.choice("scheme", &schemes).unwrap_or(bootstrap.scheme);
    bootstrap.interval = table.choice("interval", &methods);
    bootstrap.level = table.number("level", INSIDE_ONE).unwrap_or(bootstrap.level);
    table.finish();
    note_unused("bootstrap", &table, &["replicates", "scheme"], unused);
    if bootstrap.interval.is_some_and(|method| method != IntervalMethod::Delta) {
        unused.push("bootstrap.interval".to_owned());
    }
    bootstrap
}
