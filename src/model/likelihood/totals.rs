//! Holds what the runs add up to while they are gone through.

use super::run_density::RunDensity;

/// Sums over the runs of a block, w being the slope of a run in r: Σ w, Σ w x, Σ w dr/dk, Σ w G with G = g exp(C′ f),
/// Σ w dG/dδ̃0, Σ w x f and Σ w G f.
pub(super) type BlockSums = [f64; 7];

/// What the runs add up to.
#[derive(Debug)]
pub(super) struct Totals {
    /// log likelihood with its slopes in the noise, of the dry runs and of the wet ones
    pub of_kind: [RunDensity; 2],
    /// slopes in what runs keep, block by block
    pub blocks: Vec<BlockSums>,
}
