//! Tests of the likelihood a run at a time against the statement as it is written, with slopes taken by differences.

use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use super::*;
use crate::runs::MeasurementErrors;

/// ln of a density and of the probability of less, of tails with so many degrees of freedom; of the normal without.
fn oracle(nu: Option<f64>, z: f64) -> (f64, f64) {
    match nu {
        None => (Normal::standard().ln_pdf(z), ln_normal_cdf(z).0),
        Some(nu) => {
            let t = StudentsT::new(0.0, 1.0, nu).expect("valid");
            // as much of it within 1 as of the normal
            let c = t.inverse_cdf(Normal::standard().cdf(1.0));
            let below = if z < 0.0 { t.cdf(c * z) } else { 1.0 - t.cdf(-c * z) };
            (t.ln_pdf(c * z) + c.ln(), below.ln())
        }
    }
}

/// Errors of every other run, the rest without; some of the speed alone, some of the restitution alone.
pub(super) fn with_errors(mut runs: Runs) -> Runs {
    let mut rng = crate::seed::stream(1, "with_errors", 0);
    let mut errors = MeasurementErrors::default();
    for run in 0..runs.len() {
        let (speed, restitution) = (rng.random_range(0.0..0.02), rng.random_range(0.0..0.02));
        let [of_speed, of_restitution] = [run % 2 == 0, run % 3 > 0].map(|on| f64::from(u8::from(on)));
        errors.impact_speed_sd.push(of_speed * speed * runs.impact_speed[run]);
        errors.restitution_sd.push(of_restitution * restitution);
    }
    runs.errors = Some(errors);
    runs
}

/// The statement a run at a time: half a difference of m over the speed's error, or the energy's scale.
fn by_run(scene: &Scene, runs: &Runs, form: Form, full: &[f64]) -> f64 {
    let nu = (scene.model.likelihood == scene::LikelihoodFamily::Student).then_some(full[ParameterKind::Nu.slot()]);
    let both = scene.model.noise == NoiseOn::Both;
    let truncated = scene.model.sticking == Sticking::Truncated;
    let limit = scene.data.smallest_restitution;
    let filled = runs.errors_with_medians();
    let errors = |run: usize| {
        let errors = filled.as_ref();
        errors.map_or((0.0, 0.0), |e| (e.impact_speed_sd[run], e.restitution_sd[run]))
    };
    let m = rebound::mean_restitution;
    let term = |stuck: bool, look: &dyn Fn(f64, bool) -> (f64, f64, f64), e: f64| {
        // distance above the mean, S, and dy/de
        let of_limit = |measured| {
            let (distance, spread, _) = look(limit, measured);
            distance / spread
        };
        if stuck {
            return oracle(nu, of_limit(false)).1;
        }
        let (distance, spread, stretch) = look(e, true);
        let density = oracle(nu, distance / spread).0 - spread.ln() + stretch.ln();
        density - if truncated { oracle(nu, -of_limit(true)).1 } else { 0.0 }
    };
    let middle = trend::middle_film_ratio(runs);
    let mut sum = 0.0;
    for group in &runs.dry {
        for run in group.rebounds.start..group.stuck.end {
            let (s, u) = errors(run);
            let (k, v) = (full[COMMON_SLOTS + group.particle], runs.impact_speed[run]);
            let e_dry = |v: f64| form.dry.restitution(k, v);
            let h = 1e-5 * v;
            let slope = (e_dry(v + h) - e_dry(v - h)) / (2.0 * h);
            let look = |e: f64, measured: bool| {
                let on = f64::from(u8::from(measured));
                let speed_part = s * (on * e_dry(v) / v + slope);
                (
                    e - e_dry(v),
                    (full[ParameterKind::SigmaDry.slot()].powi(2) + on * u * u + speed_part * speed_part).sqrt(),
                    1.0,
                )
            };
            sum += term(group.stuck.contains(&run), &look, runs.restitution[run]);
        }
    }
    for series in &runs.series {
        for run in series.runs() {
            let (s, u) = errors(run);
            let v = runs.impact_speed[run];
            let r = |v: f64| {
                let row = NewRun {
                    particle: &scene.particles[series.particle].name,
                    liquid: Some(&scene.liquids[series.liquid].name),
                    diameter: runs.diameter[run],
                    film: Some((runs.film[run], 0.0)),
                    impact_speed: v,
                    restitution: f64::NAN,
                };
                kept(scene, (&row, middle), form, full)
            };
            let h = 1e-5 * v;
            let slope = (r(v + h) - r(v - h)) / (2.0 * h);
            let look = |e: f64, measured: bool| {
                let on = f64::from(u8::from(measured));
                if both {
                    let y = rebound::kept_of_mean_restitution(e);
                    let turn = rebound::slope_mean_restitution(y);
                    let speed_part = s * (e / (v * turn) + slope);
                    let own = (full[ParameterKind::SigmaWet.slot()].powi(2) + on * u * u) / (turn * turn);
                    return (
                        y - r(v),
                        (full[ParameterKind::SigmaEnergy.slot()].powi(2) + own + speed_part * speed_part).sqrt(),
                        1.0 / turn,
                    );
                }
                let step = s * slope;
                let speed_part = on * s * m(r(v)) / v + 0.5 * (m(r(v) + step) - m(r(v) - step));
                (
                    e - m(r(v)),
                    (full[ParameterKind::SigmaWet.slot()].powi(2) + on * u * u + speed_part * speed_part).sqrt(),
                    1.0,
                )
            };
            sum += term(series.stuck.contains(&run), &look, runs.restitution[run]);
        }
    }
    sum
}

