//! Holds `docs/findings.schema.json` to the findings that fits of many kinds of scene write.

use crate::common::{kept, read_in_project, table_of, Folder};
use crate::contradictions::contradictions;
use std::collections::BTreeSet;

use rayon::prelude::*;
use serde_json::{json, Value};

fn json_of(path: &str) -> Value {
    serde_json::from_str(&read_in_project(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn schema() -> Value {
    json_of("docs/findings.schema.json")
}

/// What of a value a schema refuses, by the keywords that hold a value to more than the types of Rust do; an unknown keyword
/// is a fault. Objects are closed: a field that is not described is refused.
fn faults(all: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let mut found = vec![];
    let mut require = |holds: bool, what: String| {
        if !holds {
            found.push(format!("{at}: {what}"));
        }
    };
    let inside = |of: &Value, value: &Value, key: &str| faults(all, of, value, &format!("{at}{key}"));
    let mut below = vec![];
    for (keyword, says) in schema.as_object().expect("a schema is an object") {
        match keyword.as_str() {
            "$schema" | "$defs" | "title" | "description" | "format" | "default" | "readOnly" | "minimum"
            | "maximum" => {}
            "$ref" => {
                let place = says.as_str().and_then(|text| text.strip_prefix('#'));
                let own = place.and_then(|place| all.pointer(place));
                below.extend(inside(own.unwrap_or_else(|| panic!("no {says}")), value, ""));
            }
            "anyOf" | "oneOf" => {
                let holds = list(says).iter().any(|one| inside(one, value, "").is_empty());
                require(holds, "none of what is allowed".to_owned());
            }
            "type" => {
                let types = says.as_array().map_or(std::slice::from_ref(says), Vec::as_slice);
                let holds = types.iter().any(|name| is_of_type(value, name));
                require(holds, format!("not of type {says}"));
            }
            "const" => require(value == says, format!("not {says}")),
            // an array of a fixed size has both
            "minItems" | "maxItems" => {
                let size = value.as_array().map(Vec::len);
                let holds = size.is_none_or(|size| says.as_u64() == Some(size as u64));
                require(holds, format!("{size:?} items, {keyword} {says}"));
            }
            "items" => {
                let entries = value.as_array().into_iter().flatten().enumerate();
                below.extend(entries.flat_map(|(i, entry)| inside(says, entry, &format!("[{i}]"))));
            }
            "required" => {
                let Some(object) = value.as_object() else { continue };
                for name in list(says).iter().filter_map(Value::as_str) {
                    require(object.contains_key(name), format!("without {name}"));
                }
            }
            "properties" => {
                for (name, own) in value.as_object().into_iter().flatten() {
                    match says.get(name) {
                        Some(of) => below.extend(inside(of, own, &format!(".{name}"))),
                        None => require(false, format!("{name} is unknown")),
                    }
                }
            }
            unknown => panic!("keyword {unknown} is not understood here"),
        }
    }
    found.extend(below);
    found
}

fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("a name") {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("type {other} is not understood here"),
    }
}

/// Fits to be run, so that every part of the findings is written once: a scene of the tests' data, which of its rows are left,
/// the stages, lines of `[model]`, and lines of `[bootstrap]` with tables after it.
const FITS: &str = r#"good/plain | all | least_squares,bootstrap,posterior,compare,figures | inertia = "auto" | # as it is
    good/plain | all | least_squares,bootstrap,posterior | likelihood = "student"; inertia = "none" | interval = "bca"
    good/plain | all | least_squares,bootstrap,posterior | series_offsets = true | interval = "percentile"; scheme = "series"
    good/plain | all | least_squares,posterior | noise = "both"; sticking = "censored" | # as it is
    good/plain | all | least_squares,posterior | terms = ["inertia"] | # as it is
    good/plain | all | least_squares,posterior,compare | inertia = "cap"; sticking = "excluded" | # as it is
    good/plain | all | least_squares,posterior,compare | terms = ["inertia", "viscous", "bridge", "dry_second_order"] | # as it is
    good/plain | no dry runs of 8 mm | least_squares,posterior | viscous = "film"; dry_speed_m_s = "impact"; dry_k = "diameter" | # as it is
    good/plain | dry | least_squares,bootstrap,posterior,compare | # as it is | # as it is
    good/plain | wet | least_squares,bootstrap,posterior | # as it is | [priors]; lubrication_log = { fixed = 1.9 }
    good/plain | every ninth | least_squares,bootstrap,posterior,compare | # as it is | # as it is
    good/plain | one outlier | least_squares | # as it is | [[published]]; quantity = "st_c"; particle = "PTFE"; film_ratio = 0.3; value = 6.0; se = 0.1; source = "elsewhere"
    errors | all | least_squares,posterior | # as it is | # as it is
    good/uncertain_constants | all | least_squares,posterior,figures --accuracy 0.5 | # as it is | # as it is
    good/no_film_ratio | films of their own | least_squares,bootstrap,posterior | # as it is | # as it is"#;

/// What is left of the row of a table by a kind of [`FITS`]; the first below the header is 1.
fn left(kind: &str, number: usize, row: &str) -> Option<String> {
    let is_left = match kind {
        "dry" => row.contains(",dry,"),
        "wet" => !row.contains(",dry,"),
        "no dry runs of 8 mm" => !row.contains(",dry,8,"),
        "every ninth" => number.is_multiple_of(9),
        _ => true,
    };
    let row = match (kind, row.rsplit_once(',')) {
        ("one outlier", Some((before, _))) if number == 10 => format!("{before},0.2"),
        ("films of their own", _) => row.replace(",240,", &format!(",{},", 140 + 15 * number)),
        _ => row.to_owned(),
    };
    is_left.then_some(row)
}

/// The findings of such a fit; and the scene with the header of its runs.
fn fitted([scene, kind, stages, model, bootstrap]: [&str; 5]) -> (Value, String) {
    let place = Folder::new();
    let read = |file: &str| read_in_project(&format!("tests/data/{scene}/{file}"));
    let table = read("runs.csv");
    let (header, rows) = table.split_once('\n').expect("a header");
    let rows = (1..).zip(rows.lines());
    let rows = Vec::from_iter(rows.filter_map(|(number, row)| left(kind, number, row)));
    place.write("runs.csv", format!("{header}\n{}\n", rows.join("\n")));
    // with few draws and replicates
    let [model, bootstrap] = [model, bootstrap].map(|lines| lines.replace("; ", "\n"));
    let scene = format!(
        "{}\n[model]\n{model}\n[sampler]\nchains = 2\nwarmup = 100\ndraws = 100\n\
         [bootstrap]\nreplicates = 100\n{bootstrap}\n",
        read("scene.toml")
    );
    place.write("scene.toml", &scene);
    let words = format!("fit scene.toml --out out --quiet --threads 1 --stages {stages}");
    let (status, _, said) = place.run(&words);
    assert!(matches!(status, Some(0 | 1)), "{kind} {model}: {said}");
    (place.json("out/findings.json"), format!("{scene}\n{header}"))
}

pub fn committed_findings(report: &str) -> Value {
    json_of(&format!("reports/{report}/findings.json"))
}

#[test]
fn the_committed_schema_is_that_of_the_types() {
    let made = wetcor::report::findings_schema().expect("a schema");
    let is_same = made == kept("docs/findings.schema.json", &made);
    assert!(is_same, "the types have changed: run this test with UPDATE_EXPECTED=1");
}

#[test]
fn findings_of_every_kind_of_fit_are_as_described_and_contradict_nothing() {
    let schema = schema();
    let assert_described = |name: &str, findings: &Value| {
        assert_eq!(faults(&schema, &schema, findings, ""), Vec::<String>::new(), "{name}");
        assert_rows_of_their_own(name, findings);
    };
    table_of(FITS).par_iter().for_each(|fit| {
        let (name, (findings, given)) = (fit.join(", "), fitted(*fit));
        assert_described(&name, &findings);
        assert_eq!(contradictions(&findings, &given), Vec::<String>::new(), "{name}");
    });
    for name in ["mueller2016", "sticking"] {
        assert_described(name, &committed_findings(name));
    }
}

/// A quantity of a place by a source has one row, and some are main numbers.
fn assert_rows_of_their_own(name: &str, findings: &Value) {
    let rows = list(&findings["estimates"]);
    let place = |row: &Value| {
        let keys = ["quantity", "particle", "liquid", "diameter_m", "film_ratio", "source"];
        keys.map(|key| row[key].to_string())
    };
    let mut places = BTreeSet::new();
    for row in rows {
        assert!(places.insert(place(row)), "{name}: a second row of {row}");
        let is_known = !row["value"].is_null() && !row["se"].is_null() && !row["interval"].is_null();
        assert_eq!(row["reason"].is_null(), is_known, "{name}: {row}");
    }
    let has_main = rows.iter().any(|row| row["main"] == true);
    assert!(has_main || rows.is_empty(), "{name}: no main number");
}

#[test]
fn planted_faults_are_refused() {
    let schema = schema();
    let findings = committed_findings("mueller2016");
    let faults = |findings: &Value| faults(&schema, &schema, findings, "");
    assert!(faults(&findings).is_empty());
    // a place, what stands there instead, or nothing, and the fault
    for [place, value, words] in table_of(
        r#"/estimates/0/level |  | .estimates[0]: without level
        /dry/0/weight | 1.0 | .dry[0]: weight is unknown
        /series/3/film_m | "0.0003" | .series[3].film_m: not of type
        /counts/runs | "many" | .counts.runs: not of type
        /posterior/chains | "four" | .posterior: none of what is allowed
        /film_groups/0/ends | [0.1] | .film_groups[0].ends: Some(1) items
        /remarks/0/level | "maybe" | .remarks[0].level: none of what is allowed"#,
    ) {
        let mut changed = findings.clone();
        let (object, key) = place.rsplit_once('/').expect("a key");
        let object = changed.pointer_mut(object).and_then(Value::as_object_mut);
        let object = object.expect("an object");
        match value {
            "" => drop(object.remove(key)),
            value => drop(object.insert(key.to_owned(), serde_json::from_str(value).expect("JSON"))),
        }
        assert_ne!(changed, findings, "{words}: nothing was planted");
        let found = faults(&changed);
        assert!(found.iter().any(|fault| fault.contains(words)), "{words}: {found:#?}");
    }
}

/// The twin: a second row of a place, a reason without need and main numbers without their mark are seen.
#[test]
fn planted_rows_are_refused() {
    let findings = committed_findings("mueller2016");
    let holds = |findings: &Value| std::panic::catch_unwind(|| assert_rows_of_their_own("planted", findings)).is_ok();
    assert!(holds(&findings));
    let plants: [fn(&mut Vec<Value>); 3] = [
        |rows| rows.push(rows[0].clone()),
        |rows| rows[0]["reason"] = json!("none"),
        |rows| rows.iter_mut().for_each(|row| row["main"] = json!(false)),
    ];
    for plant in plants {
        let mut changed = findings.clone();
        plant(changed["estimates"].as_array_mut().expect("a list"));
        assert!(!holds(&changed));
    }
}

#[test]
fn every_field_is_described() {
    let schema = schema();
    let defined = schema["$defs"].as_object().expect("definitions").iter();
    let file = ("the file".to_owned(), &schema);
    for (name, object) in defined.map(|(name, of)| (name.clone(), of)).chain([file]) {
        for (key, property) in object["properties"].as_object().into_iter().flatten() {
            let words = property["description"].as_str().unwrap_or_default();
            assert!(!words.is_empty() && !words.contains("None"), "{name}.{key}: {words:?}");
        }
    }
}
