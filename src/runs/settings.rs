//! Reads a table of settings that predictions are asked for: a line each.

use std::path::Path;

use super::fields::{column, rows_by_fields, Column};
use super::refusals::whole_file;
use crate::error::{unless_wrong, Error};
use crate::scene::TableFile;
use crate::units::Dimension;

/// A setting.
#[derive(Debug, Clone, PartialEq)]
pub struct AskedSetting {
    /// line of the table, from 1
    pub line: u64,
    /// name of the particle
    pub particle: String,
    /// name of the liquid; `None` of a dry plate
    pub liquid: Option<String>,
    /// D, m
    pub diameter: f64,
    /// δ, m; `None` of a dry plate
    pub film: Option<f64>,
    /// v, m/s, where the table gives it
    pub impact_speed: Option<f64>,
}

/// The columns of the table.
const COLUMNS: [Column; 5] = [
    column("particle", Dimension::One, true),
    column("liquid", Dimension::One, false),
    column("diameter", Dimension::Length, true),
    column("film", Dimension::Thickness, false),
    column("impact_speed", Dimension::Speed, false),
];

/// Reads the settings of a CSV or a workbook. A liquid that is empty or `dry` is none.
///
/// Fails with every bad cell named, where there is no line, and where a column is there that nobody reads.
pub fn read_settings(path: &Path) -> Result<Vec<AskedSetting>, Error> {
    let (fields, settings) = rows_by_fields(&TableFile::given(path), &COLUMNS, |fields, row| {
        let of = fields.setting(row)?;
        Some(AskedSetting {
            line: row.0,
            particle: of.particle.to_owned(),
            liquid: of.liquid.map(str::to_owned),
            diameter: of.diameter?,
            film: of.film,
            impact_speed: fields.number("impact_speed", row),
        })
    })?;
    let has_speed = fields.has("impact_speed");
    let (mut problems, unread) = fields.finish();
    if !unread.is_empty() {
        let place = format!("columns {}", unread.join(", "));
        let known = "`particle`, `liquid`, `diameter_mm`, `film_um` and `impact_speed_m_s` alone, in any unit";
        problems.push(whole_file(&place, known));
    }
    if settings.is_empty() && problems.is_empty() {
        problems.push(whole_file("no settings below the header", "one line a setting"));
    }
    if let Some(setting) = settings.iter().find(|own| has_speed && own.impact_speed.is_none()) {
        let problem = whole_file("impact_speed", "a number above 0, as the column has in other lines");
        problems.push(problem.on(setting.line));
    }
    unless_wrong(problems, settings).map_err(|problems| Error::input(path, problems))
}
