//! Holds what one run adds to the log likelihood, with its slopes.

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

/// The spreads of wet runs.
#[derive(Debug, Clone, Copy)]
pub struct Spreads {
    /// σ
    pub sigma: f64,
    /// σ_r; 0 where noise acts on the restitution alone
    pub energy: f64,
}

/// The logarithm of the density of noise at a z, or of the probability of less, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LnOfNoise {
    pub value: f64,
    /// in z
    pub z: f64,
    /// in the shape of the noise
    pub shape: f64,
}

/// What sums over rebounds of one spread read of their noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Summed {
    /// ν; `None` of normal noise
    pub nu: Option<f64>,
    /// c, and the slope of ln c in ν
    pub stretch: f64,
    pub stretch_slope: f64,
    /// ln of the density at 0, and its slope in ν
    pub peak: f64,
    pub peak_slope: f64,
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
