//! Places a run on the scale its noise is symmetric on, and says how wide, with the measurement errors of its own.

use super::errors::{Errors, MeanKept};
use super::nodes::{DryRow, Nodes};
use crate::physics::balance::Balance;
use crate::physics::rebound::{kept_of_mean_restitution, mean_and_slope, slope_mean_restitution};

/// What runs have of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ByRow {
    /// whether noise has Student's tails
    pub student: bool,
    /// the rebounds on the scale of the energy kept, where noise acts there, too
    pub energies: Option<EnergyScales>,
    /// measurement errors of the rebounds and of the stuck runs; empty where there are none
    pub rebounds: Vec<Errors>,
    pub stuck: Vec<Errors>,
    /// dry runs; empty where their sums say the same
    pub dry: Vec<DryRow>,
}

/// The rebounds on the scale of the energy kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct EnergyScales {
    pub(super) rebounds: Vec<EnergyScale>,
    pub(super) limit: EnergyScale,
}

/// A restitution on the scale of the energy kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EnergyScale {
    /// y = m⁻¹(e)
    pub kept: f64,
    /// e
    pub(super) restitution: f64,
    /// 1/m′(y)²
    pub stretch: f64,
}

/// The spreads of wet runs.
#[derive(Debug, Clone, Copy)]
pub struct Spreads {
    /// σ
    pub sigma: f64,
    /// σ_r; 0 where noise acts on the restitution alone
    pub energy: f64,
}

/// Where a run lies on the scale its noise is symmetric on, and how wide, with slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// m(r), or r
    pub mean: f64,
    /// slope of the mean in r
    pub(super) mean_slope: f64,
    /// S²
    pub variance: f64,
    /// slopes of S² in r and in dr/dv
    pub(super) variance_slopes: [f64; 2],
    /// slopes of S² in σ and σ_r
    pub(super) of_spreads: [f64; 2],
}

impl ByRow {
    /// Whether all rebounds have σ for their spread, so that they may be summed together.
    pub fn spreads_are_one(&self) -> bool {
        self.energies.is_none() && self.rebounds.is_empty()
    }
}

impl EnergyScale {
    pub fn of(restitution: f64) -> EnergyScale {
        let kept = kept_of_mean_restitution(restitution);
        let slope = slope_mean_restitution(kept);
        EnergyScale {
            kept,
            restitution,
            stretch: 1.0 / (slope * slope),
        }
    }

    /// A run that keeps r on average, seen from here.
    pub fn place(self, spreads: Spreads, kept: MeanKept, errors: Errors) -> Placed {
        let Spreads { sigma, energy } = spreads;
        // a restitution of 0 shares nothing with the speed
        let speed_part = self.restitution * errors.slowness * self.stretch.sqrt() + kept.speed_slope;
        let square = errors.speed * errors.speed;
        Placed {
            mean: kept.r,
            mean_slope: 1.0,
            variance: energy * energy
                + (sigma * sigma + errors.restitution) * self.stretch
                + square * speed_part * speed_part,
            variance_slopes: [0.0, 2.0 * square * speed_part],
            of_spreads: [2.0 * sigma * self.stretch, 2.0 * energy],
        }
    }
}

impl EnergyScales {
    pub fn new(rebounds: &Nodes, limit: f64) -> EnergyScales {
        EnergyScales {
            rebounds: rebounds.restitution.iter().map(|e| EnergyScale::of(*e)).collect(),
            limit: EnergyScale::of(limit),
        }
    }
}

/// A run on the scale of the restitution that keeps r on average; `shares` whether its restitution was measured with the
/// same speed.
pub(super) fn place_restitution(sigma: f64, kept: MeanKept, errors: Errors, shares: bool) -> Placed {
    let MeanKept { r, speed_slope } = kept;
    let (mean, mean_slope) = mean_and_slope(r);
    let mut placed = Placed {
        mean,
        mean_slope,
        variance: sigma * sigma + errors.restitution,
        variance_slopes: [0.0; 2],
        of_spreads: [2.0 * sigma, 0.0],
    };
    if errors.speed > 0.0 {
        let step = errors.speed * speed_slope;
        let ((above, above_slope), (below, below_slope)) = (mean_and_slope(r + step), mean_and_slope(r - step));
        let share = if shares { errors.speed * errors.slowness } else { 0.0 };
        let speed_part = share * mean + 0.5 * (above - below);
        placed.variance += speed_part * speed_part;
        placed.variance_slopes = [
            2.0 * speed_part * (share * mean_slope + 0.5 * (above_slope - below_slope)),
            speed_part * errors.speed * (above_slope + below_slope),
        ];
    }
    placed
}

/// A dry run on the scale of the restitution.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedDry {
    /// e_dry
    pub mean: f64,
    /// S²
    pub variance: f64,
    /// slope of S² in k
    pub variance_slope: f64,
}

/// A dry run of mean e_dry and S² = σ² + u² + s² (e_dry/v + de_dry/dv)².
pub(super) fn place_dry(balance: &Balance, p: f64, sigma: f64, errors: Errors, shares: bool) -> PlacedDry {
    let [e_dry, slope_k, bend_k] = balance.e_dry(p);
    let own = sigma * sigma + errors.restitution;
    if errors.speed == 0.0 {
        return PlacedDry {
            mean: e_dry,
            variance: own,
            variance_slope: 0.0,
        };
    }
    let share = f64::from(u8::from(shares));
    // v d/dv is a fifth of k d/dk
    let speed_part = errors.speed * errors.slowness * (share * e_dry + 0.2 * balance.dry_k * slope_k);
    let slope = errors.speed * errors.slowness * (share * slope_k + 0.2 * (slope_k + balance.dry_k * bend_k));
    PlacedDry {
        mean: e_dry,
        variance: own + speed_part * speed_part,
        variance_slope: 2.0 * speed_part * slope,
    }
}

/// z of a restitution, (y − r)/S: a run that keeps r on average, with these spreads σ and σ_r, comes out lower with the
/// probability F(z).
pub fn on_energies(restitution: f64, r: f64, spreads: Spreads) -> f64 {
    let at = EnergyScale::of(restitution);
    let kept = MeanKept { r, speed_slope: 0.0 };
    let placed = at.place(spreads, kept, Errors::default());
    (at.kept - r) / placed.variance.sqrt()
}
