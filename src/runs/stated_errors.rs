//! Refuses runs whose measurement errors are said to be all that scatters them, where some state none.

use std::ops::Range;

use super::series::{DryGroup, Runs, Series};
use crate::error::{unless_wrong, Error, Problem};
use crate::scene::{NoiseOn, Scene, Sticking, SIGMA_DRY, SIGMA_WET};

/// Runs of one kind, as far as their noise goes.
#[derive(Debug, Default)]
struct NoiseOfRuns {
    rebounds: usize,
    /// rebounds that state no error of the restitution beyond what it shares with the impact speed
    without_errors: usize,
    stuck: usize,
}

/// Checks that runs whose spread a scene holds at 0 have another: every one of them states an error of its restitution.
///
/// Fails with the key of each spread that may not be 0, and why.
pub(super) fn check_stated_errors(scene: &Scene, runs: &Runs) -> Result<(), Error> {
    let (dry, wet) = (
        runs.dry.iter().map(DryGroup::kinds),
        runs.series.iter().map(Series::kinds),
    );
    let kinds = [
        (SIGMA_DRY.name, "dry", NoiseOfRuns::of(runs, dry)),
        (SIGMA_WET.name, "wet", NoiseOfRuns::of(runs, wet)),
    ];
    let problem = |(key, kind, noise): (&str, &str, NoiseOfRuns)| {
        let choice = scene.held_at_zero(key)?;
        let why = noise.why_not_zero(scene, kind)?;
        let expected = format!("expected a number above 0: {why}");
        let problem = Problem::new(format!("[priors] {key}"), expected).on(choice.line);
        Some(problem.found("`fixed 0`".to_owned()))
    };
    let problems = kinds.into_iter().filter_map(problem).collect();
    unless_wrong(problems, ()).map_err(|problems| Error::input(&scene.file, problems))
}

impl NoiseOfRuns {
    fn of(runs: &Runs, kinds: impl Iterator<Item = [Range<usize>; 2]>) -> NoiseOfRuns {
        let mut noise = NoiseOfRuns::default();
        let states = |run: &usize| runs.errors.as_ref().is_some_and(|errors| errors.of(*run)[1] > 0.0);
        for [rebounds, stuck] in kinds {
            noise.rebounds += rebounds.len();
            noise.without_errors += rebounds.filter(|run| !states(run)).count();
            noise.stuck += stuck.len();
        }
        noise
    }

    /// Why nothing but the errors may not scatter these; `None` where that is well.
    fn why_not_zero(&self, scene: &Scene, kind: &str) -> Option<String> {
        if self.without_errors > 0 {
            return Some(format!(
                "{} of {} {kind} rebounds in use state no error of the restitution (column restitution_sd or \
                 rebound_speed_sd_m_s, beyond what it shares with impact_speed_sd_m_s)",
                self.without_errors, self.rebounds
            ));
        }
        if self.stuck > 0 {
            return Some(format!(
                "{} {kind} runs in use stuck, whose restitution was not measured, so that no error scatters it; or [model] \
                 sticking = \"excluded\"",
                self.stuck
            ));
        }
        if self.rebounds > 0 && scene.model.sticking == Sticking::Truncated {
            return Some(format!(
                "with [model] sticking = \"truncated\" runs that stuck are missing, and without a spread none of the {kind} \
                 ones could have"
            ));
        }
        let on_energy = kind == "wet" && self.rebounds > 0 && scene.model.noise == NoiseOn::Both;
        on_energy.then(|| {
            "[model] noise = \"both\" asks for a spread of the restitution beside that of the energy".to_owned()
        })
    }
}
