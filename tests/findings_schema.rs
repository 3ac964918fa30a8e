//! Holds `docs/findings.schema.json` to the findings that fits of many kinds of scene write.

use crate::common::{kept, read_in_project, table_of, wetcor, Folder};
use std::collections::BTreeSet;

use rayon::prelude::*;
use serde_json::{json, Value};

fn json_of(path: &str) -> Value {
    serde_json::from_str(&read_in_project(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn schema() -> Value {
    json_of("docs/findings.schema.json")
}

/// What of a value a schema refuses, by the keywords that the schema uses; any other keyword is a fault. Objects are closed:
/// a field that is not described is refused.
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
            "$schema" | "$defs" | "title" | "description" | "format" | "default" | "readOnly" => {}
            "$ref" => {
                let place = says.as_str().and_then(|text| text.strip_prefix('#'));
                let place = place.expect("a place inside");
                below.extend(inside(
                    all.pointer(place).unwrap_or_else(|| panic!("no {place}")),
                    value,
                    "",
                ));
            }
            "anyOf" | "oneOf" => {
                let holds = list(says).iter().any(|one| inside(one, value, "").is_empty());
                require(holds, "none of what is allowed".to_owned());
            }
            "type" => {
                let holds = match says {
                    Value::Array(types) => types.iter().any(|name| is_of_type(value, name)),
                    name => is_of_type(value, name),
                };
                require(holds, format!("not of type {says}"));
            }
            "const" => require(value == says, format!("not {says}")),
            "enum" => require(list(says).contains(value), format!("{value} is none of {says}")),
            "minimum" | "maximum" => {
                let limit = says.as_f64().expect("a number");
                let holds = |number: f64| {
                    if keyword == "minimum" {
                        number >= limit
                    } else {
                        number <= limit
                    }
                };
                require(value.as_f64().is_none_or(holds), format!("beyond the {keyword} {says}"));
            }
            "minItems" | "maxItems" => {
                let (size, limit) = (
                    value.as_array().map_or(0, Vec::len) as u64,
                    says.as_u64().expect("a number"),
                );
                let holds = if keyword == "minItems" {
                    size >= limit
                } else {
                    size <= limit
                };
                require(holds || !value.is_array(), format!("{size} items, {keyword} {limit}"));
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

/// A fit to be run: a scene of the tests' data with more settings, what becomes of each row of its table, and arguments.
struct Fit {
    name: &'static str,
    scene: &'static str,
    /// lines of `[model]`
    model: &'static str,
    /// lines of `[bootstrap]`, and tables after it
    bootstrap: &'static str,
    /// the row, or another in its place, or none; by its number, the first below the header being 1
    row: fn(usize, &str) -> Option<String>,
    arguments: &'static [&'static str],
}

const LEAST_SQUARES: &[&str] = &["--stages", "least_squares,figures"];
const RESAMPLED: &[&str] = &["--stages", "least_squares,bootstrap"];
const SAMPLED: &[&str] = &["--stages", "least_squares,posterior"];

/// A published number at a film ratio that the runs have not.
const PUBLISHED: &str = "[[published]]\nquantity = \"st_c\"\nparticle = \"PTFE\"\nfilm_ratio = 0.3\nvalue = 6.0\n\
     se = 0.1\nsource = \"elsewhere\"\n";

fn as_it_is(_: usize, row: &str) -> Option<String> {
    Some(row.to_owned())
}

fn only(keep: bool, row: &str) -> Option<String> {
    keep.then(|| row.to_owned())
}

fn plain(name: &'static str, model: &'static str, arguments: &'static [&'static str]) -> Fit {
    Fit {
        name,
        scene: "good/plain",
        model,
        bootstrap: "",
        row: as_it_is,
        arguments,
    }
}

impl Fit {
    fn of(self, scene: &'static str) -> Fit {
        Fit { scene, ..self }
    }

    fn with(self, bootstrap: &'static str) -> Fit {
        Fit { bootstrap, ..self }
    }

    fn rows(self, row: fn(usize, &str) -> Option<String>) -> Fit {
        Fit { row, ..self }
    }
}

fn fits() -> Vec<Fit> {
    let an_outlier = |i: usize, row: &str| match (i, row.rsplit_once(',')) {
        (10, Some((before, _))) => Some(format!("{before},0.2")),
        _ => Some(row.to_owned()),
    };
    let own_films = |i: usize, row: &str| Some(row.replace(",240,", &format!(",{},", 140 + 15 * i)));
    vec![
        plain("every stage", "inertia = \"auto\"", &[]),
        plain("least squares", "", LEAST_SQUARES),
        plain("bca", "", RESAMPLED).with("interval = \"bca\""),
        plain("series resampled", "", RESAMPLED).with("interval = \"percentile\"\nscheme = \"series\""),
        plain("student", "likelihood = \"student\"", SAMPLED),
        plain("series offsets", "series_offsets = true", SAMPLED),
        plain(
            "noise on the energy",
            "noise = \"both\"\nsticking = \"censored\"",
            SAMPLED,
        ),
        plain(
            "viscous film",
            "viscous = \"film\"\ndry_speed_m_s = \"impact\"",
            SAMPLED,
        ),
        plain("k of each diameter", "dry_k = \"diameter\"", SAMPLED),
        plain("no inertia", "inertia = \"none\"", SAMPLED),
        plain(
            "an accuracy",
            "",
            &["--stages", "least_squares,posterior", "--accuracy", "0.5"],
        ),
        plain("dry runs alone", "", &[]).rows(|_, row| only(row.contains(",dry,"), row)),
        plain("wet runs alone", "", &["--stages", "least_squares,bootstrap,posterior"])
            .rows(|_, row| only(!row.contains(",dry,"), row)),
        plain("too few to quote", "", &[]).rows(|i, row| only(i % 9 == 0, row)),
        plain("measurement errors", "", SAMPLED).of("errors"),
        plain("uncertain constants", "", LEAST_SQUARES).of("good/uncertain_constants"),
        plain("no film ratio", "", RESAMPLED).of("good/no_film_ratio"),
        plain("an outlier", "", LEAST_SQUARES).rows(an_outlier),
        plain("films of their own", "", SAMPLED)
            .of("good/no_film_ratio")
            .rows(own_films),
        plain("k of a diameter without dry runs", "dry_k = \"diameter\"", SAMPLED)
            .rows(|_, row| only(!row.contains(",dry,8,"), row)),
        plain("a value that is held", "", SAMPLED).with("[priors]\nlubrication_log = { fixed = 1.9 }\n"),
        plain("no viscous loss", "terms = [\"inertia\"]", SAMPLED),
        plain("a number published elsewhere", "", LEAST_SQUARES).with(PUBLISHED),
    ]
}

fn fitted(fit: &Fit) -> Value {
    let place = Folder::new();
    let read = |file: &str| read_in_project(&format!("tests/data/{}/{file}", fit.scene));
    let table = read("runs.csv");
    let (header, rows) = table.split_once('\n').expect("a header");
    let rows: Vec<String> = (1..)
        .zip(rows.lines())
        .filter_map(|(i, row)| (fit.row)(i, row))
        .collect();
    place.write("runs.csv", format!("{header}\n{}\n", rows.join("\n")));
    // with these settings, and few draws and replicates
    let (text, model, bootstrap) = (read("scene.toml"), fit.model, fit.bootstrap);
    let scene = format!(
        "{text}\n[model]\n{model}\n[sampler]\nchains = 2\nwarmup = 100\ndraws = 100\n\
         [bootstrap]\nreplicates = 100\n{bootstrap}\n"
    );
    place.write("scene.toml", scene);
    let words = [
        &["fit", "scene.toml", "--out", "out", "--quiet", "--threads", "1"],
        fit.arguments,
    ]
    .concat();
    let (status, _, said) = wetcor(place.path(), &words);
    assert!(matches!(status, Some(0 | 1)), "{}: {said}", fit.name);
    place.json("out/findings.json")
}

fn committed_findings(report: &str) -> Value {
    json_of(&format!("reports/{report}/findings.json"))
}

#[test]
fn the_committed_schema_is_that_of_the_types() {
    let made = wetcor::report::findings_schema().expect("a schema");
    assert!(
        made == kept("docs/findings.schema.json", &made),
        "the types have changed: run this test with UPDATE_EXPECTED=1"
    );
}

#[test]
fn findings_of_every_kind_of_fit_are_as_described() {
    let schema = schema();
    let written: Vec<(&str, Value)> = fits().par_iter().map(|fit| (fit.name, fitted(fit))).collect();
    let committed = ["mueller2016", "sticking"].map(|name| (name, committed_findings(name)));
    for (name, findings) in written.iter().chain(&committed) {
        let found = faults(&schema, &schema, findings, "");
        assert!(found.is_empty(), "{name}: {found:#?}");
        assert_rows_of_their_own(name, findings);
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
        /counts/runs | -1 | .counts.runs: beyond the minimum 0
        /posterior/chains | "four" | .posterior: none of what is allowed
        /film_groups/0/ends | [0.1] | .film_groups[0].ends: 1 items
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
        |rows| {
            for row in rows {
                row["main"] = json!(false);
            }
        },
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
