//! Computes log likelihoods and new draws of many runs at once.

use rand::Rng;

use super::At;
use crate::model::likelihood::tails::Tails;
use crate::model::normals::Normals;

impl At<'_, '_> {
    /// Whether a run depends on its mean and on one of two spreads alone, with normal noise and no run left unlogged.
    pub(super) fn is_plain(&self) -> bool {
        let pointwise = self.pointwise;
        let no_errors = pointwise.errors.is_none() && self.energy.is_none();
        no_errors && !pointwise.truncated && self.tails == Tails::Normal
    }

    /// [`At::ln_likelihood`] of some runs, as many as there is room for.
    pub fn ln_likelihoods(&self, runs: &[usize], into: &mut [f64]) {
        let plain = self.is_plain();
        for (into, &run) in into.iter_mut().zip(runs) {
            *into = if plain && !self.pointwise.stuck[run] {
                let (mean, spread) = self.mean_and_spread(run);
                let z = (self.pointwise.runs.restitution[run] - mean) / spread.sigma;
                Tails::Normal.ln_unit_density(z) - spread.ln
            } else {
                self.ln_likelihood(run)
            };
        }
    }

    /// A new draw of every run, as [`At::predict`] gives; `scratch` is overwritten.
    pub fn predictions<R: Rng + ?Sized>(&self, normals: &Normals, rng: &mut R, scratch: &mut Vec<f64>) {
        let runs = self.pointwise.len();
        scratch.resize(runs, 0.0);
        if !self.is_plain() {
            for (run, new) in scratch.iter_mut().enumerate() {
                *new = self.predict(run, rng);
            }
            return;
        }
        normals.fill(rng, scratch);
        let limit = self.pointwise.limit;
        let (dry, wet) = scratch.split_at_mut(self.pointwise.dry);
        let (dry_setting, wet_setting) = self.pointwise.setting.split_at(self.pointwise.dry);
        for (new, setting, sigma) in [(dry, dry_setting, self.dry.sigma), (wet, wet_setting, self.wet.sigma)] {
            for (new, setting) in new.iter_mut().zip(setting) {
                let e = self.means[*setting as usize] + sigma * *new;
                *new = if e <= limit { 0.0 } else { e };
            }
        }
    }
}
