//! Tests of the likelihood a run at a time against the statement as it is written, with slopes taken by differences.

use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use super::*;
use crate::runs::RunError;

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
fn with_errors(mut runs: Runs) -> Runs {
    let mut rng = crate::seed::stream(1, "with_errors", 0);
    for run in 0..runs.len() {
        let (speed, restitution) = (rng.random_range(0.0..0.02), rng.random_range(0.0..0.02));
        let [of_speed, of_restitution] = [run % 2 == 0, run % 3 > 0].map(|on| f64::from(u8::from(on)));
        runs.errors.push(RunError {
            impact_speed_sd: of_speed * speed * runs.impact_speed[run],
            restitution_sd: of_restitution * restitution,
            speed_correlation: 0.0,
        });
    }
    runs
}

/// ln ∫ φ(z) f(z) dz by very many steps.
fn over_normal(far: f64, steps: usize, ln_f: impl Fn(f64) -> f64) -> f64 {
    let step = 2.0 * far / steps as f64;
    let lns: Vec<f64> = (0..=steps)
        .map(|index| {
            let z = step * index as f64 - far;
            ln_f(z) + Normal::standard().ln_pdf(z)
        })
        .collect();
    let most = lns.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + (lns.iter().map(|ln| (ln - most).exp()).sum::<f64>() * step).ln()
}

/// What the oracle knows of a run.
struct OracleRun {
    v: f64,
    /// s/v and u
    errors: (f64, f64),
    /// the true speed over the measured one
    true_speed: runs::TrueSpeed,
    sigma: f64,
    /// σ_r
    energy: f64,
}

/// What the oracle is told of a run.
#[derive(Clone, Copy)]
enum OracleSeen {
    Rebound(f64),
    Stuck,
    /// that it rebounded
    Logged,
}

