//! Runs the command over every kept input, good and bad, and holds its messages and exit statuses.
//!
//! `tests/data/README.md` says how the examples are laid out and how the golden texts are rewritten.

use crate::common::{contents, entries, in_project, is_update, Folder, Ran};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use wetcor::runs::{self, Table};
use wetcor::scene::{self, Scene};

/// The arguments of an example without `args.txt`.
const USUAL: &str = "fit scene.toml --out out";

/// Good examples whose numbers may differ in the last digits: units and sums round differently.
const ROUNDED: &str =
    "both_rebound_and_restitution heights_above_the_film heights_above_the_plate no_film_ratio other_units stokes_numbers";

/// The good example that says how well its constants are known, and so lacks the notice that nothing does.
const UNCERTAIN: &str = "uncertain_constants";

/// Largest relative difference of a number of those.
const ROUNDING: f64 = 1e-12;

/// Findings that are differences of nearly equal numbers lose this much more.
const DIFFERENCES: &str = "bias constants growth heterogeneity lack_of_fit runs_show remarks";
const LOST: f64 = 1e6;

/// The folders of one kind of example; anything else beside them is a mistake.
fn cases(kind: &str) -> Vec<PathBuf> {
    let folder = in_project("tests/data").join(kind);
    let entries = std::fs::read_dir(&folder).expect("the examples are there");
    let mut cases: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    cases.sort();
    for case in &cases {
        assert!(case.is_dir(), "{} is no folder", case.display());
    }
    assert!(cases.len() > 10, "the examples are lost");
    cases
}

fn name(path: &Path) -> &str {
    path.file_name().and_then(|name| name.to_str()).expect("a plain name")
}

/// An example copied to a temporary folder, under its own name: a run leaves the repository alone.
struct Copy {
    _place: Folder,
    folder: PathBuf,
}

impl Copy {
    fn of(case: &Path) -> Copy {
        let place = Folder::new();
        let folder = place.path().join(name(case));
        std::fs::create_dir(&folder).expect("writable");
        for (path, bytes) in contents(case) {
            let to = folder.join(&path);
            std::fs::create_dir_all(to.parent().expect("it lies inside")).expect("writable");
            std::fs::write(&to, bytes).expect("writable");
        }
        for kept in ["args.txt", "expected.txt"] {
            let _ = std::fs::remove_file(folder.join(kept));
        }
        Copy { _place: place, folder }
    }

    fn plain() -> Copy {
        Copy::of(&in_project("tests/data/good/plain"))
    }

    /// Its files with their bytes, and what lies in it, empty folders among it.
    fn holds(&self) -> (BTreeMap<PathBuf, Vec<u8>>, Vec<String>) {
        (contents(&self.folder), entries(&self.folder))
    }

