//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + σ z; on the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound's measured restitution
//! errs by u besides, so that σ² + u² stands in the place of σ². z′ is integrated over (`energy.rs`), as is the true impact speed
//! where the measured one errs (`hidden.rs`).
//!
//! F is of one family and shape for all runs. A stuck run was not measured, so that only its impact speed errs.

use super::pointwise::Pointwise;
use super::run_density::{RunDensity, Totals};
use super::run_noise::RunNoise;
use super::trend::FilmLaw;
use crate::physics::balance::Balance;

impl Pointwise {
    /// Adds the runs, but for rebounds where nodes hold these.
    pub(super) fn add_to(&self, full: &[f64], noise: &[RunNoise; 2], rebounds_are_nodes: bool, totals: &mut Totals) {
        let mut laws = self.laws(full);
        // repeats stick with one probability
        let mut last_stuck: Option<(usize, RunDensity)> = None;
        let is_read = |run: &usize| !(self.is_shared(*run) || rebounds_are_nodes && !self.is_stuck(*run));
        for run in (0..self.len()).filter(is_read) {
            let law = laws(self.setting(run));
            let kind = usize::from(run >= self.dry);
            let of = match last_stuck {
                Some((same, of)) if self.sticks_as(run, same) => of,
                _ => self.alone(run, self.impact(run, &law.balance), &noise[kind]),
            };
            if self.is_stuck(run) {
                last_stuck = Some((run, of));
            }
            let count = self.count(run);
            totals.of_kind[kind].add(of, count);
            law.add(
                &mut totals.blocks[self.setting(run).block],
                [of.kept, of.viscous, of.dry_k],
                count,
            );
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
