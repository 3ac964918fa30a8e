//! Reads the cells of a row by the columns that its header has, and gathers what is wrong.

use super::cells::CellNumbers;
use super::columns::present;
use super::header::{find, Column, FoundColumns};
use crate::error::{quoted, Problem};
use crate::scene::{name_is_allowed, NAME_RULE};
use crate::units::{MAGNITUDES, MAGNITUDE_EXPECTED};

/// A row: its line from 1, and its cells.
pub(crate) type Row<'r> = (u64, &'r [&'r str]);

/// The columns of a table, each named by its place in those that were wanted.
pub(crate) struct Fields {
    wanted: &'static [Column],
    found: FoundColumns,
    /// cells of the header
    width: usize,
    numbers: CellNumbers,
    problems: Vec<Problem>,
}

impl Fields {
    /// Those of a table whose header is yet to come.
    pub fn new(wanted: &'static [Column]) -> Fields {
        Fields {
            wanted,
            found: FoundColumns::default(),
            width: 0,
            numbers: CellNumbers::default(),
            problems: vec![],
        }
    }

    /// Finds the columns in a header. Fails where one is missing, stands twice or is misspelt.
    pub fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.found = find(names, line, self.wanted)?;
        self.width = names.len();
        Ok(())
    }

    /// How many cells the header has.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether the table has a column.
    pub fn has(&self, field: usize) -> bool {
        self.found.columns[field].is_some()
    }

    /// What was wrong so far.
    pub fn problems(&self) -> usize {
        self.problems.len()
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

    /// Adds what is wrong with a row as a whole.
    pub fn refuse(&mut self, problem: Problem) {
        self.problems.push(problem);
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
        let expected = match self.numbers.read(cell, (line, &column.name)) {
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
    pub fn needed_number(&mut self, field: usize, row: Row, why: &str) -> Option<f64> {
        let before = self.problems.len();
        let number = self.number(field, row);
        if number.is_none() && self.problems.len() == before {
            let place = self.wanted[field].base;
            self.problem(row.0, place, None, format!("expected a number above 0{why}"));
        }
        number
    }

    /// The name of a particle or a liquid; a problem where it may not be one.
    pub fn name<'c>(&mut self, field: usize, (line, cells): (u64, &[&'c str])) -> Option<&'c str> {
        let name = self.word(field, cells)?;
        if !name_is_allowed(name) {
            let place = self.wanted[field].base;
            self.problem(line, place, Some(name), format!("expected {NAME_RULE}"));
        }
        Some(name)
    }

    /// All that was wrong, and the columns that nobody reads.
    pub fn finish(self) -> (Vec<Problem>, Vec<String>) {
        let mut problems = self.problems;
        problems.extend(self.numbers.doubt());
        (problems, self.found.unread)
    }
}
