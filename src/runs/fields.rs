//! Reads a table whose columns are not those of runs: its rows as texts, and their cells by the columns that it may have,
//! whatever their units.

use super::columns::{present, ColumnPlace};
use super::csv::other_width;
use super::decimals::Decimals;
use super::refusals::{whole_file, CellPlace};
use super::source::TableSource;
use super::workbook::{Workbook, NONE_HIDDEN};
use crate::error::{quoted, unless_wrong, Error, Problem};
use crate::scene::{closest, letters_apart, name_is_allowed, Naming, TableFile, DRY, NAME_RULE};
use crate::units::{names_in_words, Dimension, Unit, MAGNITUDES, MAGNITUDE_EXPECTED};

/// A row of a table that is not blank.
#[derive(Debug, Clone)]
pub(crate) struct TextRow {
    /// its line or row, from 1
    pub line: u64,
    /// as they stand there; those of a header without blanks around them
    pub cells: Vec<String>,
    /// whether it is of a sheet, where a row ends with its last cell that is not empty
    pub is_of_sheet: bool,
}

/// The header of a CSV, or of a sheet of a workbook, and every row below it in order.
pub(crate) fn text_rows(file: &TableFile) -> Result<(TextRow, Vec<TextRow>), Error> {
    let path = file.path.as_path();
    let naming = Naming::default();
    let refused = |problems: Vec<Problem>| Error::input(&file.shown(), problems);
    let is_of_sheet = file.ends_with(TableFile::WORKBOOK);
    let row = |line, cells| TextRow {
        line,
        cells,
        is_of_sheet,
    };
    let mut source = TableSource::open(path)?;
    if file.ends_with(".parquet") {
        return Err(refused(vec![whole_file("a Parquet table", "a CSV or a workbook")]));
    }
    let mut rows = vec![];
    if is_of_sheet {
        let bytes = source.workbook(path)?;
        let mut book = Workbook::open(&bytes).map_err(refused)?;
        if file.sheet.is_none() {
            book.refuse_several_sheets().map_err(refused)?;
        }
        let mut sheet = book.sheet(file.sheet.as_deref()).map_err(refused)?;
        let header = sheet.names(&naming).map_err(refused)?;
        sheet.refuse_hidden_columns(&header).map_err(refused)?;
        let header = row(header.line.unwrap_or(1), header.names);
        while let Some(found) = sheet.next_row().map_err(refused)? {
            rows.push(row(found.number, found.texts(found.width())));
        }
        sheet.refuse_hidden_rows(NONE_HIDDEN).map_err(refused)?;
        return Ok((header, rows));
    }
    let mut table = source.csv(path, &naming)?;
    let header = table.names(None).map_err(refused)?;
    let header = row(header.line.unwrap_or(1), header.names);
    while let Some(record) = table.next_record().map_err(refused)? {
        if !record.is_empty() {
            rows.push(row(record.line, record.texts()));
        }
    }
    Ok((header, rows))
}

/// A column that a table may have.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    /// its name, without a unit
    pub base: &'static str,
    /// `One` of words and plain numbers
    pub dimension: Dimension,
    pub needed: bool,
}

/// A column of such a table.
pub(crate) const fn column(base: &'static str, dimension: Dimension, needed: bool) -> Column {
    Column {
        base,
        dimension,
        needed,
    }
}

impl Column {
    /// The unit of a name that is this column's.
    pub fn unit_of(&self, name: &str) -> Option<&'static Unit> {
        self.dimension.unit(name.strip_prefix(self.base)?)
    }
}

/// A row: its line from 1, and its cells.
pub(crate) type Row<'r> = (u64, &'r [&'r str]);

/// The columns of a table, each called by its name without a unit, and what is wrong with its cells.
pub(crate) struct Fields {
    wanted: &'static [Column],
    /// where each of them stands
    columns: Vec<Option<ColumnPlace>>,
    /// names that nobody reads
    unread: Vec<String>,
    decimals: Decimals<&'static str>,
    /// cells of the header
    width: usize,
    problems: Vec<Problem>,
}

/// Reads every row of a table by the columns that it may have; what `read` gives of a row with a problem is left out.
///
/// Fails where the table cannot be opened, or a column is missing, stands twice or is misspelt.
pub(crate) fn rows_by_fields<T>(
    file: &TableFile,
    wanted: &'static [Column],
    mut read: impl FnMut(&mut Fields, Row) -> Option<T>,
) -> Result<(Fields, Vec<T>), Error> {
    let (header, rows) = text_rows(file)?;
    let found = Fields::of(wanted, &header.cells, header.line);
    let mut fields = found.map_err(|problems| Error::input(&file.shown(), problems))?;
    let mut all = vec![];
    for row in &rows {
        if let Some(cells) = fields.cells(row, false) {
            let before = fields.problems.len();
            let read = read(&mut fields, (row.line, &cells));
            all.extend(read.filter(|_| fields.problems.len() == before));
        }
    }
    Ok((fields, all))
}

/// What a sphere falls on, as a row gives it; lengths in m.
#[derive(Debug)]
pub(crate) struct RowOfSetting<'c> {
    /// name of the particle
    pub particle: &'c str,
    /// name of the liquid; `None` of a dry plate
    pub liquid: Option<&'c str>,
    /// D; `None` where it was refused
    pub diameter: Option<f64>,
    /// δ; `None` of a dry plate, and where it was refused
    pub film: Option<f64>,
}

