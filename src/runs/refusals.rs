//! Says where a bad cell stands, and what is wrong with a row, a file, or a file that a library cannot read.

use std::fmt::Display;

use super::damaged::unless_damaged;
use crate::error::Problem;

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
