//! Holds that a spread held at 0 leaves the stated measurement errors as all noise, and gates where they are not.

use crate::common::scenes::{design, scene_of, truth, PTFE, STEPWISE, THIN};
use crate::common::{
    assert_expected, assert_seldom, cells, compare, counts, holds, normal, rows, sample_as_usual, seed_of, Place, Says,
    Told,
};
use crate::laws;
use wetcor::findings::remarks::BEYOND_CHANCE;
use wetcor::findings::{self, Findings};
use wetcor::remark::Remark;
use wetcor::runs;
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

/// A table whose runs err as they state, times a factor; `row` is changed by what is done to it.
fn table(place: &Place, seed: u64, factor: f64, change: impl Fn(usize, &mut String)) -> String {
    let mut rng = stream(seed, "stated errors", 0);
    let mut csv = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution,restitution_sd\n".to_owned();
    for (index, run) in rows(&place.scene, seed).into_iter().enumerate() {
        let z = normal(&mut rng);
        let sd = 0.006 * (1 + index % 3) as f64;
        let e = run.restitution + factor * sd * z;
        let mut line = format!("{},{e},{sd}\n", cells(&run));
        change(index, &mut line);
        csv.push_str(&line);
    }
    csv
}

fn fit(place: &Place, seed: u64, factor: f64) -> Findings {
    place.fit_rows(&table(place, seed, factor, |_, _| ()))
}

fn of_errors(findings: &Findings) -> Vec<&Remark> {
    let all = findings.checks();
    all.filter(|check| check.code.starts_with("stated_errors")).collect()
}

