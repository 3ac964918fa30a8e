//! Holds that rows which are means of several runs give what the runs give; `data/transcripts/rows.txt` has other rows that are
//! no single runs.

use std::fmt::Write;

use crate::common::scenes::{design, scene_of, truth, STEPWISE, THIN};
use crate::common::{self, cells, rows, Place};
use wetcor::findings::Findings;
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::runs::NewRun;
use wetcor::scene::Scene;

/// Two liquids and three films, six runs of each setting.
fn scene_text() -> String {
    let thick = "[liquids.thick]\ndensity_kg_m3 = 960\nviscosity_mPa_s = 20\n";
    let truth = truth([1.85, 0.8, 0.008, 0.015], "");
    let speeds = ["30, 60, 90, 120, 150", "0.4, 0.8, 1.2, 1.6, 2.0"];
    let design = design(
        ["4.762", "0.04, 0.06, 0.08"],
        &["thin", "thick"],
        speeds,
        "repeats = 6\n",
    );
    let ptfe = "[particles.PTFE]\ndensity_kg_m3 = 2150\n";
    scene_of("rows", &[ptfe, THIN, thick, STEPWISE, &truth, &design])
}

const REPEATS: usize = 6;

const HEADER: &str = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution";

/// The runs of each setting of the design, those of which none stuck.
fn settings(scene: &Scene, seed: u64) -> Vec<Vec<NewRun<'_>>> {
    let all = rows(scene, seed);
    let mut settings: Vec<Vec<NewRun>> = vec![];
    for run in all {
        let is_same = |own: &&mut Vec<NewRun>| cells(&own[0]) == cells(&run);
        match settings.iter_mut().find(is_same) {
            Some(own) => own.push(run),
            None => settings.push(vec![run]),
        }
    }
    assert!(settings.iter().all(|own| own.len() == REPEATS));
    settings.retain(|own| own.iter().all(|run| run.restitution > 0.15));
    assert!(settings.len() > 25, "{}", settings.len());
    settings
}

fn single_runs(settings: &[Vec<NewRun>]) -> String {
    let lines = settings.iter().flatten();
    let lines: Vec<String> = lines.map(|run| format!("{},{}", cells(run), run.restitution)).collect();
    format!("{HEADER}\n{}\n", lines.join("\n"))
}

/// The same as means, with a spread in a column of this name.
fn means(settings: &[Vec<NewRun>], column: &str, of_sd: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{HEADER},{column},runs\n");
    for own in settings {
        let n = own.len() as f64;
        let mean = own.iter().map(|run| run.restitution).sum::<f64>() / n;
        let squares: f64 = own.iter().map(|run| (run.restitution - mean).powi(2)).sum();
        let sd = (squares / (n - 1.0)).sqrt();
        writeln!(text, "{},{mean},{},{n}", cells(&own[0]), of_sd(sd)).expect("a text");
    }
    text
}

/// Every main estimate of least squares with its standard error.
fn estimates(found: &Findings) -> Vec<(f64, f64)> {
    let dry = found.dry.iter().map(|dry| (dry.dry_k.value, dry.dry_k.se));
    let scaling = found.scaling.iter().flat_map(|law| {
        let both = [EInf, StC].map(|quantity| &law.estimates[quantity]);
        both.map(|estimate| (estimate.value, estimate.se))
    });
    let both = dry.chain(scaling).filter_map(|(value, se)| Some((value?, se?)));
    let main = found.main.parameters.iter();
    let main = main.filter_map(|parameter| Some((parameter.number.value?, parameter.number.se?)));
    both.chain(main).collect()
}

#[test]
fn means_give_what_the_single_runs_give() {
    let place = Place::new(&scene_text());
    let settings = settings(&place.scene, common::seed_of("means of runs"));
    let root = (REPEATS as f64).sqrt();
    let single = place.fit_rows(&single_runs(&settings));
    let expected = estimates(&single);
    assert!(expected.len() > 10, "{expected:?}");
    let far = |found: &Findings| {
        let each = estimates(found).into_iter().zip(&expected);
        let each = each.map(|(own, other)| {
            let value = (own.0 - other.0).abs() / other.1;
            value.max((own.1 / other.1 - 1.0).abs())
        });
        each.fold(0.0, f64::max)
    };
    for text in [
        means(&settings, "restitution_sd_of_runs", |sd| sd),
        means(&settings, "restitution_se", |sd| sd / root),
    ] {
        let found = place.fit_rows(&text);
        assert_eq!(found.counts.runs, single.counts.runs);
        assert_eq!(found.counts.used, single.counts.used);
        assert!(far(&found) < 1e-9, "{}", far(&found));
        let (rows, runs) = (settings.len(), single.counts.runs);
        let words = format!("{rows} rows are means and stand for {runs} runs");
        assert!(found.notices().any(|notice| notice.text.contains(&words)), "{words}");
    }
    // a standard error taken for the sd of single runs
    let twin = place.fit_rows(&means(&settings, "restitution_sd_of_runs", |sd| sd / root));
    assert!(far(&twin) > 0.3, "{}", far(&twin));
}
