//! Attacks folders that are read back.

use crate::common::{Folder, Says};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use serde_json::{json, Value};
use wetcor::error::Error;
use wetcor::physics::Setting;
use wetcor::report::finished::Finished;
use wetcor::report::prediction::{self, Prediction};

use super::attack::{is_hostile, Outcome, Place};

const FINDINGS: &str = "findings.json";

/// A fit as small as it can be, once for all tests.
fn fit() -> &'static (Place, PathBuf) {
    static FIT: OnceLock<(Place, PathBuf)> = OnceLock::new();
    FIT.get_or_init(|| {
        let place = Place::plain();
        place.add_to_scene("[sampler]\nchains = 2\nwarmup = 300\ndraws = 200\n[model]\nlikelihood = \"student\"");
        let words = "fit scene.toml --seed 1 --out r --stages least_squares,posterior";
        let outcome = place.ask(words);
        assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
        let folder = place.path("r");
        (place, folder)
    })
}

/// A copy of what a prediction reads of a fit.
struct Copy {
    place: Folder,
}

impl Copy {
    fn new() -> Copy {
        let copy = Copy { place: Folder::new() };
        std::fs::copy(fit().1.join(FINDINGS), copy.path()).expect("writable");
        copy
    }

    fn path(&self) -> PathBuf {
        self.place.join(FINDINGS)
    }

    fn write(&self, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(), bytes).expect("writable");
    }

    fn findings(&self) -> Value {
        serde_json::from_slice(&std::fs::read(self.path()).expect("readable")).expect("JSON")
    }

    /// A prediction without a process of its own.
    fn predicted(&self) -> Result<String, Error> {
        predicted(self.place.path())
    }

    /// A prediction by the command.
    fn run(&self, more: &str) -> Outcome {
        let words = format!("predict {} {ASKED} {more}", self.place.path().display());
        fit().0.ask(words.trim_end())
    }
}

const ASKED: &str = "--particle PTFE --liquid AK10 --diameter-mm 4 --film-um 200 --speed-m-s 0.05:2:4";

fn predicted(folder: &Path) -> Result<String, Error> {
    let finished = Finished::read(folder)?;
    let law = finished.law("PTFE", 4.762e-3, true)?;
    let basis = &finished.basis;
    let particle = basis.particles.iter().find(|particle| particle.name == "PTFE");
    let liquid = basis.liquids.iter().find(|liquid| liquid.name == "AK10");
    let (Some(particle), Some(liquid)) = (particle, liquid) else {
        return Err(Error::Usage("another name".to_owned()));
    };
    let setting = Setting {
        density: particle.density_kg_m3,
        diameter: 4e-3,
        roughness: Some(5e-6),
        liquid_density: liquid.density_kg_m3,
        viscosity: liquid.viscosity_pa_s,
        film: 2e-4,
        surface_tension: liquid.surface_tension_n_m,
    };
    let rows = law.curve(Some(&setting)).predict(&[0.05, 0.3, 2.0]);
    let prediction = Prediction::new("PTFE", Some("AK10"), setting.diameter, Some(&setting), rows);
    prediction::csv(&[prediction], false)
}

/// It is a table of finite numbers, or a refusal on one line.
fn assert_mannered(outcome: &Result<String, Error>, of: &str) {
    match outcome {
        Ok(table) => {
            let odd = |word: &str| table.to_lowercase().contains(word);
            assert!(
                !odd("nan") && !odd("inf") && table.lines().count() == 4,
                "{of}: {table}"
            );
        }
        Err(error) => {
            let text = error.to_string();
            assert!(!text.is_empty() && !text.chars().any(is_hostile), "{of}: {text:?}");
        }
    }
}

/// Every place of a value, as a path of keys and indices; of a long list the first and the last.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(map) => map
            .iter()
            .for_each(|(key, value)| places(value, &format!("{at}/{key}"), found)),
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                if index == 0 || index + 1 == list.len() {
                    places(value, &format!("{at}/{index}"), found);
                }
            }
        }
        _ => found.push(at.to_owned()),
    }
}

const EXTREMES: &str = r#"[0, -1, 1, 0.5, 1e308, -1e308, 5e-324, 1000000000000000, 18446744073709551615, null,
    "\u001b[2J\n\u202e", [], {}, true]"#;