#[test]
fn right_errors_pass_and_halved_ones_gate() {
    const SETS: u64 = 400;
    let place = Place::new(&scene_text());
    let seed = seed_of("right_errors_pass_and_halved_ones_gate");
    const TRUTHS: [(&str, f64); 3] = [
        ("dry_k[PTFE]", 0.183),
        ("lubrication_log", 1.85),
        ("inertial_prefactor", 1.0),
    ];
    let (mut low, mut gated, mut all) = (0, 0, 0);
    let mut covered = vec![];
    for set in 0..SETS {
        let findings = fit(&place, seed + set, 1.0);
        let checks = of_errors(&findings);
        assert_eq!(checks.len(), 2);
        low += checks.iter().filter(|check| check.value.expect("a p") < 0.05).count();
        gated += checks.iter().filter(|check| !check.passed).count();
        all += 2;
        covered.push(TRUTHS.map(|(name, truth)| holds(findings.fitted(name).interval, truth)));
    }
    assert_expected("p below 0.05", low, all, 0.05);
    assert_seldom("gated", gated, all, BEYOND_CHANCE);
    for ((name, _), count) in TRUTHS.into_iter().zip(counts(&covered)) {
        assert_expected(name, count, SETS, 0.95);
    }
    // the planted fault: errors half of what they are
    for set in 0..50 {
        let findings = fit(&place, seed + set, 2.0);
        assert!(
            of_errors(&findings).iter().any(|check| check.gates() && !check.passed) && !findings.main.verdict.passed
        );
    }
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
fn the_posterior_is_that_of_the_errors_alone() {
    let place = Place::new(&scene_text().replace("repeats = 4", "repeats = 8"));
    let seed = seed_of("the_posterior_is_that_of_the_errors_alone");
    for (factor, may_be_quoted) in [(1.0, true), (2.0, false)] {
        let text = table(&place, seed, factor, |_, _| ());
        let table = place.read_rows(&text);
        let mut findings = findings::fit_least_squares(&place.scene, &table, 1, true);
        let posterior = sample_as_usual(&mut findings, &place.scene, &table.runs);
        let compared = compare(&mut findings, &place.scene, &table.runs, &posterior);
        assert!(compared.models.iter().all(|model| model.elpd_loo.is_finite()));
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

#[test]
fn every_stage_and_prediction_run_without_a_spread() {
    let place = Place::new(&scene_text());
    let text = table(
        &place,
        seed_of("every_stage_and_prediction_run_without_a_spread"),
        1.0,
        |_, _| (),
    );
    std::fs::write(&place.scene.data.runs[0].path, text).expect("writable");
    place.folder.succeed("check scene.toml");
    place.folder.succeed("fit scene.toml --out out");
    let report = place.folder.read("out/report.md");
    assert!(!report.contains("NaN") && report.contains("σ_wet"), "{report}");
    let asked = "--particle PTFE --liquid thin --diameter-mm 4.762 --film-um 250 --speed-m-s 0.6:1.8:4";
    let predicted = place.folder.succeed(&format!("predict out {asked}"));
    assert!(!predicted.contains("NaN") && !predicted.contains("inf"), "{predicted}");
    // a run without error of its own lies where the curve does
    let cells = laws::rows(&predicted);
    assert_eq!(cells.len(), 4, "{predicted}");
    for row in &cells {
        for names in [["run_q05", "restitution_q05"], ["run_q95", "restitution_q95"]] {
            let [run, curve] = names.map(|name| row[name].parse::<f64>().expect("a number"));
            assert!((run - curve).abs() < 1e-3, "{predicted}");
        }
    }
    place.folder.succeed("simulate scene.toml --out simulated.csv");
}

/// What a scene and its runs are refused with; `None` where they are read.
fn refusal(scene: &str, change: impl Fn(usize, &mut String)) -> Option<String> {
    let place = Place::new(scene);
    let text = table(&place, 1, 1.0, change);
    std::fs::write(&place.scene.data.runs[0].path, text).expect("writable");
    runs::read(&place.scene).err().map(|error| error.to_string())
}

#[test]
fn runs_that_nothing_would_scatter_are_refused() {
    let no_error = |line: &mut String| {
        let cut = line.rfind(',').expect("cells");
        line.truncate(cut);
        line.push_str(",\n");
    };
    let stuck = |line: &mut String| {
        let cells: Vec<&str> = line.trim_end().split(',').collect();
        *line = format!("{},0,0.01\n", cells[..5].join(","));
    };
    let nothing = |_: usize, _: &mut String| ();
    let dry_alone = scene_text().replace("sigma_wet = { fixed = 0 }\n", "");
    let wet_alone = scene_text().replace("sigma_dry = { fixed = 0 }\n", "");
    assert_eq!(refusal(&scene_text(), nothing), None);
    let found = refusal(&dry_alone, |_, line| no_error(line)).expect("refused");
    assert!(found.contains("scene.toml") && found.contains("[priors] sigma_dry: found `fixed 0`, expected a number above 0: 20 of 20 dry rebounds in use state no error of the restitution (column restitution_sd"), "{found}");
    // what the other kind states is its own affair
    let of_dry = |_: usize, line: &mut String| {
        if line.contains(",dry,") {
            no_error(line);
        }
    };
    assert_eq!(refusal(&wet_alone, of_dry), None);
    assert_eq!(
        refusal(&scene_text().replace("fixed = 0 }", "fixed = 0.01 }"), |_, line| {
            no_error(line)
        }),
        None
    );
    let found = refusal(&scene_text(), |index, line| {
        if index == 30 {
            stuck(line)
        }
    })
    .expect("refused");
    found.says("[priors] sigma_wet");
    found.says("1 wet runs in use stuck");
    let excluded = scene_text().replace("[model]", "[model]\nsticking = \"excluded\"");
    assert_eq!(
        refusal(&excluded, |index, line| if index == 30 {
            stuck(line)
        }),
        None
    );
    for (key, value) in [("sticking", "truncated"), ("noise", "both")] {
        let scene = scene_text().replace("[model]", &format!("[model]\n{key} = \"{value}\""));
        let found = refusal(&scene, nothing).expect("refused");
        found.says("[priors] sigma_wet");
        found.says(&format!("{key} = \"{value}\""));
    }
}