/// Letters by which the name of a column may differ from a known one and be it misspelt.
const MISSPELT: usize = 2;

impl Fields {
    /// Finds the columns in a header. Fails where one is missing, stands twice or is misspelt.
    pub fn of(wanted: &'static [Column], names: &[String], line: u64) -> Result<Fields, Vec<Problem>> {
        let mut columns: Vec<Option<ColumnPlace>> = vec![None; wanted.len()];
        let (mut unread, mut problems) = (vec![], vec![]);
        let problem = |expected: String| Problem::new("header", expected).on(line);
        let known = || {
            let units_of = |column: &Column| column.dimension.units().iter();
            let named = |column: &Column, unit: &Unit| format!("{}{}", column.base, unit.suffix);
            wanted
                .iter()
                .flat_map(move |column| units_of(column).map(move |unit| named(column, unit)))
        };
        for (index, name) in names.iter().enumerate() {
            let mut places = wanted.iter().zip(&mut columns);
            let named = places.find_map(|(column, place)| Some((column.unit_of(name)?, place)));
            match named {
                Some((unit, place @ None)) => {
                    let name = name.clone();
                    *place = Some(ColumnPlace { index, name, unit });
                }
                Some((_, Some(before))) => {
                    let expected = format!("expected one column for it; {} is there already", quoted(&before.name));
                    problems.push(problem(expected).found(quoted(name)));
                }
                None => match known().find(|known| letters_apart(name, known, MISSPELT).is_some()) {
                    Some(near) if near.len() > 2 * MISSPELT => {
                        problems.push(problem(format!("expected `{near}`")).found(quoted(name)));
                    }
                    _ if name.is_empty() => {}
                    _ => unread.push(quoted(name)),
                },
            }
        }
        for (column, _) in wanted.iter().zip(&columns).filter(|(_, place)| place.is_none()) {
            if column.needed {
                let names = names_in_words(column.base, column.dimension);
                let near = closest(column.base, unread.iter().map(|name: &String| name.trim_matches('`')));
                let hint = near.map_or(String::new(), |near| format!("; {} may be it", quoted(near)));
                problems.push(problem(format!("expected a column {names}{hint}")));
            }
        }
        let fields = Fields {
            wanted,
            columns,
            unread,
            decimals: Decimals::new(),
            width: names.len(),
            problems: vec![],
        };
        unless_wrong(problems, fields)
    }

