//! Reads a sheet of a spreadsheet with calamine. The only file that names it.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::Cursor;

use calamine::{DataRef, Dimensions, Reader, SheetType, SheetVisible, Xlsx, XlsxCellReader};
use zip::result::ZipError;

use super::checked_rows::{Cell, CheckedRows};
use super::collect::{rows_in_words, Collected, SheetRead};
use super::columns::{unnamed_column, ColumnPlace, TableHeader, TableLayout, MOST_ABOVE};
use super::decimals::parse_number;
use super::headers::units::is_row_of_units;
use super::hidden_rows::{hidden_in, Hidden};
use super::raw_row::REBOUNDS;
use super::refusals::{readable, whole_file, CellPlace};
use crate::error::{quoted, unless_wrong, Problem, Problems};
use crate::files::{MOST_COLUMNS, MOST_UNPACKED};
use crate::scene::{closest, HiddenRows, Naming, Scene};

/// A row that is not empty.
#[derive(Default)]
pub(super) struct SheetRow {
    /// from 1, as a spreadsheet counts
    pub number: u64,
    /// those that are not empty, by their columns: one far out costs no more than one beside the others
    pub(super) cells: BTreeMap<usize, Cell<String>>,
    /// columns of those of them that are merged with cells above, each with the number of the first row of its cell
    merged: BTreeMap<usize, u64>,
    /// what their formats show behind numbers: the `in` of `0.00 "in"`
    shown: BTreeMap<usize, String>,
}

impl SheetRow {
    /// The text of the cells of so many columns; nothing of an empty one.
    pub fn texts(&self, width: usize) -> Vec<String> {
        let mut texts = vec![String::new(); width];
        for (column, held) in self.cells.range(..width) {
            texts[*column] = held.borrowed().text().into_owned();
        }
        texts
    }

    /// The same without blanks around them.
    fn trimmed(&self, width: usize) -> Vec<String> {
        self.texts(width).iter().map(|text| text.trim().to_owned()).collect()
    }

    /// Columns up to the last that holds something.
    pub fn width(&self) -> usize {
        self.cells.last_key_value().map_or(0, |(column, _)| column + 1)
    }
}

/// Reads the runs of a sheet. Fails with every bad cell named by row and column, and where it hides rows and the scene does
/// not say what is meant by that.
pub(super) fn read_sheet(mut sheet: Sheet, scene: &Scene) -> Result<Collected, Problems> {
    let header = sheet.header(&scene.data.naming)?;
    let layout = TableLayout::new(&header, &scene.data.naming)?;
    let mut checked = CheckedRows::new(&layout, scene, None);
    let mut unnamed = BTreeSet::new();
    let rebounds: Vec<&ColumnPlace> = REBOUNDS.into_iter().filter_map(|column| layout.place(column)).collect();
    let mut last_run = 0;
    let mut of_other_units = BTreeSet::new();
    while let Some(row) = sheet.next_row()? {
        unnamed.extend(row.cells.range(layout.width..).map(|(column, _)| *column));
        let texts = row.texts(layout.width);
        let is_own = |(column, text): (usize, &String)| !text.is_empty() && !row.merged.contains_key(&column);
        if !texts.iter().enumerate().any(is_own) {
            // a note beside the table
            continue;
        }
        let in_order = texts.iter().map(String::as_str);
        let screened = checked.collected.screened;
        let is_run = checked.add(CellPlace::Row(row.number), in_order, |place| {
            row.cells.get(&place.index).map(Cell::borrowed)
        });
        if !is_run {
            continue;
        }
        for (index, shown) in &row.shown {
            let other = layout.other_unit_shown(*index, shown);
            if let Some((name, expected)) = other.filter(|_| of_other_units.insert(*index)) {
                let place = format!("row {}, column {name}", row.number);
                checked.problems.push(Problem::new(place, expected));
            }
        }
        // a run that the scene leaves out has no part in the cell
        if checked.collected.screened == screened {
            let is_of_run_above = |first: &u64| *first <= last_run;
            let again = rebounds
                .iter()
                .filter(|place| row.merged.get(&place.index).is_some_and(is_of_run_above));
            again
                .filter_map(|place| rebound_again(&row, place))
                .for_each(|problem| checked.problems.push(problem));
            last_run = row.number;
        }
    }
    if let Err(problems) = sheet.refuse_hidden_rows(HIDDEN_ROWS_EXPECTED) {
        checked.problems.extend(problems.into());
    }
    let own = layout
        .columns_read()
        .filter(|(_, place)| sheet.hides_column(place.index));
    sheet.read.hidden_columns = own.map(|(_, place)| quoted(&place.name)).collect();
    checked.collected.sheet = Some(sheet.read);
    let unnamed = unnamed.into_iter().map(unnamed_column);
    checked.collected.remarks.unknown.extend(unnamed);
    checked.finish()
}

