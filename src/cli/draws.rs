//! Shows the draws of a posterior as they come.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::scene::Scene;

use crate::progress::Progress;

/// Shows draws as they come, and counts divergences among the kept ones.
pub(super) struct Draws {
    progress: Progress,
    name: &'static str,
    /// draws that one posterior takes where all goes well
    of_one: u64,
    diverged: AtomicU64,
}

impl Draws {
    /// Draws of so many posteriors of the scene.
    pub(super) fn of(scene: &Scene, name: &'static str, posteriors: u64) -> Draws {
        let sampler = &scene.sampler;
        let of_chain = sampler.warmup.saturating_add(sampler.draws);
        let of_one = sampler.chains.saturating_mul(of_chain);
        Draws {
            progress: Progress::bar(name, of_one.saturating_mul(posteriors)),
            name,
            of_one,
            diverged: AtomicU64::new(0),
        }
    }

    pub(super) fn one(&self, kept: bool, diverging: bool) {
        if kept && diverging {
            let diverged = 1 + self.diverged.fetch_add(1, Relaxed);
            self.progress.say(format!("{}, {diverged} divergences", self.name));
        }
        // sampled anew with shorter steps, or drawn on
        self.progress.add_beyond(1, self.of_one);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_draws_never_pass_those_expected() {
        let text = "title = \"few\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n\
                    roughness_um = 5\n[sampler]\nchains = 2\nwarmup = 3\ndraws = 4\n";
        let path = std::path::Path::new("few/scene.toml");
        let scene = wetcor::scene::parse(text, path, String::new()).expect("a scene");
        let draws = Draws::of(&scene, "posterior", 1);
        for drawn in 1..100 {
            draws.one(true, false);
            let expected = draws.progress.length();
            assert!(
                drawn <= expected && expected <= 14.max(drawn + 14),
                "{drawn} of {expected}"
            );
        }
    }
}