    /// As many cells of a row as the header has; `None`, and a problem, of one that has others. Where words follow numbers, a
    /// row that goes on with empty cells may as well be shifted by a decimal comma; else it `may_end_blank`.
    pub fn cells<'r>(&mut self, row: &'r TextRow, may_end_blank: bool) -> Option<Vec<&'r str>> {
        let (found, width) = (row.cells.len(), self.width);
        let ends_blank = || row.cells.iter().skip(width).all(|cell| cell.trim().is_empty());
        let fits = match row.is_of_sheet {
            true => found <= width,
            false => found == width || found > width && may_end_blank && ends_blank(),
        };
        if !fits {
            let problem = other_width(row.line, &row.cells, width, !row.is_of_sheet);
            self.problems.push(problem);
            return None;
        }
        let mut cells: Vec<&str> = row.cells.iter().map(String::as_str).collect();
        cells.resize(width, "");
        Some(cells)
    }

    /// Whether the table has a column.
    pub fn has(&self, field: &str) -> bool {
        self.column(field).is_some()
    }

    fn column(&self, field: &str) -> Option<&ColumnPlace> {
        let at = self.wanted.iter().position(|column| column.base == field)?;
        self.columns.get(at)?.as_ref()
    }

    /// The cells of a row in the columns that were found.
    pub fn read_cells<'c>(&self, cells: &'c [&'c str]) -> impl Iterator<Item = &'c str> + use<'_, 'c> {
        let columns = self.columns.iter().flatten();
        columns.filter_map(|column| cells.get(column.index).copied())
    }

    /// Adds what is wrong with a cell, or with a line for want of one.
    pub fn problem(&mut self, line: u64, place: &str, found: Option<&str>, expected: String) {
        let problem = Problem::new(place, expected).on(line);
        self.problems.push(problem.found(found.map(quoted)));
    }

    /// A word; `None` where it is missing.
    pub fn word<'c>(&self, field: &str, cells: &[&'c str]) -> Option<&'c str> {
        present(cells.get(self.column(field)?.index)?)
    }

    /// A number in SI; `None` where it is missing, and a problem where it is none that `check` takes in its unit.
    pub fn checked_number(
        &mut self,
        field: &'static str,
        (line, cells): Row,
        check: impl Fn(f64, &Unit) -> Result<f64, String>,
    ) -> Option<f64> {
        let ColumnPlace { index, name, unit } = self.column(field)?.clone();
        let text = present(cells.get(index)?)?;
        let number = self.decimals.read(text, field, CellPlace::Line(line));
        let finite = number.and_then(|number| {
            let is_finite = number.is_finite();
            is_finite.then_some(number).ok_or("expected a finite number".to_owned())
        });
        let checked = finite.and_then(|number| check(number, unit));
        checked
            .map_err(|expected| self.problem(line, &name, Some(text), expected))
            .ok()
    }

    /// A number above zero in SI; `None` where it is missing, and a problem where it is none.
    pub fn number(&mut self, field: &'static str, row: Row) -> Option<f64> {
        self.checked_number(field, row, |number, unit| {
            let value = unit.to_si(number);
            if number <= 0.0 {
                Err("expected a number above 0".to_owned())
            } else if MAGNITUDES.contains(&value) {
                Ok(value)
            } else {
                Err(format!("expected {MAGNITUDE_EXPECTED}"))
            }
        })
    }

    /// A number that must be there; a problem where it is not, `why` following what was expected.
    fn needed_number(&mut self, field: &'static str, row: Row, why: &str) -> Option<f64> {
        let before = self.problems.len();
        let number = self.number(field, row);
        if number.is_none() && self.problems.len() == before {
            self.problem(row.0, field, None, format!("expected a number above 0{why}"));
        }
        number
    }

    /// The name of a particle or a liquid; a problem where it may not be one.
    fn name<'c>(&mut self, field: &str, (line, cells): (u64, &[&'c str])) -> Option<&'c str> {
        let name = self.word(field, cells)?;
        if !name_is_allowed(name) {
            self.problem(line, field, Some(name), format!("expected {NAME_RULE}"));
        }
        Some(name)
    }

    /// Particle, liquid, diameter and film; the film of a dry plate is not read. `None`, and a problem, without a particle.
    pub fn setting<'c>(&mut self, (line, cells): (u64, &'c [&'c str])) -> Option<RowOfSetting<'c>> {
        let row = (line, cells);
        let Some(particle) = self.name("particle", row) else {
            self.problem(line, "particle", None, format!("expected {NAME_RULE}"));
            return None;
        };
        let named = self.name("liquid", row);
        let has_film = self
            .word("film", cells)
            .is_some_and(|film| film.replace(',', ".").parse() != Ok(0.0));
        if named.is_none() && has_film {
            let expected = format!("expected the name of a liquid, or `{DRY}`, beside a film");
            self.problem(line, "liquid", None, expected);
        }
        let liquid = named.filter(|liquid| !liquid.eq_ignore_ascii_case(DRY));
        let diameter = self.needed_number("diameter", row, "");
        let film = liquid.and_then(|_| self.needed_number("film", row, ", since there is a liquid"));
        Some(RowOfSetting {
            particle,
            liquid,
            diameter,
            film,
        })
    }

    /// All that was wrong, and the columns that nobody reads. A number with a comma is wrong where none of all commas tells
    /// what they set off.
    pub fn finish(mut self) -> (Vec<Problem>, Vec<String>) {
        if let Some((at, field, text, expected)) = self.decimals.doubt() {
            let place = self.column(field).map_or(String::new(), |column| column.name.clone());
            self.problem(at.number(), &place, Some(&text), expected);
        }
        (self.problems, self.unread)
    }
}
