//! Holds the bootstrap against R's boot, the fast kernels against the full fit, and replicates against threads.

use crate::common::{kept, read_in_project, Place, Told};
use crate::laws::{number, rows, Row};
use crate::statistics;
use wetcor::findings::{self, Findings};
use wetcor::inference::bootstrap::intervals::Replicates;
use wetcor::inference::bootstrap::jackknife::acceleration;
use wetcor::inference::bootstrap::{replicate, weights, Plan, Pool, Target};
use wetcor::inference::kernel;
use wetcor::inference::law::Law;
use wetcor::inference::regression::Regression;
use wetcor::physics::dry::Order;
use wetcor::physics::Quantity::{EInf, StC, ThresholdSpeed};
use wetcor::ranks::Ranks;
use wetcor::scene::ResamplingScheme;
use wetcor::study::calibration::{self, DrawnSets};

fn table(name: &str) -> Vec<Row> {
    rows(&read_in_project(&format!("tests/data/boot/{name}.csv")).replace('"', ""))
}

fn column(table_name: &str, name: &str) -> Vec<f64> {
    table(table_name).iter().map(|row| number(row, name)).collect()
}

/// R's replicates, estimate and acceleration in; R's z0 and limits out.
#[test]
fn intervals_are_rs_given_its_replicates() {
    for name in ["city_ratio", "aircondit_mean", "law_cor"] {
        let replicates = Replicates::new(column(&format!("{name}_t"), "t").into_iter());
        let mut compared = 0;
        for row in table(&format!("{name}_ci")) {
            let numbers = ["conf", "lo", "hi", "t0", "z0", "a"].map(|name| number(&row, name));
            let [level, lo, hi, estimate, z0, a] = numbers;
            // the replicates are stored with 15 digits: so must the estimate be, or its ties come apart
            let estimate: f64 = format!("{estimate:.14e}").parse().expect("a number");
            let made = match row["type"].as_str() {
                "perc" => replicates.percentile(level, f64::INFINITY).expect("replicates"),
                "bca" => replicates.bca(estimate, a, level, f64::INFINITY).expect("defined"),
                _ => continue,
            };
            assert!((replicates.z0(estimate) - z0).abs() < 1e-10, "{name}: z0");
            let close = |x: f64, y: f64| (x - y).abs() <= 1e-10 * y.abs();
            assert!(close(made.lo, lo) && close(made.hi, hi), "{name} {row:?}: {made:?}");
            compared += 1;
            // the planted fault: the acceleration's sign flipped
            if row["type"] == "bca" && a.abs() > 0.05 {
                let flipped = replicates.bca(estimate, -a, level, f64::INFINITY).expect("defined");
                assert!(!close(flipped.lo, lo) && !close(flipped.hi, hi), "{name}: {flipped:?}");
            }
        }
        assert_eq!(compared, 4, "{name}");
    }
}

/// R's influence values in, R's acceleration out.
#[test]
fn the_acceleration_is_rs_given_its_influence_values() {
    for name in ["city_ratio", "aircondit_mean", "law_cor"] {
        let expected = number(&table(&format!("{name}_ci"))[0], "a");
        let found = acceleration(&[column(&format!("{name}_L"), "L")]);
        assert!((found / expected - 1.0).abs() < 1e-9, "{name}: {found} {expected}");
    }
}

#[test]
fn undefined_intervals_say_why() {
    let equal = Replicates::new([0.5, 0.5, 0.5].into_iter());
    assert_eq!(equal.bca(0.5, 0.0, 0.95, f64::INFINITY), Err("all replicates equal"));
    let above = Replicates::new([0.6, 0.7, f64::NAN].into_iter());
    assert!(above.mean_sd().is_some_and(|(mean, _)| (mean - 0.65).abs() < 1e-12));
    assert_eq!(above.bca(0.5, 0.0, 0.95, f64::INFINITY), Err("z0 infinite"));
    let around = Replicates::new([0.4, 0.6, 0.7].into_iter());
    let found = around.bca(0.5, f64::NAN, 0.95, f64::INFINITY);
    assert_eq!(found, Err("acceleration not finite"));
    let none = Replicates::new(std::iter::empty());
    assert!(none.percentile(0.95, f64::INFINITY).is_none());
}

/// e at each x, by a law and a scatter of its own.
fn scattered(x: &[f64]) -> Vec<f64> {
    let of = |(run, x): (usize, &f64)| (0.52 - 7.4 * x).sqrt() + 0.02 * (7.0 * run as f64).sin();
    x.iter().enumerate().map(of).collect()
}

