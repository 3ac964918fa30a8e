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
    /// Of so many runs alike.
    pub fn times(self, count: f64) -> RunDensity {
        RunDensity {
            value: count * self.value,
            sigma: count * self.sigma,
            energy: count * self.energy,
            shape: count * self.shape,
            kept: count * self.kept,
            viscous: count * self.viscous,
            dry_k: count * self.dry_k,
        }
    }
}
