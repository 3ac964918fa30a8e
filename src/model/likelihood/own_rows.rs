//! Holds what runs have of their own, where they are taken one at a time.

use super::errors::Errors;
use super::hidden_speed::Together;
use super::nodes::{DryRow, NodeFilm};
use super::shared_speed::SharedRuns;

/// What runs have of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ByRow {
    /// whether noise has Student's tails
    pub student: bool,
    /// whether noise acts on the energy kept, too
    pub both: bool,
    /// measurement errors of the rebounds and of the stuck runs; empty where there are none
    pub rebounds: Vec<Errors>,
    pub stuck: Vec<Errors>,
    /// dry runs; empty where their sums say the same
    pub dry: Vec<DryRow>,
    /// wet runs that have one true speed, group by group
    pub shared: Vec<SharedRuns<WetPlace>>,
    /// the wet runs whose impact speeds err
    pub speeds: SpeedParts,
    /// the groups of the dry runs, each setting with its sphere
    pub dry_shared: Vec<SharedRuns<usize>>,
}

/// Where the parameters of a wet setting are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WetPlace {
    pub block: usize,
    pub film: NodeFilm,
}

/// Runs of one true speed, or a run at one of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Part {
    /// node of a rebound
    Rebound(usize),
    /// the same, as a run that was logged because it rebounded
    Logged(usize),
    /// node of a stuck run
    Stuck(usize),
    /// place among those that share a true speed
    Shared(usize),
}

/// The wet runs whose impact speeds err, in parts of one true speed each.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SpeedParts {
    /// each with the number of its first setting
    pub parts: Vec<(Part, usize)>,
    /// where the film of each setting is
    pub settings: Vec<usize>,
    /// each film of a block once
    pub films: Vec<WetPlace>,
    pub together: Together,
    /// parts that may not go with others
    pub apart: Vec<usize>,
}

impl ByRow {
    /// Whether all rebounds have σ for their spread, so that they may be summed together.
    pub fn spreads_are_one(&self) -> bool {
        !self.both && self.rebounds.is_empty()
    }
}
