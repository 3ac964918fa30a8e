//! Holds the runs of a scene as the likelihood reads them: wet ones as nodes in blocks, dry ones as sums.

use super::dry_sums::DryRuns;
use super::nodes::{Nodes, WetBlock};
use super::own_rows::ByRow;
use super::tails::Tails;
use super::trend::{BlockLaw, FilmParameters};
use crate::model::parameters::{COMMON_SLOTS, SHAPE_SLOT};
use crate::physics::Form;

/// The log likelihood of the runs of a scene as a function of a full vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Likelihood {
    pub(super) form: Form,
    /// at or below this e* the run stuck
    pub(super) limit: f64,
    /// whether runs that stuck were not logged, so that a rebound's density is that of runs that rebound
    pub(super) truncated: bool,
    pub(super) blocks: Vec<WetBlock>,
    pub(super) rebounds: Nodes,
    pub(super) stuck: Nodes,
    /// what runs have of their own, where they are taken one at a time
    pub(super) own: Option<ByRow>,
    /// wet runs that rebounded
    pub(super) wet_rebounds: f64,
    /// sum of squares of the wet rebounds about the means of their settings
    pub(super) leftover: f64,
    pub(super) dry: Vec<DryRuns>,
}

impl Likelihood {
    /// Whether it takes one run at a time, because these have spreads or tails of their own.
    pub fn needs_rows(&self) -> bool {
        self.own.is_some()
    }

    /// Nodes of wet runs, rebounded and stuck: different settings, or runs where these are taken one at a time.
    pub fn nodes(&self) -> usize {
        self.rebounds.len() + self.stuck.len()
    }

    /// The energy balance of a block at a full vector of parameters, which `films` has read.
    pub(super) fn law(&self, block: &WetBlock, full: &[f64], films: FilmParameters) -> BlockLaw {
        BlockLaw {
            films,
            dry_k: full[COMMON_SLOTS + block.sphere],
            density_ratio: block.density_ratio,
            offset: block.offset.map_or(0.0, |slot| full[slot]),
        }
    }

    /// The tails of noise at a full vector of parameters.
    pub(super) fn tails(&self, full: &[f64]) -> Tails {
        let own = self.own.as_ref();
        own.map_or(Tails::Normal, |own| Tails::of(own.family, full[SHAPE_SLOT]))
    }
}
