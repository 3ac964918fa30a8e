//! Holds tables of more runs than are kept, read as few that stand for all and a sample, against the same tables read whole.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{seed_of, write, Place, Told};
use crate::condensing::{self, OF_THEIR_OWN};
use serde_json::Value;
use wetcor::findings::{self, Findings};
use wetcor::model::simulate::Simulation;
use wetcor::ranks::Ranks;
use wetcor::runs::{self, Table};

/// Ten tables, so that what stands for eight of them is put together before it is with the others.
const TABLES: usize = 10;

fn scene(own: &str, format: &str) -> String {
    let tables: Vec<String> = (0..TABLES).map(|part| format!("\"part-{part}.{format}\"")).collect();
    condensing::scene(own)
        .replace("very many runs", "more runs than are kept")
        .replace("\"runs.csv\"", &format!("[{}]", tables.join(", ")))
        .replace("[truth]", "[sampler]\ndraws = 500\n[truth]")
}

fn drawn(own: &str, format: &str, runs: usize, name: &str) -> Place {
    let place = Place::new(&scene(own, format));
    let simulation = Simulation::new(&place.scene, Some((runs / TABLES) as u64)).expect("a design");
    for (table, part) in place.scene.data.runs.iter().zip(0..) {
        write(&simulation, seed_of(name) + part, &table.path);
    }
    place
}

fn few_of(place: &Place, most_kept: usize) -> Table {
    let table = runs::read_any_number(&place.scene, most_kept, &Ranks::alone());
    let table = table.unwrap_or_else(|error| panic!("{error}"));
    assert!(
        table.runs.sample.is_some() && table.runs.len() < table.rows / 3,
        "{}",
        table.runs.len()
    );
    table
}

fn fit(place: &Place, table: &Table) -> Findings {
    findings::fit_least_squares(&place.scene, table, 1, true)
}

/// Every number of a finding by its place in the document.
fn numbers(value: &Value, place: &str, into: &mut Vec<(String, f64)>) {
    match value {
        Value::Object(entries) => entries
            .iter()
            .for_each(|(key, own)| numbers(own, &format!("{place}.{key}"), into)),
        Value::Array(entries) => entries
            .iter()
            .enumerate()
            .for_each(|(key, own)| numbers(own, &format!("{place}.{key}"), into)),
        Value::Number(number) => into.extend(number.as_f64().map(|number| (place.to_owned(), number))),
        _ => {}
    }
}

/// The numbers of some findings.
fn numbers_of(findings: &Findings, sections: &[&str]) -> Vec<(String, f64)> {
    let document = serde_json::to_value(findings).expect("a document");
    let mut all = vec![];
    for section in sections {
        numbers(&document[section], section, &mut all);
    }
    assert!(!all.is_empty());
    all
}

/// Numbers that differ by more than a share of themselves, or that only one has.
fn apart(few: &[(String, f64)], all: &[(String, f64)], share: impl Fn(&str) -> Option<f64>) -> Vec<String> {
    let held = |some: &[(String, f64)]| -> BTreeMap<String, f64> {
        let held = some.iter().filter(|(place, _)| share(place).is_some());
        held.cloned().collect()
    };
    let (few, all) = (held(few), held(all));
    let places: BTreeSet<&String> = few.keys().chain(all.keys()).collect();
    let is_apart = |place: &&&String| match (few.get(**place), all.get(**place)) {
        (Some(few), Some(all)) => {
            share(place).is_some_and(|share| (few - all).abs() > share * all.abs() + f64::MIN_POSITIVE)
        }
        _ => true,
    };
    let apart = places.iter().filter(is_apart);
    apart
        .map(|place| format!("{place}: {:?}, {:?}", few.get(*place), all.get(*place)))
        .collect()
}

/// What the bootstrap and the sample say is held to other lines.
fn is_of_sample(place: &str) -> bool {
    let words = ["bootstrap", "interval", "lack_of_fit", "width", "ends"];
    words.iter().any(|word| place.contains(word))
}

/// Values to 1e-9; what is made of their curvature, which cancels more, to 1e-5. The fits over all film ratios stand first: their
/// square root turns at a rebound, and whether its search ends there is a matter of rounding, with all runs as with few.
fn of_least_squares(place: &str) -> Option<f64> {
    let is_pooled = ["scaling.0.", "scaling.1."]
        .iter()
        .any(|pooled| place.starts_with(pooled));
    (!is_of_sample(place) && !is_pooled).then(|| if place.ends_with(".value") { 1e-9 } else { 1e-5 })
}

const FITTED: [&str; 8] = [
    "counts",
    "dry",
    "series",
    "scaling",
    "energy",
    "energy_balance",
    "terms",
    "identifies",
];

fn hold_least_squares(few: &Findings, all: &Findings) {
    let [of_few, of_all] = [few, all].map(|own| numbers_of(own, &FITTED));
    let found = apart(&of_few, &of_all, of_least_squares);
    assert!(found.is_empty(), "{found:#?}");
}

/// The largest share by which a width of the sandwich differs. Fits that hang on a run have none of a sample.
fn widths_apart(few: &Findings, all: &Findings) -> f64 {
    let [of_few, of_all] = [few, all].map(|own| -> BTreeMap<String, f64> {
        let widths = numbers_of(own, &["dry", "series", "scaling"]).into_iter();
        widths.filter(|(place, _)| place.ends_with(".bootstrap.se")).collect()
    });
    assert!(
        of_few.len() > 10 && of_few.len() <= of_all.len(),
        "{} {}",
        of_few.len(),
        of_all.len()
    );
    let apart = of_few.iter().map(|(place, few)| (few / of_all[place] - 1.0).abs());
    apart.fold(0.0, f64::max)
}

#[test]
fn least_squares_says_the_same_of_a_table_that_is_not_kept() {
    for (own, format) in [(OF_THEIR_OWN, "csv"), ("", "parquet")] {
        let place = drawn(own, format, 120_000, "a table that is not kept");
        let (few, all) = (few_of(&place, 100_000), place.read());
        let (of_few, of_all) = (fit(&place, &few), fit(&place, &all));
        assert_eq!(few.sha256, all.sha256);
        hold_least_squares(&of_few, &of_all);
        // of some 2,200 runs a fit a width is known to 1.5 %
        let widths = widths_apart(&of_few, &of_all);
        assert!(widths < 0.07, "{widths}");
        let codes = |findings: &Findings| findings.tells("condensed_runs");
        assert!(codes(&of_few) && !codes(&of_all));
        // the planted fault: a stand-in of every series counts for a tenth more
        let mut faulty = few;
        for series in &faulty.runs.series {
            faulty.runs.count[series.rebounds.start] *= 1.1;
        }
        let of_faulty = numbers_of(&fit(&place, &faulty), &FITTED);
        let found = apart(&of_faulty, &numbers_of(&of_all, &FITTED), of_least_squares);
        assert!(found.len() > 20, "{found:#?}");
    }
}
