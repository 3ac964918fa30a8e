//! Times the log posterior with its slopes, of settings that repeat or do not and under each noise, and the sampling of two
//! thousand and a million runs.
//!
//! Runs are simulated in the design of `datasets/mueller2016`: at its five speeds, or each at a speed of its own; in its
//! films, or each in a film of its own.

use std::path::Path;

use divan::{black_box, Bencher};
use rand_distr::{Distribution, StandardNormal};
use wetcor::inference::nuts::{Effort, SamplingPlan, TARGET_ACCEPT};
use wetcor::inference::prepared_posterior::PreparedPosterior;
use wetcor::inference::sampling::sample_by_nuts;
use wetcor::model::likelihood::Likelihood;
use wetcor::model::parameters::{ModelParameters, ParameterKind};
use wetcor::model::posterior::{LogDensity, PosteriorDensity};
use wetcor::model::simulate::Simulation;
use wetcor::physics::Inertia;
use wetcor::runs::{self, NewRun, RunError, Runs};
use wetcor::scene::{self, LikelihoodFamily, NoiseOn, Scene};
use wetcor::seed::{stream, StreamName};

fn main() {
    divan::main();
}

const SIZES: [u64; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// What runs have of their own.
#[derive(Clone, Copy, PartialEq)]
enum Own {
    Nothing,
    Speeds,
    /// sd of their logarithm 0.02
    Films,
}

/// The example's scene and so many simulated runs, in order.
fn simulated(runs: u64, own: Own) -> (Scene, Runs) {
    simulated_of(runs, own, |_| true)
}

/// The same, of which some are kept, changed or not.
fn simulated_of(runs: u64, own: Own, mut keep: impl FnMut(&mut NewRun) -> bool) -> (Scene, Runs) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
    let mut scene = scene::read(&path).expect("the example's scene is good");
    if let Some(design) = scene.design.as_mut().filter(|_| own == Own::Films) {
        design.film_rel_sd = Some(0.02);
    }
    if let Some(design) = scene.design.as_mut().filter(|_| own == Own::Speeds) {
        // as many speeds as give each of the 84 combinations of the design one run a speed
        let count = (runs / 84).max(1);
        let speed = |i: u64| 0.767 + 0.95 * (i as f64 + 0.5) / count as f64;
        design.speeds = (0..count).map(speed).collect();
    }
    let simulation = Simulation::new(&scene, Some(runs)).expect("the example has a truth and a design");
    let mut rows = simulation.under(1).all();
    rows.retain_mut(|run| keep(run));
    let runs = runs::arrange(&scene, &rows);
    drop(rows);
    (scene.clone(), runs)
}

fn parts(scene: &Scene, runs: &Runs) -> (ModelParameters, Likelihood) {
    let form = scene.model.form();
    let parameters = ModelParameters::of(scene, runs, form).expect("priors with room");
    (parameters, Likelihood::new(scene, runs, form))
}

/// The truth the runs were drawn from.
fn truth(scene: &Scene, parameters: &ModelParameters) -> Vec<f64> {
    let truth = scene.truth.as_ref().expect("the example has one");
    let of = |kind: ParameterKind| match kind {
        ParameterKind::DryK(particle) => truth.dry_k[particle],
        ParameterKind::Shared(coefficient) => truth.value(coefficient),
        ParameterKind::SigmaDry => truth.sigma_dry,
        ParameterKind::SigmaWet => truth.sigma_wet,
        ParameterKind::SigmaEnergy => truth.sigma_energy,
        ParameterKind::SigmaSeries => truth.sigma_series,
        ParameterKind::Shape(_) => truth.shape,
        ParameterKind::LubricationTrend | ParameterKind::InertialTrend => None,
    };
    parameters.sampled.iter().map(|p| of(p.kind).expect("given")).collect()
}

fn evaluate(bencher: Bencher, posterior: &PosteriorDensity, draw: &[f64]) {
    let point = posterior.point_at(draw);
    let mut slopes = vec![0.0; point.len()];
    bencher.bench_local(|| posterior.ln_density(black_box(&point), &mut slopes));
}

/// Log posterior and slopes where settings repeat.
#[divan::bench(args = SIZES)]
fn tidy(bencher: Bencher, runs: u64) {
    under(bencher, simulated(runs, Own::Nothing));
}

/// The same with every run in a film of its own; divide by the runs.
#[divan::bench(args = SIZES)]
fn in_own_films(bencher: Bencher, runs: u64) {
    under(bencher, simulated(runs, Own::Films));
}

fn under(bencher: Bencher, (scene, runs): (Scene, Runs)) {
    let (parameters, likelihood) = parts(&scene, &runs);
    let draw = truth(&scene, &parameters);
    evaluate(bencher, &PosteriorDensity::new(parameters, likelihood), &draw);
}

/// Over every wet row that rebounded, or that stuck, where each has a film of its own, with each form of inertia.
fn own_films(bencher: Bencher, inertia: Inertia, rebounded: bool) {
    let keep = |run: &mut NewRun| run.liquid.is_some() && (run.restitution > 0.0) == rebounded;
    let (mut scene, runs) = simulated_of(2_000, Own::Films, keep);
    scene.model.inertia = Some(inertia);
    let (parameters, rows) = parts(&scene, &runs);
    let draw = truth(&scene, &parameters);
    evaluate(bencher, &PosteriorDensity::new(parameters, rows), &draw);
}

#[divan::bench(args = Inertia::ALL)]
fn rebounds_in_own_films(bencher: Bencher, inertia: Inertia) {
    own_films(bencher, inertia, true);
}

