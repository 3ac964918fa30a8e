//! Computes log likelihoods and new draws of many runs at once.

use std::ops::Range;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::{EvaluatedLaw, Pointwise};
use crate::model::likelihood::tails::Tails;

/// Runs of one kind that follow one another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stretch {
    runs: Range<usize>,
    stuck: bool,
}

impl Pointwise<'_> {
    /// Some runs as stretches in which all are dry or wet, and stuck or not.
    pub fn stretches(&self, runs: &[usize]) -> Vec<Stretch> {
        let kind = |run: usize| (self.stuck[run], run < self.dry);
        let stretches = runs.chunk_by(|a, b| *b == a + 1 && kind(*a) == kind(*b));
        let of = |stretch: &[usize]| Stretch {
            runs: stretch[0]..stretch[0] + stretch.len(),
            stuck: self.stuck[stretch[0]],
        };
        stretches.map(of).collect()
    }

    /// By how many σ the smallest restitution that is a rebound lies above the mean, for each of some runs.
    pub fn limits(&self, full: &[f64], runs: &[usize]) -> Vec<f64> {
        // nothing is computed of the other settings
        let mut at = self.without_means(full);
        let mut mean = self.means(full);
        if !self.is_plain() {
            at.means = self.settings.iter().map(mean).collect();
            return runs.iter().map(|&run| at.limit_z(run)).collect();
        }
        let mut last = None;
        let of_run = |&run: &usize| {
            let setting = self.setting[run];
            match last {
                Some((same, z)) if same == setting => z,
                _ => {
                    let above = self.limit - mean(&self.settings[setting as usize]);
                    last.insert((setting, above / at.spread(run).sigma)).1
                }
            }
        };
        runs.iter().map(of_run).collect()
    }
}

impl EvaluatedLaw<'_, '_> {
    /// [`EvaluatedLaw::ln_likelihood`] of the runs of some stretches, of which there are as many as there is room for.
    pub fn ln_likelihoods(&self, stretches: &[Stretch], into: &mut [f64]) {
        let mut rest = into;
        for stretch in stretches {
            let (into, after) = rest.split_at_mut(stretch.runs.len());
            rest = after;
            self.of_stretch(stretch, into);
        }
    }

    fn of_stretch(&self, Stretch { runs, stuck }: &Stretch, into: &mut [f64]) {
        if !self.pointwise.is_plain() {
            for (into, run) in into.iter_mut().zip(runs.clone()) {
                *into = self.ln_likelihood(run);
            }
            return;
        }
        let setting = &self.pointwise.setting[runs.clone()];
        if *stuck {
            let places = runs.clone().zip(setting).zip(into);
            // what stuck in one setting has one probability
            let mut last = None;
            for ((run, setting), into) in places {
                *into = match last {
                    Some((same, value)) if same == setting => value,
                    _ => last.insert((setting, self.ln_likelihood(run))).1,
                };
            }
            return;
        }
        let spread = self.spread(runs.start);
        let restitution = &self.pointwise.runs.restitution[runs.clone()];
        for ((into, e), setting) in into.iter_mut().zip(restitution).zip(setting) {
            let z = (e - self.means[*setting as usize]) / spread.sigma;
            *into = Tails::Normal.ln_unit_density(z) - spread.ln;
        }
    }

    /// A new draw of every run, as [`EvaluatedLaw::predict`] gives; `scratch` is overwritten.
    pub fn predictions<R: Rng + ?Sized>(&self, rng: &mut R, scratch: &mut Vec<f64>) {
        let runs = self.pointwise.len();
        scratch.resize(runs, 0.0);
        if !self.pointwise.is_plain() {
            for (run, new) in scratch.iter_mut().enumerate() {
                *new = self.predict(run, rng);
            }
            return;
        }
        let limit = self.pointwise.limit;
        let (dry, wet) = scratch.split_at_mut(self.pointwise.dry);
        let (dry_setting, wet_setting) = self.pointwise.setting.split_at(self.pointwise.dry);
        for (new, setting, sigma) in [(dry, dry_setting, self.dry.sigma), (wet, wet_setting, self.wet.sigma)] {
            for (new, setting) in new.iter_mut().zip(setting) {
                let z: f64 = StandardNormal.sample(rng);
                let e = self.means[*setting as usize] + sigma * z;
                *new = if e <= limit { 0.0 } else { e };
            }
        }
    }
}
