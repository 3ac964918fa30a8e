//! Tests of many runs at once against one at a time.

use super::by_row::with_errors;
use super::*;
use crate::model::likelihood::pointwise::EvaluatedLaw;
use crate::physics::Viscous;
use crate::seed::stream;

/// Every kind of noise, with stuck runs censored and not logged, with and without errors of the runs' own.
fn scenes() -> Vec<(Scene, bool)> {
    let mut scenes = vec![];
    for likelihood in [scene::LikelihoodFamily::Normal, scene::LikelihoodFamily::Student] {
        for noise in [NoiseOn::Restitution, NoiseOn::Both] {
            for sticking in [Sticking::Censored, Sticking::Truncated] {
                for errors in [false, true] {
                    let mut scene = scene();
                    (scene.model.likelihood, scene.model.noise) = (likelihood, noise);
                    scene.model.sticking = sticking;
                    scenes.push((scene, errors));
                }
            }
        }
    }
    scenes
}

/// The likelihood of runs at many draws is that of one run at one draw, in blocks that begin and end anywhere.
#[test]
fn runs_at_many_draws_have_the_likelihoods_of_one_at_one() {
    for (scene, errors) in scenes() {
        let runs = runs(&scene, if errors { 8 } else { 20 }, "runs_at_many_draws");
        let runs = if errors { with_errors(runs) } else { runs };
        for form in [
            Form::new(Inertia::Saturating, DRY_SPEEDS[1]),
            Form {
                viscous: Viscous::Film,
                ..Form::new(Inertia::Stepwise, DRY_SPEEDS[0])
            },
        ] {
            let pointwise = Pointwise::new(&scene, &runs, form);
            let draws: Vec<Vec<f64>> = (0..5)
                .map(|draw| FULL.iter().map(|x| x * (1.0 + 0.01 * f64::from(draw))).collect())
                .collect();
            let at = pointwise.at_draws(draws.iter().map(Vec::as_slice).collect());
            let laws: Vec<EvaluatedLaw> = draws.iter().map(|full| pointwise.at(full)).collect();
            assert_eq!(at.len(), draws.len());
            for first in (0..runs.len()).step_by(7) {
                let some = first..runs.len().min(first + 7);
                let mut rows = vec![f64::NAN; some.len() * draws.len()];
                at.ln_likelihoods(some.clone(), &mut rows);
                let one = |run: usize| laws.iter().map(move |law| law.ln_likelihood(run));
                let expected: Vec<f64> = some.flat_map(one).collect();
                assert_eq!(rows, expected, "{form:?}");
            }
        }
    }
}

/// How many standard deviations the most deviant share of new draws lies from its probability: of those below a
/// restitution on both sides of the mean, and of those that stick.
fn farthest(full: &[f64], name: &str) -> f64 {
    const DRAWS: usize = 20_000;
    let scene = scene();
    let runs = runs(&scene, 20, name);
    let pointwise = Pointwise::new(&scene, &runs, Form::new(Inertia::Saturating, DRY_SPEEDS[0]));
    let (at, drawn_at) = (pointwise.at(&FULL), pointwise.at(full));
    let limit = scene.data.smallest_restitution;
    let points = |run: usize| {
        let (mean, sigma) = at.mean_and_sigma(run);
        [mean - sigma, mean + 0.5 * sigma].map(|e| e.max(limit))
    };
    let mut below = vec![[0.0; 2]; runs.len()];
    let mut rng = stream(1, name, 0);
    for _ in 0..DRAWS {
        let new = drawn_at.predictions(&mut rng);
        for (run, (below, new)) in below.iter_mut().zip(&new).enumerate() {
            assert!(*new == 0.0 || *new > limit);
            for (below, point) in below.iter_mut().zip(points(run)) {
                *below += f64::from(u8::from(*new <= point));
            }
        }
    }
    let mut farthest: f64 = 0.0;
    for (run, below) in below.iter().enumerate() {
        for (below, point) in below.iter().zip(points(run)) {
            let p = at.tails().probability(at.z(run, point));
            let n = DRAWS as f64;
            // a share of hardly any or of nearly all says nothing in normal terms
            if n * p.min(1.0 - p) > 100.0 {
                farthest = farthest.max((below - n * p).abs() / (n * p * (1.0 - p)).sqrt());
            }
        }
    }
    farthest
}

#[test]
fn new_draws_of_all_runs_have_their_probabilities() {
    let found = farthest(&FULL, "new_draws_of_all_runs_have_their_probabilities");
    assert!(found < 4.5, "{found}");
}

#[test]
fn a_spread_a_tenth_too_wide_is_seen() {
    for kind in [ParameterKind::SigmaWet, ParameterKind::SigmaDry] {
        let mut full = FULL;
        full[kind.slot()] *= 1.1;
        let found = farthest(&full, "a_spread_a_tenth_too_wide_is_seen");
        assert!(found > 9.0, "{found}");
    }
}