    fn scene(&self) -> Scene {
        scene::read(&self.folder.join("scene.toml")).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Its runs.
    fn table(&self) -> Table {
        runs::read(&self.scene()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Runs the command with words between blanks.
    fn run(&self, words: &str) -> Ran {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wetcor"));
        command.current_dir(&self.folder).args(words.split_whitespace());
        // what a terminal or its user may ask for is no part of a golden text
        for variable in ["COLUMNS", "CLICOLOR_FORCE", "FORCE_COLOR", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        let output = command.output().expect("the command can be started");
        let text = |bytes| String::from_utf8(bytes).expect("plain text");
        (output.status.code(), text(output.stdout), text(output.stderr))
    }
}

#[test]
fn every_bad_example_is_refused_in_its_words_and_nothing_is_written() {
    let update = is_update();
    let mut failures = vec![];
    for case in cases("bad") {
        let copy = Copy::of(&case);
        let before = copy.holds();
        let arguments = std::fs::read_to_string(case.join("args.txt"));
        let (status, out, err) = copy.run(arguments.as_deref().unwrap_or(USUAL));
        let mut fail = |why: String| failures.push(format!("{}: {why}", name(&case)));
        if status != Some(2) {
            fail(format!("exit status {status:?}"));
        }
        if !out.is_empty() {
            fail(format!("standard output holds {out:?}"));
        }
        if copy.holds() != before {
            fail("something was written".to_owned());
        }
        if err.contains("panicked") || !err.starts_with("error: ") && !err.starts_with("Infers ") {
            fail(format!("no error message but {err:?}"));
        }
        let golden = case.join("expected.txt");
        if update {
            std::fs::write(&golden, &err).expect("the golden text can be written");
        }
        match std::fs::read_to_string(&golden) {
            Ok(expected) if expected == err => {}
            Ok(expected) => fail(format!("expected\n{expected}but it says\n{err}")),
            Err(error) => fail(format!("expected.txt: {error}")),
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The notice of a scene that gives no uncertainty of its constants.
const EXACT: &str = "constants_exact";

/// What a fit found, without what names its input or says how well the constants are known.
fn findings(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("findings.json")).expect("findings.json is written");
    let mut findings: Value = serde_json::from_str(&text).expect("findings.json is JSON");
    let all = findings.as_object_mut().expect("an object");
    for key in ["scene", "title", "data_sha256", "scene_sha256"] {
        all.remove(key).expect("the key is there");
    }
    let counts = all.get_mut("counts").and_then(Value::as_object_mut).expect("an object");
    counts.remove("sheets");
    let notices = all.get_mut("remarks").and_then(Value::as_array_mut).expect("a list");
    let of_file = ["sheets_not_read", "unknown_column", "unheeded_column", EXACT];
    notices.retain(|notice| !of_file.iter().any(|code| notice["code"] == *code));
    // an uncertainty of a constant adds to what is told and changes nothing else
    for row in all.get_mut("constants").and_then(Value::as_array_mut).expect("a list") {
        let row = row.as_object_mut().expect("an object");
        for key in ["constants_sd", "combined"] {
            row.remove(key).expect("the key is there");
        }
        let by = row.get_mut("by").and_then(Value::as_array_mut).expect("a list");
        by.retain(|moves| moves["constant"] != "film_offset");
        for moves in by {
            moves.as_object_mut().expect("an object").remove("rel_sd");
        }
    }
    findings
}

/// Where two findings differ by more than a share of the number.
fn differences(at: &str, a: &Value, b: &Value, rounding: f64, found: &mut Vec<String>) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for (key, value) in a {
                let is_difference = DIFFERENCES.split(' ').any(|own| own == key);
                let lost = if is_difference { LOST } else { 1.0 };
                differences(&format!("{at}.{key}"), value, &b[key], rounding * lost, found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                differences(&format!("{at}[{index}]"), a, b, rounding, found);
            }
        }
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().expect("a number"), y.as_f64().expect("a number"));
            if (x - y).abs() > rounding * x.abs().max(y.abs()) {
                found.push(format!("{at}: {x} and {y}"));
            }
        }
        _ if a == b => {}
        _ => found.push(format!("{at}: {a} and {b}")),
    }
}

#[test]
fn every_good_example_gives_the_same_findings() {
    let plain = Copy::plain();
    // draws differ from a rounding on: what was read shows in the fits
    let fits = "fit scene.toml --out out --stages least_squares,figures --verbose";
    let (status, _, plain_err) = plain.run(fits);
    assert_eq!(status, Some(0), "{plain_err}");
    let reference = findings(&plain.folder.join("out"));
    assert_eq!(reference["counts"]["runs"], 31);
    assert_eq!(reference["counts"]["stuck"], 1);
    assert_eq!(reference["series"].as_array().map(Vec::len), Some(4));
    let mut failures = vec![];
    for case in cases("good") {
        let copy = Copy::of(&case);
        let (status, _, err) = copy.run(fits);
        let mut fail = |why: String| failures.push(format!("{}: {why}", name(&case)));
        if status != Some(0) {
            fail(format!("exit status {status:?}: {err}"));
            continue;
        }
        // a notice of its own stands in expected.txt; everything else is as for the plain example
        let own = std::fs::read_to_string(case.join("expected.txt")).unwrap_or_default();
        let in_exact = |line: &&str| name(&case) == UNCERTAIN && line.contains("taken as exact");
        let plain_err: String = plain_err.split_inclusive('\n').filter(|line| !in_exact(line)).collect();
        let expected = format!("{own}{plain_err}");
        let sorted = |text: &str| {
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines.sort();
            lines
        };
        // what only informs comes after the cautions
        if sorted(&err) != sorted(&expected) {
            fail(format!("expected\n{expected}but it says\n{err}"));
        }
        let is_rounded = ROUNDED.split(' ').any(|own| own == name(&case));
        let rounding = if is_rounded { ROUNDING } else { 0.0 };
        let mut found = vec![];
        let own = findings(&copy.folder.join("out"));
        differences("", &reference, &own, rounding, &mut found);
        if !found.is_empty() {
            fail(found.join("\n  "));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Rows count from 1 below the header, screened ones too; what a restitution shares with its speed is taken out.
#[test]
fn rows_and_measurement_errors_are_the_same_from_every_format() {
    let copy = Copy::of(&in_project("tests/data/errors"));
    let mut scene = copy.scene();
    let from_csv = copy.table().runs;
    // blank lines are no rows, and a quote may hold the end of a line
    let csv = copy.folder.join("runs.csv");
    let text = std::fs::read_to_string(&csv).expect("readable");
    std::fs::write(&csv, text.replacen("PTFE,", "\n\"PTFE\",", 1)).expect("writable");
    let from_quoted = copy.table().runs;
    scene.data.runs = vec![copy.folder.join("runs.parquet").into()];
    let from_parquet = runs::read(&scene).unwrap_or_else(|error| panic!("{error}")).runs;
    // which line of which file a row is, is another matter
    assert_eq!(from_csv.places.of(6).to_string(), "runs.csv, line 7");
    assert_eq!(from_quoted.places.of(6).to_string(), "runs.csv, line 8");
    assert_eq!(from_parquet.places.of(6).to_string(), "runs.parquet, row 6");
    let values = |runs: &wetcor::runs::Runs| {
        let mut runs = runs.clone();
        runs.places = Default::default();
        format!("{runs:?}")
    };
    assert_eq!(values(&from_csv), values(&from_quoted));
    assert_eq!(values(&from_csv), values(&from_parquet));
    // dry first; then the rebounds, then what stuck
    assert_eq!(from_csv.row, [5, 7, 3, 4, 6, 2]);
    let errors = from_csv.errors;
    let of_speed: Vec<f64> = errors.iter().map(|error| error.impact_speed_sd).collect();
    assert_eq!(of_speed, [0.0, 0.005, 0.1, 0.0, 0.0, 0.02]);
    // 0.05² = (0.6 · 0.1/2)² + 0.04²; a share of 0.84 · 0.005/0.5 is more than 0.001; 0.01/0.5 where it stuck
    let expected = [0.0, 0.0, 0.04, 0.02, 0.0, 0.02];
    for (own, expected) in errors.iter().map(|error| error.restitution_sd).zip(expected) {
        assert!((own - expected).abs() < 1e-15, "{own} and {expected}");
    }
    assert_eq!(from_csv.restitution, [0.81, 0.84, 0.6, 0.7, 0.65, 0.0]);
}
