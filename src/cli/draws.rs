//! Shows the draws of a posterior as they come.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::scene::Scene;

use crate::progress::Progress;

/// Shows draws as they come, and counts divergences among the kept ones.
pub(super) struct Draws {
    progress: Progress,
    name: &'static str,
    drawn: AtomicU64,
    diverged: AtomicU64,
}

impl Draws {
    /// Draws of so many posteriors of the scene.
    pub(super) fn of(scene: &Scene, quiet: bool, name: &'static str, posteriors: u64) -> Draws {
        let sampler = &scene.sampler;
        let all = sampler
            .chains
            .saturating_mul(sampler.warmup.saturating_add(sampler.draws));
        Draws {
            progress: Progress::bar(name, all.saturating_mul(posteriors), quiet),
            name,
            drawn: AtomicU64::new(0),
            diverged: AtomicU64::new(0),
        }
    }

    pub(super) fn one(&self, kept: bool, diverging: bool) {
        let drawn = 1 + self.drawn.fetch_add(1, Relaxed);
        if kept && diverging {
            let diverged = 1 + self.diverged.fetch_add(1, Relaxed);
            self.progress.say(format!("{}, {diverged} divergences", self.name));
        }
        if drawn.is_multiple_of(64) {
            self.progress.at(drawn);
        }
    }
}
