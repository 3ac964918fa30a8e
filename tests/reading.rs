//! Runs the command over every kept input, good and bad, and holds its messages, exit statuses and manners.
//!
//! `tests/data/README.md` says how the examples are laid out and how the golden texts are rewritten.

use crate::common::{contents, entries, fitted_example, in_project, is_update, Folder, Ran, Says};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

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

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.folder.join(name), text).expect("writable");
    }

    fn scene(&self) -> Scene {
        scene::read(&self.folder.join("scene.toml")).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Its runs.
    fn table(&self) -> Table {
        runs::read(&self.scene()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The command with words between blanks.
    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wetcor"));
        command.current_dir(&self.folder).args(words.split_whitespace());
        // what a terminal or its user may ask for is no part of a golden text
        for variable in ["COLUMNS", "CLICOLOR_FORCE", "FORCE_COLOR", "RUST_BACKTRACE"] {
            command.env_remove(variable);
        }
        command
    }

    fn run(&self, words: &str) -> Ran {
        told(self.command(words).output().expect("the command can be started"))
    }

    /// The same of a command that must succeed.
    fn succeed(&self, words: &str) -> Ran {
        let ran = self.run(words);
        assert_eq!(ran.0, Some(0), "{words}: {ran:?}");
        ran
    }
}

fn told(output: Output) -> Ran {
    let text = |bytes| String::from_utf8(bytes).expect("plain text");
    (output.status.code(), text(output.stdout), text(output.stderr))
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
    let (_, _, plain_err) = plain.succeed(fits);
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
    copy.write("runs.csv", copy.text("runs.csv").replacen("PTFE,", "\n\"PTFE\",", 1));
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

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let copy = Copy::plain();
    let folder = fitted_example().to_str().expect("a plain path");
    let predict = format!(
        "predict {folder} --particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286 --speed-m-s 0.5:2:2000 --quiet"
    );
    for words in [
        "fit scene.toml --out out",
        "check scene.toml",
        "check scene.toml --json",
        &predict,
        "completions bash",
        "man fit",
        "--help",
    ] {
        let mut child = copy
            .command(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command can be started");
        drop(child.stdout.take());
        let (status, _, err) = told(child.wait_with_output().expect("it ends"));
        assert_eq!(status, Some(0), "{words}: {err}");
        let is_error = |line: &str| line.starts_with("error");
        err.lacks("panicked");
        assert!(!err.lines().any(is_error), "{words}: {err}");
    }
    assert!(copy.folder.join("out/report.md").exists());
}

#[test]
fn check_prints_json_and_writes_nothing() {
    let copy = Copy::plain();
    let before = copy.holds();
    let (_, out, err) = copy.succeed("check scene.toml --json");
    err.reads("");
    let overview: Value = serde_json::from_str(&out).expect("it is JSON");
    assert_eq!(overview["runs"], 31);
    assert_eq!(overview["title"], "PTFE spheres on a wetted plate");
    let (_, out, _) = copy.succeed("check scene.toml");
    out.begins("PTFE spheres on a wetted plate\n31 runs read\n");
    assert!(copy.holds() == before);
}

/// A report's files, without the one that holds times.
fn report(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = contents(folder);
    files.remove(Path::new("timing.json")).expect("timing.json is there");
    assert!(files.contains_key(Path::new("report.md")) && files.contains_key(Path::new("findings.json")));
    files
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let copy = Copy::plain();
    let mut first = None;
    for threads in [1, 2, 4] {
        copy.succeed(&format!("fit scene.toml --out out --threads {threads}"));
        let files = report(&copy.folder.join("out"));
        let is_same = files == *first.get_or_insert_with(|| files.clone());
        assert!(is_same, "{threads} threads");
    }
}

#[test]
fn a_second_fit_replaces_the_first_whole() {
    let copy = Copy::plain();
    let before = copy.holds();
    // the default place: reports/<the scene's folder name> under the current folder
    let place = copy.folder.join("reports/plain");
    let (_, out, _) = copy.succeed("fit scene.toml");
    out.says("report: reports/plain/report.md");
    let first = report(&place);
    copy.write("reports/plain/draws/draws.zarr/c.9", "of an older version");
    copy.write("reports/plain/report.md", "changed");
    copy.succeed("fit scene.toml");
    assert!(report(&place) == first);
    std::fs::remove_dir_all(copy.folder.join("reports")).expect("it is there");
    assert!(copy.holds() == before, "something unfinished is left");
}

/// A run with a reason in `exclude` is counted under it, and nothing else of its row is read, by either reader.
#[test]
fn an_excluded_run_is_counted_under_its_reason() {
    let plain = Copy::plain();
    let all = plain.table();
    let text = plain.text("runs.csv");
    let excluding = |reasons: &dyn Fn(usize) -> &'static str| -> String {
        let with = |(row, line): (usize, &str)| format!("{line},{}\n", if row == 0 { "exclude" } else { reasons(row) });
        text.lines().enumerate().map(with).collect()
    };
    let reasons = |row: usize| match row {
        3 | 9 => "blurred | twice",
        12 => "no film",
        _ => "",
    };
    let table = excluding(&reasons);
    // nor is what stands beside a reason
    let unread = table.replacen("0.7818,blurred", "lost,blurred", 1);
    assert_ne!(unread, table);
    for table in [table.clone(), table.replacen("particle", "\"particle\"", 1), unread] {
        plain.write("runs.csv", table);
        let some = plain.table();
        let screened: Vec<(&str, usize)> = some.screened.iter().map(|s| (s.reason.as_str(), s.runs)).collect();
        assert_eq!(
            screened,
            [("excluded: `blurred | twice`", 2), ("excluded: `no film`", 1)]
        );
        assert_eq!((some.rows, some.runs.len()), (all.rows, all.runs.len() - 3));
        assert!([3, 9, 12].iter().all(|row| !some.runs.row.contains(row)));
    }
    // the reasons stand in the report as they are
    plain.write("runs.csv", table);
    plain.succeed("fit scene.toml --out out --stages least_squares");
    plain.text("out/report.md").says("excluded: `blurred | twice`");
}

/// Several tables are one, of any formats, whose rows count on; the file with a mistake is named.
#[test]
fn several_tables_are_read_as_one() {
    let copy = Copy::plain();
    let (text, scene_text) = (copy.text("runs.csv"), copy.text("scene.toml"));
    let whole = copy.table();
    let (header, rows) = text.split_once('\n').expect("a header");
    let rows: Vec<&str> = rows.lines().collect();
    let (first, last) = rows.split_at(13);
    let part = |rows: &[&str]| format!("{header}\n{}\n", rows.join("\n"));
    copy.write("one.csv", part(first));
    let german = part(last).replace(',', ";").replace('.', ",");
    copy.write("two.txt", &german);
    let list = |names: &str| copy.write("scene.toml", scene_text.replace("\"runs.csv\"", names));
    list("[\"one.csv\", \"two.txt\"]");
    let mut both = copy.table();
    both.runs.places = whole.runs.places.clone();
    assert_eq!(format!("{:?}", both.runs), format!("{:?}", whole.runs));
    assert_eq!(both.rows, whole.rows);
    let hash = |name: &str| wetcor::seed::sha256(copy.text(name).as_bytes());
    let lines = format!("{}\n{}\n", hash("one.csv"), hash("two.txt"));
    assert_eq!(both.sha256, wetcor::seed::sha256(lines.as_bytes()));
    // neither table is written over
    let scene = copy.scene();
    let kept = |name: &str| scene::why_not_overwritten(&copy.folder.join(name), &scene).is_some();
    assert!(kept("one.csv") && kept("two.txt") && !kept("runs.csv"));
    let refused = |expected: &str| {
        let (status, _, err) = copy.run("check scene.toml");
        assert_eq!(status, Some(2), "{err}");
        err.says(expected);
    };
    copy.write("two.txt", german.replacen("PTFE", "PTFA", 1));
    refused("two.txt: 1 problem; nothing was written\n  line 2, column particle: found `PTFA`");
    for again in ["one.csv", "./one.csv"] {
        list(&format!("[\"one.csv\", \"{again}\"]"));
        refused("expected every table once");
    }
    list("[]");
    refused("expected a text in quotes, or a list of such");
    let without: String = part(last)
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            format!("{},{}\n", cells[..4].join(","), cells[5..].join(","))
        })
        .collect();
    copy.write("two.txt", without);
    list("[\"one.csv\", \"two.txt\"]");
    refused("two.txt: 1 problem; nothing was written\n  header: expected a column `film_ratio`, as one.csv has");
}