/// Refuses a rebound in a cell that is merged with that of a run above it: one rebound is no measurement of several runs, but
/// all of them may have stuck.
fn rebound_again(row: &SheetRow, place: &ColumnPlace) -> Option<Problem> {
    let text = row.cells.get(&place.index)?.borrowed().text();
    let is_above_zero = parse_number(&text).is_ok_and(|number| number.value > 0.0);
    let expected =
        "expected the rebound of this run alone, not one in a cell that is merged with the cell above; a mean of runs \
                    stands in one row, with their number in a column `runs`";
    let problem = || Problem::new(format!("row {}, column {}", row.number, place.name), expected);
    is_above_zero.then(|| problem().found(quoted(&text)))
}

/// What is expected of hidden rows where a scene can say what they are.
const HIDDEN_ROWS_EXPECTED: &str =
    "none, or in [data] `hidden_rows = \"leave\"` to leave them out or \"take\" to read them";

/// What is expected of hidden rows and columns where none can.
pub(super) const NONE_HIDDEN: &str = "none: show it, or delete it";

/// A workbook whose sheets can be read.
pub(super) struct Workbook<'b> {
    bytes: &'b [u8],
    book: Xlsx<Cursor<&'b [u8]>>,
}

impl<'b> Workbook<'b> {
    /// Opens the file with these bytes.
    pub fn open(bytes: &'b [u8]) -> Result<Workbook<'b>, Vec<Problem>> {
        check_unpacked(bytes)?;
        let book = workbook(|| Xlsx::new(Cursor::new(bytes)))?;
        Ok(Workbook { bytes, book })
    }

    /// Its sheets of cells, each with whether it is hidden.
    pub fn sheets(&self) -> Vec<(String, bool)> {
        let of_cells = |sheet: &&calamine::Sheet| sheet.typ == SheetType::WorkSheet;
        let sheets = self.book.sheets_metadata().iter().filter(of_cells);
        let each = sheets.map(|sheet| (sheet.name.clone(), sheet.visible != SheetVisible::Visible));
        each.collect()
    }

    /// Refuses a workbook of which more than one sheet has something in it, hidden or not.
    pub fn refuse_several_sheets(&mut self) -> Result<(), Vec<Problem>> {
        let mut names = vec![];
        for (name, _) in self.sheets() {
            if !self.sheet(Some(&name))?.peek(1)?.is_empty() {
                names.push(quoted(&name));
            }
        }
        if names.len() < 2 {
            return Ok(());
        }
        let found = format!("the workbook has {} sheets", names.len());
        names.truncate(MOST_NAMED);
        let expected = format!("the one to read, as \"book.xlsx#May\", of {}", names.join(", "));
        Err(vec![whole_file(&found, &expected)])
    }

    /// The sheet that is named, or the first that is not hidden.
    pub fn sheet(&mut self, wanted: Option<&str>) -> Result<Sheet<'_, 'b>, Vec<Problem>> {
        let mut sheets = self.sheets();
        let at = sheet_named(&sheets, wanted)?;
        let (name, is_hidden) = sheets.remove(at);
        let hidden = hidden_in(self.bytes, &name)?;
        let (book, sheet) = (&mut self.book, name.as_str());
        let merged = workbook(|| book.merge_cells_by_sheet_name(sheet))?;
        let cells = workbook(move || book.worksheet_cells_reader(sheet))?;
        let formats = cells.styles().iter().map(|style| style.number_format.as_ref());
        let shown = formats.map(|format| format.map_or(String::new(), |format| shown_behind(&format.format_code)));
        Ok(Sheet {
            read: SheetRead {
                name,
                is_hidden,
                others: sheets,
                ..SheetRead::default()
            },
            shown: shown.collect(),
            cells,
            ahead: VecDeque::new(),
            at_end: false,
            merged: MergedCells::new(merged),
            hidden,
            hidden_rows: None,
        })
    }
}

/// A sheet, read row by row; what the formulas gave stands for them.
pub(super) struct Sheet<'s, 'b> {
    pub read: SheetRead,
    cells: XlsxCellReader<'s, Cursor<&'b [u8]>>,
    /// what the format of each style shows behind a number
    shown: Vec<String>,
    /// rows that were read and not given yet; before the end more cells may follow in the last
    ahead: VecDeque<SheetRow>,
    at_end: bool,
    merged: MergedCells,
    hidden: Hidden,
    /// what is done with hidden rows
    hidden_rows: Option<HiddenRows>,
}

impl Sheet<'_, '_> {
    pub fn name(&self) -> &str {
        &self.read.name
    }

