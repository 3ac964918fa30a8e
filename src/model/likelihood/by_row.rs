//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + S z, with S² = σ² + u² + t². Here u is what the run's own restitution errs by, and t
//! what its impact speed does, which e = v_r/v shares: t = s m(r)/v + ½ (m(r + h) − m(r − h)), h = s dr/dv. Half a
//! difference in place of a slope, because m turns more sharply at the threshold than a speed is measured.
//!
//! On the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound e is taken to the energy's scale, y = m⁻¹(e), where it
//! has the spread S² = σ_r² + (σ² + u²)/m′(y)² + s² (e/(v m′(y)) + dr/dv)² about r: exact without σ, and to first order
//! in σ with it. A run sticks with the probability F((y_l − r)/S_l), y_l and S_l belonging to the limit. A restitution at
//! or below zero has no place where the limit is not negative, so that a rebound's y is always above y_l.
//!
//! F is normal, or Student's with one ν for all runs. A stuck run was not measured, so that only its impact speed errs.

use std::ops::Range;

use super::errors::{Errors, MeanKept};
use super::nodes::Nodes;
use super::placed::{place_dry, place_restitution, ByRow, Placed, Spreads};
use super::prepared::Likelihood;
use super::sums::BlockSums;
use super::tails::{Density, Tails};
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;

/// The noise of wet runs at a full vector of parameters, where runs are taken one at a time.
#[derive(Clone, Copy)]
pub(super) struct RowNoise<'l> {
    pub own: &'l ByRow,
    pub tails: Tails,
    pub spreads: Spreads,
}

/// Runs of a block that are taken one at a time, with its energy balance.
pub(super) struct BlockRows<'b> {
    pub rebounds: Range<usize>,
    pub stuck: Range<usize>,
    pub balance: &'b Balance,
}

impl Likelihood {
    /// Log likelihood of some runs of a block; adds its slopes in the spreads and in ν, and in r to `sums`.
    pub(super) fn run_by_run(
        &self,
        rows: BlockRows,
        noise: &RowNoise,
        slopes: &mut [f64],
        sums: &mut BlockSums,
    ) -> f64 {
        let RowNoise { own, tails, spreads } = *noise;
        let balance = rows.balance;
        let none = Errors::default();
        let (mut value, mut of_spreads, mut of_nu) = (0.0, [0.0; 2], 0.0);
        let mut add = |nodes: &Nodes, node: usize, errors: Errors, placed: Placed, of_mean: f64, of_variance: f64| {
            let at = nodes.impact(node);
            let slope = of_mean * placed.mean_slope + of_variance * placed.variance_slopes[0];
            sums.kept += slope;
            sums.viscous += slope * at.over_stokes;
            sums.dry -= 0.5 * slope * balance.kept(&at).1;
            let slope = of_variance * placed.variance_slopes[1];
            if slope != 0.0 {
                let of_k = balance.in_log_speed_slope_k(&at) * errors.slowness;
                sums.viscous -= slope * at.over_stokes * errors.slowness;
                sums.dry -= 0.5 * slope * of_k;
            }
            for (sum, of_spread) in of_spreads.iter_mut().zip(placed.of_spreads) {
                *sum += of_variance * of_spread;
            }
        };
        for node in rows.rebounds {
            let errors = own.rebounds.get(node).copied().unwrap_or(none);
            let kept = errors.mean_kept(balance, &self.rebounds.impact(node));
            let (placed, e, stretch) = match &own.energies {
                Some(energies) => {
                    let at = energies.rebounds[node];
                    (at.place(spreads, kept, errors), at.kept, at.stretch)
                }
                None => {
                    let placed = place_restitution(spreads.sigma, kept, errors, true);
                    (placed, self.rebounds.restitution[node], 1.0)
                }
            };
            let density = tails.ln_density(e - placed.mean, placed.variance, stretch);
            value += density.value;
            of_nu += density.nu;
            add(&self.rebounds, node, errors, placed, density.mean, density.variance);
            if self.truncated {
                let placed = noise.place_limit(kept, errors, true);
                let side = ln_probability_of_side(tails, -1.0, self.limit_of(own), &placed);
                value -= side.value;
                of_nu -= side.nu;
                add(&self.rebounds, node, errors, placed, -side.mean, -side.variance);
            }
        }
        for node in rows.stuck {
            let errors = own.stuck.get(node).copied().unwrap_or(none).of_speed_alone();
            let kept = errors.mean_kept(balance, &self.stuck.impact(node));
            let placed = noise.place_limit(kept, errors, false);
            let side = ln_probability_of_side(tails, 1.0, self.limit_of(own), &placed);
            let count = self.stuck.count[node];
            value += count * side.value;
            of_nu += count * side.nu;
            add(
                &self.stuck,
                node,
                errors,
                placed,
                count * side.mean,
                count * side.variance,
            );
        }
        slopes[ParameterKind::SigmaWet.slot()] += of_spreads[0];
        slopes[ParameterKind::SigmaEnergy.slot()] += of_spreads[1];
        slopes[ParameterKind::Nu.slot()] += of_nu;
        value
    }

