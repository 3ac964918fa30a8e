//! Reads the cells of a row by the columns that its header has, and gathers what is wrong.

use super::cells::{each_row, TakesRows};
use super::columns::present;
use super::header::{find, Column, FoundColumns};
use crate::error::{quoted, Error, Problem};
use crate::scene::{name_is_allowed, TableFile, DRY, NAME_RULE};
use crate::units::{MAGNITUDES, MAGNITUDE_EXPECTED};

/// A row: its line from 1, and its cells.
pub(crate) type Row<'r> = (u64, &'r [&'r str]);

/// The columns of a table, each named by its place in those that were wanted.
pub(crate) struct Fields {
    wanted: &'static [Column],
    found: FoundColumns,
    /// cells of the header
    width: usize,
    problems: Vec<Problem>,
}

/// The rows of a table, each read by `read`.
struct Rows<T, F> {
    fields: Fields,
    read: F,
    all: Vec<T>,
}

/// Reads every row of a table by the columns that it may have; what `read` gives of a row with a problem is left out.
///
/// Fails where the table cannot be opened, or a column is missing, stands twice or is misspelt.
pub(crate) fn rows_by_fields<T>(
    file: &TableFile,
    wanted: &'static [Column],
    read: impl FnMut(&mut Fields, Row) -> Option<T>,
) -> Result<(Fields, Vec<T>), Error> {
    let fields = Fields {
        wanted,
        found: FoundColumns::none(),
        width: 0,
        problems: vec![],
    };
    let mut rows = Rows {
        fields,
        read,
        all: vec![],
    };
    each_row(file, &mut rows)?;
    Ok((rows.fields, rows.all))
}

impl<T, F: FnMut(&mut Fields, Row) -> Option<T>> TakesRows for Rows<T, F> {
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.fields.found = find(names, line, self.fields.wanted)?;
        self.fields.width = names.len();
        Ok(())
    }

    fn width(&self) -> Option<usize> {
        Some(self.fields.width)
    }

    fn refuse(&mut self, problem: Problem) {
        self.fields.problems.push(problem);
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        let before = self.fields.problems.len();
        let row = (self.read)(&mut self.fields, (line, cells));
        self.all.extend(row.filter(|_| self.fields.problems.len() == before));
    }
}

/// What a row is of: particle, liquid, diameter and film, by their places in the columns that were wanted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SettingFields {
    pub particle: usize,
    pub liquid: usize,
    pub diameter: usize,
    pub film: usize,
}

/// What a sphere falls on, as a row gives it; lengths in m.
#[derive(Debug)]
pub(crate) struct RowOfSetting<'c> {
    /// name of the particle
    pub particle: &'c str,
    /// name of the liquid; `None` of a dry plate
    pub liquid: Option<&'c str>,
    /// D; `None` where it was refused
    pub diameter: Option<f64>,
    /// δ; `None` of a dry plate, and where it was refused
    pub film: Option<f64>,
}

impl Fields {
    /// Whether the table has a column.
    pub fn has(&self, field: usize) -> bool {
        self.found.columns[field].is_some()
    }

    /// Adds what is wrong with a cell, or with a line for want of one.
    pub fn problem(&mut self, line: u64, place: &str, found: Option<&str>, expected: String) {
        self.problems.push(Problem {
            line: Some(line),
            place: place.to_owned(),
            found: found.map(quoted),
            expected,
        });
    }

    /// A word; `None` where it is missing.
    pub fn word<'c>(&self, field: usize, cells: &[&'c str]) -> Option<&'c str> {
        let column = self.found.columns[field].as_ref()?;
        present(cells.get(column.index)?)
    }

    /// A number in SI; `None` where it is missing, and a problem where it is none above zero.
    pub fn number(&mut self, field: usize, (line, cells): Row) -> Option<f64> {
        let column = self.found.columns[field].clone()?;
        let cell = cells.get(column.index)?;
        let expected = match self.found.number(field, cell, line) {
            Ok(None) => return None,
            Ok(Some(value)) if value > 0.0 => {
                let value = column.to_si(value);
                if MAGNITUDES.contains(&value) {
                    return Some(value);
                }
                format!("expected {MAGNITUDE_EXPECTED}")
            }
            Ok(Some(_)) => "expected a number above 0".to_owned(),
            Err(expected) => expected,
        };
        self.problem(line, &column.name, Some(cell.trim()), expected);
        None
    }

    /// A number that must be there; a problem where it is not, `why` following what was expected.
    fn needed_number(&mut self, field: usize, row: Row, why: &str) -> Option<f64> {
        let before = self.problems.len();
        let number = self.number(field, row);
        if number.is_none() && self.problems.len() == before {
            let place = self.wanted[field].base;
            self.problem(row.0, place, None, format!("expected a number above 0{why}"));
        }
        number
    }

    /// The name of a particle or a liquid; a problem where it may not be one.
    fn name<'c>(&mut self, field: usize, (line, cells): (u64, &[&'c str])) -> Option<&'c str> {
        let name = self.word(field, cells)?;
        if !name_is_allowed(name) {
            let place = self.wanted[field].base;
            self.problem(line, place, Some(name), format!("expected {NAME_RULE}"));
        }
        Some(name)
    }

    /// Particle, liquid, diameter and film; the film of a dry plate is not read. `None`, and a problem, without a particle.
    pub fn setting<'c>(&mut self, of: SettingFields, (line, cells): (u64, &'c [&'c str])) -> Option<RowOfSetting<'c>> {
        let row = (line, cells);
        let Some(particle) = self.name(of.particle, row) else {
            self.problem(line, "particle", None, format!("expected {NAME_RULE}"));
            return None;
        };
        let liquid = self.name(of.liquid, row).filter(|liquid| *liquid != DRY);
        let diameter = self.needed_number(of.diameter, row, "");
        let film = liquid.and_then(|_| self.needed_number(of.film, row, ", since there is a liquid"));
        Some(RowOfSetting {
            particle,
            liquid,
            diameter,
            film,
        })
    }

    /// All that was wrong, and the columns that nobody reads.
    pub fn finish(mut self) -> (Vec<Problem>, Vec<String>) {
        let mut problems = self.problems;
        problems.extend(self.found.doubt());
        (problems, self.found.unread)
    }
}
