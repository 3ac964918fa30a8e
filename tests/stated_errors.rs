//! Holds that a spread held at 0 leaves the stated measurement errors as all noise, and gates where they are not.

use crate::common::scenes::{design, scene_of, truth, PTFE, STEPWISE, THIN};
use crate::common::{
    assert_expected, assert_seldom, cells, compare, counts, holds, normal, rows, sample_as_usual, seed_of, study,
    Place, Told,
};
use wetcor::findings::remarks::BEYOND_CHANCE;
use wetcor::findings::{self, Findings};
use wetcor::remark::Remark;
use wetcor::seed::stream;

fn scene_text() -> String {
    let asked = "[sampler]\nwarmup = 300\ndraws = 300\n[bootstrap]\nreplicates = 200\n";
    let truth = truth([1.85, 1.0, 0.0, 0.0], "");
    let speeds = ["30, 60, 100, 150", "0.4, 0.8, 1.2, 1.6, 2.0"];
    let design = design(["4.762", "0.04, 0.1"], &["thin"], speeds, "repeats = 4\n");
    scene_of(
        "stated errors",
        &[PTFE, THIN, STEPWISE, ESTIMATED, asked, &truth, &design],
    )
}

const ESTIMATED: &str = "[priors]\nsigma_dry = { fixed = 0 }\nsigma_wet = { fixed = 0 }\n";

/// A table whose runs err as they state, times a factor.
fn table(place: &Place, seed: u64, factor: f64) -> String {
    let mut rng = stream(seed, "stated errors", 0);
    let mut csv = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution,restitution_sd\n".to_owned();
    for (index, run) in rows(&place.scene, seed).into_iter().enumerate() {
        let z = normal(&mut rng);
        let sd = 0.006 * (1 + index % 3) as f64;
        let e = run.restitution + factor * sd * z;
        csv.push_str(&format!("{},{e},{sd}\n", cells(&run)));
    }
    csv
}

fn fit(place: &Place, seed: u64, factor: f64) -> Findings {
    place.fit_rows(&table(place, seed, factor))
}

fn of_errors(findings: &Findings) -> Vec<&Remark> {
    let all = findings.checks();
    all.filter(|check| check.code.starts_with("stated_errors")).collect()
}

#[test]
fn right_errors_pass_and_halved_ones_gate() {
    const SETS: u64 = 150;
    let test = "right_errors_pass_and_halved_ones_gate";
    const TRUTHS: [(&str, f64); 3] = [
        ("dry_k[PTFE]", 0.183),
        ("lubrication_log", 1.85),
        ("inertial_prefactor", 1.0),
    ];
    let found = study(test, SETS, |seed| {
        let findings = fit(&Place::new(&scene_text()), seed, 1.0);
        let [dry, wet] = of_errors(&findings)[..] else {
            panic!("a check of dry and one of wet runs")
        };
        let is_low = |check: &Remark| check.value.expect("a p") < 0.05;
        let [k, l, c] = TRUTHS.map(|(name, truth)| holds(findings.fitted(name).interval, truth));
        [is_low(dry), is_low(wet), !dry.passed, !wet.passed, k, l, c]
    });
    let [low_dry, low_wet, gated_dry, gated_wet, covered @ ..] = counts(&found);
    assert_expected("p below 0.05", low_dry + low_wet, 2 * SETS, 0.05);
    assert_seldom("gated", gated_dry + gated_wet, 2 * SETS, BEYOND_CHANCE);
    for ((name, _), count) in TRUTHS.into_iter().zip(covered) {
        assert_expected(name, count, SETS, 0.95);
    }
    // the planted fault: errors half of what they are
    let faulty = study(test, 20, |seed| {
        let findings = fit(&Place::new(&scene_text()), seed, 2.0);
        [of_errors(&findings).iter().any(|check| check.forbids()) && !findings.main.verdict.passed]
    });
    assert_eq!(counts(&faulty), [20]);
}

#[test]
fn with_a_spread_estimated_errors_are_only_told() {
    let place = Place::new(&scene_text().replace(ESTIMATED, ""));
    let findings = fit(&place, seed_of("with_a_spread_estimated_errors_are_only_told"), 2.0);
    assert!(of_errors(&findings).is_empty());
    let balance = findings.balance();
    let told = balance.measurement_errors.expect("runs with errors");
    assert!(
        told.p.expect("a p") < BEYOND_CHANCE && told.intrinsic_sd > 0.0,
        "{told:?}"
    );
    assert!(findings.main.verdict.passed, "{:?}", findings.main.verdict);
}

#[test]
#[ignore = "slow: run with --ignored"]
fn the_posterior_is_that_of_the_errors_alone() {
    let place = Place::new(&scene_text().replace("repeats = 4", "repeats = 8"));
    let seed = seed_of("the_posterior_is_that_of_the_errors_alone");
    for (factor, may_be_quoted) in [(1.0, true), (2.0, false)] {
        let table = place.read_rows(&table(&place, seed, factor));
        let mut findings = findings::fit_least_squares(&place.scene, &table, 1, true);
        let posterior = sample_as_usual(&mut findings, &place.scene, &table.runs);
        let compared = compare(&mut findings, &place.scene, &table.runs, &posterior);
        assert!(compared.iter().all(|model| model.elpd_loo.is_finite()));
        let held = posterior.findings.left_out.iter();
        let held: Vec<_> = held.map(|held| (held.name.as_str(), held.value)).collect();
        assert_eq!(held, [("sigma_dry", Some(0.0)), ("sigma_wet", Some(0.0))]);
        assert_eq!(
            findings.main.verdict.passed, may_be_quoted,
            "{:?}",
            findings.main.verdict
        );
        // errors alone: as wide as the inverse of the weighted squares, whatever the scatter
        for own in &posterior.findings.parameters {
            let (mean, sd) = own.mean.zip(own.sd).expect("sampled");
            let (value, se) = findings.fitted(&own.name).pair().expect("a ±");
            assert!((mean - value).abs() < 0.3 * se, "{}: {mean} {value} {se}", own.name);
            assert!((sd / se - 1.0).abs() < 0.15, "{}: {sd} {se}", own.name);
        }
    }
}
