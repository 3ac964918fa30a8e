//! Reads which tables hold the runs, and which of their runs are used.

use std::path::Path;

use super::expect::{ABOVE_ZERO, FILM_RATIO, LARGEST_FILM_RATIO, NOT_NEGATIVE, SHARE};
use super::naming::{naming, Naming, SceneNames};
use super::table::values::{number, text_or_texts};
use super::table::SceneTable;
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

/// Reads the table of the data of a scene that lies at `path`.
pub(super) fn data(table: &SceneTable, path: &Path, names: &SceneNames) -> Data {
    let runs = runs(table, path);
    let data = Data {
        naming: naming(table, names, &runs),
        runs,
        smallest_restitution: table.read_or("smallest_restitution", number(SHARE), 0.0),
        film_ratios: in_order(
            table
                .list("film_ratios", Dimension::One, FILM_RATIO)
                .unwrap_or_default(),
        ),
        film_ratio_gap: table.read_or("film_ratio_gap", number(ABOVE_ZERO), 0.004),
        screens: Screens {
            min_film: table.read("min_film", number(ABOVE_ZERO).of(Dimension::Thickness)),
            max_film_ratio: table.read_or("max_film_ratio", number(FILM_RATIO), LARGEST_FILM_RATIO),
            min_impact_speed: table.read("min_impact_speed", number(ABOVE_ZERO).of(Dimension::Speed)),
            max_impact_speed: table.read("max_impact_speed", number(ABOVE_ZERO).of(Dimension::Speed)),
        },
        film_sd: table.read("film_sd", number(NOT_NEGATIVE).of(Dimension::Thickness)),
        speed_rel_sd: table.read("speed_rel_sd", number(SHARE)),
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
    let names = table.required("runs", text_or_texts()).unwrap_or_default();
    let mut runs: Vec<TableFile> = vec![];
    for (name, at) in &names {
        let refuse = |expected: &str| table.refuse("runs", *at, Some(quoted(name)), expected);
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
