//! Reads CSV: runs on every thread at once, and once more in the order of the file where something is refused, to name it.

use std::io::{BufRead, Read};
use std::ops::Range;

use rayon::prelude::*;

use super::checked_rows::{Cell, CheckedRows, Holds};
use super::collect::{Collected, Gathering};
use super::columns::{ColumnPlace, TableLayout};
use super::decimals::{parse_number, separator_of, DecimalMarks};
use super::labels::label;
use super::records::Records;
use super::refusals::{whole_file, CellPlace, Refused};
use super::row::{RawRow, RowChecker};
use super::survey::Survey;
use super::windows::{unreadable, Window, Windows};
use crate::encoding::BYTE_ORDER_MARK;
use crate::error::Problem;
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::scene::{Naming, RunColumn, Scene};
use crate::seed::Hash;

/// What separates the columns of a text, by its first line that is not blank.
pub(super) fn separator(source: impl Read, naming: &Naming) -> std::io::Result<u8> {
    let mut lines = std::io::BufReader::new(source.take(MOST_OF_LINE as u64));
    let mut line = vec![];
    while lines.read_until(b'\n', &mut line)? > 0 {
        if !line.trim_ascii().is_empty() {
            break;
        }
        line.clear();
    }
    let text = String::from_utf8_lossy(&line);
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
    let line = text.split(['\n', '\r']).find(|line| !line.trim().is_empty());
    Ok(separator_of(line.unwrap_or_default(), naming))
}

/// The names in the first line that is not blank.
#[derive(Debug)]
pub(super) struct Header {
    pub names: Vec<String>,
    /// where it stands, from 1
    pub line: u64,
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

    /// Reads the header.
    pub fn header(&mut self) -> Result<Header, Vec<Problem>> {
        let mut header = None;
        while header.is_none() && self.advance().map_err(|problem| vec![problem])? {
            while header.is_none() && !self.window.pieces.is_empty() {
                header = self.header_of_piece()?;
            }
        }
        header.ok_or_else(|| {
            let expected = "a header line and one line a run";
            vec![whole_file("the file is blank", expected)]
        })
    }

    /// Reads the header if it is in the first piece of the window, and takes what was read out of it.
    fn header_of_piece(&mut self) -> Result<Option<Header>, Vec<Problem>> {
        let text = self.window.text(&self.window.pieces[0]);
        let (text, mut room) = text.map_err(|problem| vec![problem])?;
        let mut records = Records::new(text, self.line, self.separator, &mut room);
        let mut header = None;
        if records.advance().map_err(|problem| vec![problem])? {
            let (line, cells) = (records.line(), records.cells());
            if cells.len() > MOST_COLUMNS {
                return Err(vec![too_many_columns(cells.len(), Some(line))]);
            }
            let names = cells.iter().map(|cell| cell.trim().to_owned()).collect();
            header = Some(Header { names, line });
        }
        let (read, line) = records.next_start();
        self.line = line;
        self.window.pieces[0].start += read;
        if self.window.pieces[0].is_empty() {
            self.window.pieces.remove(0);
        }
        Ok(header)
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

    /// What stands in its columns.
    pub fn survey(mut self) -> Result<Survey, Vec<Problem>> {
        let mut survey = Survey::new(self.header()?.names);
        let read = self.each_record(|record| {
            if !record.is_empty() {
                survey.add(record.cells().iter().map(|cell| Some(*cell)));
            }
        });
        read.map_err(|problem| vec![problem])?;
        Ok(survey)
    }

    /// Reads the header, and finds in it the columns of runs.
    fn layout<'s>(&mut self, scene: &'s Scene) -> Result<TableLayout<'s>, Vec<Problem>> {
        let header = self.header()?;
        TableLayout::new(&header.names, Some(header.line), &scene.data.naming)
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
                rows.refuse(other_width(record, layout.width));
            }
        });
        if let Err(problem) = read {
            rows.refuse(problem);
        }
        Ok((rows.finish()?, self.hash.finish()))
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
            let is_added = marks.is_some_and(|marks| rows.add_read(&row, marks));
            if !is_added {
                // not every cell of a row need be good
                add_by_cell(&mut rows, &records);
                records.forget();
            }
        }
        let (runs, marks) = rows.finish_part()?;
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
fn other_width(record: &Records, width: usize) -> Problem {
    let cells = record.cells().len();
    let mut expected = format!("expected {width} as in the header");
    if record.has_line_ends() {
        expected.push_str("; a cell goes on over the end of the line: is a quote not closed?");
    } else if cells > width {
        expected.push_str("; a number takes a decimal point, not a comma");
    }
    let noun = if cells == 1 { "cell" } else { "cells" };
    Problem {
        line: Some(record.line()),
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
