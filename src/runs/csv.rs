//! Reads CSV in the order of the file: its header, and its runs or all that is wrong with them.

use std::io::{BufRead, BufReader, Read};

use super::checked_rows::{Cell, CheckedRows, TakeRuns};
use super::collect::Collected;
use super::columns::{TableHeader, TableLayout, MOST_ABOVE};
use super::decimals::separator_of;
use super::headers::units::is_row_of_units;
use super::records::{separator_named, Records};
use super::refusals::{bad_row, whole_file, CellPlace};
use super::survey::Survey;
use crate::encoding::{line_ends, BYTE_ORDER_MARK};
use crate::error::{quoted, Problem, Problems};
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::rounding::counted;
use crate::scene::{Naming, Scene};

/// What separates the columns of a text: what a first line `sep=;` says, else by the line that names them, the one that the
/// scene says or the first that is not blank.
pub(super) fn separator(source: impl Read, naming: &Naming) -> std::io::Result<u8> {
    let mut lines = BufReader::new(source.take(MOST_OF_LINE as u64));
    let mut line = vec![];
    let mut number = 0;
    while lines.read_until(b'\n', &mut line)? > 0 {
        number += 1;
        let start = line
            .strip_prefix(BYTE_ORDER_MARK.to_string().as_bytes())
            .unwrap_or(&line);
        if let Some((named, _)) = separator_named(start).filter(|_| number == 1) {
            return Ok(named);
        }
        let is_named = naming.header_row.is_none_or(|row| number >= row);
        if is_named && !line.trim_ascii().is_empty() {
            break;
        }
        line.clear();
    }
    let text = String::from_utf8_lossy(&line);
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
    let line = text.split(['\n', '\r']).find(|line| !line.trim().is_empty());
    Ok(separator_of(line.unwrap_or_default(), naming))
}

/// About how many rows a text of so many bytes has if all of it is like its start, rather too many than too few.
pub(super) fn about_rows(source: impl Read, length: u64) -> std::io::Result<usize> {
    const START: u64 = 2 << 20;
    let mut start = vec![];
    source.take(START).read_to_end(&mut start)?;
    let lines = line_ends(&start).count();
    Ok((1.05 * lines as f64 * length as f64 / start.len() as f64) as usize)
}

impl<R: Read> Records<R> {
    /// Reads the header: the names, and a row of units below them where there is one.
    pub fn header(&mut self, header_row: Option<u64>) -> Result<TableHeader, Vec<Problem>> {
        let mut header = self.names(header_row)?;
        if let Some(below) = self.next_record()? {
            if below.cells.len() == header.names.len() && is_row_of_units(below.cells.iter().copied()) {
                header.units = below.texts();
            } else {
                self.put_back();
            }
        }
        Ok(header)
    }

    /// Reads the names, on the line that the scene says or the first that is not blank, and the units above them.
    pub fn names(&mut self, header_row: Option<u64>) -> Result<TableHeader, Vec<Problem>> {
        let first = header_row.unwrap_or(1);
        let mut above: Vec<Vec<String>> = vec![];
        while let Some(record) = self.next_record()? {
            if record.line < first {
                above.truncate(MOST_ABOVE);
                above.push(record.texts());
                continue;
            }
            if header_row.is_some_and(|row| record.line > row) {
                let found = format!("line {first} is blank");
                return Err(vec![whole_file(&found, "the names of columns where `header_row` says")]);
            }
            if record.cells.len() > MOST_COLUMNS {
                return Err(vec![too_many_columns(record.cells.len(), Some(record.line))]);
            }
            let names = record.cells.iter().map(|cell| cell.trim().to_owned()).collect();
            return Ok(TableHeader {
                line: Some(record.line),
                ..TableHeader::of(&above, names)
            });
        }
        let found = header_row.map_or("the file is blank".to_owned(), |row| format!("there is no line {row}"));
        Err(vec![whole_file(&found, "a header line and one line a run")])
    }

