//! Reads CSV: runs on every thread at once, and once more in the order of the file where something is refused, to name it.

use std::io::{BufRead, Read};
use std::ops::Range;

use rayon::prelude::*;

use super::checked_rows::{Cell, CheckedRows, Holds};
use super::collect::{Collected, Gathering};
use super::columns::{ColumnPlace, Header, TableLayout};
use super::decimals::{parse_number, separator_of, DecimalMarks};
use super::labels::label;
use super::raw_row::RawRow;
use super::records::Records;
use super::refusals::{whole_file, CellPlace, Refused};
use super::row::RowChecker;
use super::survey::Survey;
use super::windows::{unreadable, Window, Windows};
use super::written_units::{is_row_of_units, units_above};
use crate::encoding::BYTE_ORDER_MARK;
use crate::error::Problem;
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::scene::{Naming, RunColumn, Scene};
use crate::seed::Hash;

/// What separates the columns of a text, by the line that names them: the one that the scene says, else the first that is
/// not blank.
pub(super) fn separator(source: impl Read, naming: &Naming) -> std::io::Result<u8> {
    let mut lines = std::io::BufReader::new(source.take(MOST_OF_LINE as u64));
    let mut line = vec![];
    let mut number = 0;
    while lines.read_until(b'\n', &mut line)? > 0 {
        number += 1;
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

/// What is done with a record.
enum Taken<T> {
    /// the next is looked at
    Passed,
    Read(T),
    /// it is still to be read
    Left,
}

/// A CSV that is read from its start to its end, a window of records at a time.
pub(super) struct Csv<R> {
    windows: Windows<R>,
    window: Window,
    /// the line the first piece of the window starts on
    line: u64,
    separator: u8,
    hash: Hash,
}

impl<R: Read + Send> Csv<R> {
    /// To be read in windows of about so many bytes.
    pub fn new(source: R, window: usize, separator: u8) -> Csv<R> {
        Csv {
            windows: Windows::new(source, window, separator),
            window: Window::default(),
            line: 1,
            separator,
            hash: Hash::default(),
        }
    }

    /// Goes on to the next window; whether there is one.
    fn advance(&mut self) -> Result<bool, Problem> {
        self.hash.update(&self.window.bytes);
        self.windows.fetch(&mut self.window).map_err(unreadable)?;
        Ok(!self.window.bytes.is_empty())
    }

    /// Reads the header: the names, and a row of units below them where there is one.
    pub fn header(&mut self, header_row: Option<u64>) -> Result<Header, Vec<Problem>> {
        let mut header = self.names(header_row)?;
        let width = header.names.len();
        let units = self.next_record(|_, cells| {
            let is_one = cells.len() == width && is_row_of_units(cells.iter().copied());
            Ok(match is_one {
                true => Taken::Read(cells.iter().map(|cell| (*cell).to_owned()).collect()),
                false => Taken::Left,
            })
        })?;
        header.units = units.unwrap_or_default();
        Ok(header)
    }

    /// Reads the names, on the line that the scene says or the first that is not blank, and the units above them.
    pub fn names(&mut self, header_row: Option<u64>) -> Result<Header, Vec<Problem>> {
        let first = header_row.unwrap_or(1);
        let mut above = vec![];
        let names = self.next_record(|line, cells| {
            if line < first {
                above = units_above(cells.iter().copied());
                return Ok(Taken::Passed);
            }
            if header_row.is_some_and(|row| line > row) {
                let found = format!("line {first} is blank");
                return Err(whole_file(&found, "the names of columns where `header_row` says"));
            }
            if cells.len() > MOST_COLUMNS {
                return Err(too_many_columns(cells.len(), Some(line)));
            }
            let names = cells.iter().map(|cell| cell.trim().to_owned()).collect();
            Ok(Taken::Read(Header {
                names,
                units_above: std::mem::take(&mut above),
                line: Some(line),
                ..Header::default()
            }))
        })?;
        names.ok_or_else(|| {
            let expected = "a header line and one line a run";
            let found = header_row.map_or("the file is blank".to_owned(), |row| format!("there is no line {row}"));
            vec![whole_file(&found, expected)]
        })
    }

    /// Gives records away, the next first, until one is read, which then is taken out of what is left, or left there.
    fn next_record<T>(
        &mut self,
        mut take: impl FnMut(u64, &[&str]) -> Result<Taken<T>, Problem>,
    ) -> Result<Option<T>, Vec<Problem>> {
        let whole = |problem| vec![problem];
        loop {
            while self.window.pieces.is_empty() {
                if !self.advance().map_err(whole)? {
                    return Ok(None);
                }
            }
            let (text, mut room) = self.window.text(&self.window.pieces[0]).map_err(whole)?;
            let mut records = Records::new(text, self.line, self.separator, &mut room);
            let mut taken = Taken::Passed;
            let (mut read, mut line) = (0, self.line);
            while matches!(taken, Taken::Passed) && records.advance().map_err(whole)? {
                taken = take(records.line(), records.cells()).map_err(whole)?;
                if !matches!(taken, Taken::Left) {
                    (read, line) = records.next_start();
                }
            }
            if matches!(taken, Taken::Passed) {
                // blank lines at the end of the piece
                (read, line) = records.next_start();
            }
            self.line = line;
            self.window.pieces[0].start += read;
            if self.window.pieces[0].is_empty() {
                self.window.pieces.remove(0);
            }
            match taken {
                Taken::Passed => {}
                Taken::Read(read) => return Ok(Some(read)),
                Taken::Left => return Ok(None),
            }
        }
    }

    /// Goes through the records below the header, which was read before, in their order.
    pub fn each_record(&mut self, mut each: impl FnMut(&Records)) -> Result<(), Problem> {
        loop {
            for piece in &self.window.pieces {
                let (text, mut room) = self.window.text(piece)?;
                let mut records = Records::new(text, self.line, self.separator, &mut room);
                while records.advance()? {
                    each(&records);
                }
                (_, self.line) = records.next_start();
            }
            if !self.advance()? {
                return Ok(());
            }
        }
    }

    /// About how many rows it has, rather too many than too few; it is about so many bytes long.
    pub fn about_rows(mut self, length: u64) -> usize {
        let has_window = self.advance().unwrap_or(false);
        if has_window {
            rows_like(&self.window.bytes, length)
        } else {
            0
        }
    }

    /// The cells of the first records that are not empty, with their lines.
    pub fn first_rows(mut self, most: usize) -> Result<Vec<(u64, Vec<String>)>, Vec<Problem>> {
        let mut rows = vec![];
        while rows.len() < most {
            let row = self.next_record(|line, cells| {
                let cells = cells.iter().map(|cell| (*cell).to_owned()).collect();
                Ok(Taken::Read((line, cells)))
            })?;
            match row {
                Some(row) => rows.push(row),
                None => break,
            }
        }
        Ok(rows)
    }

    /// What stands in its columns.
    pub fn survey(mut self, header_row: Option<u64>) -> Result<Survey, Vec<Problem>> {
        let mut survey = Survey::new(self.header(header_row)?);
        let read = self.each_record(|record| {
            if !record.is_empty() {
                survey.add(record.line(), record.cells().iter().map(|cell| Some(*cell)));
            }
        });
        read.map_err(|problem| vec![problem])?;
        Ok(survey)
    }

    /// Reads the header, and finds in it the columns of runs.
    fn layout<'s>(&mut self, scene: &'s Scene) -> Result<TableLayout<'s>, Vec<Problem>> {
        let header = self.header(scene.data.naming.header_row)?;
        TableLayout::new(&header, &scene.data.naming)
    }

    /// Reads every run in the order of the file, and names all that is wrong; with the SHA-256 of the file.
    pub fn runs_in_order(mut self, scene: &Scene) -> Result<(Collected, String), Refused> {
        let layout = self.layout(scene)?;
        let mut rows = CheckedRows::new(&layout, scene);
        // lines of separators, which are none below the last run
        let mut empty = vec![];
        let read = self.each_record(|record| {
            let line = record.line();
            if record.is_empty() {
                empty.push(line);
                return;
            }
            for line in empty.drain(..) {
                rows.refuse(empty_row(line));
            }
            if record.cells().len() == layout.width {
                add_by_cell(&mut rows, record);
            } else {
                rows.refuse(other_width(
                    record.line(),
                    record.cells().len(),
                    layout.width,
                    record.has_line_ends(),
                ));
            }
        });
        if let Err(problem) = read {
            rows.refuse(problem);
        }
        let mut collected = rows.finish()?;
        collected.lines.last = self.line - 1;
        Ok((collected, self.hash.finish()))
    }

    /// Reads every run, a window at a time on every thread; with the SHA-256 of the file, which is about so many bytes long.
    /// `None` where something is refused, be it only for what came before it.
    ///
    /// While one window is parsed, the runs of the one before it are gathered and the one after it is fetched.
    pub fn runs_at_once(
        mut self,
        scene: &Scene,
        length: u64,
        gathering: &mut Gathering,
    ) -> Option<(Collected, String)> {
        let layout = self.layout(scene).ok()?;
        let reader = PieceReader::new(scene, &layout, self.separator);
        let rows = gathering.held(rows_like(&self.window.bytes, length).min(MOST_FORESEEN));
        let mut collected = Collected::with_capacity(rows, reader.checker.has_film_ratio, &layout.remarks);
        collected.lines.last = self.line - 1;
        let (mut parsed, mut next) = (vec![], Window::default());
        let mut ends = PartEnds::default();
        while !self.window.bytes.is_empty() {
            let Csv {
                windows, window, hash, ..
            } = &mut self;
            let (of_window, (fetched, ((), ()))) = rayon::join(
                || reader.parts(window),
                || {
                    rayon::join(
                        || windows.fetch(&mut next),
                        || {
                            let mut gather = || {
                                collected.extend(&parsed);
                                gathering.after(&mut collected);
                            };
                            rayon::join(|| hash.update(&window.bytes), &mut gather)
                        },
                    )
                },
            );
            fetched.ok()?;
            parsed.clear();
            for part in of_window? {
                ends = ends.and(&part)?;
                parsed.push(part.runs);
            }
            std::mem::swap(&mut self.window, &mut next);
        }
        collected.extend(&parsed);
        (!ends.marks.are_ambiguous()).then(|| (collected, self.hash.finish()))
    }
}

