//! Gathers what is wrong with a table, cell by cell.

use std::fmt::Display;

use super::columns::TableLayout;
use super::damaged::unless_damaged;
use super::raw_row::BadCell;
use crate::error::{Problem, Problems, PROBLEMS_SHOWN};
use crate::scene::RunColumn;

/// Where a bad cell stands.
#[derive(Debug, Clone, Copy)]
pub(crate) enum CellPlace {
    /// line of a text file, from 1
    Line(u64),
    /// row of a Parquet file or of a sheet, from 1
    Row(u64),
}

impl CellPlace {
    /// The number of the line or row.
    pub fn number(self) -> u64 {
        let (CellPlace::Line(number) | CellPlace::Row(number)) = self;
        number
    }

    /// As a sentence names it.
    pub fn words(self) -> String {
        match self {
            CellPlace::Line(line) => format!("line {line}"),
            CellPlace::Row(row) => format!("row {row}"),
        }
    }
}

/// A problem of the file as a whole.
pub(crate) fn whole_file(found: &str, expected: &str) -> Problem {
    Problem::new(found, format!("expected {expected}"))
}

/// A problem of a line of a text as a whole.
pub(super) fn bad_row(line: u64, found: &str, expected: &str) -> Problem {
    whole_file("row", expected).on(line).found(found.to_owned())
}

/// Does a step of reading a file of some format by a library. A damaged file may make that panic: it too is only an
/// unreadable file.
pub(super) fn readable<T, E: Display>(format: &str, step: impl FnOnce() -> Result<T, E>) -> Result<T, Vec<Problem>> {
    let why = match unless_damaged(step) {
        Some(Ok(value)) => return Ok(value),
        Some(Err(error)) => error.to_string(),
        None => "its parts contradict each other".to_owned(),
    };
    let first = why.lines().next().unwrap_or_default();
    Err(vec![Problem::new(format!("not a readable {format}"), first)])
}

/// The problems found in a table so far; of those that nobody prints only the number, since there may be one a cell.
pub(super) struct Refusals<'p> {
    layout: &'p TableLayout<'p>,
    pub problems: Problems,
    wants_film: bool,
}

impl<'p> Refusals<'p> {
    pub fn new(layout: &'p TableLayout<'p>) -> Self {
        Refusals {
            layout,
            problems: Problems::default(),
            wants_film: false,
        }
    }

    /// A bad cell; `found` shows what stands in a column, and `None` where nothing does.
    pub fn cell(&mut self, at: CellPlace, bad: BadCell, found: impl FnOnce(RunColumn) -> Option<String>) {
        if bad.column == RunColumn::Film && !self.layout.gives(RunColumn::Film) {
            self.wants_film = true;
            return;
        }
        if self.problems.count >= PROBLEMS_SHOWN {
            self.problems.count += 1;
            return;
        }
        let column = self.layout.blamed(bad.column);
        let found = found(column).unwrap_or_else(|| "an empty cell".to_owned());
        self.named_cell(at, &self.layout.name(column), bad.expected, found);
    }

    /// The same of any column by its name.
    pub fn named_cell(&mut self, at: CellPlace, name: &str, expected: String, found: String) {
        let (line, place) = match at {
            CellPlace::Line(line) => (Some(line), format!("column {name}")),
            CellPlace::Row(row) => (None, format!("row {row}, column {name}")),
        };
        self.problems.push(Problem::new(place, expected).on(line).found(found));
    }

    /// A bad cell without which others may be good.
    pub fn cell_before_others(&mut self, at: CellPlace, bad: BadCell, found: String) {
        let others = std::mem::take(&mut self.problems);
        self.cell(at, bad, |_| Some(found));
        self.problems.extend(others);
    }

    /// What was read, if nothing was refused.
    pub fn or<T>(self, read: T) -> Result<T, Problems> {
        let missing = self
            .wants_film
            .then(|| self.layout.missing_column(RunColumn::Film, " (wet runs need it)"));
        let mut all = Problems::from(Vec::from_iter(missing));
        all.extend(self.problems);
        match all.count {
            0 => Ok(read),
            _ => Err(all),
        }
    }
}