#[divan::bench(args = Inertia::ALL)]
fn stuck_in_own_films(bencher: Bencher, inertia: Inertia) {
    own_films(bencher, inertia, false);
}

/// One square root and one division a row: what a row cannot cost less than, nearly.
#[divan::bench(args = SIZES)]
fn root_and_division(bencher: Bencher, runs: u64) {
    let values: Vec<f64> = (0..runs).map(|i| 0.2 + 0.6 * (i as f64 * 0.618).fract()).collect();
    bencher.bench_local(|| {
        let mut sums = [0.0; 4];
        for chunk in black_box(&values).as_chunks::<4>().0 {
            for (sum, x) in sums.iter_mut().zip(chunk) {
                *sum += x.sqrt() + 1.0 / x;
            }
        }
        sums.iter().sum::<f64>()
    });
}

/// What rows may have beside normal noise on the restitution.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Noise {
    /// nothing
    Plain,
    /// Student's tails
    Student,
    /// an offset of each series
    Offsets,
    /// noise on the energy kept, too
    Energy,
    /// errors of the impact speeds, 1 %, where speeds repeat
    RepeatedSpeeds,
    /// the same where every run has a film of its own
    RepeatedSpeedsInOwnFilms,
    /// the same where no run of a setting repeats a speed
    OwnSpeeds,
}

const NOISES: [Noise; 7] = [
    Noise::Plain,
    Noise::Student,
    Noise::Offsets,
    Noise::Energy,
    Noise::RepeatedSpeeds,
    Noise::RepeatedSpeedsInOwnFilms,
    Noise::OwnSpeeds,
];

/// The example's scene with a noise, and two thousand simulated runs.
fn noisy(noise: Noise) -> (Scene, Runs) {
    const ERROR: f64 = 0.01;
    let (own, error) = match noise {
        Noise::Plain | Noise::Student | Noise::Offsets | Noise::Energy => (Own::Nothing, 0.0),
        Noise::RepeatedSpeeds => (Own::Nothing, ERROR),
        Noise::RepeatedSpeedsInOwnFilms => (Own::Films, ERROR),
        Noise::OwnSpeeds => (Own::Speeds, ERROR),
    };
    let mut rng = stream(1, "speeds of the bench", 0);
    let (mut scene, mut runs) = simulated_of(2_000, own, |run| {
        let z: f64 = StandardNormal.sample(&mut rng);
        run.impact_speed *= 1.0 + error * z;
        true
    });
    if error > 0.0 {
        let of = |v: &f64| RunError {
            impact_speed_sd: error * v,
            ..RunError::default()
        };
        runs.errors = runs.impact_speed.iter().map(of).collect();
    }
    scene.model.series_offsets = noise == Noise::Offsets;
    match noise {
        Noise::Student => scene.model.likelihood = LikelihoodFamily::Student,
        Noise::Energy => scene.model.noise = NoiseOn::Both,
        _ => {}
    }
    let truth = scene.truth.as_mut().expect("the example has one");
    (truth.shape, truth.sigma_series, truth.sigma_energy) = (Some(6.0), Some(0.006), Some(0.02));
    (scene, runs)
}

/// Over every one of 2,000 rows.
#[divan::bench(args = NOISES)]
fn under_noise(bencher: Bencher, noise: Noise) {
    let (scene, runs) = noisy(noise);
    let (parameters, rows) = parts(&scene, &runs);
    let draw = truth(&scene, &parameters);
    evaluate(bencher, &PosteriorDensity::new(parameters, rows), &draw);
}

/// One exponential, square root and division a row: what a node of an integral cannot cost less than, nearly.
#[divan::bench]
fn exponential_root_and_division(bencher: Bencher) {
    let values: Vec<f64> = (0..2_000).map(|i| 0.2 + 0.6 * (f64::from(i) * 0.618).fract()).collect();
    bencher.bench_local(|| {
        let terms = black_box(&values).iter().map(|x| (-x).exp() + x.sqrt() + 1.0 / x);
        terms.sum::<f64>()
    });
}

const EFFORT: Effort = Effort {
    chains: 4,
    warmup: 1000,
    draws: 1000,
    target_accept: TARGET_ACCEPT,
};

/// Mode, four chains of 1,000 + 1,000.
fn sample(bencher: Bencher, (scene, runs): (Scene, Runs)) {
    let (parameters, likelihood) = parts(&scene, &runs);
    let plan = SamplingPlan::new(EFFORT, StreamName::new(1, "bench"));
    bencher.bench_local(|| {
        let prepared = PreparedPosterior::new(parameters.clone(), &likelihood, &vec![]).expect("a start");
        black_box(sample_by_nuts(&prepared, plan, &mut |_| 0).expect("a posterior"))
    });
}

/// Settings of the design, repeated.
#[divan::bench(args = [2_000, 1_000_000], sample_count = 5)]
fn sampling(bencher: Bencher, runs: u64) {
    sample(bencher, simulated(runs, Own::Nothing));
}

/// Every run in a film of its own.
#[divan::bench(args = [2_000, 10_000, 1_000_000], sample_count = 5)]
fn sampling_in_own_films(bencher: Bencher, runs: u64) {
    sample(bencher, simulated(runs, Own::Films));
}

/// Every run at a speed of its own.
#[divan::bench(args = [2_000, 1_000_000], sample_count = 5)]
fn sampling_at_own_speeds(bencher: Bencher, runs: u64) {
    sample(bencher, simulated(runs, Own::Speeds));
}

/// Two thousand runs.
#[divan::bench(args = NOISES, sample_count = 1)]
fn sampling_under_noise(bencher: Bencher, noise: Noise) {
    sample(bencher, noisy(noise));
}