    /// Reads the header: the names, and a row of units below them where there is one.
    pub fn header(&mut self, naming: &Naming) -> Result<TableHeader, Vec<Problem>> {
        let mut header = self.names(naming)?;
        let width = header.names.len();
        self.fill(1)?;
        let below = self.ahead.front().filter(|row| row.width() <= width);
        let units = below.map(|row| row.trimmed(width));
        let units = units.filter(|units| is_row_of_units(units.iter().map(String::as_str)));
        if let Some(units) = units {
            self.ahead.pop_front();
            header.units = units;
        }
        Ok(header)
    }

    /// Reads the names, in the row that the scene says or the first that is not empty, and the units above them.
    pub fn names(&mut self, naming: &Naming) -> Result<TableHeader, Vec<Problem>> {
        self.hidden_rows = naming.hidden_rows;
        let expected = "a row of column names and one row a run";
        let first = naming.header_row.unwrap_or(1);
        let mut above: Vec<Vec<String>> = vec![];
        let names = loop {
            self.fill(1)?;
            match self.ahead.pop_front() {
                Some(row) if row.number < first => {
                    above.truncate(MOST_ABOVE);
                    above.push(row.trimmed(row.width()));
                }
                Some(row) if naming.header_row.is_none_or(|wanted| wanted == row.number) => break row,
                Some(_) => {
                    let found = format!("row {first} is empty");
                    let expected = "the names of columns where `header_row` says";
                    return Err(vec![in_sheet(self.name(), &found, expected)]);
                }
                None => {
                    let header_row = naming.header_row;
                    let found = header_row.map_or("it is empty".to_owned(), |row| format!("there is no row {row}"));
                    return Err(vec![in_sheet(self.name(), &found, expected)]);
                }
            }
        };
        Ok(TableHeader {
            line: Some(names.number),
            sheet: Some(self.read.name.clone()),
            ..TableHeader::of(&above, names.trimmed(names.width()))
        })
    }

    /// The next row below the header that is not empty, with what cells hold that are merged with those above them; a hidden
    /// one only where the scene takes these.
    pub fn next_row(&mut self) -> Result<Option<SheetRow>, Vec<Problem>> {
        loop {
            self.fill(1)?;
            let Some(mut row) = self.ahead.pop_front() else {
                return Ok(None);
            };
            self.merged.fill(&mut row);
            if self.hidden.rows.binary_search(&row.number).is_err() {
                return Ok(Some(row));
            }
            self.read.hidden_rows.push(row.number);
            if self.hidden_rows == Some(HiddenRows::Take) {
                self.read.are_taken = true;
                return Ok(Some(row));
            }
        }
    }

    /// Whether a column, counted from 0, is hidden.
    pub fn hides_column(&self, index: usize) -> bool {
        self.hidden.columns.iter().any(|columns| columns.contains(&(index + 1)))
    }

