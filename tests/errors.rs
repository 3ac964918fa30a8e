//! Holds fits of runs with measurement errors: coverage, precision, an oracle, and the speed error that matters.

use crate::common::scenes::{design, scene_of, truth, AK10, PTFE};
use crate::common::{add_errors, binomial_z, holds, mean, normal, rows, seed_of, Place, Told};
use rand::rngs::ChaCha8Rng;
use rand::SeedableRng;
use wetcor::findings::{self, Findings};
use wetcor::inference::delta::interval;
use wetcor::inference::effective_variance::{ErrorColumns, ErrorWeights};
use wetcor::inference::law::Law;
use wetcor::inference::least_squares::Fit;
use wetcor::inference::regression::Regression;
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::runs::{arrange, Table};

/// α and β of the truth.
const TRUTH: [f64; 2] = [0.52, -0.09];

/// Runs of a series, as they were read.
#[derive(Default, Clone)]
struct Measured {
    x: Vec<f64>,
    speed: Vec<f64>,
    restitution: Vec<f64>,
    impact_speed_sd: Vec<f64>,
    restitution_sd: Vec<f64>,
}

/// What one run of a design errs by: s_v/v and s_r/v, and whether that is told.
type Errs = (f64, f64, bool);

fn draw(rng: &mut ChaCha8Rng, runs: usize, sigma: f64, errs: impl Fn(usize) -> Errs) -> Measured {
    let mut measured = Measured::default();
    for run in 0..runs {
        let mut z = || normal(rng);
        let v = 0.3 * 10f64.powf((run % 12) as f64 / 11.0);
        let (of_v, of_r, told) = errs(run);
        let e = (TRUTH[0] + TRUTH[1] / v).sqrt() + sigma * z();
        let read = v * (1.0 + of_v * z());
        let told = f64::from(u8::from(told));
        measured.add(read, (e * v + of_r * v * z()) / read, [told * of_v * read, told * of_r]);
    }
    measured
}

impl Measured {
    /// A run with the sds of its speed and of its restitution.
    fn add(&mut self, speed: f64, restitution: f64, [of_speed, of_restitution]: [f64; 2]) {
        self.x.push(1.0 / speed);
        self.speed.push(speed);
        self.restitution.push(restitution);
        self.impact_speed_sd.push(of_speed);
        self.restitution_sd.push(of_restitution);
    }
    fn errors(&self) -> ErrorColumns {
        let of_speed = self.impact_speed_sd.iter().zip(&self.speed);
        ErrorColumns {
            relative_speed_sd: of_speed.map(|(sd, v)| sd / v).collect(),
            restitution_sd: self.restitution_sd.clone(),
            ..ErrorColumns::default()
        }
    }
    fn regression(&self) -> Regression<'_> {
        Regression::new(Law::SQUARE_ROOT, &self.x, &self.restitution)
    }
    fn plain(&self) -> Fit {
        self.regression().fit()
    }
    fn weighed(&self) -> (Fit, ErrorWeights) {
        let (fit, weighing) = self.regression().fit_with_errors(Some(&self.errors()));
        (fit, weighing.expect("runs with errors"))
    }
}

fn rng(test: &str) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed_of(test))
}

/// Errors of v and of v_r that differ tenfold; every seventh run errs by nothing, of every eleventh they were not told.
fn tenfold(of_v: f64, of_r: f64) -> impl Fn(usize) -> Errs {
    move |run| {
        let factor = 10f64.powf(((run / 12) % 5) as f64 / 4.0 - 0.5);
        let given = f64::from(u8::from(run % 7 != 0));
        (given * factor * of_v, given * factor * of_r, run % 11 != 0)
    }
}

#[test]
fn weighed_fits_cover_and_are_sharper_than_plain_ones() {
    const SETS: usize = 600;
    let mut rng = rng("weighed_fits_cover_and_are_sharper_than_plain_ones");
    for (sigma, of_v, of_r) in [(0.01, 0.005, 0.005), (0.005, 0.01, 0.01), (0.002, 0.01, 0.002)] {
        let (mut covered, mut weighed, mut plain) = ([0; 2], vec![], vec![]);
        for _ in 0..SETS {
            let measured = draw(&mut rng, 60, sigma, tenfold(of_v, of_r));
            let (fit, _) = measured.weighed();
            for j in 0..2 {
                let se = fit.se(j).expect("a covariance");
                let made = interval(fit.parameters[j], se, fit.degrees_of_freedom, 0.95).expect("runs to spare");
                covered[j] += usize::from(holds(Some([made.lo, made.hi]), TRUTH[j]));
            }
            weighed.push((fit.parameters[1] - TRUTH[1]).powi(2));
            plain.push((measured.plain().parameters[1] - TRUTH[1]).powi(2));
        }
        let z = covered.map(|covered| binomial_z(covered, SETS, 0.95));
        assert!(z.iter().all(|z| z.abs() < 4.0), "{sigma}: {z:?}");
        let gains: Vec<f64> = plain.iter().zip(&weighed).map(|(plain, own)| plain - own).collect();
        let (gain, mcse) = mean(&gains);
        assert!(gain > 4.0 * mcse, "{sigma}: {gain:e} ± {mcse:e}");
    }
}

