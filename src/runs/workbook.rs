//! Reads a sheet of a spreadsheet with calamine. The only file that names it.

use std::io::Cursor;

use calamine::{DataRef, Reader, Xlsx};
use zip::result::ZipError;

use super::checked_rows::{Cell, CheckedRows, Holds};
use super::collect::Collected;
use super::columns::TableLayout;
use super::csv::too_many_columns;
use super::refusals::{readable, whole_file, CellPlace, Refused};
use super::survey::Survey;
use crate::error::{quoted, Problem};
use crate::files::{MOST_COLUMNS, MOST_UNPACKED};
use crate::scene::{closest, Scene};

/// What a cell holds.
#[derive(Debug, Default, Clone, PartialEq)]
enum Held {
    #[default]
    Nothing,
    Number(f64),
    Text(String),
    /// what is neither, as a spreadsheet shows it, and what is amiss
    Other(String, &'static str),
}

/// A row that is not empty.
struct SheetRow {
    /// from 1, as a spreadsheet counts
    number: usize,
    cells: Vec<Held>,
}

/// Reads the runs of a sheet. Fails with every bad cell named by row and column.
pub(super) fn read_sheet(sheet: Sheet, scene: &Scene) -> Result<Collected, Refused> {
    let Sheet {
        header, names, rows, ..
    } = sheet;
    let layout = TableLayout::new(&names, Some(header as u64), &scene.data.naming)?;
    let mut checked = CheckedRows::new(&layout, scene);
    for SheetRow { number, cells } in rows {
        let texts: Vec<Option<String>> = cells.iter().map(Held::text).collect();
        let in_order = texts.iter().map(|text| text.as_deref().unwrap_or_default());
        checked.add(CellPlace::Row(number), in_order, |place| {
            let text = texts.get(place.index)?.as_deref()?;
            let holds = match &cells[place.index] {
                Held::Number(value) => Holds::Number(*value),
                Held::Other(_, why) => Holds::Neither(why),
                Held::Nothing | Held::Text(_) => Holds::Text,
            };
            Some(Cell { text, holds })
        });
    }
    checked.finish()
}

/// Reads a sheet for what stands in its columns.
pub(super) fn survey_sheet(sheet: Sheet) -> Survey {
    let mut survey = Survey::new(sheet.names);
    for row in sheet.rows {
        let texts: Vec<Option<String>> = row.cells.iter().map(Held::text).collect();
        survey.add(texts.iter().map(Option::as_deref));
    }
    survey
}

/// A sheet with a header; what the formulas gave stands for them.
pub(super) struct Sheet {
    pub name: String,
    /// the row of the header, from 1
    pub header: usize,
    pub names: Vec<String>,
    /// those below the header that are not empty
    rows: std::vec::IntoIter<SheetRow>,
}

impl Sheet {
    /// That of a workbook which is named, or the first.
    pub fn read(bytes: &[u8], sheet: Option<&str>) -> Result<Sheet, Vec<Problem>> {
        check_unpacked(bytes)?;
        let mut book: Xlsx<_> = workbook(|| Xlsx::new(Cursor::new(bytes)))?;
        let sheet = sheet_named(&book.sheet_names(), sheet)?;
        let mut rows = sheet_rows(&mut book, &sheet)?.into_iter();
        let expected = "a row of column names and one row a run";
        let header = rows
            .next()
            .ok_or_else(|| vec![in_sheet(&sheet, "it is empty", expected)])?;
        Ok(Sheet {
            header: header.number,
            names: header.cells.iter().map(Held::name).collect(),
            name: sheet,
            rows,
        })
    }
}

impl Sheet {
    /// Each row by its number, from 1, and the texts of its cells.
    pub fn texts(self) -> impl Iterator<Item = (usize, Vec<String>)> {
        let text = |held: &Held| held.text().unwrap_or_default();
        self.rows
            .map(move |row| (row.number, row.cells.iter().map(text).collect()))
    }
}

/// Does a step of reading a workbook.
fn workbook<T, E: std::fmt::Display>(step: impl FnOnce() -> Result<T, E>) -> Result<T, Vec<Problem>> {
    readable("workbook", step)
}

/// Refuses an archive whose directory says that it unpacks to more than a table of runs has.
fn check_unpacked(bytes: &[u8]) -> Result<(), Vec<Problem>> {
    let size = workbook(|| {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes))?;
        let mut files = 0..archive.len();
        files.try_fold(0u64, |sum, file| {
            Ok::<_, ZipError>(sum.saturating_add(archive.by_index_raw(file)?.size()))
        })
    })?;
    if size > MOST_UNPACKED {
        let expected = format!("at most {} MiB unpacked", MOST_UNPACKED >> 20);
        return Err(vec![whole_file("too large a workbook", &expected)]);
    }
    Ok(())
}