    /// Refuses hidden rows where nothing says what is to be done with them.
    pub fn refuse_hidden_rows(&self, expected: &str) -> Result<(), Vec<Problem>> {
        if self.hidden_rows.is_some() || self.read.hidden_rows.is_empty() {
            return Ok(());
        }
        let found = format!("hidden {}", rows_in_words(&self.read.hidden_rows));
        Err(vec![in_sheet(self.name(), &found, expected)])
    }

    /// Refuses a hidden column with a name, for tables that no scene can speak of.
    pub fn refuse_hidden_columns(&self, header: &TableHeader) -> Result<(), Vec<Problem>> {
        let named = header.names.iter().enumerate().filter(|(_, name)| !name.is_empty());
        let hidden = named.filter(|(index, _)| self.hides_column(*index));
        let problems =
            hidden.map(|(_, name)| in_sheet(self.name(), &format!("hidden column {}", quoted(name)), NONE_HIDDEN));
        unless_wrong(problems.collect(), ())
    }

    /// The texts of the next rows, at most so many, which are still to be read; with their numbers.
    pub fn peek(&mut self, rows: usize) -> Result<Vec<(u64, Vec<String>)>, Vec<Problem>> {
        self.fill(rows)?;
        let texts = |row: &SheetRow| (row.number, row.texts(row.width()));
        Ok(self.ahead.iter().take(rows).map(texts).collect())
    }

    /// Reads on until so many rows are there in full, or the sheet ends.
    fn fill(&mut self, rows: usize) -> Result<(), Vec<Problem>> {
        /// cells that are read in one step
        const AT_ONCE: usize = 1 << 14;
        while self.ahead.len() <= rows && !self.at_end {
            let Sheet {
                cells, shown, ahead, ..
            } = self;
            self.at_end = workbook(|| {
                for _ in 0..AT_ONCE {
                    let cell = cells.next_cell_with_style_id().map_err(|error| error.to_string())?;
                    let Some((cell, style)) = cell else {
                        return Ok(true);
                    };
                    let shown = shown.get(style).map_or("", String::as_str);
                    let (row, column) = cell.get_position();
                    let (number, column) = (u64::from(row) + 1, column as usize);
                    let Some(held) = held(cell.get_value(), shown) else {
                        continue;
                    };
                    if column >= MOST_COLUMNS {
                        let found = format!("a row of {} columns", column + 1);
                        return Err(format!("{found}, expected at most {MOST_COLUMNS}"));
                    }
                    if ahead.back().is_some_and(|last| last.number > number) {
                        return Err("its rows are not in order".to_owned());
                    }
                    if ahead.back().is_none_or(|last| last.number < number) {
                        ahead.push_back(SheetRow {
                            number,
                            ..SheetRow::default()
                        });
                    }
                    if let Some(row) = ahead.back_mut() {
                        if !shown.is_empty() && matches!(held, Cell::Number(_)) {
                            row.shown.insert(column, shown.to_owned());
                        }
                        row.cells.insert(column, held);
                    }
                }
                Ok(false)
            })?;
        }
        Ok(())
    }
}

/// Cells of the runs that reach over several rows, of which the first alone is stored with what they hold.
struct MergedCells {
    /// those not come to, the next one last
    below: Vec<Dimensions>,
    /// of each column the last that was begun, and what it holds
    begun: BTreeMap<usize, (Dimensions, Cell<String>)>,
}

impl MergedCells {
    fn new(mut all: Vec<Dimensions>) -> MergedCells {
        all.retain(|cells| cells.end.0 > cells.start.0);
        all.sort_unstable_by_key(|cells| Reverse(cells.start));
        MergedCells {
            below: all,
            begun: BTreeMap::new(),
        }
    }

