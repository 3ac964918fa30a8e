//! Counts the nodes that integrals take, on which the time of a gradient rests.

use std::cell::Cell;

use rand_distr::{Distribution, StandardNormal};

use super::*;
use crate::model::parameters::ModelParameters;
use crate::model::simulate::Simulation;
use crate::runs::MeasurementErrors;
use crate::scene::DesignSpeeds;

thread_local!(static NODES: Cell<usize> = const { Cell::new(0) });

/// Counts so many nodes of a rule, each as often as it is of a run.
pub fn count(nodes: usize) {
    NODES.set(NODES.get() + nodes);
}

/// What runs have beside normal noise on the restitution.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Beside {
    NoiseOnEnergy,
    ErrorsOfRepeatedSpeeds,
    /// and every run in a film of its own
    ErrorsInOwnFilms,
    ErrorsOfOwnSpeeds,
}

/// Nodes a run of one gradient at the truth, of two thousand runs of the example's design; speeds err by 1 %.
fn nodes_a_run(beside: Beside) -> f64 {
    const RUNS: u64 = 2_000;
    const ERROR: f64 = 0.01;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
    let mut scene = scene::read(&path).expect("the example's scene is good");
    if beside == Beside::ErrorsOfOwnSpeeds {
        // as many as give each of the 84 combinations of the design one run a speed
        let design = scene.design.as_mut().expect("the example has one");
        design.speeds = DesignSpeeds((0..RUNS / 84).map(|i| 0.767 + 0.04 * i as f64).collect());
    }
    let mut rng = crate::seed::stream(1, "nodes_a_run", 0);
    let simulation = Simulation::new(&scene, Some(RUNS)).expect("the example has a truth and a design");
    let of_speed = f64::from(u8::from(beside != Beside::NoiseOnEnergy)) * ERROR;
    let mut new = simulation.under(1).all();
    for run in &mut new {
        let z: f64 = StandardNormal.sample(&mut rng);
        run.impact_speed *= 1.0 + of_speed * z;
        if let Some((film, _)) = run.film.as_mut().filter(|_| beside == Beside::ErrorsInOwnFilms) {
            let z: f64 = StandardNormal.sample(&mut rng);
            *film *= 1.0 + 0.02 * z;
        }
    }
    let mut runs = runs::arrange(&scene, &new);
    let mut scene = scene.clone();
    if beside == Beside::NoiseOnEnergy {
        scene.model.noise = NoiseOn::Both;
    } else {
        runs.errors = Some(MeasurementErrors {
            impact_speed_sd: runs.impact_speed.iter().map(|v| of_speed * v).collect(),
            restitution_sd: vec![0.0; runs.len()],
            speed_correlation: vec![],
        });
    }
    let form = scene.model.form();
    let truth = scene.truth.as_ref().expect("the example has one");
    let parameters = ModelParameters::of(&scene, &runs, form).expect("priors with room");
    let value = |kind: ParameterKind| match kind {
        ParameterKind::DryK(particle) => truth.dry_k[particle].expect("given"),
        ParameterKind::Shared(coefficient) => truth.value(coefficient).expect("given"),
        ParameterKind::SigmaDry => truth.sigma_dry.expect("given"),
        ParameterKind::SigmaWet => truth.sigma_wet.expect("given"),
        ParameterKind::SigmaEnergy => 0.02,
        other => unreachable!("{other:?}"),
    };
    let draw: Vec<f64> = parameters.sampled.iter().map(|of| value(of.kind)).collect();
    let full = parameters.full(&draw);
    let mut slopes = vec![0.0; full.len()];
    NODES.set(0);
    let value = Likelihood::of_rows(&scene, &runs, form).ln_density(&full, &mut slopes);
    assert!(value.is_ok_and(f64::is_finite));
    NODES.get() as f64 / runs.len() as f64
}

#[test]
fn an_integral_takes_few_nodes() {
    // what benches/README.md says of them
    let expected = [
        (Beside::NoiseOnEnergy, 8.9),
        (Beside::ErrorsOfRepeatedSpeeds, 10.8),
        (Beside::ErrorsInOwnFilms, 10.9),
        (Beside::ErrorsOfOwnSpeeds, 9.4),
    ];
    let found = expected.map(|(beside, _)| nodes_a_run(beside));
    for ((beside, expected), found) in expected.iter().zip(&found) {
        assert!((found - expected).abs() < 0.05, "{beside:?}: {found:?}");
    }
}
