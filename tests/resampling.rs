//! Holds the jackknife and percentile intervals against a script and coverage against its level.

use crate::common::scenes::{design, scene_of, truth, M20, PTFE};
use crate::common::{binomial_z, counts, holds, mean, normal, read_in_project, seed_of, study, Place, Says};
use wetcor::findings::bootstrap::{self, Estimates, Options, Resampling, MOST_RESAMPLED};
use wetcor::findings::estimate::{Estimate, QuantityEstimates};
use wetcor::findings::{self, dry, scaling, series, FitSetup};
use wetcor::inference::bootstrap::intervals::Replicates;
use wetcor::inference::bootstrap::jackknife::{acceleration, degrees_of_freedom, influence, leave_one_out};
use wetcor::inference::bootstrap::{replicate, Plan, Pool, Target};
use wetcor::inference::kernel;
use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;
use wetcor::physics::Quantity;
use wetcor::physics::Quantity::{Alpha, Beta, EInf, InertialLoss, StC};
use wetcor::runs::Table;
use wetcor::scene::{IntervalMethod, ResamplingScheme};
use wetcor::seed::stream;

fn rows(name: &str) -> Vec<Vec<String>> {
    let text = read_in_project(&format!("tests/data/bootstrap/{name}"));
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    text.lines().skip(1).map(cells).collect()
}

fn numbers(row: &[String]) -> Vec<f64> {
    row.iter().map(|cell| cell.parse().expect("a number")).collect()
}

fn quantity(law: &str, name: &str) -> fn([f64; 2]) -> f64 {
    match (law, name) {
        ("linear", "e_inf") => |p| p[0],
        ("linear", _) => |p| p[1] / p[0],
        (_, "e_inf") => |p| p[0].sqrt(),
        _ => |p| -p[1] / (2.0 * p[0]),
    }
}

/// One series of so many strata.
pub fn target(regression: Regression, strata: usize, fitted: [f64; 2]) -> Target {
    Target {
        regression,
        strata: 0..strata,
        series: 0..1,
        fitted,
        errors: None,
    }
}

/// Influences of the runs of each stratum on a quantity.
fn influences(pool: &Pool, target: &Target, value: f64, of: impl Fn([f64; 2]) -> f64) -> Vec<Vec<f64>> {
    let without = leave_one_out(pool, target, ResamplingScheme::Cases);
    let of_stratum = |fits: &Vec<[f64; 2]>| influence(value, fits.iter().map(|p| of(*p)));
    without.iter().map(of_stratum).collect()
}

/// The same runs and weights to both: numpy in extended precision, and our kernels.
#[test]
fn jackknife_and_percentile_limits_are_the_scripts() {
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
        let of = quantity(law, &row[1]);
        let (own, start) = match law {
            "linear" => (Law::LINEAR, [0.5, 0.0]),
            _ => (Law::SQUARE_ROOT, [0.52, -7.4]),
        };
        let fit = |w: &[f64]| kernel::fit(&Regression::new(own, &x, &e).weighted(w), start);
        let full = fit(&vec![1.0; x.len()]).expect("determined");
        let value = of(full);
        let target = target(Regression::new(own, &x, &e), 3, full);
        let influences = influences(&pool, &target, value, of);
        let made = Replicates::new(weights.iter().map(|w| of(fit(w).expect("determined"))));
        let limits = [0.90, 0.95].map(|level| made.percentile(level, f64::INFINITY).expect("replicates"));
        let mut found = vec![value, acceleration(&influences)];
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
            of(fit(&w).expect("determined"))
        };
        let faulty: Vec<Vec<f64>> = pool
            .strata
            .iter()
            .map(|stratum| influence(value, stratum.clone().map(heavier)))
            .collect();
        assert!((acceleration(&faulty) / expected[1] - 1.0).abs() > 1e-3);
        compared += 1;
    }
    assert_eq!(compared, 4);
}

