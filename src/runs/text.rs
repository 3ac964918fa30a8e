//! Reads runs from CSV as text: accepts what the fast reader refuses, or names the bad cell by line and column.

use std::io::{BufRead, Read};

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::checked_rows::{Cell, CheckedRows, Holds};
use super::collect::Collected;
use super::columns::TableLayout;
use super::decimals::separator_of;
use super::refusals::{whole_file, CellPlace, Refused};
use super::survey::Survey;
use crate::encoding::{line_of, BYTE_ORDER_MARK};
use crate::error::Problem;
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::scene::{Naming, Scene};

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
    let line = cell_text(&line);
    let line = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&line);
    Ok(separator_of(line, naming))
}

/// The names in the first line that is not blank.
#[derive(Debug)]
pub(super) struct Header {
    pub names: Vec<String>,
    /// where it stands, from 1
    pub line: u64,
}

/// A CSV that is read from its start to its end, a record at a time; of the text no more is held than a record.
pub(super) struct Text<R> {
    reader: csv::Reader<CountedLines<R>>,
    record: ByteRecord,
}

impl<R: Read> Text<R> {
    /// The bytes must be UTF-8, but for a byte-order mark before them.
    pub fn new(source: R, separator: u8) -> Text<R> {
        const BUFFER: usize = 1 << 16;
        Text {
            reader: ReaderBuilder::new()
                .delimiter(separator)
                .has_headers(false)
                .flexible(true)
                .trim(Trim::All)
                .buffer_capacity(BUFFER)
                .from_reader(CountedLines::of(source)),
            record: ByteRecord::new(),
        }
    }

    /// Reads the next record that is not blank; whether there is one.
    fn next_record(&mut self) -> Result<bool, Problem> {
        loop {
            self.reader.get_mut().since_record = 0;
            match self.reader.read_byte_record(&mut self.record) {
                Ok(true) if is_blank(&self.record) => continue,
                Ok(there) => {
                    self.reader.get_mut().pass(&self.record);
                    return Ok(there);
                }
                Err(error) => {
                    let lines = self.reader.get_mut();
                    lines.pass(&self.record);
                    if lines.since_record <= MOST_OF_LINE {
                        return Err(whole_file("the table cannot be read", &error.to_string()));
                    }
                    return Err(Problem {
                        line: Some(lines.line),
                        place: "row".to_owned(),
                        found: Some("a longer row".to_owned()),
                        expected: format!(
                            "expected rows of at most {MOST_OF_LINE} bytes; a cell may go on over the end of the line: is \
                             a quote not closed?"
                        ),
                    });
                }
            }
        }
    }

    /// Reads the header.
    pub fn header(&mut self) -> Result<Header, Vec<Problem>> {
        if !self.next_record().map_err(|problem| vec![problem])? {
            let expected = "a header line and one line a run";
            return Err(vec![whole_file("the file is blank", expected)]);
        }
        let line = self.reader.get_ref().line;
        if self.record.len() > MOST_COLUMNS {
            return Err(vec![too_many_columns(self.record.len(), Some(line))]);
        }
        let names: Vec<String> = self
            .record
            .iter()
            .map(|cell| cell_text(cell).trim().to_owned())
            .collect();
        Ok(Header { names, line })
    }

    /// Reads all of it for what stands in its columns.
    pub fn survey(&mut self) -> Result<Survey, Vec<Problem>> {
        let mut survey = Survey::new(self.header()?.names);
        while self.next_record().map_err(|problem| vec![problem])? {
            if self.record.iter().any(|cell| !cell.is_empty()) {
                survey.add(self.record.iter().map(|cell| std::str::from_utf8(cell).ok()));
            }
        }
        Ok(survey)
    }

