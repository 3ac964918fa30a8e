//! Holds the log density of every run at the draws of a posterior: what leaves runs out and what is written both read it.

use std::ops::Range;

use rayon::prelude::*;

use crate::inference::sampling::Sampled;
use crate::model::likelihood::pointwise::Pointwise;
use crate::physics::Form;
use crate::runs::Runs;
use crate::scene::Scene;

/// Log densities, runs times draws, that may be computed for one model; of the scene's own they are held, in 160 MB.
pub const MOST_DENSITIES: usize = 20_000_000;

/// Fewer draws than this do not carry the weights that leave runs out.
pub const FEWEST_DRAWS: usize = 400;

/// How many of the draws can leave each run out; `None` for too many runs, or few that stand for them.
pub fn affordable_draws(runs: &Runs, draws: usize) -> Option<usize> {
    let used = draws.min(MOST_DENSITIES / runs.all_measured().max(1));
    (used >= FEWEST_DRAWS.min(draws) && runs.count.is_empty()).then_some(used)
}

/// The log density of every run at the draws that are affordable.
#[derive(Debug)]
pub struct RunDensities {
    /// of all draws, every so many: 1 where each is affordable
    pub step: usize,
    /// how many draws these are
    pub draws: usize,
    rows: Vec<f64>,
}

impl RunDensities {
    /// `None` where too few draws are affordable.
    pub(super) fn of(scene: &Scene, runs: &Runs, form: Form, sampled: &Sampled) -> Option<RunDensities> {
        /// runs that are computed together, since they share what a draw says of their film
        const BLOCK: usize = 16;
        let step = sampled
            .draws()
            .div_ceil(affordable_draws(runs, sampled.draws())?)
            .max(1);
        let full = sampled.full_draws();
        let some: Vec<&[f64]> = full.iter().step_by(step).map(Vec::as_slice).collect();
        let draws = some.len();
        let pointwise = Pointwise::new(scene, runs, form);
        let at = pointwise.at_draws(some);
        let mut rows = vec![0.0; runs.len() * draws];
        let firsts = (0..runs.len()).into_par_iter().step_by(BLOCK);
        let blocks = rows.par_chunks_mut((BLOCK * draws).max(1)).zip(firsts);
        blocks.for_each(|(rows, first)| at.ln_likelihoods(first..runs.len().min(first + BLOCK), rows));
        Some(RunDensities { step, draws, rows })
    }

    /// Those of some runs, a row a run that is as long as there are draws.
    pub fn rows(&self, runs: Range<usize>) -> &[f64] {
        &self.rows[runs.start * self.draws..runs.end * self.draws]
    }

    /// By how much the log density of a run differs between draws.
    pub fn spread(&self, run: usize) -> f64 {
        let row = || self.rows(run..run + 1).iter().copied();
        row().fold(f64::NEG_INFINITY, f64::max) - row().fold(f64::INFINITY, f64::min)
    }
}
