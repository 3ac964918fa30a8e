//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + σ z; on the energy kept as well: e* = m(r + σ_r z′) + σ z, whose density is integrated
//! over z′ (`convolution.rs`). A rebound's measured restitution errs by u besides, so that σ² + u² stands in the place of
//! σ². Where the impact speed errs, the true one is integrated over (`hidden_speed.rs`).
//!
//! F is normal, or Student's with one ν for all runs; two noises of one run then share what widens them. A stuck run was not
//! measured, so that only its impact speed errs.

use std::ops::Range;

use super::errors::Errors;
use super::nodes::Nodes;
use super::prepared::Likelihood;
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::run_law::{ByRow, RunImpact, RunNoise};
use super::sums::BlockSums;
use super::tails::Tails;
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::{Balance, Impact};

/// The noise of wet runs at a full vector of parameters, where runs are taken one at a time.
#[derive(Clone, Copy)]
pub(super) struct RowNoise<'l> {
    pub own: &'l ByRow,
    pub noise: RunNoise,
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
        let RowNoise { own, noise } = *noise;
        let balance = rows.balance;
        let mut all = RunDensity::default();
        let mut add = |run: RunImpact, seen: Seen, count: f64| {
            let of = noise.density(run, seen);
            all.value += count * of.value;
            all.sigma += count * of.sigma;
            all.energy += count * of.energy;
            all.nu += count * of.nu;
            sums.kept += count * of.kept;
            sums.viscous += count * of.viscous;
            sums.dry -= 0.5 * count * of.dry_k;
        };
        let run = |nodes: &Nodes, errors: &[Errors], node: usize| RunImpact {
            balance,
            impact: nodes.impact(node),
            errors: errors.get(node).copied().unwrap_or(Errors::NONE),
        };
        for node in rows.rebounds {
            let run = run(&self.rebounds, &own.rebounds, node);
            add(run, Seen::Rebound(self.rebounds.restitution[node]), 1.0);
            if self.truncated {
                add(run, Seen::On(Side::Above, self.limit), -1.0);
            }
        }
        for node in rows.stuck {
            let run = run(&self.stuck, &own.stuck, node);
            add(run, Seen::On(Side::Below, self.limit), self.stuck.count[node]);
        }
        slopes[ParameterKind::SigmaWet.slot()] += all.sigma;
        slopes[ParameterKind::SigmaEnergy.slot()] += all.energy;
        slopes[ParameterKind::Nu.slot()] += all.nu;
        all.value
    }

    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn of_dry_rows(&self, own: &ByRow, tails: Tails, full: &[f64], slopes: &mut [f64]) -> f64 {
        let noise = RunNoise {
            tails,
            spreads: Spreads {
                sigma: full[ParameterKind::SigmaDry.slot()],
                energy: 0.0,
            },
            wet: false,
        };
        let mut value = 0.0;
        for row in &own.dry {
            let place_of_k = COMMON_SLOTS + row.sphere;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let run = RunImpact {
                balance: &balance,
                impact: Impact {
                    dry_root: row.dry_root,
                    over_stokes: 0.0,
                    fixed: [0.0; 2],
                },
                errors: row.errors,
            };
            let mut add = |seen: Seen, count: f64| {
                let of = noise.density(run, seen);
                value += count * of.value;
                slopes[place_of_k] += count * of.dry_k;
                slopes[ParameterKind::SigmaDry.slot()] += count * of.sigma;
                slopes[ParameterKind::Nu.slot()] += count * of.nu;
            };
            match row.restitution {
                Some(e) => {
                    add(Seen::Rebound(e), 1.0);
                    if self.truncated {
                        add(Seen::On(Side::Above, self.limit), -1.0);
                    }
                }
                None => add(Seen::On(Side::Below, self.limit), 1.0),
            }
        }
        value
    }
}