    /// Reads every row below the header, which was read before.
    pub fn rows(&mut self, layout: &TableLayout, scene: &Scene) -> Result<Collected, Refused> {
        let mut rows = CheckedRows::new(layout, scene);
        // lines of separators, which are none below the last run
        let mut empty = vec![];
        loop {
            match self.next_record() {
                Ok(true) => {}
                Ok(false) => break,
                Err(problem) => {
                    rows.refuse(problem);
                    break;
                }
            }
            let line = self.reader.get_ref().line;
            let record = &self.record;
            if record.len() > 1 && record.iter().all(<[u8]>::is_empty) {
                empty.push(line);
                continue;
            }
            for line in empty.drain(..) {
                rows.refuse(empty_row(line));
            }
            if record.len() != layout.width {
                rows.refuse(other_width(record, layout.width, line));
                continue;
            }
            rows.add(CellPlace::Line(line), |place| {
                // the whole file was checked to be UTF-8
                let text = std::str::from_utf8(record.get(place.index)?).ok()?;
                Some(Cell {
                    text,
                    holds: Holds::Text,
                })
            });
        }
        rows.finish()
    }
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
fn other_width(record: &ByteRecord, width: usize, line: u64) -> Problem {
    let mut expected = format!("expected {width} as in the header");
    if record.iter().any(|cell| cell.contains(&b'\n')) {
        expected.push_str("; a cell goes on over the end of the line: is a quote not closed?");
    } else if record.len() > width {
        expected.push_str("; a number takes a decimal point, not a comma");
    }
    let noun = if record.len() == 1 { "cell" } else { "cells" };
    Problem {
        line: Some(line),
        place: "row".to_owned(),
        found: Some(format!("{} {noun}", record.len())),
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

/// A line of blanks only, which is no row.
fn is_blank(record: &ByteRecord) -> bool {
    record.len() == 1 && record[0].is_empty()
}

fn cell_text(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell).into_owned()
}

/// Hands a source on without its byte-order mark, and counts lines up to records that come in its order.
struct CountedLines<R> {
    source: R,
    /// what is to come before the source: what stood where the mark may stand
    first: Option<Vec<u8>>,
    /// what was handed on, from somewhere before the last record counted to
    seen: Vec<u8>,
    /// where in `seen` lines are counted to
    counted: usize,
    /// bytes of the source before `seen`
    before: u64,
    /// the line that stands at `counted`
    line: u64,
    /// bytes handed on for the record that is being read
    since_record: usize,
}

impl<R: Read> CountedLines<R> {
    fn of(source: R) -> Self {
        CountedLines {
            source,
            first: None,
            seen: vec![],
            counted: 0,
            before: 0,
            line: 1,
            since_record: 0,
        }
    }

    /// Counts up to the line a record starts on; the reader's own position stands before any blank lines it skipped.
    fn pass(&mut self, record: &ByteRecord) {
        let from = record.position().map_or(0, |position| position.byte());
        let from = from
            .checked_sub(self.before)
            .and_then(|from| usize::try_from(from).ok());
        let from = from.unwrap_or(0).clamp(self.counted, self.seen.len());
        let blanks = self.seen[from..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        let passed = &self.seen[self.counted..];
        self.line += line_of(passed, from + blanks - self.counted) - 1;
        self.counted = from + blanks;
    }
}

impl<R: Read> Read for CountedLines<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        if self.since_record > MOST_OF_LINE {
            return Err(std::io::Error::other("a longer row"));
        }
        if self.first.is_none() {
            let mut first = vec![];
            let mut mark = [0; 4];
            let mark = BYTE_ORDER_MARK.encode_utf8(&mut mark).as_bytes();
            self.source.by_ref().take(mark.len() as u64).read_to_end(&mut first)?;
            if first == mark {
                first.clear();
            }
            self.first = Some(first);
        }
        let fetched = match &mut self.first {
            Some(first) if !first.is_empty() => {
                let fetched = first.len().min(into.len());
                into[..fetched].copy_from_slice(&first[..fetched]);
                first.drain(..fetched);
                fetched
            }
            _ => self.source.read(into)?,
        };
        self.before += self.counted as u64;
        self.seen.drain(..std::mem::take(&mut self.counted));
        self.seen.extend_from_slice(&into[..fetched]);
        self.since_record += fetched;
        Ok(fetched)
    }
}