/// Where errors are all there is, their χ² is one a degree of freedom; with the covariance of e and v forgotten, or with
/// the wrong sign, it is not.
#[test]
fn errors_explain_the_scatter_they_make() {
    const SETS: usize = 400;
    let mut rng = rng("errors_explain_the_scatter_they_make");
    let (mut right, mut without, mut wrong) = (vec![], vec![], vec![]);
    for _ in 0..SETS {
        let measured = draw(&mut rng, 60, 0.0, |run| (0.01 + 0.001 * (run % 7) as f64, 0.003, true));
        let (fit, weighing) = measured.weighed();
        right.push(weighing.summary.reduced_chi_squared);
        let with = |tau2: &dyn Fn(f64, f64) -> f64| {
            let mut faulty = measured.clone();
            for run in 0..faulty.x.len() {
                let m = (TRUTH[0] + TRUTH[1] * faulty.x[run]).sqrt();
                let of_v = faulty.impact_speed_sd[run] * faulty.x[run];
                let slope = -TRUTH[1] * faulty.x[run] / (2.0 * m);
                faulty.restitution_sd[run] = (faulty.restitution_sd[run].powi(2) + of_v * of_v * tau2(m, slope)).sqrt();
                faulty.impact_speed_sd[run] = 0.0;
            }
            faulty.weighed().1.summary.reduced_chi_squared
        };
        without.push(with(&|m, slope| m * m + slope * slope));
        wrong.push(with(&|m, slope| (m - slope) * (m - slope)));
        assert!(fit.covariance.is_ok());
    }
    let z = |values: &[f64]| {
        let (mean, mcse) = mean(values);
        (mean - 1.0) / mcse
    };
    assert!(z(&right).abs() < 4.5, "{:?}", mean(&right));
    assert!(z(&without) > 20.0, "{:?}", mean(&without));
    assert!(z(&wrong) > 20.0, "{:?}", mean(&wrong));
}

/// Errors of v alone pull β towards zero; what is taken off leaves it where it is.
#[test]
fn errors_of_the_speed_do_not_bias_a_weighed_fit() {
    const SETS: usize = 600;
    let mut rng = rng("errors_of_the_speed_do_not_bias_a_weighed_fit");
    let (mut weighed, mut plain) = (vec![], vec![]);
    for _ in 0..SETS {
        let measured = draw(&mut rng, 60, 0.005, |_| (0.03, 0.001, true));
        let z = |fit: &Fit| (fit.parameters[1] - TRUTH[1]) / fit.se(1).expect("a covariance");
        weighed.push(z(&measured.weighed().0));
        plain.push(z(&measured.plain()));
    }
    let ((weighed, mcse), (plain, _)) = (mean(&weighed), mean(&plain));
    assert!(weighed.abs() < 4.0 * mcse, "{weighed} ± {mcse}");
    assert!(plain > 4.5 * mcse, "{plain} ± {mcse}");
}

