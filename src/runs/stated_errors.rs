//! Refuses runs whose measurement errors are said to be all that scatters them, where some state none.

use std::ops::Range;

use super::series::{DryGroup, Runs, Series};
use crate::error::{unless_wrong, Error, Problem};
use crate::scene::{NoiseOn, Scene, Sticking, SIGMA_DRY, SIGMA_WET};

/// Checks that runs whose spread a scene holds at 0 have another: every one of them states an error of its restitution.
///
/// Fails with the key of each spread that may not be 0, and why.
pub(super) fn check_stated_errors(scene: &Scene, runs: &Runs) -> Result<(), Error> {
    let dry: Vec<Kinds> = runs.dry.iter().map(DryGroup::kinds).collect();
    let wet: Vec<Kinds> = runs.series.iter().map(Series::kinds).collect();
    let problem = |(key, kind, own): (&str, &str, Vec<Kinds>)| {
        let choice = scene.held_at_zero(key)?;
        let why = why_not_zero(scene, runs, kind, own)?;
        let expected = format!("expected a number above 0: {why}");
        let problem = Problem::new(format!("[priors] {key}"), expected).on(choice.line);
        Some(problem.found("`fixed 0`".to_owned()))
    };
    let kinds = [(SIGMA_DRY.name, "dry", dry), (SIGMA_WET.name, "wet", wet)];
    let problems = kinds.into_iter().filter_map(problem).collect();
    unless_wrong(problems, ()).map_err(|problems| Error::input(&scene.file, problems))
}

/// Where rebounds stand, and runs that stuck.
type Kinds = [Range<usize>; 2];

/// Why nothing but the errors may not scatter the runs of one kind; `None` where that is well.
fn why_not_zero(scene: &Scene, runs: &Runs, kind: &str, own: Vec<Kinds>) -> Option<String> {
    let states = |run: &usize| runs.errors.get(*run).is_some_and(|error| error.restitution_sd > 0.0);
    let (mut rebounds, mut without_errors, mut stuck) = (0, 0, 0);
    for [rebounded, others] in own {
        rebounds += rebounded.len();
        without_errors += rebounded.filter(|run| !states(run)).count();
        stuck += others.len();
    }
    if without_errors > 0 {
        return Some(format!(
            "{without_errors} of {rebounds} {kind} rebounds in use state no error of the restitution (column restitution_sd or \
             rebound_speed_sd_m_s, beyond what it shares with impact_speed_sd_m_s)"
        ));
    }
    if stuck > 0 {
        return Some(format!(
            "{stuck} {kind} runs in use stuck, whose restitution was not measured, so that no error scatters it; or [model] \
             sticking = \"excluded\""
        ));
    }
    if rebounds > 0 && scene.model.sticking == Sticking::Truncated {
        return Some(format!(
            "with [model] sticking = \"truncated\" runs that stuck are missing, and without a spread none of the {kind} \
             ones could have"
        ));
    }
    let on_energy = kind == "wet" && rebounds > 0 && scene.model.noise == NoiseOn::Both;
    on_energy
        .then(|| "[model] noise = \"both\" asks for a spread of the restitution beside that of the energy".to_owned())
}