/// Of 95 % percentile intervals of the slope, over data sets of 8 strata of 3 runs whose noise grows with x.
#[test]
fn percentile_intervals_cover_and_with_their_ends_swapped_do_not() {
    const SETS: u64 = 1000;
    let name = "percentile_intervals_cover_and_with_their_ends_swapped_do_not";
    let x: Vec<f64> = (0..24).map(|run| 0.01 * f64::from(1 + run / 3)).collect();
    let pool = Pool {
        strata: (0..8).map(|stratum| 3 * stratum..3 * stratum + 3).collect(),
        series: std::iter::once(0..24).collect(),
    };
    // curved, so that the linear law is only near it
    let truth: Vec<f64> = x.iter().map(|x| 0.8 - 5.0 * x - 10.0 * x * x).collect();
    let line = |e: &[f64]| {
        let runs = Regression::new(Law::LINEAR, &x, e).weighted(&[1.0; 24]);
        kernel::fit(&runs, [0.5, 0.0]).expect("determined")
    };
    let aim = line(&truth)[1];
    let outcomes = study(name, SETS, |seed| {
        let mut rng = stream(seed_of(name), name, seed.wrapping_sub(seed_of(name)));
        let scattered = truth.iter().zip(&x).map(|(mean, x)| mean + 0.3 * x * normal(&mut rng));
        let e: Vec<f64> = scattered.collect();
        let fitted = line(&e);
        let target = target(Regression::new(Law::LINEAR, &x, &e), 8, fitted);
        let plan = Plan {
            replicates: 1000,
            scheme: ResamplingScheme::Cases,
            seed,
        };
        let influences = influences(&pool, &target, fitted[1], |p| p[1]);
        let df = degrees_of_freedom(&influences).expect("it varies");
        let fits = replicate(&pool, &[target], plan, &|_| ());
        let made = Replicates::new(fits[0].iter().map(|fit| fit.expect("determined")[1]));
        let [made, narrow] = [df, f64::INFINITY].map(|df| made.percentile(0.95, df).expect("replicates"));
        let ends = [[made.lo, made.hi], [made.hi, made.lo], [narrow.lo, narrow.hi]];
        ends.map(|ends| holds(Some(ends), aim))
    });
    let [hits, swapped, narrow] = counts(&outcomes);
    assert!(binomial_z(hits, SETS as usize, 0.95).abs() < 4.5, "{hits} of {SETS}");
    assert!(binomial_z(swapped, SETS as usize, 0.95) < -50.0, "{swapped} of {SETS}");
    // limits taken as if the spread were known
    assert!(narrow < hits, "{narrow} {hits}");
}

/// Noise that grows with 1/St: the delta method takes it as even, and both others do not.
fn many() -> String {
    let more = "inertia = \"saturating\"\nfilm_scale = 0.07\nnoise = \"heteroscedastic\"\n";
    let truth = truth([1.9, 0.45, 0.01, 0.02], more);
    let own = "film_rel_sd = 0.02\nimpact_speed_rel_sd = 0.05\n[bootstrap]\nreplicates = 1000\n";
    let films = ["4.762, 8.0", "0.04, 0.06, 0.10"];
    let design = design(films, &["M20"], ["60, 100, 150", "0.5, 1.0, 2.0"], own);
    scene_of("many runs", &[PTFE, M20, &truth, &design]).replace("runs.csv", "runs.parquet")
}

/// Every estimate that is resampled, and how.
fn resampled(place: &Place, table: &Table, most_resampled: usize) -> (Vec<Estimate>, Resampling) {
    let (scene, runs) = (&place.scene, &table.runs);
    let mut dry = dry::fit_dry_laws(scene, runs);
    let setup = FitSetup { scene, runs, dry: &dry };
    let mut series = series::fit_series(setup);
    let mut scaling = scaling::fit_scaling(setup);
    let estimates = Estimates {
        dry: &mut dry,
        series: &mut series,
        scaling: &mut scaling,
    };
    let options = Options {
        seed: seed_of("resampled"),
        keep_all: false,
        most_resampled,
    };
    let (resampling, _) = bootstrap::add_bootstrap_intervals(scene, runs, estimates, options, &|_| ());
    let of_dry = dry.into_iter().map(|fitted| fitted.dry_k);
    let of = |estimates: &QuantityEstimates, quantities: &[Quantity]| -> Vec<Estimate> {
        let all = estimates.iter().filter(|(quantity, _)| quantities.contains(quantity));
        all.map(|(_, estimate)| estimate.clone()).collect()
    };
    let of_series = series.iter();
    let of_series = of_series.flat_map(|fit| of(&fit.estimates, &[Alpha, Beta]));
    let of_law = [EInf, StC, InertialLoss];
    let of_scaling = scaling.iter().flat_map(|fitted| of(&fitted.estimates, &of_law));
    let all = of_dry.chain(of_series).chain(of_scaling);
    (all.collect(), resampling)
}

fn bootstrap_se(estimate: &Estimate) -> f64 {
    estimate.bootstrap.as_ref().and_then(|boot| boot.se).expect("resampled")
}

