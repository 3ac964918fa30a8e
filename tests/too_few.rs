//! Holds that runs which leave nothing to tell their scatter by are refused at once, with the reason, and no more than these.

use std::time::{Duration, Instant};

use crate::common::scenes::{scene_of, AK10, HEADER, PE, PTFE};
use crate::common::{Place, Says};
use serde_json::Value;

fn scene_text() -> String {
    let sampler = "[sampler]\nchains = 2\nwarmup = 200\ndraws = 100\n";
    scene_of("few", &[PTFE, PE, AK10, sampler])
}

const DRY: [&str; 4] = ["1,0.818", "2,0.789", "1.4,0.811", "0.6,0.835"];
const WET: [&str; 6] = ["0.9,0.642", "1.7,0.681", "1.3,0.66", "1.5,0.67", "1.1,0.66", "0.7,0.61"];

/// So many dry and wet runs of one particle.
fn rows(dry: usize, wet: usize) -> String {
    let dry = DRY[..dry].iter().map(|run| format!("PTFE,dry,4.762,,{run}\n"));
    let wet = WET[..wet].iter().map(|run| format!("PTFE,AK10,4.762,286,{run}\n"));
    dry.chain(wet).collect()
}

/// What `wetcor fit` did.
struct Outcome {
    status: Option<i32>,
    out: String,
    report: String,
    findings: Value,
    took: Duration,
}

fn fit(scene: &str, rows: &str, more: &str) -> Outcome {
    let place = Place::new(scene);
    place.folder.write("runs.csv", format!("{HEADER}{rows}"));
    let began = Instant::now();
    let (status, out, _) = place.run(&format!("fit scene.toml --out out {more}"));
    Outcome {
        took: began.elapsed(),
        status,
        out,
        report: place.folder.read("out/report.md"),
        findings: place.folder.json("out/findings.json"),
    }
}

/// The text of a check that failed.
fn failed(findings: &Value, code: &str) -> Option<String> {
    let remarks = findings["remarks"].as_array().expect("a list");
    let remark = remarks.iter().find(|remark| remark["code"] == code)?;
    (remark["passed"] == false && remark["level"] == "forbids").then(|| remark["text"].to_string())
}

fn assert_refused(outcome: &Outcome, words: &str) {
    let Outcome {
        status, out, findings, ..
    } = outcome;
    assert_eq!(*status, Some(1), "{out}");
    assert!(out.starts_with("Verdict: not to be quoted"), "{out}");
    assert!(findings["posterior"].is_null() && findings["compare"].is_null());
    let why = failed(findings, "runs_to_spare").unwrap_or_else(|| panic!("{}", findings["remarks"]));
    assert!(why.contains(words), "{why}");
    outcome.report.says("Nothing was sampled: ");
}

#[test]
fn four_runs_for_five_parameters_are_refused_within_a_second() {
    // the fastest of a few: the machine may be busy
    let tries = || fit(&scene_text(), &rows(2, 2), "");
    let outcomes = [tries(), tries(), tries()];
    assert_refused(&outcomes[0], "4 runs for 5 parameters (k, L, C, σ_dry, σ_wet)");
    outcomes[0].out.says("4 runs for 5 parameters");
    let fastest = outcomes.iter().map(|outcome| outcome.took).min().expect("some");
    assert!(fastest < Duration::from_secs(1), "{fastest:?}");
}

#[test]
fn an_open_form_of_inertia_does_not_sample_first() {
    let open = scene_text() + "[model]\ninertia = \"auto\"\n";
    let outcome = fit(&open, &rows(2, 2), "--stages least_squares,posterior,compare");
    assert_refused(&outcome, "4 runs for 5 parameters");
}

#[test]
fn as_many_runs_as_parameters_are_refused_and_one_more_is_sampled() {
    let stages = "--stages least_squares,posterior";
    assert_refused(&fit(&scene_text(), &rows(2, 3), stages), "5 runs for 5 parameters");
    let sampled = fit(&scene_text(), &rows(3, 3), stages);
    assert!(sampled.findings["posterior"].is_object(), "{}", sampled.out);
    assert_eq!(failed(&sampled.findings, "runs_to_spare"), None);
}

#[test]
fn the_dry_and_the_wet_runs_are_counted_by_themselves() {
    let stages = "--stages least_squares,posterior";
    assert_refused(
        &fit(&scene_text(), &rows(1, 6), stages),
        "1 dry rebound for 1 parameter (k)",
    );
    assert_refused(
        &fit(&scene_text(), &rows(4, 2), stages),
        "2 wet rebounds for 2 parameters (L, C)",
    );
    // a particle of one dry run stands beside one that tells the spread of both
    let beside = rows(4, 4) + "PE,dry,4.762,,1,0.87\nPE,AK10,4.762,286,1.2,0.7\n";
    assert!(fit(&scene_text(), &beside, stages).findings["posterior"].is_object());
    // a spread that is held cannot shrink
    let held = scene_text() + "[priors]\nsigma_dry = { fixed = 0.01 }\n";
    assert!(fit(&held, &rows(1, 6), stages).findings["posterior"].is_object());
}

#[test]
fn an_exact_fit_is_refused_though_there_are_runs_enough() {
    // one run at each of many films: no series has a spread of its own, all together lie on the balance
    let exact = |noise: f64| {
        let (k, l, c): (f64, f64, f64) = (0.18, 1.8, 0.5);
        let mut rows = String::new();
        for i in 0..5 {
            let v = 0.6 + 0.3 * f64::from(i);
            let e = 1.0 - k * v.powf(0.2) + noise * f64::from(1 - i % 2 * 2);
            rows.push_str(&format!("PTFE,dry,4.762,,{v},{e}\n"));
        }
        for i in 0..8 {
            let (v, ratio) = (0.9 + 0.1 * f64::from(i), 0.02 + 0.01 * f64::from(i));
            let stokes = 2150.0 * 4.762e-3 * v / (9.0 * 9.3e-3);
            let lost = c * 930.0 / 2150.0 * ratio * (3.0 - 6.0 * ratio + 4.0 * ratio * ratio);
            let kept = (1.0 - k * 2f64.powf(0.2)).powi(2) - lost - 4.0 * l / stokes;
            let e = kept.sqrt() + noise * f64::from(1 - i % 2 * 2);
            rows.push_str(&format!("PTFE,AK10,4.762,{},{v},{e}\n", 4762.0 * ratio));
        }
        let stages = "--stages least_squares,posterior";
        fit(
            &(scene_text() + "[model]\ninertia = \"stepwise\"\nterms = [\"inertia\", \"viscous\"]\n"),
            &rows,
            stages,
        )
    };
    let refused = exact(0.0);
    assert_eq!(refused.status, Some(1));
    let why = failed(&refused.findings, "noise").unwrap_or_else(|| panic!("{}", refused.findings["remarks"]));
    why.says("without noise");
    assert!(refused.findings["posterior"].is_null());
    assert!(exact(0.005).findings["posterior"].is_object());
}

#[test]
fn least_squares_without_a_run_to_spare_are_not_quoted() {
    for (dry, wet) in [(2, 2), (1, 0), (1, 6), (4, 2)] {
        let outcome = fit(&scene_text(), &rows(dry, wet), "--stages least_squares");
        assert_eq!(outcome.status, Some(1), "{dry} {wet}: {}", outcome.out);
        assert!(outcome.out.contains("as many parameters as runs"), "{}", outcome.out);
    }
    assert_eq!(
        fit(&scene_text(), &rows(3, 0), "--stages least_squares").status,
        Some(0)
    );
}