/// The runs of a piece of text.
struct Part {
    runs: Collected,
    marks: DecimalMarks,
    /// whether lines of separators stand at its end
    ends_empty: bool,
}

/// What is known of the parts so far that those after them must go with.
#[derive(Default)]
struct PartEnds {
    marks: DecimalMarks,
    are_empty: bool,
}

impl PartEnds {
    /// With one part more; `None` where it does not go with those before.
    fn and(self, part: &Part) -> Option<PartEnds> {
        let marks = self.marks.and(part.marks);
        let has_rows = part.runs.rows > 0;
        let is_bad = marks.are_mixed() || (self.are_empty && has_rows);
        (!is_bad).then_some(PartEnds {
            marks,
            are_empty: self.are_empty || part.ends_empty,
        })
    }
}

/// Reads pieces of a text, each on its own.
struct PieceReader<'s> {
    checker: RowChecker<'s>,
    layout: &'s TableLayout<'s>,
    separator: u8,
    /// what the cells of a row hold; `None` where it is not read
    columns: Vec<Option<(RunColumn, ColumnPlace)>>,
}

impl<'s> PieceReader<'s> {
    fn new(scene: &'s Scene, layout: &'s TableLayout<'s>, separator: u8) -> Self {
        let mut columns = vec![None; layout.width];
        for column in RunColumn::ALL {
            if let Some(place) = layout.place(column) {
                columns[place.index] = Some((column, place.clone()));
            }
        }
        PieceReader {
            checker: RowChecker::new(scene, layout.gives(RunColumn::FilmRatio)),
            layout,
            separator,
            columns,
        }
    }

