//! Holds the jackknife and studentized intervals against a script, coverage against its level, and says what cannot vary.

mod common;

use std::path::Path;

use common::{binomial_z, seed_of, Place};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use wetcor::findings::{self, Findings};
use wetcor::inference::bootstrap::intervals::{studentized, Replicates};
use wetcor::inference::bootstrap::jackknife::{acceleration, degrees_of_freedom, influence, leave_one_out};
use wetcor::inference::bootstrap::kernel::Sample;
use wetcor::inference::bootstrap::{kernel, replicate, Plan, Pool, Target};
use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;
use wetcor::scene::{ResamplingScheme, WetLaw};
use wetcor::seed::stream;

fn rows(name: &str) -> Vec<Vec<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/bootstrap")
        .join(name);
    let text = std::fs::read_to_string(path).expect("the reference is in the repository");
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

fn numbers(row: &[String]) -> Vec<f64> {
    row.iter().map(|cell| cell.parse().expect("a number")).collect()
}

/// A quantity of a law with its gradient.
type Quantity = (fn([f64; 2]) -> f64, fn([f64; 2]) -> [f64; 2]);

fn quantity(law: &str, name: &str) -> Quantity {
    match (law, name) {
        ("linear", "e_inf") => (|p| p[0], |_| [1.0, 0.0]),
        ("linear", _) => (|p| p[1] / p[0], |p| [-p[1] / (p[0] * p[0]), 1.0 / p[0]]),
        (_, "e_inf") => (|p| p[0].sqrt(), |p| [0.5 / p[0].sqrt(), 0.0]),
        _ => (|p| -p[1] / (2.0 * p[0]), |p| [p[1] / (2.0 * p[0] * p[0]), -0.5 / p[0]]),
    }
}

fn se([g, h]: [f64; 2], [aa, ab, bb]: [f64; 3]) -> f64 {
    (g * g * aa + 2.0 * g * h * ab + h * h * bb).sqrt()
}

/// The same runs and weights to both: numpy in extended precision, and our kernels.
#[test]
fn jackknife_and_studentized_limits_are_the_scripts() {
    let table: Vec<Vec<f64>> = rows("runs.csv").iter().map(|row| numbers(row)).collect();
    let [x, e] = [1, 2].map(|cell| table.iter().map(|row| row[cell]).collect::<Vec<f64>>());
    let mut pool = Pool {
        strata: vec![],
        series: std::iter::once(0..x.len()).collect(),
    };
    for stratum in 0..3 {
        let size = table.iter().filter(|row| row[0] == f64::from(stratum)).count();
        let start = pool.strata.last().map_or(0, |last| last.end);
        pool.strata.push(start..start + size);
    }
    let weights: Vec<Vec<f64>> = rows("replicates.csv").iter().map(|row| numbers(row)).collect();
    let mut compared = 0;
    for row in rows("reference.csv") {
        let (law, expected) = (row[0].as_str(), numbers(&row[2..]));
        let (of, gradient) = quantity(law, &row[1]);
        let fit = |w: &[f64]| match law {
            "linear" => kernel::linear(&Sample::new(&x, &e, w)),
            _ => kernel::square_root(&Sample::new(&x, &e, w), [0.52, -7.4]),
        };
        let full = fit(&vec![1.0; x.len()]).expect("determined");
        let (value, own) = (of(full.parameters), se(gradient(full.parameters), full.covariance));
        let target = Target {
            regression: Regression::new(if law == "linear" { Law::LINEAR } else { Law::SQUARE_ROOT }, &x, &e),
            strata: 0..3,
            series: 0..1,
            fitted: full.parameters,
            run_weights: None,
        };
        let influences: Vec<Vec<f64>> = leave_one_out(&pool, &target, ResamplingScheme::Cases)
            .iter()
            .map(|stratum| influence(value, stratum.iter().map(|p| of(*p))))
            .collect();
        let mut t = Replicates::new(weights.iter().map(|w| {
            let fit = fit(w).expect("determined");
            (of(fit.parameters) - value) / se(gradient(fit.parameters), fit.covariance)
        }));
        let limits = [0.90, 0.95].map(|level| studentized(&mut t, value, own, level).expect("replicates"));
        let mut found = vec![value, own, acceleration(&influences)];
        found.extend(degrees_of_freedom(&influences));
        found.extend(limits.iter().flat_map(|made| [made.lo, made.hi]));
        assert_eq!(found.len(), expected.len());
        for (place, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= 1e-10 * b.abs(), "{row:?}, {place}: {a} {b}");
        }
        // the planted fault: the others of a stratum left as they weigh
        let heavier = |run: usize| {
            let mut w = vec![1.0; x.len()];
            w[run] = 0.0;
            of(fit(&w).expect("determined").parameters)
        };
        let faulty: Vec<Vec<f64>> = pool
            .strata
            .iter()
            .map(|stratum| influence(value, stratum.clone().map(heavier)))
            .collect();
        assert!((acceleration(&faulty) / expected[2] - 1.0).abs() > 1e-3);
        compared += 1;
    }
    assert_eq!(compared, 4);
}

