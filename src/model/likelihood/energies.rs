//! Computes the log likelihood where noise acts on the energy kept as well as on the restitution.
//!
//! e* = m(r + σ_r z′) + σ z. A rebound e is taken to the energy's scale, y = m⁻¹(e), where it is normal about r with the
//! variance S² = σ_r² + (σ/m′(y))²: exact without σ, and to first order in σ with it. A run sticks with the probability
//! Φ((y_l − r)/S_l), y_l and S_l belonging to the limit. A restitution at or below zero has no place where the limit is
//! not negative, so that a rebound's y is always above y_l.

use super::normal::ln_normal_cdf;
use super::{Block, Law, Likelihood, Nodes, Sums};
use crate::model::parameters::Kind;
use crate::model::priors::LN_ROOT_TWO_PI;
use crate::physics::rebound::{kept_of_mean_restitution, slope_mean_restitution};

/// The rebounds on the scale of the energy kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Energies {
    rebounds: Vec<Energy>,
    limit: Energy,
}

/// A restitution on the scale of the energy kept.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Energy {
    /// y = m⁻¹(e)
    kept: f64,
    /// 1/m′(y)²
    stretch: f64,
}

impl Energy {
    fn of(restitution: f64) -> Energy {
        let kept = kept_of_mean_restitution(restitution);
        let slope = slope_mean_restitution(kept);
        Energy {
            kept,
            stretch: 1.0 / (slope * slope),
        }
    }
}

/// The spreads of wet runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spreads {
    /// σ
    pub sigma: f64,
    /// σ_r
    pub energy: f64,
}

impl Spreads {
    /// S² at a restitution.
    fn variance(&self, at: Energy) -> f64 {
        self.energy * self.energy + self.sigma * self.sigma * at.stretch
    }
}

/// z of the limit and the variance there, (y_l − r)/S_l: a run that keeps r on average sticks with the probability Φ(z).
pub fn on_energies(limit: f64, kept: f64, (sigma, energy): (f64, f64)) -> f64 {
    let limit = Energy::of(limit);
    (limit.kept - kept) / Spreads { sigma, energy }.variance(limit).sqrt()
}

/// Log density of a rebound that keeps r on average, before any truncation.
pub(super) fn ln_density(restitution: f64, kept: f64, (sigma, energy): (f64, f64)) -> f64 {
    let at = Energy::of(restitution);
    let variance = Spreads { sigma, energy }.variance(at);
    let distance = at.kept - kept;
    -0.5 * (distance * distance / variance + (variance / at.stretch).ln()) - LN_ROOT_TWO_PI
}

impl Energies {
    pub(super) fn new(rebounds: &Nodes, limit: f64) -> Energies {
        Energies {
            rebounds: rebounds.restitution.iter().map(|e| Energy::of(*e)).collect(),
            limit: Energy::of(limit),
        }
    }
}

impl Likelihood {
    /// Log likelihood of a block; adds its slopes in both spreads, and in r to `sums`.
    pub(super) fn of_energies(
        &self,
        energies: &Energies,
        block: &Block,
        law: &Law,
        spreads: Spreads,
        slopes: &mut [f64],
        sums: &mut Sums,
    ) -> f64 {
        let (mut value, mut of_sigma, mut of_energy) = (0.0, 0.0, 0.0);
        let mut add = |nodes: &Nodes, node: usize, slope: f64| {
            let at = nodes.abscissa(node);
            sums.kept += slope;
            sums.viscous += slope * at.viscous;
            sums.dry += slope * law.kept(&at).1;
        };
        let limit = energies.limit;
        let of_limit = spreads.variance(limit);
        // ln Φ(± z) of the limit, with its slopes
        let side = |r: f64, sign: f64| {
            let z = sign * (limit.kept - r) / of_limit.sqrt();
            let (ln_cdf, mills) = ln_normal_cdf(z);
            (ln_cdf, -sign * mills / of_limit.sqrt(), -0.5 * mills * z / of_limit)
        };
        for node in block.rebounds.clone() {
            let (r, _) = law.kept(&self.rebounds.abscissa(node));
            let at = energies.rebounds[node];
            let variance = spreads.variance(at);
            let distance = at.kept - r;
            let square = distance * distance / variance;
            value -= 0.5 * (square + (variance / at.stretch).ln()) + LN_ROOT_TWO_PI;
            let of_variance = 0.5 * (square - 1.0) / variance;
            of_sigma += of_variance * 2.0 * spreads.sigma * at.stretch;
            of_energy += of_variance * 2.0 * spreads.energy;
            let mut slope = distance / variance;
            if self.truncated {
                let (ln_cdf, of_r, of_variance) = side(r, -1.0);
                value -= ln_cdf;
                slope -= of_r;
                of_sigma -= of_variance * 2.0 * spreads.sigma * limit.stretch;
                of_energy -= of_variance * 2.0 * spreads.energy;
            }
            add(&self.rebounds, node, slope);
        }
        for node in block.stuck.clone() {
            let (r, _) = law.kept(&self.stuck.abscissa(node));
            let count = self.stuck.count[node];
            let (ln_cdf, of_r, of_variance) = side(r, 1.0);
            value += count * ln_cdf;
            of_sigma += count * of_variance * 2.0 * spreads.sigma * limit.stretch;
            of_energy += count * of_variance * 2.0 * spreads.energy;
            add(&self.stuck, node, count * of_r);
        }
        slopes[Kind::SigmaWet.slot()] += of_sigma;
        slopes[Kind::SigmaEnergy.slot()] += of_energy;
        value
    }
}