#[test]
fn the_sandwich_is_as_wide_as_the_replicates_that_it_stands_for() {
    let place = Place::new(&many());
    let table = place.draw(seed_of("runs of the sandwich"), Some(20_000));
    let (by_rows, of_rows) = resampled(&place, &table, usize::MAX);
    let (sandwich, of_many) = resampled(&place, &table, 0);
    assert_eq!(by_rows.len(), 1 + 2 * 6 + 2 * 2 * 4 + 2 * 3);
    assert_eq!([of_rows.resampled_fits, of_many.resampled_fits], [1 + 6 + 2 * 4, 0]);
    let pairs = sandwich.iter().zip(&by_rows);
    let found: Vec<f64> = pairs
        .map(|(own, by_rows)| bootstrap_se(own) / bootstrap_se(by_rows))
        .collect();
    // an sd of 1,000 replicates has a standard error of 2.2 %
    assert!(found.iter().all(|share| (share - 1.0).abs() < 0.09), "{found:?}");
    let (mean, _) = mean(&found);
    assert!((mean - 1.0).abs() < 0.02, "{mean}");
    for estimate in &sandwich {
        let half = 1.959_964 * bootstrap_se(estimate);
        let quoted = estimate.interval.expect("an interval");
        assert!((0.5 * (quoted[1] - quoted[0]) / half - 1.0).abs() < 1e-6);
        let methods = estimate.intervals.iter();
        let methods: Vec<(&str, f64)> = methods.map(|made| (made.method, made.level)).collect();
        assert_eq!(methods, [("delta", 0.95), ("sandwich", 0.9), ("sandwich", 0.95)]);
    }
    // the planted fault: the delta method's, which takes the noise as even
    let even = |estimate: &Estimate| estimate.se.expect("one") / bootstrap_se(estimate);
    assert!(sandwich.iter().any(|estimate| (even(estimate) - 1.0).abs() > 0.1));
}

#[test]
fn a_fit_of_many_that_hangs_on_few_runs_has_no_uncertainty_but_its_profile() {
    let text = [
        ("density_kg_m3 = 2150", "density_kg_m3 = 940"),
        ("viscosity_mPa_s = 20", "viscosity_mPa_s = 48.3"),
        ("noise = \"heteroscedastic\"", ""),
        ("[0.04, 0.06, 0.10]", "[0.03, 0.04]"),
    ];
    let text = text.iter().fold(many(), |text, (from, to)| text.replace(from, to));
    let place = Place::new(&text);
    let table = place.draw(seed_of("runs that hang on few"), Some(20_000));
    let (by_rows, _) = resampled(&place, &table, usize::MAX);
    let (of_many, resampling) = resampled(&place, &table, 0);
    // one series has fewer runs than a sandwich is quoted of
    assert_eq!(resampling.resampled_fits, 1);
    let hangs = |estimate: &Estimate| estimate.bootstrap.is_none();
    let (mut withheld, mut profiles, mut off) = (0, 0, false);
    for (estimate, by_rows) in of_many.iter().zip(&by_rows) {
        if !hangs(estimate) {
            let share = bootstrap_se(estimate) / bootstrap_se(by_rows);
            assert!((share - 1.0).abs() < 0.12, "{share}");
            continue;
        }
        let why = estimate.why_none.as_deref().expect("it says why");
        assert_eq!(estimate.se, None, "{why}");
        if estimate.method == "profile" {
            profiles += 1;
        } else {
            withheld += 1;
            assert_eq!((estimate.interval, estimate.intervals.len()), (None, 0));
            why.begins("a single run near the edge of the square root");
            // what the delta method would have said
            off |= by_rows
                .se
                .is_some_and(|se| (se / bootstrap_se(by_rows) - 1.0).abs() > 0.2);
        }
    }
    assert!(
        withheld + profiles > 3 && (withheld == 0 || off),
        "{withheld} {profiles} {off}"
    );
}

#[test]
#[ignore = "slow: run with --ignored"]
fn a_table_of_very_many_runs_is_told_that_nothing_was_resampled() {
    let mut place = Place::new(&many());
    let table = place.draw(1, Some(MOST_RESAMPLED as u64 + 800));
    let found = findings::fit_least_squares(&place.scene, &table, 1, true);
    let resampling = found.bootstrap.as_ref().expect("the stage ran");
    assert_eq!((resampling.by_sandwich, resampling.resampled_fits), (true, 0));
    let mut of_laws = found.scaling.iter().map(|row| &row.estimates[EInf]);
    let is_by = |estimate: &Estimate, method: &str| estimate.method == method && estimate.bootstrap.is_some();
    assert!(of_laws.all(|estimate| is_by(estimate, "sandwich")));
    // at the line, here one of fewer runs, they are resampled as ever
    place.scene.bootstrap.replicates = 2;
    let few = place.draw(1, Some(4_800));
    let by_sandwich = |most: usize| resampled(&place, &few, most).1.by_sandwich;
    let runs = few.runs.len();
    assert_eq!([runs - 1, runs].map(by_sandwich), [true, false]);
    // where the scene wants the interval of least squares, that is quoted
    let dry_k = |place: &Place| resampled(place, &few, 0).0.remove(0);
    assert!(is_by(&dry_k(&place), "sandwich"));
    place.scene.bootstrap.interval = Some(IntervalMethod::Delta);
    assert!(is_by(&dry_k(&place), "delta"));
}