#[test]
fn fits_are_those_of_an_independent_program() {
    let text = include_str!("data/effective_variance/reference.json");
    let reference: serde_json::Value = serde_json::from_str(text).expect("the reference is JSON");
    let column = |value: &serde_json::Value| -> Vec<f64> {
        let numbers = value.as_array().expect("a list").iter();
        numbers.map(|x| x.as_f64().expect("a number")).collect()
    };
    let runs = |name: &str| column(&reference["runs"][name]);
    let fits = reference["fits"].as_array().expect("a list");
    assert_eq!(fits.len(), 3);
    for expected in fits {
        let number = |name: &str| expected[name].as_f64().expect("a number");
        let [of_v, of_e] = ["impact_speed_sd", "restitution_sd"].map(&runs);
        let mut measured = Measured::default();
        for (run, (v, e)) in runs("speed").into_iter().zip(runs("restitution")).enumerate() {
            measured.add(v, e, [of_v[run], of_e[run]].map(|sd| sd * number("scale")));
        }
        let (fit, weighing) = measured.weighed();
        let near = |found: f64, expected: f64| {
            let most = 1e-8 * expected.abs();
            assert!((found - expected).abs() <= most, "{found} and {expected}");
        };
        for j in 0..2 {
            near(fit.parameters[j], column(&expected["parameters"])[j]);
            near(fit.se(j).expect("a covariance"), column(&expected["se"])[j]);
            // its curvature is a difference
            let ratio = weighing.bias[j] / column(&expected["bias"])[j];
            assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
        }
        near(weighing.summary.intrinsic_sd, number("intrinsic_sd"));
        near(weighing.summary.reduced_chi_squared, number("reduced_chi_squared"));
    }
}

#[test]
fn an_error_far_too_small_or_large_has_no_infinite_weight() {
    let mut rng = rng("an_error_far_too_small_or_large_has_no_infinite_weight");
    let plain = draw(&mut rng, 60, 0.01, |_| (0.01, 0.01, false));
    // nothing but an error whose square vanishes is no error
    let mut one = Measured {
        restitution_sd: vec![0.0; 60],
        ..plain
    };
    one.restitution_sd[7] = 1e-300;
    let (fit, weighing) = one.regression().fit_with_errors(Some(&one.errors()));
    assert_eq!((fit, weighing), (one.plain(), None));
    // among others it counts as one of them
    let mut among = draw(&mut rng, 60, 0.01, |_| (0.01, 0.01, true));
    let (usual, _) = among.weighed();
    let near = |fit: &Fit, share: f64| {
        let apart = (fit.parameters[1] - usual.parameters[1]).abs() / fit.se(1).expect("a covariance");
        assert!(apart < share, "{apart}");
    };
    among.restitution_sd[7] = 1e-300;
    among.impact_speed_sd[7] = 0.0;
    let (fit, weighing) = among.weighed();
    assert_eq!(weighing.summary.runs_with_errors, 59);
    near(&fit, 0.3);
    // and one that is huge leaves its run out
    for sd in [1e3, 1e60] {
        among.restitution_sd[7] = sd;
        among.restitution[7] = 1.09;
        let (fit, weighing) = among.weighed();
        near(&fit, 0.5);
        assert!(weighing.variance.iter().all(|variance| *variance > 0.0));
    }
    among.impact_speed_sd[8] = 1e60;
    let (fit, weighing) = among.weighed();
    assert_eq!(weighing.summary.runs_left_out, 1);
    near(&fit, 0.5);
}

/// A rebound read below the threshold holds a plain fit at the edge of the law's domain; its error of v lets it go.
#[test]
fn a_run_that_may_have_been_too_slow_to_rebound_is_left_out() {
    let mut rng = rng("a_run_that_may_have_been_too_slow_to_rebound_is_left_out");
    let mut measured = draw(&mut rng, 60, 0.005, |_| (0.01, 0.005, true));
    let slow = 0.95 * -TRUTH[1] / TRUTH[0];
    measured.add(slow, 0.1, [0.05 * slow, 0.005]);
    let far = |fit: &Fit| (fit.parameters[1] - TRUTH[1]).abs() / fit.se(1).unwrap_or(1e-9);
    let plain = measured.plain();
    assert!(far(&plain) > 4.5, "{plain:?}");
    let (fit, weighing) = measured.weighed();
    assert_eq!((weighing.summary.runs_left_out, fit.degrees_of_freedom), (1, 58));
    assert!(far(&fit) < 4.0, "{fit:?}");
    // with a speed that is exact, nothing lets it go
    measured.impact_speed_sd[60] = 0.0;
    let (held, _) = measured.regression().fit_with_errors(Some(&measured.errors()));
    assert!(far(&held) > 4.5, "{held:?}");
}

