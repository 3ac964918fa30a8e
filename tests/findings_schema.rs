//! Holds `docs/findings.schema.json` to the findings that fits of many kinds of scene write.

use crate::common::{wetcor, Folder};
use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;
use serde_json::{json, Map, Value};
use wetcor::findings::SCHEMA;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn json_of(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn schema() -> Value {
    json_of(&root().join("docs/findings.schema.json"))
}

/// The schema and what of a value it refuses, by the keywords that the schema uses; any other keyword is a fault.
struct Validator<'a> {
    schema: &'a Value,
    faults: Vec<String>,
    /// descriptions of the properties that the value has, after the object's own
    reached: BTreeSet<[&'a str; 2]>,
}

impl<'a> Validator<'a> {
    fn new(schema: &'a Value) -> Validator<'a> {
        Validator {
            schema,
            faults: vec![],
            reached: BTreeSet::new(),
        }
    }

    fn faults(schema: &'a Value, value: &Value) -> Vec<String> {
        let mut validator = Validator::new(schema);
        validator.check(schema, value, "");
        validator.faults
    }

    fn require(&mut self, holds: bool, at: &str, what: &str) {
        if !holds {
            self.faults.push(format!("{at}: {what}"));
        }
    }

    fn check(&mut self, schema: &'a Value, value: &Value, at: &str) {
        for (keyword, says) in schema.as_object().expect("a schema is an object") {
            match keyword.as_str() {
                "$schema" | "$id" | "$defs" | "title" | "description" => {}
                "$ref" => {
                    let place = says
                        .as_str()
                        .and_then(|text| text.strip_prefix('#'))
                        .expect("a place inside");
                    let found = self.schema.pointer(place).unwrap_or_else(|| panic!("no {place}"));
                    self.check(found, value, at);
                }
                "anyOf" => {
                    let holds = list(says).iter().any(|one| {
                        let mut alone = Validator::new(self.schema);
                        alone.check(one, value, at);
                        self.reached.append(&mut alone.reached);
                        alone.faults.is_empty()
                    });
                    self.require(holds, at, "none of what is allowed");
                }
                "type" => {
                    let holds = match says {
                        Value::Array(types) => types.iter().any(|name| is_of_type(value, name)),
                        name => is_of_type(value, name),
                    };
                    self.require(holds, at, &format!("not of type {says}"));
                }
                "const" => self.require(value == says, at, &format!("not {says}")),
                "enum" => self.require(list(says).contains(value), at, &format!("{value} is none of {says}")),
                "minimum" => {
                    let holds = value
                        .as_f64()
                        .is_none_or(|number| number >= says.as_f64().expect("a number"));
                    self.require(holds, at, &format!("below {says}"));
                }
                "minItems" | "maxItems" => self.size(keyword, says, value.as_array().map(Vec::len), at),
                "minLength" | "maxLength" => {
                    self.size(keyword, says, value.as_str().map(|text| text.chars().count()), at);
                }
                "items" => {
                    for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(says, item, &format!("{at}[{i}]"));
                    }
                }
                "required" => {
                    let Some(object) = value.as_object() else { continue };
                    for name in list(says).iter().filter_map(Value::as_str) {
                        self.require(object.contains_key(name), at, &format!("without {name}"));
                    }
                }
                "properties" => {
                    for (name, own) in value.as_object().into_iter().flatten() {
                        if let Some(of) = says.get(name) {
                            self.reached.insert([words(schema), words(of)]);
                            self.check(of, own, &format!("{at}.{name}"));
                        }
                    }
                }
                "additionalProperties" => {
                    assert_eq!(says, &json!(false), "any other value is not understood here");
                    let known = schema["properties"].as_object().expect("properties");
                    for name in value.as_object().into_iter().flat_map(Map::keys) {
                        self.require(known.contains_key(name), at, &format!("{name} is unknown"));
                    }
                }
                unknown => panic!("keyword {unknown} is not understood here"),
            }
        }
    }

    fn size(&mut self, keyword: &str, says: &Value, size: Option<usize>, at: &str) {
        let (Some(size), Some(limit)) = (size, says.as_u64()) else {
            return;
        };
        let holds = if keyword.starts_with("min") {
            size as u64 >= limit
        } else {
            size as u64 <= limit
        };
        self.require(holds, at, &format!("{size} items, {keyword} {limit}"));
    }
}

/// The description of a schema.
fn words(schema: &Value) -> &str {
    schema["description"].as_str().unwrap_or_default()
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

/// The scene with these settings and few draws and replicates.
fn scene_text(fit: &Fit, folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("scene.toml")).expect("a scene");
    let Fit { model, bootstrap, .. } = fit;
    format!(
        "{text}\n[model]\n{model}\n[sampler]\nchains = 2\nwarmup = 100\ndraws = 100\n\
         [bootstrap]\nreplicates = 100\n{bootstrap}\n"
    )
}

fn fitted(fit: &Fit) -> Value {
    let place = Folder::new();
    let source = root().join("tests/data").join(fit.scene);
    let table = std::fs::read_to_string(source.join("runs.csv")).expect("runs");
    let (header, rows) = table.split_once('\n').expect("a header");
    let rows: Vec<String> = (1..)
        .zip(rows.lines())
        .filter_map(|(i, row)| (fit.row)(i, row))
        .collect();
    let table = format!("{header}\n{}\n", rows.join("\n"));
    place.write("runs.csv", table);
    place.write("scene.toml", scene_text(fit, &source));
    let words = [
        &["fit", "scene.toml", "--out", "out", "--quiet", "--threads", "1"],
        fit.arguments,
    ]
    .concat();
    let (status, _, said) = wetcor(place.path(), &words);
    assert!(matches!(status, Some(0 | 1)), "{}: {said}", fit.name);
    place.json("out/findings.json")
}

/// Fields that none of these fits writes: they need replicates or draws that fail, or more runs than are kept.
const WRITTEN_BY_NONE: &str = "Bootstrapped.failures \
     CompressionSummary.bound \
     CompressionSummary.held_against \
     CompressionSummary.max_log_density_error \
     CompressionSummary.nodes \
     CompressionSummary.rows \
     Counts.sheets \
     Failed.reason \
     Failed.replicates \
     SeriesOffset.why_none";

/// The whole document and every object in it, by its name.
fn objects(schema: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let inside = schema["$defs"].as_object().expect("definitions").iter();
    inside
        .map(|(name, object)| (name.as_str(), object))
        .chain([("", schema)])
}

fn committed_findings(report: &str) -> Value {
    json_of(&root().join("reports").join(report).join("findings.json"))
}

#[test]
fn findings_of_every_kind_of_fit_are_as_described() {
    let schema = schema();
    let mut reached = BTreeSet::new();
    let written: Vec<(&str, Value)> = fits().par_iter().map(|fit| (fit.name, fitted(fit))).collect();
    let committed = ["mueller2016", "sticking"];
    for (name, findings) in written
        .into_iter()
        .chain(committed.map(|name| (name, committed_findings(name))))
    {
        let mut validator = Validator::new(&schema);
        validator.check(&schema, &findings, "");
        assert!(validator.faults.is_empty(), "{name}: {:#?}", validator.faults);
        reached.append(&mut validator.reached);
    }
    let unreached = objects(&schema).flat_map(|(name, object)| {
        let properties = object["properties"].as_object().expect("properties").iter();
        let unreached = properties.filter(|(_, of)| !reached.contains(&[words(object), words(of)]));
        unreached
            .map(move |(key, _)| format!("{name}.{key}"))
            .collect::<Vec<String>>()
    });
    let unreached: Vec<String> = unreached.collect();
    let by_none: Vec<&str> = WRITTEN_BY_NONE.split(' ').collect();
    assert_eq!(unreached, by_none, "of the fits that are looked at");
}

#[test]
fn the_version_is_that_of_the_program() {
    assert_eq!(schema()["properties"]["schema"]["const"], SCHEMA);
    assert_eq!(schema()["$id"], SCHEMA);
}

#[test]
fn planted_faults_are_refused() {
    let schema = schema();
    let findings = committed_findings("mueller2016");
    assert!(Validator::faults(&schema, &findings).is_empty());
    let refused = |plant: fn(&mut Value), words: &str| {
        let mut changed = findings.clone();
        plant(&mut changed);
        assert_ne!(changed, findings, "{words}: nothing was planted");
        let faults = Validator::faults(&schema, &changed);
        assert!(faults.iter().any(|fault| fault.contains(words)), "{words}: {faults:#?}");
    };
    refused(
        |all| drop(remove(all, "/series/0/alpha", "level")),
        "series[0].alpha: without level",
    );
    refused(|all| all["dry"][0]["weight"] = json!(1.0), "dry[0]: weight is unknown");
    refused(
        |all| all["series"][3]["film_m"] = json!("0.0003"),
        "series[3].film_m: not of type",
    );
    refused(|all| all["counts"]["runs"] = json!(-1), "counts.runs: below 0");
    refused(
        |all| all["posterior"]["chains"] = json!("four"),
        "posterior: none of what is allowed",
    );
    refused(
        |all| all["film_groups"][0]["ends"] = json!([0.1]),
        "film_groups[0].ends: 1 items",
    );
    refused(
        |all| all["dry"][0]["stop"] = json!("tired"),
        "dry[0].stop: \"tired\" is none of",
    );
    refused(|all| all["schema"] = json!("wetcor.findings/1"), "schema: not");
}

fn remove(value: &mut Value, place: &str, name: &str) -> Option<Value> {
    value.pointer_mut(place)?.as_object_mut()?.remove(name)
}

/// Units that a description may end with.
const UNITS: &str = "no unit; m; m/s; (m/s)^(-1/5); m²/s²; s/m; kg/m³; Pa s; N/m; \
    the unit of the quantity; the unit of the result; the unit of the quantity in `with`; as `unit` says; as `text` says; as that of `value`";

#[test]
fn objects_are_closed_and_every_number_has_its_unit() {
    let schema = schema();
    for (name, object) in objects(&schema) {
        assert_eq!(object["additionalProperties"], json!(false), "{name}");
        assert!(object["description"].is_string(), "{name}");
        let properties = object["properties"].as_object().expect("properties");
        let required = list(&object["required"]);
        assert!(
            required
                .iter()
                .all(|own| properties.contains_key(own.as_str().expect("a name"))),
            "{name}"
        );
        for (key, property) in properties {
            let text = words(property);
            assert!(text.ends_with('.'), "{name}.{key}: {text:?}");
            let whole = property.to_string();
            let of_number = whole.contains("\"number\"") || whole.contains("#/$defs/Estimate\"");
            let has_unit = UNITS.split("; ").any(|unit| text.ends_with(&format!("({unit}).")));
            assert_eq!(
                of_number || whole.contains("#/$defs/MainNumber\""),
                has_unit,
                "{name}.{key}: {text}"
            );
        }
    }
}
