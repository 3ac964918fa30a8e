//! Tests of the likelihood a run at a time against the statement as it is written, with slopes taken by differences.

use rayon::prelude::*;
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};

use super::*;
use crate::runs::RunError;

/// The tails of the statement: normal, or Student's, scaled so that they hold as much within 1 as the normal ones do.
enum OracleTails {
    Normal,
    Student { t: StudentsT, scale: f64 },
}

impl OracleTails {
    fn new(nu: Option<f64>) -> OracleTails {
        let Some(nu) = nu else {
            return OracleTails::Normal;
        };
        let t = StudentsT::new(0.0, 1.0, nu).expect("valid");
        let scale = t.inverse_cdf(Normal::standard().cdf(1.0));
        OracleTails::Student { t, scale }
    }

    fn ln_density(&self, z: f64) -> f64 {
        match self {
            OracleTails::Normal => Normal::standard().ln_pdf(z),
            OracleTails::Student { t, scale } => t.ln_pdf(scale * z) + scale.ln(),
        }
    }

    /// ln of the probability of less.
    fn ln_below(&self, z: f64) -> f64 {
        match self {
            OracleTails::Normal => ln_normal_cdf(z).0,
            OracleTails::Student { t, scale } if z < 0.0 => t.cdf(scale * z).ln(),
            OracleTails::Student { t, scale } => (1.0 - t.cdf(-scale * z)).ln(),
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

/// The statement at some parameters, a run at a time: what is hidden of it is integrated over with very many steps.
struct Oracle<'o> {
    scene: &'o Scene,
    runs: &'o Runs,
    form: Form,
    full: &'o [f64],
    tails: OracleTails,
    /// the film ratio at which L and C have no trend
    middle: f64,
    errors: Option<Vec<RunError>>,
    true_speeds: Option<runs::TrueSpeeds>,
}

impl Oracle<'_> {
    fn of(&self, kind: ParameterKind) -> f64 {
        self.full[kind.slot()]
    }

    /// The dry group of a run; of a wet one none.
    fn dry(&self, run: usize) -> Option<&runs::DryGroup> {
        let mut groups = self.runs.dry.iter();
        groups.find(|group| (group.rebounds.start..group.stuck.end).contains(&run))
    }

    fn is_stuck(&self, run: usize) -> bool {
        let of_dry = self.runs.dry.iter().map(|group| &group.stuck);
        let of_series = self.runs.series.iter().map(|series| &series.stuck);
        of_dry.chain(of_series).any(|stuck| stuck.contains(&run))
    }

    /// Mean of e* at a speed, where so much more of the energy is kept.
    fn mean(&self, run: usize, v: f64, lucky: f64) -> f64 {
        if let Some(group) = self.dry(run) {
            let e_dry = self.form.dry.restitution(self.full[COMMON_SLOTS + group.particle], v);
            return rebound::mean_restitution(e_dry.powi(2));
        }
        let mut series = self.runs.series.iter();
        let series = series.find(|series| series.runs().contains(&run)).expect("wet");
        let row = NewRun {
            particle: &self.scene.particles[series.particle].name,
            liquid: Some(&self.scene.liquids[series.liquid].name),
            diameter: self.runs.diameter[run],
            film: Some((self.runs.film[run], 0.0)),
            impact_speed: v,
            restitution: f64::NAN,
        };
        rebound::mean_restitution(kept(self.scene, (&row, self.middle), self.form, self.full) + lucky)
    }

    /// Log of the density of a run at the true speed over the measured one, or of the probability that it rebounded.
    fn ln_at(&self, run: usize, q: f64, was_logged: bool) -> f64 {
        let is_dry = self.dry(run).is_some();
        let sigma = self.of([ParameterKind::SigmaWet, ParameterKind::SigmaDry][usize::from(is_dry)]);
        let limit = self.scene.data.smallest_restitution;
        let of = |mean: f64| {
            if was_logged {
                return self.tails.ln_below((mean - limit) / sigma);
            }
            if self.is_stuck(run) {
                return self.tails.ln_below((limit - mean) / sigma);
            }
            let own = self.errors.as_ref().map_or(0.0, |errors| errors[run].restitution_sd);
            let spread = (sigma * q).hypot(own);
            self.tails.ln_density((self.runs.restitution[run] - mean * q) / spread) - spread.ln()
        };
        let v = q * self.runs.impact_speed[run];
        if is_dry || self.scene.model.noise != NoiseOn::Both {
            return of(self.mean(run, v, 0.0));
        }
        let energy = self.of(ParameterKind::SigmaEnergy);
        over_normal(40.0, 30_000, |z| of(self.mean(run, v, energy * z)))
    }

    /// The same of runs that share their true speed, or of one, at any.
    fn ln_of(&self, all: &[usize], was_logged: bool) -> f64 {
        let product = |z: f64| -> f64 {
            let each = all.iter().map(|run| {
                let of_run = self.true_speeds.as_ref().map(|speeds| speeds.of_run[*run]);
                let true_speed = of_run.unwrap_or(runs::TrueSpeed::EXACT);
                self.ln_at(*run, true_speed.mean + true_speed.sd * z, was_logged)
            });
            each.sum()
        };
        // a dry run that stuck is that far off
        match &self.errors {
            Some(errors) if errors[all[0]].impact_speed_sd > 0.0 => over_normal(40.0, 8_000, product),
            _ => product(0.0),
        }
    }
}

/// The log likelihood as it is written.
pub(super) fn by_run(scene: &Scene, runs: &Runs, form: Form, full: &[f64]) -> f64 {
    let films = runs.series.iter().flat_map(|series| series.runs());
    let logs: Vec<f64> = films.map(|run| (runs.film[run] / runs.diameter[run]).ln()).collect();
    let errors = runs.errors_with_medians();
    let is_student = scene.model.likelihood == scene::LikelihoodFamily::Student;
    let oracle = Oracle {
        scene,
        runs,
        form,
        full,
        tails: OracleTails::new(is_student.then_some(full[SHAPE_SLOT])),
        middle: (logs.iter().sum::<f64>() / logs.len() as f64).exp(),
        true_speeds: errors.as_ref().map(|errors| runs.true_speeds(scene, errors)),
        errors,
    };
    let shared = oracle.true_speeds.iter().flat_map(|all| &all.shared);
    let groups: Vec<Vec<usize>> = shared.map(|shared| shared.runs().collect()).collect();
    let is_alone = |run: &usize| !groups.iter().flatten().any(|shared| shared == run);
    let alone = (0..runs.len()).filter(is_alone).map(|run| vec![run]);
    let mut sum = 0.0;
    for all in groups.iter().cloned().chain(alone) {
        sum += oracle.ln_of(&all, false);
        let logged: Vec<usize> = all.into_iter().filter(|run| !oracle.is_stuck(*run)).collect();
        if scene.model.sticking == Sticking::Truncated && !logged.is_empty() {
            sum -= oracle.ln_of(&logged, true);
        }
    }
    sum
}

/// Every tail, every kind of noise, with and without errors, and with stuck runs counted or not logged.
#[test]
#[ignore = "slow: run with --ignored"]
fn runs_one_at_a_time_are_summed_as_it_is_written() {
    let mut cases = vec![];
    for likelihood in [scene::LikelihoodFamily::Normal, scene::LikelihoodFamily::Student] {
        for noise in [NoiseOn::Restitution, NoiseOn::Both] {
            for sticking in [Sticking::Censored, Sticking::Truncated] {
                for errors in [ErrorsOf::None, ErrorsOf::Repeats, ErrorsOf::Apart] {
                    let mut scene = scene();
                    scene.model.likelihood = likelihood;
                    scene.model.noise = noise;
                    scene.model.sticking = sticking;
                    cases.push((scene, errors));
                }
            }
        }
    }
    assert_eq!(cases.len(), 24);
    cases.par_iter().for_each(|(scene, errors)| {
        let (both, errors) = (scene.model.noise == NoiseOn::Both, *errors);
        // an integral by very many steps takes its time, one in two dimensions the most
        let (each, forms) = match (both, errors) {
            (false, ErrorsOf::None) => (20, forms()),
            (true, ErrorsOf::Apart) => (4, vec![forms()[0]]),
            _ => (10, vec![forms()[0]]),
        };
        let runs = runs(scene, each, "runs_one_at_a_time_are_summed_as_it_is_written");
        let runs = errors.added_to(runs);
        for form in &forms {
            agree(scene, &runs, *form, errors, &with_trends(FULL, *form));
            if scene.model.likelihood == scene::LikelihoodFamily::Normal && forms.len() > 1 {
                for full in [FULL, WIDE, with_trends(WIDE, *form)] {
                    agree(scene, &runs, *form, errors, &full);
                }
            }
        }
    });
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
        // a run close to its threshold bends the curve within a step
        let [near, far] = [h, 2.0 * h].map(|h| (at(h) - at(-h)) / (2.0 * h));
        let difference = near + (near - far) / 3.0;
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
