//! Holds what few runs say that stand for many against what the many say.

use crate::common::scenes::{design, scene_of, truth, AK10, M50, PTFE};
use crate::common::{seed_of, Place};
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::{ModelParameters, ParameterKind};
use wetcor::physics::Coefficient;
use wetcor::runs::{Runs, Table};
use wetcor::scene::Scene;

/// From far above the threshold to below it, so that some settings rebound now and then; `own` is what runs have of their own.
pub fn scene(own: &str) -> String {
    let model = "[model]\ninertia = \"saturating\"\n";
    let more = "inertia = \"saturating\"\nfilm_scale = 0.069\n";
    let truth = truth([1.85, 0.47, 0.009, 0.02], more);
    let speeds = ["30, 60, 90, 120, 150", "0.4, 0.8, 1.2, 1.6, 2.0"];
    let design = design(["3.175, 4.762", "0.04, 0.09"], &["AK10", "M50"], speeds, "");
    let limit = "smallest_restitution = 0.05\n";
    let parts = [limit, PTFE, AK10, M50, model, &truth, &design, own, "\n"];
    scene_of("very many runs", &parts)
}

pub const OF_THEIR_OWN: &str = "film_rel_sd = 0.02\nimpact_speed_rel_sd = 0.05";

const RUNS: u64 = 120_000;

fn drawn(own: &str, name: &str) -> (Place, Table) {
    let place = Place::new(&scene(own));
    let table = place.draw(seed_of(name), Some(RUNS));
    (place, table)
}

/// The planted fault: a stand-in of every series counts for a tenth more.
pub fn miscounted(mut few: Runs) -> Runs {
    for series in &few.series {
        few.count[series.rebounds.start] *= 1.1;
    }
    few
}

/// The log densities of all runs and of few, less their first, at points about the truth that a posterior of so many reaches.
fn moves(scene: &Scene, all: &Runs, few: &Runs) -> Vec<[f64; 2]> {
    let form = scene.model.form();
    let parameters = ModelParameters::of(scene, all, form).expect("priors with room");
    let truth = |kind: &ParameterKind| match kind {
        ParameterKind::Shared(Coefficient::LubricationLog) => 1.85,
        ParameterKind::Shared(Coefficient::InertialPrefactor) => 0.47,
        ParameterKind::Shared(Coefficient::FilmScale) => 0.069,
        ParameterKind::DryK(_) => 0.183,
        ParameterKind::SigmaDry => 0.009,
        ParameterKind::SigmaWet => 0.02,
        other => panic!("{other:?} is not in this model"),
    };
    let at: Vec<f64> = parameters.sampled.iter().map(|own| truth(&own.kind)).collect();
    let likelihoods = [all, few].map(|runs| Likelihood::new(scene, runs, form));
    let densities = |moved: Option<usize>| {
        let mut point = at.clone();
        if let Some(place) = moved {
            point[place] *= 1.004;
        }
        let full = parameters.full(&point);
        let mut slopes = vec![0.0; full.len()];
        likelihoods
            .each_ref()
            .map(|of| of.ln_density(&full, &mut slopes).expect("a density"))
    };
    let [first_all, first_few] = densities(None);
    let moved = (0..at.len()).map(|place| densities(Some(place)));
    moved.map(|[all, few]| [all - first_all, few - first_few]).collect()
}

#[test]
fn the_log_density_of_few_runs_moves_as_that_of_all() {
    let as_all = |place: &Place, table: &Table| {
        let few = table.runs.condensed(place.scene.data.smallest_restitution);
        let few = few.expect("very many runs without errors");
        let found = moves(&place.scene, &table.runs, &few);
        assert!(found.iter().all(|[all, few]| (all - few).abs() < 1e-3), "{found:?}");
        (few, found)
    };
    // films may spread farther than groups do
    let (place, table) = drawn("film_rel_sd = 0.1\nimpact_speed_rel_sd = 0.05", "films of all kinds");
    let (few, _) = as_all(&place, &table);
    assert!(few.len() < table.runs.len() / 2, "{}", few.len());
    let (place, table) = drawn(OF_THEIR_OWN, "the density of few runs");
    let (few, found) = as_all(&place, &table);
    assert!(found.iter().any(|[all, _]| all.abs() > 10.0), "{found:?}");
    let found = moves(&place.scene, &table.runs, &miscounted(few));
    assert!(found.iter().any(|[all, few]| (all - few).abs() > 1e-3), "{found:?}");
}