    /// The limit on the scale the noise of wet runs is symmetric on.
    #[inline]
    fn limit_of(&self, own: &ByRow) -> f64 {
        own.energies.as_ref().map_or(self.limit, |energies| energies.limit.kept)
    }

    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn of_dry_rows(&self, own: &ByRow, tails: Tails, full: &[f64], slopes: &mut [f64]) -> f64 {
        let sigma = full[ParameterKind::SigmaDry.slot()];
        let mut value = 0.0;
        for row in &own.dry {
            let place_of_k = COMMON_SLOTS + row.sphere;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let rebounded = row.restitution.is_some();
            let errors = if rebounded {
                row.errors
            } else {
                row.errors.of_speed_alone()
            };
            let dry = place_dry(&balance, row.dry_root, sigma, errors, rebounded);
            let [_, slope_k, _] = balance.e_dry(row.dry_root);
            let mut add = |sign: f64, of: Density| {
                value += sign * of.value;
                slopes[place_of_k] += sign * (of.variance * dry.variance_slope + of.mean * slope_k);
                slopes[ParameterKind::SigmaDry.slot()] += sign * of.variance * 2.0 * sigma;
                slopes[ParameterKind::Nu.slot()] += sign * of.nu;
            };
            let placed = Placed {
                mean: dry.mean,
                mean_slope: 1.0,
                variance: dry.variance,
                variance_slopes: [0.0; 2],
                of_spreads: [0.0; 2],
            };
            match row.restitution {
                Some(e) => {
                    add(1.0, tails.ln_density(e - dry.mean, dry.variance, 1.0));
                    if self.truncated {
                        add(-1.0, ln_probability_of_side(tails, -1.0, self.limit, &placed));
                    }
                }
                None => add(1.0, ln_probability_of_side(tails, 1.0, self.limit, &placed)),
            }
        }
        value
    }
}

impl RowNoise<'_> {
    /// A run as seen from the limit.
    fn place_limit(&self, kept: MeanKept, errors: Errors, shares: bool) -> Placed {
        let errors = if shares { errors } else { errors.of_speed_alone() };
        match &self.own.energies {
            Some(energies) => energies.limit.place(self.spreads, kept, errors),
            None => place_restitution(self.spreads.sigma, kept, errors, shares),
        }
    }
}

/// ln F(± (limit − mean)/S), with its slopes in the mean, in S² and in ν.
fn ln_probability_of_side(tails: Tails, sign: f64, limit: f64, placed: &Placed) -> Density {
    let spread = placed.variance.sqrt();
    let z = sign * (limit - placed.mean) / spread;
    let probability = tails.ln_probability(z);
    Density {
        value: probability.value,
        mean: -sign * probability.z / spread,
        variance: -0.5 * probability.z * z / placed.variance,
        nu: probability.nu,
    }
}
