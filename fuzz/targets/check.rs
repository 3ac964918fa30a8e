//! Does all that `check` does with any scene and table, and what `fit` begins with: the input holds both, with a zero byte
//! between.
#![no_main]

use wetcor::findings::{self, overview};
use wetcor::model::parameters::ModelParameters;
use wetcor::report;
use wetcor_fuzz::{assert_told, is_line, Place};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some(at) = bytes.iter().position(|byte| *byte == 0) else {
        return;
    };
    let Ok(scene) = std::str::from_utf8(&bytes[..at]) else {
        return;
    };
    let Some(place) = Place::of(scene) else { return };
    let table = match place.read(&bytes[at + 1..]) {
        Ok(table) => table,
        Err(error) => return assert_told(&error, "runs.csv"),
    };
    let used = table.runs.len() + table.screened.iter().map(|s| s.runs).sum::<usize>();
    assert_eq!(used, table.rows);
    let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
    if let Err(error) = ModelParameters::of(&place.scene, &table.runs, findings.form) {
        return assert_told(&error, "scene.toml");
    }
    let overview = overview::summarise_runs(&place.scene, &table, &findings);
    let json = report::json::text(&overview).expect("any overview can be written");
    // a range is whole or absent, and every number of it is finite
    assert!(!json.contains("[null") && !json.contains("null]"), "{json}");
    let text = report::markdown::overview_text(&overview);
    assert!(text.lines().all(is_line), "{text:?}");
    // and the whole report of least squares, without draws
    let told = report::Told {
        scene: &place.scene,
        runs: &table.runs,
        overview: &overview,
        findings: &findings,
        posterior: None,
    };
    let files = report::files(told, true).expect("any findings can be told");
    let mut names: Vec<String> = files.whole.iter().map(|(name, _)| name.to_lowercase()).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), files.whole.len(), "two files of one name");
});