    /// The runs of a window, a piece after the other; `None` where something is refused.
    fn parts(&self, window: &Window) -> Option<Vec<Part>> {
        let part = |piece| self.part(window, piece);
        window.pieces.par_iter().map(part).collect()
    }

    fn part(&self, window: &Window, piece: &Range<usize>) -> Option<Part> {
        let (text, mut room) = window.text(piece).ok()?;
        let mut records = Records::new(text, 1, self.separator, &mut room);
        let most = memchr::memchr_iter(b'\n', text.as_bytes()).count() + 1;
        let mut rows = CheckedRows::of_part(self.layout, self.checker.clone(), most);
        let mut row = self.layout.row_before_its_cells();
        let mut ends_empty = false;
        while records.advance().ok()? {
            if records.is_empty() {
                ends_empty = true;
                records.forget();
                continue;
            }
            if ends_empty || records.cells().len() != self.columns.len() {
                return None;
            }
            let marks = self.read_cells(&records, &mut row);
            let is_added = marks.is_some_and(|marks| rows.add_read(records.line(), &row, marks));
            if !is_added {
                // not every cell of a row need be good
                add_by_cell(&mut rows, &records);
                records.forget();
            }
        }
        let (_, next_line) = records.next_start();
        let (runs, marks) = rows.finish_part(next_line - 1)?;
        Some(Part {
            runs,
            marks,
            ends_empty,
        })
    }

