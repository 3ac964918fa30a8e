//! Holds the runs of a scene as the likelihood reads them: wet ones as nodes in blocks, dry ones as sums.

use super::dry_sums::DryRuns;
use super::nodes::{Nodes, WetBlock};
use super::run_law::ByRow;
use super::tails::Tails;
use super::trend::{FilmLosses, FilmParameters};
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;
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
    /// the different film ratios: the shape of the inertial loss is computed once for each
    pub(super) film_ratios: Vec<f64>,
    /// f of each of them
    pub(super) ln_films: Vec<f64>,
    pub(super) rebounds: Nodes,
    pub(super) stuck: Nodes,
    /// what runs have of their own, where they are taken one at a time
    pub(super) own: Option<ByRow>,
    /// wet runs that rebounded
    pub(super) wet_rebounds: f64,
    /// what the nodes leave of the wet rebounds' sum of squares
    pub(super) leftover: f64,
    pub(super) dry: Vec<DryRuns>,
}

impl Likelihood {
    /// Whether the likelihood is one of rows and cannot be compressed, because runs have spreads or tails of their own.
    pub fn needs_rows(&self) -> bool {
        self.own.is_some()
    }

    /// Nodes of wet runs, rebounded and stuck: the cost of one evaluation.
    pub fn nodes(&self) -> usize {
        self.rebounds.len() + self.stuck.len()
    }

    /// The energy balance of a block at a full vector of parameters, which `film` has read.
    pub(super) fn balance(&self, block: &WetBlock, full: &[f64], film: &FilmLosses) -> Balance {
        let balance = film.balance(self.form, full[COMMON_SLOTS + block.sphere], block.density_ratio);
        block.offset.map_or(balance, |slot| balance.with_offset(full[slot]))
    }

    /// The tails of noise at a full vector of parameters.
    pub(super) fn tails(&self, full: &[f64]) -> Tails {
        let student = self.own.as_ref().is_some_and(|own| own.student);
        Tails::of(student.then(|| full[ParameterKind::Nu.slot()]))
    }

    /// What the parameters say at a film ratio, by its index.
    #[inline]
    pub(super) fn film(&self, film: usize, parameters: &FilmParameters) -> FilmLosses {
        parameters.losses(self.film_ratios[film], self.ln_films[film])
    }
}
