//! Reads which tables hold the runs, and which of their runs are used.

use std::path::Path;

use super::expect::{ABOVE_ZERO, FILM_RATIO, LARGEST_FILM_RATIO, NOT_NEGATIVE, SHARE};
use super::keys::{Key, Section};
use super::naming::{naming, Naming, SceneNames};
use super::table::{read_nothing, Number, Numbers, SceneTable, TextOrTexts};
use super::table_file::TableFile;
use crate::error::quoted;
use crate::units::Dimension;

/// Which runs, and which of them are used.
#[derive(Debug, Clone, PartialEq)]
pub struct Data {
    /// the tables of runs, at least one, whose rows follow one another
    pub runs: Vec<TableFile>,
    /// what they call their columns and their words
    pub naming: Naming,
    /// a restitution at or below this counts as stuck
    pub smallest_restitution: f64,
    /// where runs carry no film ratio: the nominal ones they were made at, in increasing order; empty where groups are to be
    /// found
    pub film_ratios: Vec<f64>,
    /// where neither names a film ratio: sorted δ/D is split at larger gaps
    pub film_ratio_gap: f64,
    /// sd of an error of the film thickness that all runs share, m; absent: the films are taken as exact
    pub film_sd: Option<f64>,
    /// sd over value of an error that all speeds share; absent: their scale is taken as exact
    pub speed_rel_sd: Option<f64>,
    /// which runs are left out
    pub screens: Screens,
}

/// Limits outside which a run is left out and counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screens {
    /// thinnest film, m
    pub min_film: Option<f64>,
    /// largest film ratio δ/D; never above [`super::LARGEST_FILM_RATIO`]
    pub max_film_ratio: f64,
    /// slowest impact, m/s
    pub min_impact_speed: Option<f64>,
    /// fastest impact, m/s
    pub max_impact_speed: Option<f64>,
}

const RUNS: Key<TextOrTexts> = Key::new("runs", TextOrTexts)
    .means(
        "table of runs, beside the scene: .csv, .tsv, .txt, .parquet, .xlsx (first visible sheet, or \
         \"book.xlsx#May\")",
    )
    .example("\"runs.csv\"");

const SMALLEST_RESTITUTION: Key<Number, f64> = Key::new("smallest_restitution", Number(SHARE))
    .means("a run with this restitution or less stuck")
    .example("0.02")
    .defaults_to(0.0);

const FILM_RATIOS: Key<Numbers> = Key::new("film_ratios", Numbers(FILM_RATIO))
    .means("nominal film ratios δ/D; a run within 15 % of one belongs to it")
    .example("[0.03, 0.06]")
    .optional("groups are found");

const FILM_RATIO_GAP: Key<Number, f64> = Key::new("film_ratio_gap", Number(ABOVE_ZERO))
    .means("where groups are found: wider gaps between film ratios part them")
    .example("0.01")
    .defaults_to(0.004);

const MIN_FILM: Key<Number> = Key::of("min_film", Dimension::Thickness, Number(ABOVE_ZERO))
    .means("runs on thinner films are left out, and counted")
    .example("200")
    .optional("no film is too thin");

const MAX_FILM_RATIO: Key<Number, f64> = Key::new("max_film_ratio", Number(FILM_RATIO))
    .means("runs at larger film ratios are left out, and counted")
    .example("0.2")
    .defaults_to(LARGEST_FILM_RATIO);

const MIN_IMPACT_SPEED: Key<Number> = Key::of("min_impact_speed", Dimension::Speed, Number(ABOVE_ZERO))
    .means("slower runs are left out, and counted")
    .example("0.3")
    .optional("no impact is too slow");

const MAX_IMPACT_SPEED: Key<Number> = Key::of("max_impact_speed", Dimension::Speed, Number(ABOVE_ZERO))
    .means("faster runs are left out, and counted")
    .example("2.5")
    .optional("no impact is too fast");

const FILM_SD: Key<Number> = Key::of("film_sd", Dimension::Thickness, Number(NOT_NEGATIVE))
    .means("sd of an error of the film that all runs share")
    .example("10")
    .optional("films are taken as exact");

const SPEED_REL_SD: Key<Number> = Key::new("speed_rel_sd", Number(SHARE))
    .means("sd over value of an error that all speeds share")
    .example("0.01")
    .optional("their scale is taken as exact");

/// What is to be said of the table of the data.
pub(super) fn guide() -> Section {
    let (_, keys) = read_nothing(|table| data(table, Path::new(""), &SceneNames::default()));
    let about = "Which tables hold the runs, what they call things, and which runs are used";
    Section::new("[data]", about, keys)
}

/// Reads the table of the data of a scene that lies at `path`.
pub(super) fn data(table: &SceneTable, path: &Path, names: &SceneNames) -> Data {
    let runs = runs(table, path);
    let data = Data {
        naming: naming(table, names, &runs),
        runs,
        smallest_restitution: table.read_or(&SMALLEST_RESTITUTION),
        film_ratios: in_order(table.read(&FILM_RATIOS).unwrap_or_default()),
        film_ratio_gap: table.read_or(&FILM_RATIO_GAP),
        screens: Screens {
            min_film: table.read(&MIN_FILM),
            max_film_ratio: table.read_or(&MAX_FILM_RATIO),
            min_impact_speed: table.read(&MIN_IMPACT_SPEED),
            max_impact_speed: table.read(&MAX_IMPACT_SPEED),
        },
        film_sd: table.read(&FILM_SD),
        speed_rel_sd: table.read(&SPEED_REL_SD),
    };
    table.finish();
    data
}

/// Each number once, in increasing order.
fn in_order(mut numbers: Vec<f64>) -> Vec<f64> {
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    numbers
}

/// The tables of runs, each once and in a format that can be read.
fn runs(table: &SceneTable, path: &Path) -> Vec<TableFile> {
    let names = table.read(&RUNS).unwrap_or_default();
    let mut runs: Vec<TableFile> = vec![];
    for (name, at) in &names {
        let refuse = |expected: &str| table.refuse(RUNS.base, *at, Some(quoted(name)), expected);
        let file = TableFile::named(path.parent(), name);
        if !file.has_known_ending() {
            refuse(&format!("expected {}", TableFile::ENDING_EXPECTED));
        }
        if runs.iter().any(|other| other.is_same_as(&file)) {
            refuse("expected every table once");
        }
        runs.push(file);
    }
    runs
}