/// The statement a run at a time, or a group that shares its true speed: what is hidden of it is integrated over with very many steps.
pub(super) fn by_run(scene: &Scene, runs: &Runs, form: Form, full: &[f64]) -> f64 {
    let nu = (scene.model.likelihood == scene::LikelihoodFamily::Student).then_some(full[SHAPE_SLOT]);
    let both = scene.model.noise == NoiseOn::Both;
    let truncated = scene.model.sticking == Sticking::Truncated;
    let limit = scene.data.smallest_restitution;
    let filled = runs.errors_with_medians();
    let true_speeds = filled.as_ref().map(|errors| runs.true_speeds(scene, errors));
    let known = |run: usize, sigma: f64, energy: f64| {
        let v = runs.impact_speed[run];
        let errors = filled.as_ref();
        OracleRun {
            v,
            errors: errors.map_or((0.0, 0.0), |e| (e[run].impact_speed_sd / v, e[run].restitution_sd)),
            true_speed: true_speeds
                .as_ref()
                .map_or(runs::TrueSpeed::EXACT, |all| all.of_run[run]),
            sigma,
            energy,
        }
    };
    // log of a factor of the true speed over the measured one; `mean` is that of e* at a speed and a noise on the energy
    let factor = |run: &OracleRun, seen: OracleSeen, q: f64, mean: &dyn Fn(f64, f64) -> f64| {
        let of = |mean: f64| match seen {
            OracleSeen::Stuck => oracle(nu, (limit - mean) / run.sigma).1,
            OracleSeen::Logged => oracle(nu, (mean - limit) / run.sigma).1,
            OracleSeen::Rebound(e) => {
                let spread = (run.sigma * q).hypot(run.errors.1);
                oracle(nu, (e - mean * q) / spread).0 - spread.ln()
            }
        };
        if run.energy > 0.0 {
            over_normal(40.0, 30_000, |z| of(mean(q * run.v, run.energy * z)))
        } else {
            of(mean(q * run.v, 0.0))
        }
    };
    let films = runs.series.iter().flat_map(|series| series.runs());
    let logs: Vec<f64> = films.map(|run| (runs.film[run] / runs.diameter[run]).ln()).collect();
    let middle = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
    let mut sum = 0.0;
    let mut add = |all: &[usize],
                   seen: &dyn Fn(usize) -> OracleSeen,
                   means: &dyn Fn(usize, f64, f64) -> f64,
                   of: &dyn Fn(usize) -> OracleRun,
                   sign: f64| {
        let known: Vec<(usize, OracleRun)> = all.iter().map(|run| (*run, of(*run))).collect();
        let product = |z: f64| -> f64 {
            let each = known.iter().map(|(run, of)| {
                let q = of.true_speed.mean + of.true_speed.sd * z;
                factor(of, seen(*run), q, &|v, lucky| means(*run, v, lucky))
            });
            each.sum()
        };
        // a dry run that stuck is that far off
        let errs = known[0].1.errors.0 > 0.0;
        sum += sign
            * if errs {
                over_normal(40.0, 8_000, product)
            } else {
                product(0.0)
            };
    };
    let shared = true_speeds.iter().flat_map(|all| &all.shared);
    let groups: Vec<Vec<usize>> = shared.map(|shared| shared.runs().collect()).collect();
    let shared: std::collections::HashSet<usize> = groups.iter().flatten().copied().collect();
    let alone = (0..runs.len()).filter(|run| !shared.contains(run)).map(|run| vec![run]);
    let stuck = |run: usize| {
        let of_dry = runs.dry.iter().map(|group| &group.stuck);
        of_dry
            .chain(runs.series.iter().map(|series| &series.stuck))
            .any(|stuck| stuck.contains(&run))
    };
    for all in groups.iter().cloned().chain(alone) {
        let dry = |run: usize| {
            let mut groups = runs.dry.iter();
            groups.find(|group| (group.rebounds.start..group.stuck.end).contains(&run))
        };
        let energy = if both && dry(all[0]).is_none() {
            full[ParameterKind::SigmaEnergy.slot()]
        } else {
            0.0
        };
        let sigma = if dry(all[0]).is_some() {
            ParameterKind::SigmaDry
        } else {
            ParameterKind::SigmaWet
        };
        let of = |run: usize| known(run, full[sigma.slot()], energy);
        let mean = |run: usize, v: f64, lucky: f64| {
            if let Some(group) = dry(run) {
                let e_dry = form.dry.restitution(full[COMMON_SLOTS + group.particle], v);
                return rebound::mean_restitution(e_dry.powi(2));
            }
            let mut series = runs.series.iter();
            let series = series.find(|series| series.runs().contains(&run)).expect("wet");
            let row = NewRun {
                particle: &scene.particles[series.particle].name,
                liquid: Some(&scene.liquids[series.liquid].name),
                diameter: runs.diameter[run],
                film: Some((runs.film[run], 0.0)),
                impact_speed: v,
                restitution: f64::NAN,
            };
            rebound::mean_restitution(kept(scene, (&row, middle), form, full) + lucky)
        };
        let seen = |run: usize| {
            if stuck(run) {
                OracleSeen::Stuck
            } else {
                OracleSeen::Rebound(runs.restitution[run])
            }
        };
        add(&all, &seen, &mean, &of, 1.0);
        let logged: Vec<usize> = all.iter().copied().filter(|run| !stuck(*run)).collect();
        if truncated && !logged.is_empty() {
            add(&logged, &|_| OracleSeen::Logged, &mean, &of, -1.0);
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
                for errors in [ErrorsOf::None, ErrorsOf::Repeats, ErrorsOf::Apart] {
                    let mut scene = scene();
                    scene.model.likelihood = likelihood;
                    scene.model.noise = noise;
                    scene.model.sticking = sticking;
                    let integrated = errors != ErrorsOf::None || noise == NoiseOn::Both;
                    let each = if integrated { 10 } else { 20 };
                    let runs = runs(&scene, each, "runs_one_at_a_time_are_summed_as_it_is_written");
                    let runs = errors.added_to(runs);
                    // an integral by very many steps takes its time
                    let forms = if integrated { vec![forms()[0]] } else { forms() };
                    for form in forms {
                        agree(&scene, &runs, form, errors, &with_trends(FULL, form));
                        if likelihood == scene::LikelihoodFamily::Normal && !integrated {
                            for full in [FULL, WIDE, with_trends(WIDE, form)] {
                                agree(&scene, &runs, form, errors, &full);
                            }
                        }
                    }
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 24);
}

/// So wide a spread that truncation is felt by dry runs, too.
const WIDE: [f64; SLOTS] = {
    let mut full = FULL;
    // σ_wet and σ_dry
    full[4] = 0.05;
    full[5] = 0.2;
    full
};

/// Which runs have measurement errors, and whether some share a true speed, be it over settings.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ErrorsOf {
    None,
    Repeats,
    /// runs whose speeds are far apart
    Apart,
}

impl ErrorsOf {
    fn added_to(self, runs: Runs) -> Runs {
        /// beyond any gap between repeats
        const APART: f64 = 1.06;
        if self == ErrorsOf::None {
            return runs;
        }
        let mut runs = with_errors(runs);
        if self == ErrorsOf::Apart {
            let mut order: Vec<usize> = (0..runs.len()).collect();
            order.sort_by(|a, b| runs.impact_speed[*a].total_cmp(&runs.impact_speed[*b]));
            let mut last = 0.0;
            for run in order {
                if runs.impact_speed[run] < APART * last {
                    runs.errors[run].impact_speed_sd = 0.0;
                } else if runs.errors[run].impact_speed_sd > 0.0 {
                    last = runs.impact_speed[run];
                }
            }
        }
        runs
    }
}

fn agree(scene: &Scene, runs: &Runs, form: Form, errors: ErrorsOf, full: &[f64; SLOTS]) {
    let model = &scene.model;
    let (student, both) = (
        model.likelihood == scene::LikelihoodFamily::Student,
        model.noise == NoiseOn::Both,
    );
    let plain = !student && !both && runs.errors.is_empty();
    let name = format!("{:?} {:?} {:?} {form:?}", model.likelihood, model.noise, model.sticking);
    let likelihood = Likelihood::new(scene, runs, form);
    assert_eq!(likelihood.needs_rows, !plain);
    let (mut slopes, mut unused) = ([0.0; SLOTS], [0.0; SLOTS]);
    let value = likelihood.ln_density(full, &mut slopes).expect("inside the domain");
    // in two dimensions the integrals have a test of their own
    if !both || runs.errors.is_empty() {
        let within = if plain { 1e-12 } else { 1e-8 };
        let differs = |expected: f64| (value - expected).abs() > within * (100.0 + expected.abs());
        let expected = by_run(scene, runs, form, full);
        assert!(!differs(expected), "{name}: {value} {expected}");
        // the planted fault: k is off by a hundred-thousandth
        let off = shifted(full, SLOTS - 1, 1e-6);
        assert!(!plain || differs(by_run(scene, runs, form, &off)), "{name}");
    }
    if errors == ErrorsOf::Repeats {
        let errors = runs.errors_with_medians().expect("given");
        let shared = runs.true_speeds(scene, &errors).shared;
        assert!(shared.iter().any(|shared| shared.settings.len() > 1), "{name}");
    }
    let pointwise = Pointwise::new(scene, runs, form);
    let at = pointwise.at(full);
    let together = at.ln_likelihood_of(0..pointwise.len());
    let gap = (value - together).abs() / (100.0 + value.abs());
    assert!(gap < 1e-10, "{name}: {value} {together}");
    let summed: f64 = (0..pointwise.len()).map(|run| at.ln_likelihood(run)).sum();
    let gap = (value - summed).abs() / (100.0 + value.abs());
    // of runs that share a true speed each is told given the others
    if errors == ErrorsOf::Repeats {
        assert!(gap > 1e-10, "{name}: no run shares its true speed");
    } else {
        assert!(gap < 1e-10, "{name}: {value} {summed}");
    }
    at_many_draws(&pointwise, &name);
    for (place, slope) in slopes.iter().enumerate() {
        let h = 1e-6 * full[place].abs().max(0.1);
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

/// The likelihood of runs at many draws is that of one run at one draw, in blocks that begin and end anywhere.
fn at_many_draws(pointwise: &Pointwise, name: &str) {
    let draws: Vec<Vec<f64>> = (0..3)
        .map(|draw| FULL.iter().map(|x| x * (1.0 + 0.01 * f64::from(draw))).collect())
        .collect();
    let at = pointwise.at_draws(draws.iter().map(Vec::as_slice).collect());
    let laws: Vec<EvaluatedLaw> = draws.iter().map(|full| pointwise.at(full)).collect();
    assert_eq!(at.len(), draws.len());
    for first in (0..pointwise.len()).step_by(7) {
        let some = first..pointwise.len().min(first + 7);
        let mut rows = vec![f64::NAN; some.len() * draws.len()];
        at.ln_likelihoods(some.clone(), &mut rows);
        let one = |run: usize| laws.iter().map(move |law| law.ln_likelihood(run));
        let expected: Vec<f64> = some.flat_map(one).collect();
        assert_eq!(rows, expected, "{name}");
    }
}

/// How many standard deviations the most deviant share of new draws lies from its probability: of those below a restitution on
/// both sides of a run's mean, and of those that stick. Draws are made at these parameters.
fn farthest(scene: &Scene, errors: bool, drawn_at: &[f64], name: &str) -> f64 {
    const DRAWS: usize = 20_000;
    let mut rng = crate::seed::stream(1, name, 0);
    let runs = runs(scene, 20, name);
    let runs = if errors { with_errors(runs) } else { runs };
    let pointwise = Pointwise::new(scene, &runs, Form::new(Inertia::Saturating, DRY_SPEEDS[0]));
    let (at, drawn_at) = (pointwise.at(&FULL), pointwise.at(drawn_at));
    let limit = scene.data.smallest_restitution;
    let mut farthest: f64 = 0.0;
    for run in (0..runs.len()).step_by(7) {
        let (mean, sigma) = at.mean_and_sigma(run);
        let points = [mean - 2.0 * sigma, mean + sigma].map(|e| e.max(limit));
        let mut below = [0.0; 2];
        for _ in 0..DRAWS {
            let new = drawn_at.predict(run, &mut rng);
            assert!(new == 0.0 || new > limit);
            for (below, point) in below.iter_mut().zip(points) {
                *below += f64::from(u8::from(new <= point));
            }
        }
        for (below, point) in below.into_iter().zip(points) {
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
fn new_draws_have_the_probabilities_that_the_likelihood_gives_them() {
    let name = "new_draws_have_the_probabilities";
    for (likelihood, noise, errors) in [
        (scene::LikelihoodFamily::Normal, NoiseOn::Restitution, false),
        (scene::LikelihoodFamily::Normal, NoiseOn::Both, false),
        (scene::LikelihoodFamily::Student, NoiseOn::Both, false),
        (scene::LikelihoodFamily::Student, NoiseOn::Restitution, false),
        (scene::LikelihoodFamily::Normal, NoiseOn::Restitution, true),
        (scene::LikelihoodFamily::Student, NoiseOn::Restitution, true),
    ] {
        let mut scene = scene();
        (scene.model.likelihood, scene.model.noise) = (likelihood, noise);
        let found = farthest(&scene, errors, &FULL, name);
        assert!(found < 4.5, "{likelihood:?} {noise:?} {errors}: {found}");
    }
    // the planted fault: a spread that is a tenth too wide
    for kind in [ParameterKind::SigmaWet, ParameterKind::SigmaDry] {
        let mut wider = FULL;
        wider[kind.slot()] *= 1.1;
        let found = farthest(&scene(), false, &wider, name);
        assert!(found > 9.0, "{found}");
    }
}
