//! Tests of many runs at once against one at a time.

use super::by_row::with_errors;
use super::*;
use crate::model::likelihood::pointwise::EvaluatedLaw;
use crate::physics::Viscous;

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
