//! Holds the examples in the repository: the runs, their distance from the paper, and the committed reports.

use crate::common::{contents, in_project, read_in_project, wetcor_here, Says};
use crate::findings_schema::committed_findings;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{json, Value};

/// Everything in a report's folder but `timing.json`, the page for browsers and the draws, which are never committed, by path.
fn files(folder: &Path) -> BTreeMap<PathBuf, String> {
    let mut found = contents(folder);
    let is_kept = |name: &Path| {
        !name.starts_with("draws") && name != Path::new("timing.json") && name != Path::new("report.html")
    };
    found.retain(|name, _| is_kept(name));
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("plain text");
    found.into_iter().map(|(name, bytes)| (name, text(bytes))).collect()
}

/// Both numbers, as far as rounding on another machine may move them.
fn close(a: f64, b: f64, se: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs()).max(se)
}

/// What rests on draws: on another machine's vector paths these are other draws of the same posterior.
const DRAWN: [&str; 4] = [
    "findings.posterior",
    "findings.compare",
    "findings.estimates",
    "findings.remarks",
];

/// Structure exactly, numbers closely; `se` is the standard error of the estimate the values belong to. Of what rests on draws
/// means to ten of their Monte Carlo errors, texts but for their numbers; the rest is as random as the draws.
fn assert_same(a: &Value, b: &Value, se: f64, place: &str) {
    let is_drawn = DRAWN.iter().any(|drawn| place.starts_with(drawn));
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => {
            let (x, y) = (x.as_f64().unwrap_or(f64::NAN), y.as_f64().unwrap_or(f64::NAN));
            assert!(is_drawn || close(x, y, se), "{place}: {x} {y}");
        }
        (Value::Array(x), Value::Array(y)) => {
            assert_eq!(x.len(), y.len(), "{place}");
            for (index, (x, y)) in x.iter().zip(y).enumerate() {
                assert_same(x, y, se, &format!("{place}[{index}]"));
            }
        }
        (Value::Object(x), Value::Object(y)) => {
            assert_eq!(x.keys().collect::<Vec<_>>(), y.keys().collect::<Vec<_>>(), "{place}");
            for (value, mcse) in [("mean", "mcse_mean"), ("sd", "mcse_sd")] {
                let numbers = [a[value].as_f64(), b[value].as_f64(), a[mcse].as_f64()];
                if let [Some(p), Some(q), Some(error)] = numbers {
                    assert!((p - q).abs() <= 10.0 * error, "{place}.{value}: {p} {q}");
                }
            }
            let se = a["se"].as_f64().unwrap_or(se);
            for (key, value) in x {
                assert_same(value, &y[key], se, &format!("{place}.{key}"));
            }
        }
        (Value::String(x), Value::String(y)) if is_drawn => assert_eq!(masked(x), masked(y), "{place}"),
        _ => assert_eq!(a, b, "{place}"),
    }
}

/// Cells of a table exactly, numbers closely.
fn assert_same_cells(a: &str, b: &str, name: &str) {
    let cells = |text: &str| text.split([',', '\n']).map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (cells(a), cells(b));
    assert_eq!(a.len(), b.len(), "{name}");
    for (a, b) in a.iter().zip(&b) {
        let is_same = match (a.parse(), b.parse()) {
            (Ok(a), Ok(b)) => close(a, b, 0.0),
            _ => a == b,
        };
        assert!(is_same, "{name}: {a} {b}");
    }
}

/// Text with every number, hash and version replaced by a mark.
fn masked(text: &str) -> String {
    let mut masked = String::new();
    let mut in_number = false;
    for word in text.chars() {
        // 0.0000012 and 1.2e-6, 1e-6 and 0 print differently: a run of digits, points and exponents is one number
        let part = word.is_ascii_digit() || in_number && matches!(word, '.' | 'e' | '-');
        if part && !in_number {
            masked.push('#');
        }
        if !part {
            masked.push(word);
        }
        in_number = part;
    }
    masked.replace('−', "-").replace("-#", "#").replace("+#", "#")
}

#[test]
fn the_committed_report_is_what_the_command_writes() {
    a_committed_report_is_written_again("mueller2016");
}

#[test]
#[ignore = "slow: noise on the energy is an integral a run"]
fn the_committed_report_of_stuck_runs_is_what_the_command_writes() {
    a_committed_report_is_written_again("sticking");
}

