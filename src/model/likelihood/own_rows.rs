//! Holds what runs have of their own, where they are taken one at a time.

use super::errors::Errors;
use super::nodes::{DryRow, NodeFilm};
use super::shared_speed::SharedRuns;
use crate::scene::LikelihoodFamily;

/// What runs have of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ByRow {
    /// what distribution noise has
    pub family: LikelihoodFamily,
    /// whether noise acts on the energy kept, too
    pub both: bool,
    /// measurement errors of the rebounds and of the stuck runs; empty where there are none
    pub rebounds: Vec<Errors>,
    pub stuck: Vec<Errors>,
    /// dry runs; empty where their sums say the same
    pub dry: Vec<DryRow>,
    /// wet runs that have one true speed, group by group
    pub shared: Vec<SharedRuns<WetPlace>>,
    /// the groups of the dry runs, each setting with its sphere
    pub dry_shared: Vec<SharedRuns<usize>>,
}

/// Where the parameters of a wet setting are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WetPlace {
    pub block: usize,
    pub film: NodeFilm,
}

impl ByRow {
    /// Whether all rebounds have σ for their spread, so that they may be summed together.
    pub fn spreads_are_one(&self) -> bool {
        !self.both && self.rebounds.is_empty()
    }
}
