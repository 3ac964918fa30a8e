//! Reads runs from CSV as text: accepts what a typed reader refuses, or names the bad cell by line and column.

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::collect::Collected;
use super::columns::{Column, Plan};
use super::refusals::{At, Refusals};
use super::row::{check, Against, BadCell, RawRow};
use super::whole_file;
use crate::encoding::line_of;
use crate::error::{quoted, Problem};
use crate::scene::{Scene, MISSING};

/// A cell that is missing.
pub(super) fn is_missing(cell: &str) -> bool {
    cell.is_empty() || cell == MISSING
}

/// The number a cell that is not missing holds, or what was expected of it.
pub(super) fn number(cell: &str) -> Result<f64, String> {
    cell.parse().map_err(|_| {
        let comma = cell.replacen(',', ".", 1).parse::<f64>().is_ok();
        format!("expected a number{}", if comma { " with a decimal point" } else { "" })
    })
}

/// The names in the first line that is not blank.
#[derive(Debug)]
pub(super) struct Header {
    pub names: Vec<String>,
    /// where it stands, from 1
    pub line: u64,
}

pub(super) fn header(text: &str) -> Result<Header, Vec<Problem>> {
    let mut record = ByteRecord::new();
    let mut reader = reader(text);
    loop {
        match reader.read_byte_record(&mut record) {
            Ok(true) if is_blank(&record) => {}
            Ok(true) => break,
            _ => {
                let expected = "a header line and one line a run";
                return Err(vec![whole_file("the file is blank", expected)]);
            }
        }
    }
    let line = Lines::of(text).line(&record);
    let names: Vec<String> = record.iter().map(|cell| cell_text(cell).trim().to_owned()).collect();
    if let [only] = names.as_slice() {
        if let Some(separator) = [';', '\t', '|'].into_iter().find(|c| only.contains(*c)) {
            return Err(vec![Problem {
                line: Some(line),
                place: "header".to_owned(),
                found: Some(format!("columns separated by `{}`", separator.escape_default())),
                expected: "expected commas between columns and a decimal point in numbers".to_owned(),
            }]);
        }
    }
    Ok(Header { names, line })
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(text.as_bytes())
}

/// A line of blanks only, which is no row.
fn is_blank(record: &ByteRecord) -> bool {
    record.len() == 1 && record[0].is_empty()
}

fn cell_text(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell).into_owned()
}

/// Reads every row below the header.
pub(super) fn read(text: &str, plan: &Plan, scene: &Scene) -> Result<Collected, Vec<Problem>> {
    let mut reader = reader(text);
    let mut record = ByteRecord::new();
    let mut refusals = Refusals::new(plan);
    let mut lines = Lines::of(text);
    let has_film_ratio = plan.place(Column::FilmRatio).is_some();
    let mut against = Against::new(scene, has_film_ratio);
    let mut collected = Collected::with_capacity(0, has_film_ratio, &plan.unknown);
    let mut is_header = true;
    loop {
        match reader.read_byte_record(&mut record) {
            Ok(true) if is_blank(&record) => continue,
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                refusals.other(whole_file("the table cannot be read", &error.to_string()));
                break;
            }
        }
        if std::mem::take(&mut is_header) {
            continue;
        }
        let Parsed { row, mut bad } = match row_of(&record, plan) {
            Ok(parsed) => parsed,
            Err(problem) => {
                let line = Some(lines.line(&record));
                refusals.other(Problem { line, ..problem });
                continue;
            }
        };
        if let Some(row) = check(&row, &mut against, &mut bad) {
            collected.push(&row, has_film_ratio, scene);
        }
        for bad in bad {
            refusals.cell(At::Line(lines.line(&record)), bad, |column| {
                let cell = record.get(plan.place(column)?.index)?;
                let cell = cell_text(cell);
                let cell = cell.trim();
                (!cell.is_empty()).then(|| quoted(cell))
            });
        }
    }
    refusals.or(collected)
}

/// Counts lines up to records that come in the order of the file.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        Lines {
            bytes: text.as_bytes(),
            at: 0,
            line: 1,
        }
    }

    /// The line a record starts on; the reader's own position stands before any blank lines it skipped.
    fn line(&mut self, record: &ByteRecord) -> u64 {
        let from = record.position().map_or(0, |position| position.byte());
        let from = usize::try_from(from).unwrap_or(0).max(self.at);
        let rest = self.bytes.get(from..).unwrap_or_default();
        let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let passed = self.bytes.get(self.at..).unwrap_or_default();
        self.line += line_of(passed, from + blanks - self.at) - 1;
        self.at = from + blanks;
        self.line
    }
}

struct Parsed<'a> {
    row: RawRow<'a>,
    bad: Vec<BadCell>,
}

/// The cells of a record as numbers and names. Fails on a wrong number of cells.
fn row_of<'a>(record: &'a ByteRecord, plan: &Plan) -> Result<Parsed<'a>, Problem> {
    if record.len() != plan.width {
        let mut expected = format!("expected {} as in the header", plan.width);
        if record.iter().any(|cell| cell.contains(&b'\n')) {
            expected.push_str("; a cell goes on over the end of the line: is a quote not closed?");
        } else if record.len() > plan.width {
            expected.push_str("; a number takes a decimal point, not a comma");
        }
        let noun = if record.len() == 1 { "cell" } else { "cells" };
        return Err(Problem {
            line: None,
            place: "row".to_owned(),
            found: Some(format!("{} {noun}", record.len())),
            expected,
        });
    }
    // as spreadsheets write below a table
    if record.iter().all(<[u8]>::is_empty) {
        return Err(Problem {
            line: None,
            place: "row".to_owned(),
            found: Some("empty cells only".to_owned()),
            expected: "expected a run, or no line at all".to_owned(),
        });
    }
    let cell = |column: Column| {
        let place = plan.place(column)?;
        // the whole file was checked to be UTF-8
        let text = std::str::from_utf8(record.get(place.index)?).ok()?;
        // blanks of any kind, as the typed reader takes them
        let text = text.trim();
        (!is_missing(text)).then_some((text, place))
    };
    let mut row = RawRow {
        particle: cell(Column::Particle).map(|(text, _)| text),
        liquid: cell(Column::Liquid).map(|(text, _)| text),
        ..RawRow::default()
    };
    let mut bad = vec![];
    for column in Column::NUMBERS {
        // the film of a dry run is not read at all
        if row.is_dry() && matches!(column, Column::Film | Column::FilmRatio) {
            continue;
        }
        let Some((text, place)) = cell(column) else {
            continue;
        };
        match number(text) {
            Ok(value) => row.set(column, Some(place.to_si(value))),
            Err(expected) => bad.push(BadCell { column, expected }),
        }
    }
    Ok(Parsed { row, bad })
}
