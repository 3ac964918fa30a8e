//! Attacks folders that are read back.

use crate::common::{Folder, Says};
use std::path::Path;

use serde_json::{json, Value};
use wetcor::error::Error;
use wetcor::physics::Setting;
use wetcor::report::finished::Finished;
use wetcor::report::prediction::{self, Prediction};

use super::attack::{attack, is_hostile};

/// What a prediction reads of a fit.
const FINDINGS: &str = "r/findings.json";

/// Draws of each parameter that are left of the fit: a prediction takes as much time as it has draws.
const DRAWS: usize = 10;

/// A fit as small as it can be.
fn fitted() -> Folder {
    let place = Folder::plain();
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 150\ndraws = 100\n[model]\nlikelihood = \"student\"");
    let outcome = attack(
        &place,
        "fit scene.toml --seed 1 --out r --stages least_squares,posterior",
    );
    assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
    let mut findings = place.json(FINDINGS);
    let draws = &mut findings["posterior"]["basis"]["draws"];
    for own in draws.as_array_mut().expect("a list") {
        own["values"].as_array_mut().expect("a list").truncate(DRAWS);
    }
    place.write(FINDINGS, findings.to_string());
    place
}

const PREDICT: &str =
    "predict r --particle PTFE --liquid AK10 --diameter-mm 4 --film-um 200 --speed-m-s 0.05:2:4 --format";

fn predicted(folder: &Path) -> Result<String, Error> {
    let finished = Finished::read(folder)?;
    let law = finished.law("PTFE", 4.762e-3, true)?;
    let basis = finished.basis();
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
            let is_table = table.lines().count() == 4;
            assert!(is_table && !odd("nan") && !odd("inf"), "{of}: {table}");
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
        Value::Array(list) => (0..list.len())
            .filter(|index| *index == 0 || index + 1 == list.len())
            .for_each(|index| places(&list[index], &format!("{at}/{index}"), found)),
        _ => found.push(at.to_owned()),
    }
}

const EXTREMES: &str = r#"[0, -1, 0.5, 1e308, 5e-324, 18446744073709551615, null, "\u001b[2J\n\u202e", []]"#;

/// The parts that a prediction reads, the draws among them, each value of them replaced by extremes.
#[test]
fn d13_no_change_of_findings_gives_a_number_that_is_none() {
    let fit = fitted();
    let findings = fit.json(FINDINGS);
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
            fit.write(FINDINGS, changed.to_string());
            let outcome = predicted(&fit.join("r"));
            assert_mannered(&outcome, &of);
            refused += usize::from(outcome.is_err());
            believed += usize::from(outcome.is_ok());
        }
    }
    // a title or a word of a verdict changes no number; a count or a viscosity does
    assert!(refused > 120 && believed > 12, "{refused} {believed}");
}

/// Texts that are refused are among the extremes above.
#[test]
fn d11_texts_of_a_finished_fit_do_not_move_a_terminal() {
    let fit = fitted();
    let hostile = "\u{1b}[2J\n\u{202e}x";
    let mut findings = fit.json(FINDINGS);
    findings["title"] = json!(hostile);
    let remark = json!({"code": "x", "level": "forbids", "passed": false, "text": hostile, "next_step": ""});
    findings["remarks"] = json!([remark]);
    fit.write(FINDINGS, findings.to_string());
    for format in ["csv", "json"] {
        let outcome = attack(&fit, &format!("{PREDICT} {format}"));
        outcome.assert_mannered(format);
        assert_eq!(outcome.status, Some(1), "{outcome:?}");
        outcome.err.says("not either: \\u{1b}[2J\\n\\u{202e}x\n");
        if format == "json" {
            let told: Value = serde_json::from_str(&outcome.out).expect("JSON");
            assert_eq!(told["title"], hostile);
        }
    }
}
