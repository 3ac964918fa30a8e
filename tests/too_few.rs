//! Holds that runs which leave nothing to tell their scatter by are refused at once, with the reason, and no more than these.

use std::time::{Duration, Instant};

use crate::common::scenes::{scene_of, AK10, HEADER, PE, PTFE};
use crate::common::{sample, Place, Ran, Says, Told};
use wetcor::findings::Findings;

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

/// Least squares and the posterior, where there is one.
fn found(scene: &str, rows: &str) -> Findings {
    let place = Place::new(scene);
    let mut findings = place.fit_rows(&format!("{HEADER}{rows}"));
    sample(&mut findings, &place.scene, &place.read().runs);
    findings
}

fn is_sampled(findings: &Findings) -> bool {
    assert!(findings.posterior.is_none() || !findings.forbids("runs_to_spare"));
    findings.posterior.is_some()
}

fn assert_refused(findings: &Findings, words: &str) {
    assert!(findings.posterior.is_none() && findings.forbids("runs_to_spare"));
    findings.check("runs_to_spare").text.says(words);
}

/// `wetcor fit`, and the folder it wrote to.
fn fit(scene: &str, rows: &str, more: &str) -> (Place, Ran) {
    let place = Place::new(scene);
    place.folder.write("runs.csv", format!("{HEADER}{rows}"));
    let ran = place.run(&format!("fit scene.toml --out out {more}"));
    (place, ran)
}

#[test]
fn four_runs_for_five_parameters_are_refused_within_a_second() {
    let open = scene_text() + "[model]\ninertia = \"auto\"\n";
    let counted = "4 runs for 5 parameters";
    for (scene, printed) in [(scene_text(), counted), (open, "Verdict: not to be quoted")] {
        // the fastest of a few: the machine may be busy
        let mut fastest = Duration::MAX;
        for _ in 0..3 {
            let began = Instant::now();
            let (place, (status, out, _)) = fit(&scene, &rows(2, 2), "");
            fastest = fastest.min(began.elapsed());
            assert_eq!(status, Some(1), "{out}");
            out.begins("Verdict: not to be quoted");
            out.says(printed);
            place.folder.read("out/report.md").says("Nothing was sampled: ");
            place.folder.read("out/findings.json").says(counted);
            let findings = place.folder.json("out/findings.json");
            assert!(findings["posterior"].is_null() && findings["compare"].is_null());
        }
        assert!(fastest < Duration::from_secs(1), "{fastest:?}");
    }
}

#[test]
fn as_many_runs_as_parameters_are_refused_and_one_more_is_sampled() {
    let words = "5 runs for 5 parameters (k, L, C, σ_dry, σ_wet)";
    assert_refused(&found(&scene_text(), &rows(2, 3)), words);
    assert!(is_sampled(&found(&scene_text(), &rows(3, 3))));
}

#[test]
fn the_dry_and_the_wet_runs_are_counted_by_themselves() {
    let of = |dry, wet| found(&scene_text(), &rows(dry, wet));
    assert_refused(&of(1, 6), "1 dry rebound for 1 parameter (k)");
    assert_refused(&of(4, 2), "2 wet rebounds for 2 parameters (L, C)");
    // a particle of one dry run stands beside one that tells the spread of both
    let beside = rows(4, 4) + "PE,dry,4.762,,1,0.87\nPE,AK10,4.762,286,1.2,0.7\n";
    assert!(is_sampled(&found(&scene_text(), &beside)));
    // a spread that is held cannot shrink
    let held = scene_text() + "[priors]\nsigma_dry = { fixed = 0.01 }\n";
    assert!(is_sampled(&found(&held, &rows(1, 6))));
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
        let model = "[model]\ninertia = \"stepwise\"\nterms = [\"inertia\", \"viscous\"]\n";
        found(&(scene_text() + model), &rows)
    };
    let refused = exact(0.0);
    assert!(refused.forbids("noise") && refused.posterior.is_none());
    refused.check("noise").text.says("without noise");
    assert!(is_sampled(&exact(0.005)));
}

#[test]
fn least_squares_without_a_run_to_spare_are_not_quoted() {
    let of = |(dry, wet)| fit(&scene_text(), &rows(dry, wet), "--stages least_squares").1;
    for runs in [(2, 2), (1, 0), (1, 6), (4, 2)] {
        let (status, out, _) = of(runs);
        assert_eq!(status, Some(1), "{runs:?}: {out}");
        out.says("as many parameters as runs");
    }
    assert_eq!(of((3, 0)).0, Some(0));
}
