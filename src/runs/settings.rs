//! Reads a table of settings that predictions are asked for: a line each.

use std::path::Path;

use super::cells::{each_row, TakesRows};
use super::fields::Fields;
use super::header::{column, Column};
use crate::error::{Error, Problem};
use crate::scene::{TableFile, DRY, NAME_RULE};
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

/// The columns of the table, by their place in [`COLUMNS`].
#[derive(Clone, Copy)]
enum Field {
    Particle,
    Liquid,
    Diameter,
    Film,
    ImpactSpeed,
}

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
    let mut rows = Rows {
        fields: Fields::new(&COLUMNS),
        settings: vec![],
    };
    each_row(&TableFile::given(path), &mut rows)?;
    let has_speed = rows.fields.has(Field::ImpactSpeed as usize);
    let Rows { fields, settings } = rows;
    let (mut problems, unread) = fields.finish();
    let whole = |place: &str, expected: &str| Problem {
        line: None,
        place: place.to_owned(),
        found: None,
        expected: expected.to_owned(),
    };
    if !unread.is_empty() {
        let place = format!("columns {}", unread.join(", "));
        let known = "expected `particle`, `liquid`, `diameter_mm`, `film_um` and `impact_speed_m_s` alone, in any unit";
        problems.push(whole(&place, known));
    }
    if settings.is_empty() && problems.is_empty() {
        problems.push(whole("no settings below the header", "expected one line a setting"));
    }
    if let Some(setting) = settings.iter().find(|own| has_speed && own.impact_speed.is_none()) {
        problems.push(Problem {
            line: Some(setting.line),
            ..whole(
                "impact_speed",
                "expected a number above 0, as the column has in other lines",
            )
        });
    }
    if problems.is_empty() {
        Ok(settings)
    } else {
        Err(Error::input(path, problems))
    }
}

struct Rows {
    fields: Fields,
    settings: Vec<AskedSetting>,
}

impl TakesRows for Rows {
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.fields.header(names, line)
    }

    fn width(&self) -> Option<usize> {
        Some(self.fields.width())
    }

    fn refuse(&mut self, problem: Problem) {
        self.fields.refuse(problem);
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        let before = self.fields.problems();
        let setting = self.setting(line, cells);
        self.settings
            .extend(setting.filter(|_| self.fields.problems() == before));
    }
}

impl Rows {
    fn setting(&mut self, line: u64, cells: &[&str]) -> Option<AskedSetting> {
        let row = (line, cells);
        let fields = &mut self.fields;
        let Some(particle) = fields.name(Field::Particle as usize, row) else {
            fields.problem(line, "particle", None, format!("expected {NAME_RULE}"));
            return None;
        };
        let liquid = fields.name(Field::Liquid as usize, row).filter(|liquid| *liquid != DRY);
        let diameter = fields.needed_number(Field::Diameter as usize, row, "");
        let film = match liquid {
            Some(_) => fields.needed_number(Field::Film as usize, row, ", since there is a liquid"),
            None => None,
        };
        Some(AskedSetting {
            line,
            particle: particle.to_owned(),
            liquid: liquid.map(str::to_owned),
            diameter: diameter?,
            film,
            impact_speed: fields.number(Field::ImpactSpeed as usize, row),
        })
    }
}
