//! Holds where each main number comes from, and that the dry law and one k for all diameters are tested before it is quoted.

mod common;

use common::{seed_of, Place};
use wetcor::findings::checks::Check;
use wetcor::findings::main_numbers::{MainPlace, Source};
use wetcor::findings::posterior::MethodChoice;
use wetcor::findings::{self, Findings};
use wetcor::runs::Table;

/// Two liquids of one density, so that the law may take them as one.
const SCENE: &str = r#"
title = "main numbers"
[data]
runs = "runs.csv"
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[liquids.thin]
density_kg_m3 = 930
viscosity_mPa_s = 9.3
[liquids.thick]
density_kg_m3 = 930
viscosity_mPa_s = 20
[model]
inertia = "saturating"
[sampler]
warmup = 300
draws = 300
[bootstrap]
replicates = 200
[truth]
dry_k = { PTFE = 0.183 }
lubrication_log = 1.85
inertia = "saturating"
inertial_prefactor = 0.47
film_scale = 0.069
dry_speed_m_s = 2.0
sigma_dry = 0.009
sigma_wet = 0.02
[design]
diameter_mm = { PTFE = [3.175, 8.0] }
liquids = ["thin", "thick"]
film_ratio = { PTFE = [0.04, 0.1] }
height_mm = [30, 60, 100, 150]
dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]
repeats = 4
"#;

fn fit(scene: &str, table: impl FnOnce(&Place) -> Table) -> Findings {
    let place = Place::new(scene);
    let table = table(&place);
    let mut findings = findings::fit_least_squares(&place.scene, &table, 1, true);
    findings
        .add_posterior(&place.scene, &table.runs, MethodChoice::Nodes, &|_, _| {})
        .unwrap_or_else(|error| panic!("{error}"));
    findings
}

fn simulated(name: &str, scene: &str) -> Findings {
    fit(scene, |place| place.draw(seed_of(name), None))
}

/// Sources at a film ratio, with the liquid each stands for.
fn sources(findings: &Findings, film_ratio: f64) -> Vec<(Source, Option<&str>)> {
    let here = findings.main.at.iter().filter(|place| place.film_ratio == film_ratio);
    here.map(|place| (place.source, place.liquid.as_deref())).collect()
}

#[test]
fn parameters_come_from_the_posterior_and_e_inf_from_the_law_where_every_run_rebounded() {
    let findings = simulated("parameters_come_from_the_posterior", SCENE);
    let main = &findings.main;
    assert!(main.verdict.passed && !main.provisional, "{:?}", main.verdict);
    let names: Vec<&str> = main.parameters.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "dry_k[PTFE]",
            "lubrication_log",
            "inertial_prefactor",
            "film_scale",
            "delta_c_over_roughness"
        ]
    );
    let posterior = findings.posterior.as_ref().expect("sampled");
    for own in &main.parameters {
        assert_eq!(own.number.source, Source::Posterior, "{own:?}");
        let mut all = posterior.parameters.iter().chain(&posterior.derived);
        let summary = all.find(|summary| summary.name == own.name).expect("summarised");
        assert_eq!((own.number.value, own.number.se), (summary.mean, summary.sd));
        let (lo, hi) = summary.q025.zip(summary.q975).expect("quantiles");
        let [low, high] = own.number.interval.expect("an interval");
        assert!((low - lo).abs() < 1e-12 && (high - hi).abs() < 1e-12, "{own:?}");
    }
    for film_ratio in [0.04, 0.1] {
        assert_eq!(
            sources(&findings, film_ratio),
            [
                (Source::SquareRootLaw, None),
                (Source::Posterior, Some("thin")),
                (Source::Posterior, Some("thick"))
            ]
        );
    }
    let law = &main.at[0];
    let row = findings
        .scaling
        .iter()
        .find(|row| row.law == wetcor::scene::WetLaw::Sqrt && row.film_ratio == Some(law.film_ratio));
    let row = row.expect("fitted");
    assert_eq!((law.st_c.value, law.st_c.interval), (row.st_c.value, row.st_c.interval));
    assert_eq!(law.st_c.method, "percentile");
}

#[test]
fn one_liquid_is_named_by_the_law() {
    let scene = SCENE.replace("liquids = [\"thin\", \"thick\"]", "liquids = [\"thick\"]");
    let findings = simulated("one_liquid_is_named_by_the_law", &scene);
    assert_eq!(
        sources(&findings, 0.1),
        [
            (Source::SquareRootLaw, Some("thick")),
            (Source::Posterior, Some("thick"))
        ]
    );
}

fn all_from_posterior(findings: &Findings, film_ratio: f64) -> bool {
    let of = sources(findings, film_ratio);
    !of.is_empty()
        && of
            .iter()
            .all(|(source, liquid)| *source == Source::Posterior && liquid.is_some())
}

