//! Places a run on the scale its noise is symmetric on, and says how wide, with the measurement errors of its own.

use super::errors::Errors;
use super::nodes::{DryRow, Nodes};
use crate::physics::balance::Balance;
use crate::physics::rebound::{kept_of_mean_restitution, mean_and_slope, slope_mean_restitution};

/// What runs have of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ByRow {
    /// whether noise has Student's tails
    pub student: bool,
    /// the rebounds on the scale of the energy kept, where noise acts there, too
    pub energies: Option<Energies>,
    /// measurement errors of the rebounds and of the stuck runs; empty where there are none
    pub rebounds: Vec<Errors>,
    pub stuck: Vec<Errors>,
    /// dry runs; empty where their sums say the same
    pub dry: Vec<DryRow>,
}

/// The rebounds on the scale of the energy kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Energies {
    pub(super) rebounds: Vec<Energy>,
    pub(super) limit: Energy,
}

/// A restitution on the scale of the energy kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Energy {
    /// y = m⁻¹(e)
    pub kept: f64,
    /// e
    pub(super) restitution: f64,
    /// 1/m′(y)²
    pub stretch: f64,
}

/// The spreads of wet runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spreads {
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

impl Energy {
    pub fn of(restitution: f64) -> Energy {
        let kept = kept_of_mean_restitution(restitution);
        let slope = slope_mean_restitution(kept);
        Energy {
            kept,
            restitution,
            stretch: 1.0 / (slope * slope),
        }
    }

    /// A run that keeps r on average, seen from here.
    pub fn place(self, spreads: Spreads, (r, by_speed): (f64, f64), errors: Errors) -> Placed {
        let Spreads { sigma, energy } = spreads;
        // a restitution of 0 shares nothing with the speed
        let moved = self.restitution * errors.slowness * self.stretch.sqrt() + by_speed;
        let square = errors.speed * errors.speed;
        Placed {
            mean: r,
            mean_slope: 1.0,
            variance: energy * energy + (sigma * sigma + errors.restitution) * self.stretch + square * moved * moved,
            variance_slopes: [0.0, 2.0 * square * moved],
            of_spreads: [2.0 * sigma * self.stretch, 2.0 * energy],
        }
    }
}

impl Energies {
    pub fn new(rebounds: &Nodes, limit: f64) -> Energies {
        Energies {
            rebounds: rebounds.restitution.iter().map(|e| Energy::of(*e)).collect(),
            limit: Energy::of(limit),
        }
    }
}

/// A run on the scale of the restitution that keeps r on average; `shares` whether its restitution was measured with the
/// same speed.
pub(super) fn place(sigma: f64, (r, by_speed): (f64, f64), errors: Errors, shares: bool) -> Placed {
    let (mean, mean_slope) = mean_and_slope(r);
    let mut placed = Placed {
        mean,
        mean_slope,
        variance: sigma * sigma + errors.restitution,
        variance_slopes: [0.0; 2],
        of_spreads: [2.0 * sigma, 0.0],
    };
    if errors.speed > 0.0 {
        let step = errors.speed * by_speed;
        let ((above, above_slope), (below, below_slope)) = (mean_and_slope(r + step), mean_and_slope(r - step));
        let share = if shares { errors.speed * errors.slowness } else { 0.0 };
        let moved = share * mean + 0.5 * (above - below);
        placed.variance += moved * moved;
        placed.variance_slopes = [
            2.0 * moved * (share * mean_slope + 0.5 * (above_slope - below_slope)),
            moved * errors.speed * (above_slope + below_slope),
        ];
    }
    placed
}

/// A dry run's mean e_dry and S² = σ² + u² + s² (e_dry/v + de_dry/dv)², as (mean, variance, slope of the variance in k).
pub(super) fn place_dry(balance: &Balance, p: f64, sigma: f64, errors: Errors, shares: bool) -> (f64, f64, f64) {
    let [e_dry, slope_k, bend_k] = balance.e_dry(p);
    let own = sigma * sigma + errors.restitution;
    if errors.speed == 0.0 {
        return (e_dry, own, 0.0);
    }
    let share = f64::from(u8::from(shares));
    // v d/dv is a fifth of k d/dk
    let moved = errors.speed * errors.slowness * (share * e_dry + 0.2 * balance.dry_k * slope_k);
    let slope = errors.speed * errors.slowness * (share * slope_k + 0.2 * (slope_k + balance.dry_k * bend_k));
    (e_dry, own + moved * moved, 2.0 * moved * slope)
}

/// z of a restitution, (y − r)/S: a run that keeps r on average, with these spreads σ and σ_r, comes out lower with the
/// probability F(z).
pub fn on_energies(restitution: f64, kept: f64, (sigma, energy): (f64, f64)) -> f64 {
    let at = Energy::of(restitution);
    let placed = at.place(Spreads { sigma, energy }, (kept, 0.0), Errors::default());
    (at.kept - kept) / placed.variance.sqrt()
}