    /// Gives a row what cells hold that began above it; rows come from the top.
    fn fill(&mut self, row: &mut SheetRow) {
        let index = row.number - 1;
        self.begun.retain(|_, (cells, _)| u64::from(cells.end.0) >= index);
        for (column, (cells, held)) in &self.begun {
            if !row.cells.contains_key(column) {
                row.cells.insert(*column, held.clone());
                row.merged.insert(*column, u64::from(cells.start.0) + 1);
            }
        }
        while let Some(cells) = self.below.pop_if(|cells| u64::from(cells.start.0) <= index) {
            let column = cells.start.1 as usize;
            let held = row.cells.get(&column).filter(|_| u64::from(cells.start.0) == index);
            let held = held.cloned();
            self.begun.extend(held.map(|held| (column, (cells, held))));
        }
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

/// Which sheet to read, by its place.
fn sheet_named(sheets: &[(String, bool)], wanted: Option<&str>) -> Result<usize, Vec<Problem>> {
    let some = || {
        let names: Vec<String> = sheets.iter().take(MOST_NAMED).map(|(sheet, _)| quoted(sheet)).collect();
        names.join(", ")
    };
    let Some(wanted) = wanted else {
        let first = sheets.iter().position(|(_, is_hidden)| !is_hidden);
        return first.ok_or_else(|| match sheets {
            [] => vec![whole_file("the workbook has no sheet", "a sheet with one row a run")],
            _ => {
                let expected = format!("the one to read, as \"book.xlsx#May\", of {}", some());
                vec![whole_file("all sheets are hidden", &expected)]
            }
        });
    };
    if let Some(sheet) = sheets.iter().position(|(sheet, _)| sheet == wanted) {
        return Ok(sheet);
    }
    let near = closest(wanted, sheets.iter().map(|(sheet, _)| sheet.as_str()));
    let expected = near.map_or_else(
        || format!("expected one of {}", some()),
        |near| format!("unknown sheet; did you mean {}?", quoted(near)),
    );
    Err(vec![Problem::new(format!("sheet {}", quoted(wanted)), expected)])
}

/// Sheets that a message names.
const MOST_NAMED: usize = 10;

fn in_sheet(sheet: &str, found: &str, expected: &str) -> Problem {
    whole_file(&format!("sheet {}", quoted(sheet)), expected).found(found.to_owned())
}

/// What a number format shows behind a number: a per cent sign that is only written there as `percent`, since it does not
/// multiply the number.
fn shown_behind(format: &str) -> String {
    let mut shown = String::new();
    let mut chars = format.chars();
    let written = |text: String| text.replace('%', "percent");
    while let Some(c) = chars.next() {
        match c {
            ';' => break,
            '"' => shown += &written(chars.by_ref().take_while(|c| *c != '"').collect()),
            '\\' => shown += &written(chars.next().into_iter().collect()),
            // a blank of some width, and one that fills the cell
            '_' | '*' => _ = chars.next(),
            // a colour, a condition or, behind a dollar sign, a currency and a language
            '[' => {
                let inside: String = chars.by_ref().take_while(|c| *c != ']').collect();
                let currency = inside.strip_prefix('$').and_then(|own| own.split('-').next());
                shown += currency.unwrap_or_default();
            }
            '0' | '#' | '?' | '@' => shown.clear(),
            c => shown.push(c),
        }
    }
    shown.trim().trim_start_matches("General").trim_start().to_owned()
}

/// What a cell holds, by what its format shows behind a number; `None` of an empty one.
fn held(cell: &DataRef, shown: &str) -> Option<Cell<String>> {
    let text = |text: &str| Cell::Text(text.to_owned());
    let number = |value| {
        if shown.contains('%') {
            Cell::Percent(value)
        } else {
            Cell::Number(value)
        }
    };
    let held = match cell {
        DataRef::Empty => return None,
        DataRef::Int(value) => number(*value as f64),
        DataRef::Float(value) => number(*value),
        DataRef::String(value) => text(value),
        DataRef::SharedString(value) => text(value),
        DataRef::Bool(value) => Cell::Other(value.to_string(), ""),
        DataRef::DateTime(value) => Cell::Other(format!("day {}", value.as_f64()), DATE),
        DataRef::DateTimeIso(value) | DataRef::DurationIso(value) => Cell::Other(value.clone(), DATE),
        DataRef::Error(error) => Cell::Other(error.to_string(), ": the formula failed"),
    };
    let is_blank = matches!(&held, Cell::Text(text) if text.trim().is_empty());
    (!is_blank).then_some(held)
}

/// What is amiss with a date.
const DATE: &str = ": the spreadsheet made a date of it";