#[test]
fn stuck_runs_noise_on_the_energy_errors_and_liquids_that_differ_leave_the_posterior_alone() {
    let stuck = SCENE.replace("viscosity_mPa_s = 20", "viscosity_mPa_s = 48.3");
    let findings = simulated("stuck", &stuck);
    let rows = findings
        .scaling
        .iter()
        .filter(|row| row.film_ratio.is_some() && row.stuck > 0);
    let ratios: Vec<f64> = rows.filter_map(|row| row.film_ratio).collect();
    assert!(!ratios.is_empty(), "some stuck");
    for ratio in ratios {
        assert!(all_from_posterior(&findings, ratio), "{ratio}");
    }
    let both = SCENE.replace(
        "inertia = \"saturating\"\n[sampler]",
        "inertia = \"saturating\"\nnoise = \"both\"\n[sampler]",
    );
    let findings = simulated("both", &both);
    assert!(all_from_posterior(&findings, 0.04) && all_from_posterior(&findings, 0.1));
    let differ = SCENE.replacen(
        "density_kg_m3 = 930\nviscosity_mPa_s = 20",
        "density_kg_m3 = 1400\nviscosity_mPa_s = 20",
        1,
    );
    let findings = simulated("differ", &differ);
    let biased = |row: &&wetcor::findings::scaling::Scaling| row.bias_in_se().is_some_and(|bias| bias > 0.25);
    let rows = findings
        .scaling
        .iter()
        .filter(|row| row.law == wetcor::scene::WetLaw::Sqrt);
    let ratios: Vec<f64> = rows.filter(biased).filter_map(|row| row.film_ratio).collect();
    assert!(!ratios.is_empty(), "a density ratio that differs biases the law");
    for ratio in ratios {
        assert!(all_from_posterior(&findings, ratio), "{ratio}");
    }
}

#[test]
fn without_a_posterior_least_squares_stands_in_and_is_called_provisional() {
    let place = Place::new(SCENE);
    let table = place.draw(seed_of("provisional"), None);
    let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    let main = &findings.main;
    assert!(main.provisional);
    let of: Vec<Source> = main.parameters.iter().map(|own| own.number.source).collect();
    assert_eq!(of[0], Source::DryLaw);
    assert!(of[1..].iter().all(|source| *source == Source::EnergyBalance), "{of:?}");
    let laws = main.at.iter().map(|place: &MainPlace| place.source);
    assert_eq!(laws.collect::<Vec<_>>(), [Source::SquareRootLaw; 2]);
}

/// The check of a code, of the one particle.
fn check<'f>(findings: &'f Findings, code: &str) -> &'f Check {
    let found = findings.verdicts.iter().find(|check| check.check == code);
    found.unwrap_or_else(|| panic!("no check {code}"))
}

fn dry_rows(of: impl Fn(f64, f64) -> f64) -> String {
    let mut csv = String::from("particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution\n");
    // a fixed pattern of residuals with sd 0.009 and no trend
    let residuals = [0.009, -0.011, 0.004, -0.007, 0.005];
    for diameter in [3.175, 8.0] {
        for speed in [0.4, 0.8, 1.2, 1.6, 2.0] {
            for residual in residuals {
                csv.push_str(&format!(
                    "PTFE,dry,{diameter},,{speed},{:.4}\n",
                    of(diameter, speed) + residual
                ));
            }
        }
    }
    csv
}

fn fit_dry(of: impl Fn(f64, f64) -> f64) -> Findings {
    let place = Place::new(SCENE);
    place.fit_rows(&dry_rows(of))
}

#[test]
fn k_that_differs_between_diameters_gates_with_its_advice() {
    let one = fit_dry(|_, v| 1.0 - 0.183 * v.powf(0.2));
    assert!(one.main.verdict.passed, "{:?}", one.main.verdict);
    let two = fit_dry(|diameter, v| 1.0 - if diameter > 5.0 { 0.19 } else { 0.175 } * v.powf(0.2));
    let check = check(&two, "one_dry_k_for_all_diameters");
    assert!(
        check.gates && !check.passed && check.advice.contains("dry_k = \"diameter\""),
        "{check:?}"
    );
    assert!(!two.main.verdict.passed && two.main.verdict.reason.contains("one k for all diameters"));
}

#[test]
fn a_dry_law_that_fails_its_own_runs_gates() {
    let good = fit_dry(|_, v| 1.0 - 0.183 * v.powf(0.2));
    assert!(check(&good, "dry_law_holds").passed);
    // a restitution that rises with v, as that of a marble on two sheets of paper
    let rising = fit_dry(|_, v| 0.44 + 0.02 * v);
    let failed = check(&rising, "dry_law_holds");
    assert!(
        failed.gates && !failed.passed && failed.text.contains("scatter at each speed"),
        "{failed:?}"
    );
    assert!(!rising.main.verdict.passed);
}
