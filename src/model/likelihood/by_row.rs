//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + σ z; on the energy kept as well: e* = m(r + σ_r z′) + σ z, whose density is integrated
//! over z′ (`convolution.rs`). A rebound's measured restitution errs by u besides, so that σ² + u² stands in the place of
//! σ². Where the impact speed errs, the true one is integrated over (`hidden_speed.rs`).
//!
//! F is normal, or Student's with one ν for all runs; two noises of one run then share what widens them. A stuck run was not
//! measured, so that only its impact speed errs.

use std::ops::Range;

use super::block_sums::BlockSums;
use super::errors::Errors;
use super::hidden_speed::MeasuredRun;
use super::nodes::DryRow;
use super::prepared::Likelihood;
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::run_law::{ByRow, RunImpact, RunNoise, WetRow};
use super::tails::Tails;
use super::trend::{BlockLaw, FilmLaw};
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
    pub law: &'b BlockLaw,
    /// those of one true speed, group by group
    pub repeats: &'b [Vec<WetRow>],
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
        let mut films = self.rebounds.films(rows.law);
        let mut films_of_stuck = self.stuck.films(rows.law);
        let mut all = RunDensity::default();
        let mut add = |film: &FilmLaw, of: RunDensity, count: f64| {
            all.value += count * of.value;
            all.sigma += count * of.sigma;
            all.energy += count * of.energy;
            all.nu += count * of.nu;
            film.add(sums, count * of.kept, count * of.viscous, -0.5 * count * of.dry_k);
        };
        let errors = |all: &[Errors], node: usize| all.get(node).copied().unwrap_or(Errors::NONE);
        let rebounded = Seen::On(Side::Above, self.limit);
        let stuck = Seen::On(Side::Below, self.limit);
        for node in rows.rebounds {
            let errors = errors(&own.rebounds, node);
            if errors.is_shared {
                continue;
            }
            let film = films.at(node);
            let run = RunImpact {
                balance: &film.balance,
                impact: self.rebounds.impact(node),
                errors,
            };
            let seen = Seen::Rebound(self.rebounds.restitution[node]);
            add(&film, noise.density(run, seen), 1.0);
            if self.truncated {
                add(&film, noise.density(run, rebounded), -1.0);
            }
        }
        for node in rows.stuck {
            let errors = errors(&own.stuck, node);
            if !errors.is_shared {
                let film = films_of_stuck.at(node);
                let run = RunImpact {
                    balance: &film.balance,
                    impact: self.stuck.impact(node),
                    errors,
                };
                add(&film, noise.density(run, stuck), self.stuck.count[node]);
            }
        }
        let mut over = |rows: &[WetRow], seen: &dyn Fn(&WetRow) -> Seen, count: f64| {
            let known = rows.iter().map(|row| MeasuredRun {
                seen: seen(row),
                errors: match *row {
                    WetRow::Rebound(node) => own.rebounds[node],
                    WetRow::Stuck(node) => own.stuck[node],
                },
            });
            let known: Vec<MeasuredRun> = known.collect();
            let (impact, film) = match rows[0] {
                WetRow::Rebound(node) => (self.rebounds.impact(node), films.at(node)),
                WetRow::Stuck(node) => (self.stuck.impact(node), films_of_stuck.at(node)),
            };
            let of = noise.repeats(&film.balance, impact, &known).integrate();
            add(&film, of, count);
        };
        for group in rows.repeats {
            let seen = |row: &WetRow| match *row {
                WetRow::Rebound(node) => Seen::Rebound(self.rebounds.restitution[node]),
                WetRow::Stuck(_) => stuck,
            };
            over(group, &seen, 1.0);
            let rebounds = group.iter().filter(|row| matches!(row, WetRow::Rebound(_)));
            let rebounds: Vec<WetRow> = rebounds.copied().collect();
            if self.truncated && !rebounds.is_empty() {
                over(&rebounds, &|_| rebounded, -1.0);
            }
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
        let mut add = |place_of_k: usize, of: RunDensity, count: f64| {
            value += count * of.value;
            slopes[place_of_k] += count * of.dry_k;
            slopes[ParameterKind::SigmaDry.slot()] += count * of.sigma;
            slopes[ParameterKind::Nu.slot()] += count * of.nu;
        };
        let rebounded = Seen::On(Side::Above, self.limit);
        let seen = |row: &DryRow| row.restitution.map_or(Seen::On(Side::Below, self.limit), Seen::Rebound);
        let impact = |row: &DryRow| Impact {
            dry_root: row.dry_root,
            over_stokes: 0.0,
            fixed: [0.0; 2],
        };
        for row in own.dry.iter().filter(|row| !row.errors.is_shared) {
            let place_of_k = COMMON_SLOTS + row.sphere;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let run = RunImpact {
                balance: &balance,
                impact: impact(row),
                errors: row.errors,
            };
            add(place_of_k, noise.density(run, seen(row)), 1.0);
            if self.truncated && row.restitution.is_some() {
                add(place_of_k, noise.density(run, rebounded), -1.0);
            }
        }
        for group in &own.dry_repeats {
            let first = &own.dry[group[0]];
            let place_of_k = COMMON_SLOTS + first.sphere;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let known = |rows: &[&DryRow], seen: &dyn Fn(&DryRow) -> Seen| -> Vec<MeasuredRun> {
                let each = rows.iter().map(|row| MeasuredRun {
                    seen: seen(row),
                    errors: row.errors,
                });
                each.collect()
            };
            let rows: Vec<&DryRow> = group.iter().map(|row| &own.dry[*row]).collect();
            let all = known(&rows, &seen);
            add(
                place_of_k,
                noise.repeats(&balance, impact(first), &all).integrate(),
                1.0,
            );
            let rebounds: Vec<&DryRow> = rows.into_iter().filter(|row| row.restitution.is_some()).collect();
            if let Some(first) = rebounds.first().filter(|_| self.truncated) {
                let all = known(&rebounds, &|_| rebounded);
                add(
                    place_of_k,
                    noise.repeats(&balance, impact(first), &all).integrate(),
                    -1.0,
                );
            }
        }
        value
    }
}