/// Runs of one series with a spread of weights, a zero among them.
fn runs() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let x: Vec<f64> = (0..37).map(|i| 0.004 + 0.0011 * f64::from(i)).collect();
    let e = scattered(&x);
    let w = (0..37).map(|i| f64::from((i * 7) % 4)).collect();
    (x, e, w)
}

/// The same runs with each repeated as often as it weighs.
fn repeated(values: &[f64], w: &[f64]) -> Vec<f64> {
    let each = values.iter().zip(w);
    each.flat_map(|(v, w)| std::iter::repeat_n(*v, *w as usize)).collect()
}

#[test]
fn the_kernels_are_the_full_fit() {
    let (x, e, w) = runs();
    let roots: Vec<f64> = x.iter().map(|x| (100.0 * x).powf(0.2)).collect();
    let known: Vec<f64> = x.iter().map(|x| 0.01 + 0.3 * x).collect();
    // from starts far from the minimum, too: but for the bent dry law the problem is convex
    let far = [[0.5, -7.0], [0.9, -1.0], [0.3, 5.0]];
    let fit = |law: Law, x: &[f64], offset: &[f64], starts: &[[f64; 2]]| {
        let [x_of_each, offset_of_each, e_of_each] = [x, offset, &e].map(|column| repeated(column, &w));
        let full = Regression {
            offset: &offset_of_each,
            ..Regression::new(law, &x_of_each, &e_of_each)
        };
        let full = full.fit().parameters;
        let sample = Regression {
            offset,
            ..Regression::new(law, x, &e).weighted(&w)
        };
        for start in starts {
            let fast = kernel::fit(&sample, *start).expect("determined");
            for (found, expected) in fast.iter().zip(&full) {
                let apart = (found / expected - 1.0).abs();
                assert!(apart <= 1e-11, "{law:?}: {fast:?} {full:?}");
            }
        }
        full
    };
    let plain = fit(Law::SQUARE_ROOT, &x, &[], &far);
    let shifted = fit(Law::SQUARE_ROOT, &x, &known, &far);
    assert!((shifted[0] / plain[0] - 1.0).abs() > 0.01);
    fit(Law::LINEAR, &x, &[], &[[0.5, 0.0]]);
    let straight = fit(Law::Dry(Order::First), &roots, &[], &[[0.0; 2]]);
    let bent = fit(Law::Dry(Order::Second), &roots, &[], &[[straight[0], 0.0]]);
    assert!((bent[0] / straight[0] - 1.0).abs() > 0.01);
}

/// Strata of these sizes, of one x each or of an x a run, as x and a scattered e.
fn strata(sizes: &[usize], alike: impl Fn(usize) -> bool) -> (Pool, Vec<f64>, Vec<f64>) {
    let (mut pool, mut x) = (Pool::default(), vec![]);
    for (stratum, size) in sizes.iter().enumerate() {
        pool.strata.push(x.len()..x.len() + size);
        let of = |run: usize| 0.004 + 0.002 * stratum as f64 + if alike(stratum) { 0.0 } else { 1e-4 * run as f64 };
        x.extend((0..*size).map(of));
    }
    pool.series.push(0..x.len());
    let e = scattered(&x);
    (pool, x, e)
}