/// The parts that a prediction reads, the draws among them, each value of them replaced by extremes.
#[test]
fn d13_no_change_of_findings_gives_a_number_that_is_none() {
    let started = Instant::now();
    let copy = Copy::new();
    let findings = copy.findings();
    let mut found = ["/schema", "/title", "/wetcor"].map(str::to_owned).to_vec();
    for part in "basis terms inertia viscous dry_speed_m_s left_out".split(' ') {
        places(&findings["posterior"][part], &format!("/posterior/{part}"), &mut found);
    }
    places(&findings["remarks"], "/remarks", &mut found);
    assert!(found.len() > 30, "{found:?}");
    let (mut refused, mut believed) = (0, 0);
    let extremes: Vec<Value> = serde_json::from_str(EXTREMES).expect("JSON");
    for place in &found {
        for extreme in &extremes {
            let of = format!("{place} = {extreme}");
            let mut changed = findings.clone();
            let value = changed.pointer_mut(place).expect("it is there");
            if value == extreme {
                continue;
            }
            *value = extreme.clone();
            copy.write(changed.to_string());
            let outcome = copy.predicted();
            assert_mannered(&outcome, &of);
            refused += usize::from(outcome.is_err());
            believed += usize::from(outcome.is_ok());
        }
    }
    // a title or a word of a verdict changes no number; a count or a viscosity does
    assert!(refused > 200 && believed > 20, "{refused} {believed}");
    assert!(started.elapsed().as_secs_f64() < 60.0);
}

/// Numbers of the command line that are too large or too small for any formula.
#[test]
fn d13_no_number_that_is_asked_for_gives_one_that_is_none() {
    let copy = Copy::new();
    let sizes = ["1e-320", "1e-300", "1", "1e300", "1.7e308"];
    let mut refused = 0;
    for size in sizes {
        for other in sizes {
            for (flags, format) in [
                (
                    ["--diameter-mm", size, "--film-um", other, "--viscosity-mPa-s", "9"],
                    "csv",
                ),
                (
                    ["--diameter-mm", "4", "--film-um", "200", "--viscosity-mPa-s", size],
                    "json",
                ),
            ] {
                let folder = copy.place.path().to_str().expect("a plain path");
                let fixed = ["predict", folder, "--particle", "PTFE", "--liquid-density-kg-m3", other];
                let rest = ["--speed-m-s", "1e-300:1e300:3", "--format", format];
                let outcome = fit().0.run(&[&fixed[..], &flags, &rest].concat());
                outcome.assert_mannered(&format!("{flags:?}"));
                let text = outcome.out.to_lowercase();
                assert!(!text.contains("nan") && !text.contains("inf"), "{flags:?}: {text}");
                assert!(
                    outcome.status == Some(2) || outcome.out.lines().count() > 3,
                    "{outcome:?}"
                );
                refused += usize::from(outcome.status == Some(2));
            }
        }
    }
    assert!((20..50).contains(&refused), "{refused}");
}

#[test]
fn d11_texts_of_a_finished_fit_do_not_move_a_terminal() {
    let copy = Copy::new();
    let hostile = "\u{1b}[2J\n\u{202e}x";
    let mut findings = copy.findings();
    findings["title"] = json!(hostile);
    let remark = json!({"code": "x", "level": "forbids", "passed": false, "text": hostile, "next_step": ""});
    findings["remarks"] = json!([remark]);
    copy.write(findings.to_string());
    for format in ["csv", "json"] {
        let outcome = copy.run(&format!("--format {format}"));
        outcome.assert_mannered(format);
        assert_eq!(outcome.status, Some(1), "{outcome:?}");
        outcome.err.says("not either: \\u{1b}[2J\\n\\u{202e}x\n");
        if format == "json" {
            let told: Value = serde_json::from_str(&outcome.out).expect("JSON");
            assert_eq!(told["title"], hostile);
        }
    }
    for (place, planted) in [
        ("/schema", json!(hostile)),
        ("/wetcor", json!(hostile)),
        ("/posterior/inertia", json!(hostile)),
        ("/posterior/terms", json!([hostile])),
    ] {
        let mut changed = findings.clone();
        *changed.pointer_mut(place).expect("it is there") = planted;
        copy.write(changed.to_string());
        copy.run("").assert_refused(place, &["`\\u{1b}[2J\\n\\u{202e}x`"]);
    }
}