    /// The cells of the first records that are not blank, with their lines.
    pub fn first_rows(mut self, most: usize) -> Result<Vec<(u64, Vec<String>)>, Vec<Problem>> {
        let mut rows = vec![];
        while rows.len() < most {
            let Some(record) = self.next_record()? else { break };
            rows.push((record.line, record.texts()));
        }
        Ok(rows)
    }

    /// What stands in its columns.
    pub fn survey(mut self, header_row: Option<u64>) -> Result<Survey, Vec<Problem>> {
        let mut survey = Survey::new(self.header(header_row)?);
        while let Some(record) = self.next_record()? {
            if !record.is_empty() {
                survey.add(record.line, record.cells.iter().copied());
            }
        }
        Ok(survey)
    }

    /// Reads every run, or names all that is wrong.
    pub fn runs(mut self, scene: &Scene, take: TakeRuns) -> Result<Collected, Problems> {
        let header = self.header(scene.data.naming.header_row)?;
        let layout = TableLayout::new(&header, &scene.data.naming)?;
        let mut rows = CheckedRows::new(&layout, scene, take);
        if let Err(problems) = self.add_rows(&mut rows, layout.width) {
            rows.problems.extend(problems.into());
        }
        rows.finish()
    }

    /// Adds every record below the header, or refuses it. Fails where the rest of the file cannot be read.
    fn add_rows(&mut self, rows: &mut CheckedRows, width: usize) -> Result<(), Vec<Problem>> {
        let separator = self.separator;
        // lines of separators, which are none below the last run
        let mut empty = vec![];
        while let Some(record) = self.next_record()? {
            if record.is_empty() {
                empty.push(record.line);
                continue;
            }
            for line in empty.drain(..) {
                let problem = bad_row(line, "empty cells only", "a run, or no line at all");
                rows.problems.push(problem);
            }
            let line = record.line;
            if record.cells.len() != width {
                rows.problems.push(other_width(line, &record.cells, width, true));
                continue;
            }
            // nearly every row has one line
            let goes_on = memchr::memchr2(b'\n', b'\r', record.text.as_bytes()).is_some();
            let mut cells = record.cells.iter().filter(|_| goes_on);
            if let Some(cell) = cells.find(|cell| holds_a_row(cell, separator, width)) {
                let found = quoted(cell.lines().next().unwrap_or_default());
                let expected = "a cell without rows in it: is a quote not closed?";
                rows.problems.push(bad_row(line, &found, expected));
                continue;
            }
            rows.add(CellPlace::Line(line), record.cells.iter().copied(), |place| {
                record.cells.get(place.index).copied().map(Cell::Text)
            });
            rows.give_block();
        }
        Ok(())
    }
}

/// Whether a line inside a quoted cell has as many cells as a row of so many: a quote that is not closed takes whole rows.
fn holds_a_row(cell: &str, separator: u8, width: usize) -> bool {
    let cells_of = |line: &str| line.bytes().filter(|byte| *byte == separator).count() + 1;
    let mut others = cell.split(['\n', '\r']).skip(1);
    others.any(|line| cells_of(line) >= width.max(2))
}

/// Says that a row has more or fewer cells than the header; in a text a cell may go on over the end of a line.
pub(super) fn other_width<C: AsRef<str>>(line: u64, cells: &[C], width: usize, is_of_text: bool) -> Problem {
    let mut expected = format!("{width} as in the header");
    if is_of_text && cells.iter().any(|cell| cell.as_ref().contains(['\n', '\r'])) {
        expected.push_str("; a cell goes on over the end of the line: is a quote not closed?");
    } else if cells.len() > width {
        expected.push_str("; a number takes a decimal point, not a comma");
    }
    bad_row(line, &counted(cells.len(), "cell"), &expected)
}

/// Says that a table is wider than any table of runs.
pub(super) fn too_many_columns(found: usize, line: Option<u64>) -> Problem {
    let problem = Problem::new("header", format!("expected at most {MOST_COLUMNS}")).on(line);
    problem.found(format!("{found} columns"))
}