/// However strata are drawn and summed, a replicate is the fit of every run with the weight it was drawn with.
#[test]
fn every_replicate_is_the_plain_fit_of_its_weights() {
    let sizes = [1, 2, 3, 4, 5, 6, 7, 8, 9, 17, 1, 5];
    let kinds: [fn(usize) -> bool; 3] = [|_| true, |_| false, |stratum| stratum % 2 == 0];
    for alike in kinds {
        let (pool, x, e) = strata(&sizes, alike);
        let offset: Vec<f64> = x.iter().map(|x| 0.01 + 0.3 * x).collect();
        // one target has all strata, the other those in the middle
        let some = pool.strata[3].start..pool.strata[9].end;
        let targets: Vec<Target> = [
            (Law::Dry(Order::First), [0.3, 0.0]),
            (Law::LINEAR, [0.72, 6.0]),
            (Law::SQUARE_ROOT, [0.5, -7.0]),
        ]
        .into_iter()
        .flat_map(|(law, fitted)| {
            let offset: &[f64] = if law == Law::SQUARE_ROOT { &offset } else { &[] };
            let of = |runs: std::ops::Range<usize>, strata| Target {
                regression: Regression {
                    offset: offset.get(runs.clone()).unwrap_or(&[]),
                    ..Regression::new(law, &x[runs.clone()], &e[runs])
                },
                strata,
                series: 0..1,
                fitted,
                errors: None,
            };
            [of(0..x.len(), 0..sizes.len()), of(some.clone(), 3..10)]
        })
        .collect();
        let plan = Plan {
            replicates: 150,
            scheme: ResamplingScheme::Cases,
            seed: 11,
        };
        let found = replicate(&pool, &targets, plan, &|_| ());
        // a stratum stays as large as it is, and would not with the strata forgotten
        let off = |by: &Pool| {
            let drawn = weights(by, plan.seed, 3);
            let sum = |stratum: &std::ops::Range<usize>| drawn[stratum.clone()].iter().sum::<f64>();
            let apart = pool.strata.iter().map(|own| (sum(own) - own.len() as f64).abs());
            apart.fold(0.0, f64::max)
        };
        assert!(off(&pool) < 1e-9);
        let forgotten = Pool {
            strata: pool.series.clone(),
            series: pool.series.clone(),
        };
        assert!(off(&forgotten) > 0.5);
        let distance = |target: usize, number: usize, drawn: u64| {
            let is_of_all = target.is_multiple_of(2);
            let runs = if is_of_all { 0..e.len() } else { some.clone() };
            let weights = &weights(&pool, plan.seed, drawn)[runs];
            let sample = targets[target].regression.weighted(weights);
            let plain = kernel::fit(&sample, targets[target].fitted).expect("determined");
            let found = found[target][number].expect("determined");
            let apart = |(a, b): (f64, f64)| if a == b { 0.0 } else { (a - b).abs() / b.abs() };
            found.into_iter().zip(plain).map(apart).fold(0.0, f64::max)
        };
        for target in 0..targets.len() {
            for number in 0..plan.replicates {
                let off = distance(target, number, number as u64);
                assert!(off < 1e-12, "{target} {number}: {off}");
            }
            // the planted fault: weights of another replicate
            assert!(distance(target, 3, 4) > 1e-4, "{target}");
        }
    }
}

#[test]
fn replicates_spread_as_the_delta_method_says() {
    let place = Place::new(&(statistics::clear() + "\n[bootstrap]\nreplicates = 4000\n"));
    let table = place.draw(3, None);
    let found: Findings = findings::fit_least_squares(&place.scene, &table, 1, true);
    let slowest = &found.series[0].estimates[ThresholdSpeed];
    // near β = 0 replicates of it have no mean: what stands is the fit's own, at both levels
    let methods: Vec<&str> = slowest.intervals.iter().map(|made| made.method).collect();
    assert_eq!(methods[..2], ["delta"; 2], "{slowest:?}");
    assert!(!methods.contains(&"percentile") && slowest.bootstrap.is_none());
    let row = found.square_root();
    for estimate in [&row.estimates[EInf], &row.estimates[StC]] {
        // the delta method's interval is kept at the scene's level alone
        let kept = estimate.intervals.iter();
        let kept: Vec<(&str, f64)> = kept.map(|made| (made.method, made.level)).collect();
        assert_eq!(kept, [("delta", 0.95), ("percentile", 0.9), ("percentile", 0.95)]);
        let boot = estimate.bootstrap.as_ref().expect("bootstrapped");
        let ratio = boot.se.expect("replicates") / estimate.se.expect("converged");
        assert!((0.85..1.15).contains(&ratio) && boot.failed == 0, "{ratio} {boot:?}");
    }
}

/// The committed coverage table is the one the command makes, as far as rounding on another machine may move a count.
#[test]
#[ignore = "slow: .ci/run runs it"]
fn the_committed_coverage_table_is_measured() {
    let drawn = DrawnSets {
        sets: calibration::SETS,
        seed: 1,
        ranks: &Ranks::alone(),
        progress: &|| (),
    };
    let table = calibration::measure(drawn).unwrap_or_else(|error| panic!("{error}"));
    let measured = calibration::markdown(&table).expect("a page");
    let committed = kept("reports/calibration.md", &measured);
    assert_eq!(measured.lines().count(), committed.lines().count());
    for (a, b) in measured.lines().zip(committed.lines()) {
        for (a, b) in a.split('|').zip(b.split('|')) {
            match (a.trim().parse::<f64>(), b.trim().parse::<f64>()) {
                (Ok(a), Ok(b)) => assert!((a - b).abs() <= 0.5, "{a} {b}"),
                _ => assert!(a == b || a.contains("Largest distance"), "{a}\n{b}"),
            }
        }
    }
    // the default is what the table supports
    let default = wetcor::findings::bootstrap::DEFAULT_INTERVAL.name();
    let best = format!("the default: {default}.");
    assert!(committed.contains(&best) && measured.contains(&best), "{best}");
}