/// The same sets with and without errors of v, twice as large as those that matter: β moves by four tenths of its error.
#[test]
fn the_speed_error_that_matters_moves_beta_as_it_says() {
    const SETS: usize = 4000;
    let mut rng = rng("the_speed_error_that_matters_moves_beta_as_it_says");
    // enough runs that a tenth of a standard error is a small error of v
    let design = draw(&mut rng, 240, 0.01, |_| (0.0, 0.0, false));
    let fit = design.plain();
    let regression = design.regression();
    let share = regression.speed_error_that_matters(&fit, &[], &[]).expect("a bias");
    assert!((0.002..0.03).contains(&share), "{share}");
    let se = fit.se(1).expect("a covariance");
    let moved = (0..SETS).map(|_| {
        let mut read = Measured::default();
        for (v, e) in design.speed.iter().zip(&design.restitution) {
            let factor = 1.0 + 2.0 * share * normal(&mut rng);
            read.add(v * factor, e / factor, [0.0; 2]);
        }
        (read.plain().parameters[1] - fit.parameters[1]) / se
    });
    let (moved, mcse) = mean(&Vec::from_iter(moved));
    assert!(mcse < 0.02, "{mcse}");
    assert!((moved.abs() - 0.4).abs() < 4.0 * mcse + 0.02, "{moved} ± {mcse}");
}

fn scene_text() -> String {
    let speeds = ["0.5, 0.7, 1.0, 1.4, 2.0", "0.5, 1.0, 2.0"];
    let design = design(["4, 8", "0.03, 0.06, 0.09"], &["AK10"], speeds, "repeats = 5\n");
    let design = design.replace("height_mm", "impact_speed_m_s");
    let bootstrap = "[bootstrap]\nreplicates = 2000\n";
    let truth = truth([1.85, 0.9, 0.004, 0.004], "");
    scene_of("errors", &[PTFE, AK10, &truth, &design, bootstrap])
}

/// A drawn table with errors of v of 1 % and of v_r of 0.5 %, tenfold apart; of every ninth run they are not told.
fn with_errors(place: &Place, test: &str) -> Findings {
    let mut rng = rng(test);
    let (mut rows, mut sds) = (rows(&place.scene, seed_of(test)), vec![]);
    for (run, row) in rows.iter_mut().enumerate() {
        let (v, e) = (row.impact_speed, row.restitution);
        let factor = 10f64.powf((run % 5) as f64 / 4.0 - 0.5);
        let mut z = || normal(&mut rng);
        let (s_v, s_r) = (0.01 * factor * v, 0.005 * factor * v);
        row.impact_speed = v + s_v * z();
        row.restitution = (e * v + s_r * z()) / row.impact_speed;
        let told = f64::from(u8::from(run % 9 != 0));
        sds.push([told * s_v, told * s_r / row.impact_speed]);
    }
    let mut runs = arrange(&place.scene, &rows);
    add_errors(&mut runs, &sds);
    findings::fit_least_squares(&place.scene, &Table::of(runs), 1, true)
}

/// Errors of the speed are asked for where they are not given.
#[test]
fn a_scene_with_errors_is_weighed_in_every_fit_and_replicate() {
    let test = "a_scene_with_errors_is_weighed_in_every_fit_and_replicate";
    let place = Place::new(&scene_text());
    let found = with_errors(&place, test);
    let without = place.infer(seed_of("errors_of_the_speed_are_asked_for_where_they_are_not_given"));
    assert!(!found.tells("speed_error_matters") && without.tells("speed_error_matters"));
    let given = found.counts.measurement_errors.expect("runs carry errors");
    assert_eq!(given.runs, given.of_impact_speed);
    assert!(given.runs > 150 && given.runs < found.counts.runs);
    assert!(found.dry.iter().all(|dry| dry.measurement_errors.is_some()));
    assert!(found.series.iter().all(|series| series.measurement_errors.is_some()));
    let balance = found.balance();
    assert!(balance.verdict.passed, "{}", balance.verdict.reason);
    let spread = balance.measurement_errors.expect("runs carry errors").intrinsic_sd;
    assert!((0.003..0.005).contains(&spread), "{spread}");
    for row in found.scaling.iter().filter(|row| row.film_ratio.is_some()) {
        assert!(row.verdict.passed, "{}", row.verdict.reason);
        assert!(row.measurement_errors.is_some());
        for estimate in [&row.estimates[EInf], &row.estimates[StC]] {
            let (value, se) = estimate.pair().expect("an error");
            let boot = estimate.bootstrap.as_ref().expect("replicates");
            let of_replicates = boot.se.expect("replicates");
            assert!((of_replicates / se).ln().abs() < 0.4, "{of_replicates} and {se}");
            // drawing runs of unlike weights moves their mean
            let bias = boot.bias.expect("replicates").abs();
            assert!(bias < 0.5 * se, "{boot:?}");
            let [lo, hi] = estimate.interval.expect("an interval");
            assert!(lo < value && value < hi);
        }
    }
    assert!(!found.tells("measurement_errors_too_large"));
}
