//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + σ z; on the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound's measured restitution
//! errs by u besides, so that σ² + u² stands in the place of σ². Where the impact speed errs, the true one is integrated over,
//! as z′ is (`hidden.rs`).
//!
//! F is of one family and shape for all runs. A stuck run was not measured, so that only its impact speed errs.

use std::ops::Range;

use super::block_sums::BlockSums;
use super::errors::Errors;
use super::hidden::{Rebounds, MOST_REBOUNDS};
use super::nodes::DryRow;
use super::own_rows::{ByRow, WetPlace};
use super::prepared::Likelihood;
use super::row_noise::{add_noise_slopes, RowNoise};
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::run_law::RunImpact;
use super::run_noise::RunNoise;
use super::shared_speed::SharedSetting;
use super::sums::NodeRange;
use super::tails::Tails;
use super::trend::{BlockLaw, FilmLaw};
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;

/// Runs of a block that are taken one at a time, with its energy balance.
pub(super) struct BlockRows<'b> {
    pub rebounds: Range<usize>,
    pub stuck: Range<usize>,
    pub law: &'b BlockLaw,
}

impl Likelihood {
    /// Log likelihood of some runs of a block but those that share a true speed; adds its slopes in the noise, and in r to
    /// `sums`.
    pub(super) fn run_by_run(
        &self,
        rows: BlockRows,
        noise: &RowNoise,
        (slopes, sums): (&mut [f64], &mut BlockSums),
    ) -> f64 {
        let RowNoise { own, noise } = *noise;
        let rebounded = Seen::On(Side::Above, self.limit);
        let stuck = Seen::On(Side::Below, self.limit);
        let mut all = RunDensity::default();
        let mut add = |film: &FilmLaw, of: RunDensity, count: f64| {
            let of = of.times(count);
            all.value += of.value;
            all.sigma += of.sigma;
            all.energy += of.energy;
            all.shape += of.shape;
            film.add(sums, of.kept, of.viscous, -0.5 * of.dry_k);
        };
        let errors = |all: &[Errors], node: usize| all.get(node).copied().unwrap_or(Errors::NONE);
        let mut films = self.rebounds.films(rows.law);
        let end = rows.rebounds.end;
        for first in rows.rebounds.step_by(MOST_REBOUNDS) {
            let nodes = first..end.min(first + MOST_REBOUNDS);
            let laws: Vec<FilmLaw> = nodes.clone().map(|node| films.at(node)).collect();
            // what a run errs by is its own, and is seen to one run at a time
            let together = own.rebounds.is_empty() && noise.acts_on_every_energy();
            let found = together.then(|| {
                let mut rebounds = Rebounds::NONE;
                for (node, law) in nodes.clone().zip(&laws) {
                    let (kept, _) = law.balance.kept(&self.rebounds.impact(node));
                    rebounds.push(self.rebounds.restitution[node], kept);
                }
                rebounds.densities(noise.spreads)
            });
            for (place, (node, film)) in nodes.zip(&laws).enumerate() {
                let run = RunImpact {
                    balance: &film.balance,
                    impact: self.rebounds.impact(node),
                    errors: errors(&own.rebounds, node),
                };
                if run.errors.is_shared {
                    continue;
                }
                let count = self.rebounds.count[node];
                let of = match found.as_ref().and_then(|found| found[place]) {
                    Some(of) => run.with_slopes(of),
                    None => run.density(noise, Seen::Rebound(self.rebounds.restitution[node])),
                };
                add(film, of, count);
                if self.truncated {
                    add(film, run.density(noise, rebounded), -count);
                }
            }
        }
        let mut films = self.stuck.films(rows.law);
        for node in rows.stuck {
            let film = films.at(node);
            let run = RunImpact {
                balance: &film.balance,
                impact: self.stuck.impact(node),
                errors: errors(&own.stuck, node),
            };
            if !run.errors.is_shared {
                add(&film, run.density(noise, stuck), self.stuck.count[node]);
            }
        }
        add_noise_slopes(all, ParameterKind::SigmaWet, slopes);
        all.value
    }

    /// The log likelihood of the wet runs that share a true speed; adds its slopes in the noise, and in r to the sums of
    /// each block.
    pub(super) fn of_shared_speeds(
        &self,
        noise: &RowNoise,
        blocks: &[NodeRange],
        (slopes, sums): (&mut [f64], &mut [BlockSums]),
    ) -> f64 {
        let mut value = 0.0;
        for shared in &noise.own.shared {
            let law = |of: &SharedSetting<WetPlace>| blocks[of.place.block].law.at(of.place.film);
            let laws: Vec<FilmLaw> = shared.settings.iter().map(law).collect();
            let balances: Vec<&Balance> = laws.iter().map(|law| &law.balance).collect();
            let (all, each) = shared.density(noise.noise, &balances);
            value += all.value;
            add_noise_slopes(all, ParameterKind::SigmaWet, slopes);
            for ((setting, law), of) in shared.settings.iter().zip(&laws).zip(each) {
                law.add(&mut sums[setting.place.block], of.kept, of.viscous, -0.5 * of.dry_k);
            }
        }
        value
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
        let add = |value: &mut f64, slopes: &mut [f64], place_of_k: usize, of: RunDensity| {
            *value += of.value;
            slopes[place_of_k] += of.dry_k;
            add_noise_slopes(of, ParameterKind::SigmaDry, slopes);
        };
        let rebounded = Seen::On(Side::Above, self.limit);
        let seen = |row: &DryRow| row.restitution.map_or(Seen::On(Side::Below, self.limit), Seen::Rebound);
        for row in own.dry.iter().filter(|row| !row.errors.is_shared) {
            let place_of_k = COMMON_SLOTS + row.sphere;
            let balance = Balance::dry(self.form.dry, full[place_of_k]);
            let run = RunImpact {
                balance: &balance,
                impact: row.impact(),
                errors: row.errors,
            };
            add(&mut value, slopes, place_of_k, run.density(noise, seen(row)));
            if self.truncated && row.restitution.is_some() {
                add(
                    &mut value,
                    slopes,
                    place_of_k,
                    run.density(noise, rebounded).times(-1.0),
                );
            }
        }
        for shared in &own.dry_shared {
            let place_of_k = |of: &SharedSetting<usize>| COMMON_SLOTS + of.place;
            let balance = |of: &SharedSetting<usize>| Balance::dry(self.form.dry, full[place_of_k(of)]);
            let balances: Vec<Balance> = shared.settings.iter().map(balance).collect();
            let balances: Vec<&Balance> = balances.iter().collect();
            let (all, each) = shared.density(noise, &balances);
            value += all.value;
            add_noise_slopes(all, ParameterKind::SigmaDry, slopes);
            for (setting, of) in shared.settings.iter().zip(each) {
                slopes[place_of_k(setting)] += of.dry_k;
            }
        }
        value
    }
}
