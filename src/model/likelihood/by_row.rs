//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + S z, with S² = σ² + u² + t². Here u is what the run's own restitution errs by, and t
//! what its impact speed does, which e = v_r/v shares: t = s m(r)/v + ½ (m(r + h) − m(r − h)), h = s dr/dv. Half a
//! difference in place of a slope, because m turns more sharply at the threshold than a speed is known.
//!
//! On the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound e is taken to the energy's scale, y = m⁻¹(e), where it
//! has the spread S² = σ_r² + (σ² + u²)/m′(y)² + s² (e/(v m′(y)) + dr/dv)² about r: exact without σ, and to first order
//! in σ with it. A run sticks with the probability F((y_l − r)/S_l), y_l and S_l belonging to the limit. A restitution at
//! or below zero has no place where the limit is not negative, so that a rebound's y is always above y_l.
//!
//! F is normal, or Student's with one ν for all runs. A stuck run was not measured, so that only its impact speed errs.

use std::ops::Range;

use super::errors::Errors;
use super::nodes::Nodes;
use super::placed::{place, place_dry, ByRow, Placed, Spreads};
use super::prepared::Likelihood;
use super::sums::Sums;
use super::tails::Tails;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::balance::Balance;

impl Likelihood {
    /// Log likelihood of some rebounds and some stuck runs of a block; adds its slopes in the spreads and in ν, and in r to
    /// `sums`.
    pub(super) fn one_by_one(
        &self,
        own: &ByRow,
        (rebounds, stuck): (Range<usize>, Range<usize>),
        balance: &Balance,
        (tails, spreads): (Tails, Spreads),
        slopes: &mut [f64],
        sums: &mut Sums,
    ) -> f64 {
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
        for node in rebounds {
            let errors = own.rebounds.get(node).copied().unwrap_or(none);
            let kept = errors.kept_and_by_speed(balance, &self.rebounds.impact(node));
            let (placed, e, stretch) = match &own.energies {
                Some(energies) => {
                    let at = energies.rebounds[node];
                    (at.place(spreads, kept, errors), at.kept, at.stretch)
                }
                None => {
                    let placed = place(spreads.sigma, kept, errors, true);
                    (placed, self.rebounds.restitution[node], 1.0)
                }
            };
            let density = tails.ln_density(e - placed.mean, placed.variance, stretch);
            value += density.value;
            of_nu += density.nu;
            add(&self.rebounds, node, errors, placed, density.mean, density.variance);
            if self.truncated {
                let placed = self.place_limit(own, spreads, kept, errors, true);
                let limit = own.energies.as_ref().map_or(self.limit, |energies| energies.limit.kept);
                let side = Side::of(tails, -1.0, limit, &placed);
                value -= side.value;
                of_nu -= side.nu;
                add(&self.rebounds, node, errors, placed, -side.mean, -side.variance);
            }
        }
        for node in stuck {
            let errors = own.stuck.get(node).copied().unwrap_or(none).of_speed_alone();
            let kept = errors.kept_and_by_speed(balance, &self.stuck.impact(node));
            let placed = self.place_limit(own, spreads, kept, errors, false);
            let limit = own.energies.as_ref().map_or(self.limit, |energies| energies.limit.kept);
            let side = Side::of(tails, 1.0, limit, &placed);
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
        slopes[Kind::SigmaWet.slot()] += of_spreads[0];
        slopes[Kind::SigmaEnergy.slot()] += of_spreads[1];
        slopes[Kind::Nu.slot()] += of_nu;
        value
    }

    /// A run as seen from the limit.
    fn place_limit(&self, own: &ByRow, spreads: Spreads, kept: (f64, f64), errors: Errors, shares: bool) -> Placed {
        let errors = if shares { errors } else { errors.of_speed_alone() };
        match &own.energies {
            Some(energies) => energies.limit.place(spreads, kept, errors),
            None => place(spreads.sigma, kept, errors, shares),
        }
    }

    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn of_dry_rows(&self, own: &ByRow, tails: Tails, full: &[f64], slopes: &mut [f64]) -> f64 {
        let sigma = full[Kind::SigmaDry.slot()];
        let mut value = 0.0;
        for row in &own.dry {
            let place_of_k = COMMON_SLOTS + row.particle;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let rebounded = row.restitution.is_some();
            let errors = if rebounded {
                row.errors
            } else {
                row.errors.of_speed_alone()
            };
            let (mean, variance, variance_slope) = place_dry(&balance, row.dry_root, sigma, errors, rebounded);
            let [_, slope_k, _] = balance.e_dry(row.dry_root);
            let mut add = |sign: f64, of: (f64, f64, f64, f64)| {
                let (told, of_mean, of_variance, of_nu) = of;
                value += sign * told;
                slopes[place_of_k] += sign * (of_variance * variance_slope + of_mean * slope_k);
                slopes[Kind::SigmaDry.slot()] += sign * of_variance * 2.0 * sigma;
                slopes[Kind::Nu.slot()] += sign * of_nu;
            };
            let placed = Placed {
                mean,
                mean_slope: 1.0,
                variance,
                variance_slopes: [0.0; 2],
                of_spreads: [0.0; 2],
            };
            let side = |sign: f64| {
                let side = Side::of(tails, sign, self.limit, &placed);
                (side.value, side.mean, side.variance, side.nu)
            };
            match row.restitution {
                Some(e) => {
                    let density = tails.ln_density(e - mean, variance, 1.0);
                    add(1.0, (density.value, density.mean, density.variance, density.nu));
                    if self.truncated {
                        add(-1.0, side(-1.0));
                    }
                }
                None => add(1.0, side(1.0)),
            }
        }
        value
    }
}

/// ln F(± (limit − mean)/S), with its slopes in the mean, in S² and in ν.
struct Side {
    value: f64,
    mean: f64,
    variance: f64,
    nu: f64,
}

impl Side {
    fn of(tails: Tails, sign: f64, limit: f64, placed: &Placed) -> Side {
        let spread = placed.variance.sqrt();
        let z = sign * (limit - placed.mean) / spread;
        let probability = tails.ln_probability(z);
        Side {
            value: probability.value,
            mean: -sign * probability.z / spread,
            variance: -0.5 * probability.z * z / placed.variance,
            nu: probability.nu,
        }
    }
}