/// Coverage of 95 % percentile intervals of the slope over data sets of 8 strata of 3 runs, their noise growing with x;
/// `ends` makes the interval from the ends found.
fn covered(test: &str, unit_df: bool, ends: fn(f64, f64) -> (f64, f64)) -> (usize, usize) {
    const SETS: usize = 1000;
    let x: Vec<f64> = (0..24).map(|run| 0.01 * f64::from(1 + run / 3)).collect();
    let pool = Pool {
        strata: (0..8).map(|stratum| 3 * stratum..3 * stratum + 3).collect(),
        series: std::iter::once(0..24).collect(),
    };
    let seed = seed_of(test);
    let hits = (0..SETS as u64).into_par_iter().filter(|set| {
        let mut rng = stream(seed, test, *set);
        let e: Vec<f64> = x
            .iter()
            .map(|x| {
                let z: f64 = StandardNormal.sample(&mut rng);
                // curved, so that the linear law is only near it
                0.8 - 5.0 * x - 10.0 * x * x + 0.3 * x * z
            })
            .collect();
        let truth: Vec<f64> = x.iter().map(|x| 0.8 - 5.0 * x - 10.0 * x * x).collect();
        let slope = |e: &[f64]| {
            kernel::linear(&Sample::new(&x, e, &[1.0; 24]))
                .expect("determined")
                .parameters
        };
        let fitted = slope(&e);
        let target = Target {
            regression: Regression::new(Law::LINEAR, &x, &e),
            strata: 0..8,
            series: 0..1,
            fitted,
            run_weights: None,
        };
        let plan = Plan {
            replicates: 1000,
            scheme: ResamplingScheme::Cases,
            seed: seed.wrapping_add(*set),
        };
        let without = leave_one_out(&pool, &target, plan.scheme);
        let influences: Vec<Vec<f64>> = without
            .iter()
            .map(|stratum| influence(fitted[1], stratum.iter().map(|p| p[1])))
            .collect();
        let df = if unit_df {
            f64::INFINITY
        } else {
            degrees_of_freedom(&influences).expect("it varies")
        };
        let fits = replicate(&pool, &[target], plan, &|_| ());
        let made = Replicates::new(fits.of(0).map(|fit| fit.parameters[1])).percentile(0.95, df);
        let made = made.expect("replicates");
        let (lo, hi) = ends(made.lo, made.hi);
        let aim = slope(&truth)[1];
        lo <= aim && aim <= hi
    });
    (hits.count(), SETS)
}

#[test]
fn percentile_intervals_cover_and_with_their_ends_swapped_do_not() {
    let name = "percentile_intervals_cover_and_with_their_ends_swapped_do_not";
    let (hits, of) = covered(name, false, |lo, hi| (lo, hi));
    assert!(binomial_z(hits, of, 0.95).abs() < 4.5, "{hits} of {of}");
    let (swapped, of) = covered(name, false, |lo, hi| (hi, lo));
    assert!(binomial_z(swapped, of, 0.95) < -50.0, "{swapped} of {of}");
    // limits taken as if the spread were known
    let (narrow, _) = covered(name, true, |lo, hi| (lo, hi));
    assert!(narrow < hits, "{narrow} {hits}");
}

const SCENE: &str = r#"
title = "few runs"
[data]
runs = "runs.csv"
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[liquids.AK10]
density_kg_m3 = 930
viscosity_mPa_s = 9.3
[liquids.M20]
density_kg_m3 = 930
viscosity_mPa_s = 20
"#;

fn fitted(scheme: &str, runs: &str) -> Findings {
    let place = Place::new(&format!(
        "{SCENE}\n[bootstrap]\nscheme = \"{scheme}\"\nreplicates = 500\n"
    ));
    let header = "particle,liquid,diameter_mm,film_um,film_ratio,impact_speed_m_s,restitution";
    std::fs::write(&place.scene.data.runs[0].path, format!("{header}\n{runs}")).expect("the folder is writable");
    findings::fit_least_squares(&place.scene, &place.read(), 1, true)
}

