//! Holds how film ratios are grouped: which runs belong together, and which laws are then refused.

use crate::common::scenes::HEADER;
use crate::common::{read_in_project, seed_of, Place, Says, Told};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use wetcor::findings::scaling::Scaling;
use wetcor::findings::Findings;
use wetcor::physics::Quantity::{Alpha, Beta, EInf, StC, StCEInf2};
use wetcor::runs::WIDEST;
use wetcor::scene::WetLaw;

/// The truth the example's runs were drawn from.
const LUBRICATION_LOG: f64 = 1.85;

/// The example's scene with a line more in `[data]`.
fn scene(line: &str) -> Place {
    let example = read_in_project("datasets/mueller2016/scene.toml");
    Place::new(&example.replacen("[data]", &format!("[data]\n{line}"), 1))
}

/// The example's runs as if films and speeds had been measured run by run with these relative errors, without a column of
/// film ratios.
fn measured(test: &str, film: f64, speed: f64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed_of(test));
    let mut off = |sd: f64| {
        let (u, angle): (f64, f64) = (rng.random(), rng.random());
        1.0 + sd * (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    };
    let mut text = HEADER.to_owned();
    for line in read_in_project("datasets/mueller2016/runs.csv").lines().skip(1) {
        let [particle, liquid, diameter, thickness, _, v, e] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let film_of_run = thickness.parse::<f64>().map(|x| (x * off(film)).to_string());
        let film_of_run = film_of_run.unwrap_or_default();
        let v = v.parse::<f64>().expect("a speed") * off(speed);
        text.push_str(&format!("{particle},{liquid},{diameter},{film_of_run},{v},{e}\n"));
    }
    text
}

fn at(findings: &Findings, film_ratio: Option<f64>) -> Vec<&Scaling> {
    let rows = findings.scaling.iter();
    rows.filter(|row| row.film_ratio == film_ratio).collect()
}

#[test]
fn film_ratios_that_run_into_each_other_have_no_laws() {
    let test = "film_ratios_that_run_into_each_other_have_no_laws";
    let rows = measured(test, 0.02, 0.01);
    let findings = scene("").fit_rows(&rows);
    let wide = findings.film_groups.iter();
    let wide: Vec<_> = wide.filter(|group| group.why_no_laws.is_some()).collect();
    let mut of_pe = wide.iter().filter(|group| group.particle == "PE");
    assert!(of_pe.any(|group| group.width > 2.0 * WIDEST), "{wide:?}");
    for group in &wide {
        for row in at(&findings, Some(group.film_ratio)) {
            let why = group.why_no_laws.as_ref();
            assert!(!row.verdict.passed && Some(&row.verdict.reason) == why, "{row:?}");
            assert!(row.energy.is_some(), "of one film ratio");
            for quantity in [EInf, StC, StCEInf2] {
                let estimate = &row.estimates[quantity];
                assert!(estimate.value.is_none() && estimate.se.is_none() && estimate.why_none.as_ref() == why);
            }
            assert!(row.estimates.iter().all(|(_, estimate)| estimate.value.is_none()));
        }
        let mut series = findings.series.iter().filter(|one| one.film_ratio == group.film_ratio);
        assert!(series.all(|one| !one.verdict.passed
            && one.estimates[Alpha].value.is_none()
            && one.estimates[Beta].value.is_none()));
    }
    // whether one law holds for all of a particle's film ratios cannot be tested then
    assert!(at(&findings, None).iter().all(|row| !row.verdict.passed));
    // what uses each run's own film stands
    let found = findings.check("film_groups");
    assert!(!found.passed && !found.gates(), "{found:?}");
    // the runs that barely rebound are asked about without a posterior
    let mut others = findings.remarks.iter().filter(|check| check.code != "slow_rebounds");
    assert!(others.all(|check| !check.forbids()), "{:?}", findings.remarks);
    let (l, se) = findings.fitted("lubrication_log").pair().expect("it converged");
    assert!(((l - LUBRICATION_LOG) / se).abs() < 4.0, "{l} {se}");
    // the same films as they were meant have a law each
    let exact = measured(test, 0.0, 0.0);
    let findings = scene("").fit_rows(&exact);
    let mut film_groups = findings.film_groups.iter();
    assert!(film_groups.all(|group| group.why_no_laws.is_none() && group.width == 0.0));
    assert_eq!(findings.film_groups.len(), 14);
    assert!(findings.check("film_groups").passed);
}

#[test]
fn runs_near_no_nominal_film_ratio_count_where_their_own_film_does() {
    let rows = measured("runs_near_no_nominal_film_ratio", 0.0, 0.0);
    let place = scene("film_ratios = [0.06, 0.12]");
    let findings = place.fit_rows(&rows);
    let outside = findings.film_groups.iter().filter(|group| group.why_no_laws.is_some());
    let of_outside: usize = outside.map(|group| group.runs).sum();
    // of PTFE 300 below, 150 between and 150 above; of PE 350 below, 150 above
    let found = findings.check("film_groups");
    assert_eq!(of_outside, 950, "{found:?}");
    assert!(!found.passed && !found.gates(), "{found:?}");
    found.text.says("with 950 runs");
    let why = findings.film_groups[0].why_no_laws.as_deref();
    assert_eq!(why, Some("its runs lie more than 15 % from every one of film_ratios"));
    let mut roots = at(&findings, Some(0.06));
    roots.retain(|row| row.law == WetLaw::Sqrt);
    assert!(roots.len() == 2 && roots.iter().all(|row| row.verdict.passed));
    let rebounds = |findings: &Findings| findings.energy_balance.as_ref().map(|balance| balance.runs);
    assert_eq!(rebounds(&findings), rebounds(&scene("").fit_rows(&rows)));
}

#[test]
fn the_column_goes_before_the_scene() {
    let place = scene("film_ratios = [0.2]");
    let rows = read_in_project("datasets/mueller2016/runs.csv");
    let findings = place.fit_rows(&rows);
    assert!(findings.film_groups.iter().all(|group| group.why_no_laws.is_none()));
}
