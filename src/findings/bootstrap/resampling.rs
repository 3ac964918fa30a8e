//! Holds what is resampled and how: the estimates that get an interval, and what is kept of their replicates.

use schemars::JsonSchema;
use serde::Serialize;

use crate::findings::dry::Dry;
use crate::findings::energy::Energy;
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;

/// The estimates that get a bootstrap interval.
pub struct Estimates<'e> {
    /// k of each sphere
    pub dry: &'e mut [Dry],
    /// the square-root law of each series
    pub series: &'e mut [SeriesFit],
    /// e_inf and St_c
    pub scaling: &'e mut [Scaling],
    /// the energy table
    pub energy: &'e mut [Energy],
}

/// How replicates were made.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Resampling {
    /// what was resampled
    pub scheme: &'static str,
    /// the interval that is quoted of replicates
    pub interval: &'static str,
    /// whether the runs are so many that the sandwich stands for the replicates of most fits
    pub by_sandwich: bool,
    /// replicates
    pub replicates: usize,
    /// fits that were resampled: all, but of more runs than are resampled only those that the sandwich does not serve
    pub resampled_fits: usize,
    /// strata of all runs
    pub strata: usize,
    /// strata of one run, which no resample can vary
    pub single_run_strata: usize,
}