/// Rebounds of one series about its square-root law.
fn series(liquid: &str, alpha: f64, beta: f64, runs: u32) -> String {
    let one = |run: u32| {
        let v = 0.9 + 0.1 * f64::from(run / 2);
        let e = (alpha + beta / v).sqrt() + 0.01 * (3.0 * f64::from(run)).sin();
        format!("PTFE,{liquid},4.762,286,0.06,{v:.2},{e:.4}\n")
    };
    (0..runs).map(one).collect()
}

fn notice<'f>(found: &'f Findings, code: &str) -> Option<&'f wetcor::notice::Notice> {
    found.notices.iter().find(|notice| notice.code == code)
}

#[test]
fn one_series_cannot_be_resampled_and_says_so() {
    let two = series("AK10", 0.5, -0.1, 12) + &series("M20", 0.5, -0.2, 12);
    let found = fitted("series", &two);
    // each series alone has nothing to draw in its place; both together have
    for row in &found.series {
        let boot = row.alpha.bootstrap.as_ref().expect("it is said");
        assert_eq!((boot.se, boot.replicates), (None, 0));
        assert!(boot.fallback.is_some_and(|why| why.contains("one series")), "{boot:?}");
        assert_eq!(row.alpha.method, "delta");
        assert!(row.alpha.interval.is_some());
    }
    let pooled = found
        .scaling
        .iter()
        .find(|row| row.law == WetLaw::Linear)
        .expect("wet runs");
    assert_eq!(pooled.e_inf.bootstrap.as_ref().map(|boot| boot.replicates), Some(500));
    assert_eq!(
        notice(&found, "bootstrap_one_series").map(|notice| notice.count),
        Some(2)
    );
    assert!(notice(&fitted("cases", &two), "bootstrap_one_series").is_none());
}

#[test]
fn failed_replicates_are_counted_with_their_reason_and_gate() {
    // each series at one speed: drawn alone, as every second of two is, it determines nothing
    let at = |liquid: &str, v: f64, e: f64| -> String {
        let one = |run: i32| {
            format!(
                "PTFE,{liquid},4.762,286,0.06,{v},{:.4}\n",
                e + 0.01 * f64::from(run % 3 - 1)
            )
        };
        (0..12).map(one).collect()
    };
    let found = fitted("series", &(at("AK10", 1.5, 0.68) + &at("M20", 1.0, 0.55)));
    let row = found
        .scaling
        .iter()
        .find(|row| row.law == WetLaw::Linear)
        .expect("wet runs");
    let boot = row.e_inf.bootstrap.as_ref().expect("it is said");
    assert_eq!((boot.failed, boot.replicates), (500, 500));
    assert_eq!(boot.failures.len(), 1, "{boot:?}");
    assert_eq!(
        (boot.failures[0].reason, boot.failures[0].replicates),
        ("degenerate resample", 500)
    );
    assert_eq!(row.e_inf.method, "delta");
    let check = found
        .verdicts
        .iter()
        .find(|check| check.check == "bootstrap_failures")
        .expect("checked");
    assert!(check.gates && !check.passed && check.value == Some(1.0), "{check:?}");
}

#[test]
fn strata_of_one_run_and_fits_of_few_runs_are_counted() {
    let one = "PTFE,M20,4.762,286,0.06,1.2,0.55\n";
    let found = fitted("cases", &(series("AK10", 0.5, -0.1, 24) + one));
    let single = notice(&found, "bootstrap_single_run_strata").expect("the single run is said");
    assert_eq!(single.count, 1);
    let resampling = found.bootstrap.as_ref().expect("resampled");
    assert_eq!((resampling.single_run_strata, resampling.strata), (1, 7));
    assert!(notice(&found, "bootstrap_few_runs").is_none(), "{:?}", found.notices);
    let few = fitted("cases", &series("AK10", 0.5, -0.1, 8));
    // resampling so few makes intervals too short
    assert_eq!(few.series[0].alpha.method, "delta");
    assert_eq!(
        fitted("cases", &series("AK10", 0.5, -0.1, 24)).series[0].alpha.method,
        "percentile"
    );
    assert!(notice(&few, "bootstrap_single_run_strata").is_none());
    // the series and both laws at its film ratio and over all
    assert_eq!(notice(&few, "bootstrap_few_runs").map(|notice| notice.count), Some(5));
    let stuck = fitted(
        "cases",
        &(series("AK10", 0.5, -0.1, 24) + "PTFE,AK10,4.762,286,0.06,0.95,0\n"),
    );
    assert_eq!(
        notice(&stuck, "bootstrap_partly_stuck").map(|notice| notice.count),
        Some(1)
    );
}