/// Every tail, every kind of noise, with and without errors, and with stuck runs counted or not logged.
#[test]
fn runs_one_at_a_time_are_summed_as_it_is_written() {
    let mut cases = 0;
    for likelihood in [scene::LikelihoodFamily::Normal, scene::LikelihoodFamily::Student] {
        for noise in [NoiseOn::Restitution, NoiseOn::Both] {
            for sticking in [Sticking::Censored, Sticking::Truncated] {
                for errors in [false, true] {
                    let mut scene = scene();
                    scene.model.likelihood = likelihood;
                    scene.model.noise = noise;
                    scene.model.sticking = sticking;
                    let runs = runs(&scene, 20, "runs_one_at_a_time_are_summed_as_it_is_written");
                    let runs = if errors { with_errors(runs) } else { runs };
                    let plain =
                        likelihood == scene::LikelihoodFamily::Normal && noise == NoiseOn::Restitution && !errors;
                    for form in forms() {
                        agree(&scene, &runs, form, plain);
                    }
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 16);
}

fn agree(scene: &Scene, runs: &Runs, form: Form, plain: bool) {
    let model = &scene.model;
    let name = format!("{:?} {:?} {:?} {form:?}", model.likelihood, model.noise, model.sticking);
    let full = &with_trends(FULL);
    let likelihood = Likelihood::of_rows(scene, runs, form);
    assert_eq!(likelihood.needs_rows(), !plain);
    let (mut slopes, mut unused) = ([0.0; SLOTS], [0.0; SLOTS]);
    let value = likelihood.ln_density(full, &mut slopes).expect("inside the domain");
    let expected = by_run(scene, runs, form, full);
    // the oracle's slopes in v are differences
    let gap = (value - expected).abs() / (100.0 + expected.abs());
    assert!(gap < 1e-8, "{name}: {value} {expected}");
    let pointwise = Pointwise::new(scene, runs, form);
    let at = pointwise.at(full);
    let summed: f64 = (0..pointwise.len()).map(|run| at.ln_likelihood(run)).sum();
    let gap = (value - summed).abs() / (100.0 + value.abs());
    assert!(gap < 1e-10, "{name}: {value} {summed}");
    for (place, slope) in slopes.iter().enumerate() {
        let h = 1e-6 * full[place];
        let mut at = |step| {
            likelihood
                .ln_density(&shifted(full, place, step), &mut unused)
                .expect("inside")
        };
        let difference = (at(h) - at(-h)) / (2.0 * h);
        let gap = (slope - difference).abs() / (1.0 + difference.abs());
        assert!(gap < 1e-5, "{name} {place}: {slope} {difference}");
    }
}

/// Errors of zero are none, and change no bit of what rows say.
#[test]
fn errors_of_zero_are_none() {
    let scene = scene();
    let runs = runs(&scene, 20, "errors_of_zero_are_none");
    let mut zero = runs.clone();
    zero.errors = Some(MeasurementErrors {
        impact_speed_sd: vec![0.0; runs.len()],
        restitution_sd: vec![0.0; runs.len()],
    });
    let form = Form::new(Inertia::Saturating, DRY_SPEEDS[1]);
    let mut slopes = [0.0; SLOTS];
    let [expected, found] = [&runs, &zero].map(|runs| {
        let rows = Likelihood::of_rows(&scene, runs, form);
        rows.ln_density(&FULL, &mut slopes).expect("inside")
    });
    assert!((found / expected - 1.0).abs() < 1e-13, "{found} {expected}");
    let at = [&runs, &zero].map(|runs| {
        let pointwise = Pointwise::new(&scene, runs, form);
        let at = pointwise.at(&FULL);
        (0..pointwise.len())
            .map(|run| at.ln_likelihood(run))
            .collect::<Vec<f64>>()
    });
    for (found, expected) in at[1].iter().zip(&at[0]) {
        assert!(
            (found - expected).abs() <= 1e-13 * (1.0 + expected.abs()),
            "{found} {expected}"
        );
    }
}

/// New draws have the probabilities that the likelihood gives them, on both sides of a run's median.
#[test]
fn new_draws_lie_below_a_restitution_as_often_as_they_are_expected_to() {
    const DRAWS: usize = 20_000;
    let mut rng = crate::seed::stream(1, "new_draws_lie_below_a_restitution", 0);
    for (likelihood, noise, errors) in [
        (scene::LikelihoodFamily::Student, NoiseOn::Restitution, false),
        (scene::LikelihoodFamily::Normal, NoiseOn::Restitution, true),
        (scene::LikelihoodFamily::Student, NoiseOn::Restitution, true),
    ] {
        let mut scene = scene();
        (scene.model.likelihood, scene.model.noise) = (likelihood, noise);
        let runs = runs(&scene, 20, "new_draws_lie_below_a_restitution");
        let runs = if errors { with_errors(runs) } else { runs };
        let pointwise = Pointwise::new(&scene, &runs, Form::new(Inertia::Saturating, DRY_SPEEDS[0]));
        let at = pointwise.at(&FULL);
        let rebounds = (0..runs.len()).filter(|run| runs.restitution[*run] > 0.3).step_by(29);
        for run in rebounds {
            let (mean, sigma) = at.mean_and_sigma(run);
            for side in [-2.0, 1.0] {
                let e = mean + side * sigma;
                let probability = at.tails().probability(at.z(run, e));
                let below = (0..DRAWS).filter(|_| at.predict(run, &mut rng) < e).count() as f64;
                let n = DRAWS as f64;
                let z = (below - n * probability) / (n * probability * (1.0 - probability)).sqrt();
                assert!(z.abs() < 4.5, "{run} {side}: {z}");
            }
        }
    }
}
