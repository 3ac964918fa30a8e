//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + σ z; on the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound's measured restitution
//! errs by u besides, so that σ² + u² stands in the place of σ². Where the impact speed errs, the true one is integrated over,
//! as z′ is (`hidden.rs`).
//!
//! F is of one family and shape for all runs. A stuck run was not measured, so that only its impact speed errs.

use super::hidden::{Rebounds, MOST_REBOUNDS};
use super::pointwise::Pointwise;
use super::run_density::{RunDensity, Totals};
use super::run_noise::RunNoise;
use super::tails::Tails;
use super::trend::FilmLaw;
use crate::physics::balance::Balance;

impl Pointwise {
    /// Adds the runs, but for rebounds where nodes hold these.
    pub(super) fn add_to(&self, full: &[f64], noise: &[RunNoise; 2], rebounds_are_nodes: bool, totals: &mut Totals) {
        let mut laws = self.laws(full);
        // what a run errs by is its own, and is seen to one run at a time
        // m′ falls to where all is kept: noise that acts there acts on every run
        let is_normal = noise[1].tails == Tails::Normal && noise[1].acts_on_energy(1.0);
        let together = self.errors.is_empty() && is_normal;
        let is_wet_rebound = |run: usize| run >= self.dry && !self.is_stuck(run);
        // repeats stick with one probability
        let mut last_stuck: Option<(usize, RunDensity)> = None;
        for first in (0..self.len()).step_by(MOST_REBOUNDS) {
            let is_read = |run: &usize| !(self.is_shared(*run) || rebounds_are_nodes && !self.is_stuck(*run));
            let runs = (first..self.len().min(first + MOST_REBOUNDS)).filter(is_read);
            let runs: Vec<(usize, FilmLaw)> = runs.map(|run| (run, laws(self.setting(run)))).collect();
            let mut rebounds = Rebounds::NONE;
            for (run, law) in runs.iter().filter(|(run, _)| together && is_wet_rebound(*run)) {
                let (kept, _) = law.balance.kept(&self.setting(*run).impact);
                rebounds.push(self.restitution[*run], kept);
            }
            let mut found = rebounds.densities(noise[1]).into_iter();
            for (run, law) in runs {
                let (at, kind) = (self.impact(run, &law.balance), usize::from(run >= self.dry));
                let is_one_of_many = together && is_wet_rebound(run);
                let of_rebound = is_one_of_many.then(|| found.next().flatten()).flatten();
                let of_rebound = of_rebound.map(|of| at.with_slopes(of, at.kept().1));
                let of = match last_stuck {
                    Some((same, of)) if self.sticks_as(run, same) => of,
                    _ => self.alone(run, at, &noise[kind], of_rebound),
                };
                if self.is_stuck(run) {
                    last_stuck = Some((run, of));
                }
                let count = self.count(run);
                totals.of_kind[kind].add(of, count);
                let slopes = [of.kept, of.viscous, of.dry_k];
                law.add(&mut totals.blocks[self.setting(run).block], slopes, count);
            }
        }
        for shared in &self.shared {
            let laws: Vec<FilmLaw> = shared.firsts().map(|run| laws(self.setting(run))).collect();
            let balances: Vec<Balance> = laws.iter().map(|law| law.balance).collect();
            let kind = usize::from(shared.settings[0].runs[0] >= self.dry);
            let (all, each) = shared.hidden(noise[kind], &balances, |hidden| hidden.integrate());
            totals.of_kind[kind].add(all, shared.sign);
            for ((first, law), slopes) in shared.firsts().zip(&laws).zip(each) {
                law.add(&mut totals.blocks[self.setting(first).block], slopes, shared.sign);
            }
        }
    }

    /// Whether a run sticks with the probability of another one that stuck.
    fn sticks_as(&self, run: usize, other: usize) -> bool {
        self.errors.is_empty() && self.is_stuck(run) && self.setting(run) == self.setting(other)
    }
}