    /// Puts the cells of a record in a row that holds those of the one before, and gives the marks of their decimals; `None`
    /// where one that should hold a number does not, or one may mark the row as no run.
    fn read_cells<'t>(&self, records: &Records<'t>, row: &mut RawRow<'t>) -> Option<DecimalMarks>
    where
        's: 't,
    {
        let mut marks = DecimalMarks::default();
        let unchanged = records.unchanged();
        for (cell, column) in records.cells()[unchanged..].iter().zip(&self.columns[unchanged..]) {
            let Some((column, place)) = column else {
                if label(cell).is_some() {
                    return None;
                }
                continue;
            };
            let is_label = !column.is_number() && label(cell).is_some();
            if is_label {
                return None;
            }
            let cell = self.layout.read(*column, cell);
            if !column.is_number() {
                row.set_word(*column, cell);
                continue;
            }
            let number = cell.map(parse_number).transpose().ok()?;
            row.set(*column, number.map(|number| place.to_si(number.value)));
            if let Some(number) = number {
                marks = marks.and(number.marks);
            }
        }
        Some(marks)
    }
}

/// Adds the record at hand, and names every cell of it that is wrong.
fn add_by_cell(rows: &mut CheckedRows, record: &Records) {
    rows.add(
        CellPlace::Line(record.line()),
        record.cells().iter().copied(),
        |place| {
            Some(Cell {
                text: record.cells().get(place.index)?,
                holds: Holds::Text,
            })
        },
    );
}

/// Says that a line of separators stands between runs.
fn empty_row(line: u64) -> Problem {
    Problem {
        line: Some(line),
        place: "row".to_owned(),
        found: Some("empty cells only".to_owned()),
        expected: "expected a run, or no line at all".to_owned(),
    }
}

/// Says that a row has more or fewer cells than the header.
pub(super) fn other_width(line: u64, cells: usize, width: usize, has_line_ends: bool) -> Problem {
    let mut expected = format!("expected {width} as in the header");
    if has_line_ends {
        expected.push_str("; a cell goes on over the end of the line: is a quote not closed?");
    } else if cells > width {
        expected.push_str("; a number takes a decimal point, not a comma");
    }
    let noun = if cells == 1 { "cell" } else { "cells" };
    Problem {
        line: Some(line),
        place: "row".to_owned(),
        found: Some(format!("{cells} {noun}")),
        expected,
    }
}

/// Says that a table is wider than any table of runs.
pub(super) fn too_many_columns(found: usize, line: Option<u64>) -> Problem {
    Problem {
        line,
        place: "header".to_owned(),
        found: Some(format!("{found} columns")),
        expected: format!("expected at most {MOST_COLUMNS}"),
    }
}

/// Rows for which memory is allocated without having seen them.
const MOST_FORESEEN: usize = 1 << 24;

/// About how many rows a source of some length has if all of it is like this window, rather too many than too few.
fn rows_like(window: &[u8], length: u64) -> usize {
    let lines = memchr::memchr_iter(b'\n', window).count();
    (1.05 * lines as f64 * length as f64 / window.len() as f64) as usize
}
