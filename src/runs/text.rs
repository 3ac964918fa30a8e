//! Reads runs from CSV as text: accepts what a typed reader refuses, or names the bad cell by line and column.

use csv::{ByteRecord, ReaderBuilder, Trim};

use super::collect::Collected;
use super::columns::{Column, Plan};
use super::row::{check, BadCell, Names, RawRow};
use super::whole_file;
use crate::error::Problem;
use crate::scene::Scene;

/// A cell that is missing.
pub(super) fn is_missing(cell: &str) -> bool {
    cell.is_empty() || cell == "NA"
}

/// The file as text without its byte-order mark, or why it is none.
pub(super) fn decode(bytes: &[u8]) -> Result<&str, Vec<Problem>> {
    if memchr::memchr(0, bytes).is_some() {
        return Err(vec![whole_file("the file is binary", "comma-separated text")]);
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        vec![Problem {
            line: Some(line_of(bytes, at)),
            place: "not valid UTF-8".to_owned(),
            found: bytes.get(at).map(|byte| format!("byte 0x{byte:02X}")),
            expected: "expected a text file saved as UTF-8".to_owned(),
        }]
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

fn line_of(bytes: &[u8], at: usize) -> u64 {
    1 + memchr::memchr_iter(b'\n', bytes.get(..at).unwrap_or(bytes)).count() as u64
}

/// The names in the first line that is not blank.
pub(super) fn header(text: &str) -> Result<Vec<String>, Vec<Problem>> {
    let mut record = ByteRecord::new();
    let read = reader(text).read_byte_record(&mut record);
    if !matches!(read, Ok(true)) {
        return Err(vec![whole_file(
            "the file is blank",
            "a header line and one line a run",
        )]);
    }
    let names: Vec<String> = record.iter().map(cell_text).collect();
    if let [only] = names.as_slice() {
        if let Some(separator) = [';', '\t', '|'].into_iter().find(|c| only.contains(*c)) {
            return Err(vec![Problem {
                line: Some(1),
                place: "header".to_owned(),
                found: Some(format!("columns separated by `{}`", separator.escape_default())),
                expected: "expected commas between columns and a point in numbers".to_owned(),
            }]);
        }
    }
    Ok(names)
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(text.as_bytes())
}

fn cell_text(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell).into_owned()
}

/// Reads every row below the header.
pub(super) fn read(text: &str, plan: &Plan, scene: &Scene) -> Result<Collected, Vec<Problem>> {
    let mut reader = reader(text);
    let mut record = ByteRecord::new();
    let mut problems: Vec<Problem> = vec![];
    let mut names = Names::new(scene);
    let has_film_ratio = plan.place(Column::FilmRatio).is_some();
    let mut collected = Collected::with_capacity(0, has_film_ratio, &plan.unknown);
    let mut is_header = true;
    loop {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                problems.push(whole_file("the table cannot be read", &error.to_string()));
                break;
            }
        }
        // a line of blanks only is no row
        if std::mem::take(&mut is_header) || record.len() == 1 && record[0].is_empty() {
            continue;
        }
        let bad = match row_of(&record, plan) {
            Ok(raw) => {
                let mut bad = raw.bad;
                let row = check(&raw.row, &mut names, &mut bad);
                if let Some(row) = row.filter(|_| bad.is_empty()) {
                    if has_film_ratio && row.liquid.is_some() && row.film_ratio.is_none() {
                        bad.push(BadCell {
                            column: Column::FilmRatio,
                            expected: MIXED_FILM_RATIO.to_owned(),
                        });
                    } else {
                        collected.push(&row, has_film_ratio, scene);
                    }
                }
                bad
            }
            Err(problem) => {
                let line = Some(record_line(text, &record));
                problems.push(Problem { line, ..problem });
                continue;
            }
        };
        problems.extend(bad.into_iter().map(|bad| {
            let cell = plan.place(bad.column).and_then(|place| record.get(place.index));
            Problem {
                line: Some(record_line(text, &record)),
                place: format!("column {}", plan.name(bad.column)),
                found: Some(match cell.map(cell_text) {
                    Some(cell) if !cell.is_empty() => format!("`{cell}`"),
                    _ => "an empty cell".to_owned(),
                }),
                expected: bad.expected,
            }
        }));
    }
    if problems.is_empty() {
        Ok(collected)
    } else {
        Err(problems)
    }
}

/// What a wet run without a film ratio is told when the file has that column.
pub(super) const MIXED_FILM_RATIO: &str =
    "expected the film ratio the run belongs to, as every wet run of a file with this column has";

/// The line a record starts on; the reader's own position stands before any blank lines it skipped.
fn record_line(text: &str, record: &ByteRecord) -> u64 {
    let bytes = text.as_bytes();
    let from = record.position().map_or(0, |position| position.byte());
    let from = usize::try_from(from).unwrap_or(0);
    let blanks = bytes
        .get(from..)
        .map_or(0, |rest| rest.iter().take_while(|b| b.is_ascii_whitespace()).count());
    line_of(bytes, from + blanks)
}

struct Parsed<'a> {
    row: RawRow<'a>,
    bad: Vec<BadCell>,
}

/// The cells of a record as numbers and names. Fails on a wrong number of cells.
fn row_of<'a>(record: &'a ByteRecord, plan: &Plan) -> Result<Parsed<'a>, Problem> {
    if record.len() != plan.width {
        let mut expected = format!("expected {} as in the header", plan.width);
        if record.len() > plan.width {
            expected.push_str("; a number takes a decimal point, not a comma");
        }
        return Err(Problem {
            line: None,
            place: "row".to_owned(),
            found: Some(format!("{} cells", record.len())),
            expected,
        });
    }
    let cell = |column: Column| {
        let place = plan.place(column)?;
        // the whole file was checked to be UTF-8
        let text = std::str::from_utf8(record.get(place.index)?).ok()?;
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
        match text.parse::<f64>() {
            Ok(value) => row.set(column, Some(place.to_si(value))),
            Err(_) => {
                let comma = text.replacen(',', ".", 1).parse::<f64>().is_ok();
                let hint = if comma { " with a decimal point" } else { "" };
                bad.push(BadCell {
                    column,
                    expected: format!("expected a number{hint}"),
                });
                // a stand-in that no further check complains about
                row.set(column, stand_in(column));
            }
        }
    }
    Ok(Parsed { row, bad })
}

fn stand_in(column: Column) -> Option<f64> {
    match column {
        Column::Diameter | Column::ImpactSpeed => Some(1.0),
        Column::Film => Some(f64::MIN_POSITIVE),
        Column::Restitution | Column::ReboundSpeed => Some(0.0),
        _ => None,
    }
}