fn a_committed_report_is_written_again(example: &str) {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join(example);
    let _ = std::fs::remove_dir_all(&out);
    let out_words = out.to_str().expect("a plain path");
    let (status, _, err) = wetcor_here(&["fit", &format!("datasets/{example}/scene.toml"), "--out", out_words]);
    assert_eq!(status, Some(0), "{err}");
    let (new, old) = (files(&out), files(&in_project(&format!("reports/{example}"))));
    assert_eq!(new.keys().collect::<Vec<_>>(), old.keys().collect::<Vec<_>>());
    for (name, text) in &new {
        let committed = &old[name];
        match name.extension().and_then(|extension| extension.to_str()) {
            Some("json") => {
                let parse = |text: &str| serde_json::from_str::<Value>(text).expect("valid JSON");
                assert_same(&parse(text), &parse(committed), 0.0, "findings");
            }
            Some("md") => {
                // the one word of the command that says where this copy went
                let there = text.replace(&format!(" --out {}", out.display()), "");
                let (new, old) = (masked(&there), masked(committed));
                let [new, old] = [&new, &old].map(|text| text.lines().collect::<Vec<_>>());
                assert_eq!(new, old, "{}", name.display());
            }
            Some("csv") => assert_same_cells(text, committed, &name.display().to_string()),
            Some("svg") => [text, committed].into_iter().for_each(|svg| {
                let parsed = roxmltree::Document::parse(svg).expect("valid XML");
                let svg = ("http://www.w3.org/2000/svg", "svg");
                assert!(parsed.root_element().has_tag_name(svg));
            }),
            _ => panic!("{}: what is this?", name.display()),
        }
        let (is_findings, length) = (name.ends_with("findings.json"), committed.len());
        let most = if is_findings { 600_000 } else { 300_000 };
        assert!(length < most, "{}: {length} bytes", name.display());
    }
}

/// Near the threshold, with noise on the energy kept: the matching posterior holds the truth, least squares does not.
#[test]
fn the_example_of_sticking_is_told_by_its_own_noise() {
    let findings = committed_findings("sticking");
    let number = |value: &Value| value.as_f64().expect("a number");
    let distance = |source: &str| {
        let all = findings["estimates"].as_array().expect("a list").iter();
        let mut of_l = all.filter(|one| one["quantity"] == "lubrication_log" && one["source"] == source);
        let row = of_l.next().expect("L is among them");
        (number(&row["value"]) - 1.85).abs() / number(&row["se"])
    };
    assert!(distance("posterior") < 3.0);
    assert!(distance("energy_balance") > 4.0);
}

#[test]
fn the_comparison_of_reports_can_fail() {
    let a: Value = json!({"dry": [{"value": 0.18, "se": 0.001}]});
    let same = |b: Value| std::panic::catch_unwind(|| assert_same(&a, &b, 0.0, "")).is_ok();
    assert!(same(json!({"dry": [{"value": 0.180_000_000_000_1, "se": 0.001}]})));
    assert!(!same(json!({"dry": [{"value": 0.180_001, "se": 0.001}]})));
    assert!(!same(json!({"dry": [{"value": 0.18}]})) && !same(json!({"dry": []})));
    assert_ne!(masked("usable"), masked("not usable"));
}

/// Worst distances from the published figures stated in SOURCE.md for the committed runs, in published standard errors.
const LARGEST_LINEAR: f64 = 1.75;
const LARGEST_DRY: f64 = 1.15;

#[test]
fn the_papers_figures_come_back_as_nearly_as_stated() {
    let findings = committed_findings("mueller2016");
    let published = findings["published"].as_array().expect("a list");
    assert_eq!(published.len(), 10);
    let source = read_in_project("datasets/mueller2016/SOURCE.md");
    for row in published {
        let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
        let distance = (number("ours") - number("value")) / number("se");
        let is_dry = row["quantity"] == "dry_k";
        let largest = if is_dry { LARGEST_DRY } else { LARGEST_LINEAR };
        assert!(distance.abs() <= largest, "{row}: {distance:.2}");
        // the same number stands in the table a reader sees
        let printed = format!("{distance:+.2}").replace('-', "−");
        let ratio = row["film_ratio"].as_f64();
        let ratio = ratio.map_or("all".to_owned(), |ratio| ratio.to_string());
        let [particle, quantity] = ["particle", "quantity"].map(|key| row[key].as_str().unwrap_or_default());
        let begins = format!("| {particle} | {quantity} | {ratio} |");
        let line = source.lines().find(|line| line.starts_with(&begins));
        line.unwrap_or_else(|| panic!("SOURCE.md lacks {begins}"))
            .says(&printed);
    }
}

#[test]
fn the_runs_are_what_simulate_draws_and_no_one_takes_them_for_measured() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mueller2016-runs.csv");
    let words = ["simulate", "datasets/mueller2016/scene.toml", "--force", "--out"];
    let (status, _, err) = wetcor_here(&[&words[..], &[out.to_str().expect("a plain path")]].concat());
    assert_eq!(status, Some(0), "{err}");
    let new = std::fs::read_to_string(&out).expect("it is drawn");
    let old = read_in_project("datasets/mueller2016/runs.csv");
    assert_same_cells(&new, &old, "runs.csv");
    let film = |line: &str| line.split(',').nth(3)?.parse::<f64>().ok();
    let mut films = old.lines().skip(1).filter_map(film);
    assert!(films.all(|film| film >= 200.0));
    let source = read_in_project("datasets/mueller2016/SOURCE.md");
    source.lines().next().expect("a title").says("simulated");
    read_in_project("reports/mueller2016/report.md").says("no run here was measured");
}