/// The sheet to read.
fn sheet_named(sheets: &[String], wanted: Option<&str>) -> Result<String, Vec<Problem>> {
    let Some(wanted) = wanted else {
        let none = || vec![whole_file("the workbook has no sheet", "a sheet with one row a run")];
        return sheets.first().cloned().ok_or_else(none);
    };
    if let Some(sheet) = sheets.iter().find(|sheet| *sheet == wanted) {
        return Ok(sheet.clone());
    }
    let near = closest(wanted, sheets.iter().map(String::as_str));
    let expected = near.map_or_else(
        || {
            let names: Vec<String> = sheets.iter().take(MOST_NAMED).map(|sheet| quoted(sheet)).collect();
            format!("expected one of {}", names.join(", "))
        },
        |near| format!("unknown sheet; did you mean {}?", quoted(near)),
    );
    Err(vec![Problem {
        line: None,
        place: format!("sheet {}", quoted(wanted)),
        found: None,
        expected,
    }])
}

/// Sheets that a message names.
const MOST_NAMED: usize = 10;

fn in_sheet(sheet: &str, found: &str, expected: &str) -> Problem {
    Problem {
        line: None,
        place: format!("sheet {}", quoted(sheet)),
        found: Some(found.to_owned()),
        expected: format!("expected {expected}"),
    }
}

/// The rows of a sheet that are not empty; a cell far out costs no more than one beside the others.
fn sheet_rows(book: &mut Xlsx<Cursor<&[u8]>>, sheet: &str) -> Result<Vec<SheetRow>, Vec<Problem>> {
    workbook(|| {
        let mut rows: Vec<SheetRow> = vec![];
        let mut cells = book.worksheet_cells_reader(sheet).map_err(|error| error.to_string())?;
        while let Some(cell) = cells.next_cell().map_err(|error| error.to_string())? {
            let (row, column) = cell.get_position();
            let (number, column) = (row as usize + 1, column as usize);
            let held = Held::of(cell.get_value());
            if held == Held::Nothing {
                continue;
            }
            if column >= MOST_COLUMNS {
                let too_many = too_many_columns(column + 1, None);
                return Err(format!(
                    "a row of {}, {}",
                    too_many.found.unwrap_or_default(),
                    too_many.expected
                ));
            }
            match rows.last() {
                Some(last) if last.number > number => return Err("its rows are not in order".to_owned()),
                Some(last) if last.number == number => {}
                _ => rows.push(SheetRow { number, cells: vec![] }),
            }
            if let Some(last) = rows.last_mut() {
                last.cells.resize(last.cells.len().max(column + 1), Held::Nothing);
                last.cells[column] = held;
            }
        }
        Ok(rows)
    })
}

impl Held {
    fn of(cell: &DataRef) -> Held {
        let text = |text: &str| match text.trim() {
            "" => Held::Nothing,
            _ => Held::Text(text.to_owned()),
        };
        match cell {
            DataRef::Empty => Held::Nothing,
            DataRef::Int(value) => Held::Number(*value as f64),
            DataRef::Float(value) => Held::Number(*value),
            DataRef::String(value) => text(value),
            DataRef::SharedString(value) => text(value),
            DataRef::Bool(value) => Held::Other(value.to_string(), ""),
            DataRef::DateTime(value) => Held::Other(format!("day {}", value.as_f64()), DATE),
            DataRef::DateTimeIso(value) | DataRef::DurationIso(value) => Held::Other(value.clone(), DATE),
            DataRef::Error(error) => Held::Other(error.to_string(), ": the formula failed"),
        }
    }

    /// A column's name.
    fn name(&self) -> String {
        self.text().map_or_else(String::new, |text| text.trim().to_owned())
    }

    fn text(&self) -> Option<String> {
        match self {
            Held::Nothing => None,
            Held::Number(value) => Some(value.to_string()),
            Held::Text(text) | Held::Other(text, _) => Some(text.clone()),
        }
    }
}

/// What is amiss with a date.
const DATE: &str = ": the spreadsheet made a date of it";
