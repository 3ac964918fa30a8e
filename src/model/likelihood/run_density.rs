//! Holds what one run adds to the log likelihood, with its slopes, and what all runs add up to.

/// What is known of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Seen {
    /// it rebounded with this restitution
    Rebound(f64),
    /// it came out on a side of this restitution
    On(Side, f64),
    /// it was measured on a side of this restitution, as if nothing stuck
    Measured(Side, f64),
}

/// A side of a restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    /// at or below it
    Below,
    /// above it
    Above,
}

impl Side {
    /// 1 below, −1 above.
    pub fn sign(self) -> f64 {
        match self {
            Side::Below => 1.0,
            Side::Above => -1.0,
        }
    }
}

/// The logarithm of the density of noise at a z, or of the probability of less, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct LnOfNoise {
    pub value: f64,
    /// in z
    pub z: f64,
    /// in the shape of the noise
    pub shape: f64,
}

/// The log density or log probability of a run, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct RunDensity {
    pub value: f64,
    /// in σ
    pub sigma: f64,
    /// in σ_r
    pub energy: f64,
    /// in the shape of the noise
    pub shape: f64,
    /// in r; in e_dry of a dry run
    pub kept: f64,
    /// in −L
    pub viscous: f64,
    /// in k
    pub dry_k: f64,
}

impl RunDensity {
    /// Adds so many runs alike.
    pub fn add(&mut self, more: RunDensity, count: f64) {
        self.value += count * more.value;
        self.sigma += count * more.sigma;
        self.energy += count * more.energy;
        self.shape += count * more.shape;
        self.kept += count * more.kept;
        self.viscous += count * more.viscous;
        self.dry_k += count * more.dry_k;
    }
}

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
