//! Reads and writes Parquet with polars; with `parquet_footer.rs` the only file that names it.

use std::fs::File;
use std::io::Write;

use polars::prelude::*;

use super::checked_rows::{Cell, CheckedRows, TakeRuns};
use super::collect::{too_many_rows, Collected};
use super::columns::{ColumnPlace, TableHeader, TableLayout};
use super::csv::too_many_columns;
use super::new_run::NewRun;
use super::parquet_footer::{check_counts, check_footer};
use super::refusals::{readable, whole_file, CellPlace};
use super::survey::Survey;
use crate::error::{unless_wrong, Problem, Problems};
use crate::files::MOST_COLUMNS;
use crate::scene::{RunColumn, Scene, DRY};

/// A Parquet table whose footer could be read.
pub(super) struct ParquetTable<'f> {
    /// of which no more is read than the values that are asked for
    file: &'f File,
    schema: Arc<ArrowSchema>,
    /// how many rows it says it has
    pub rows: usize,
}

impl<'f> ParquetTable<'f> {
    pub fn open(file: &'f File) -> Result<ParquetTable<'f>, Vec<Problem>> {
        polars(|| {
            check_footer(file)?;
            let mut reader = ParquetReader::new(file.try_clone()?);
            let schema = reader.schema()?;
            let rows = reader.get_metadata()?.num_rows;
            Ok(ParquetTable { file, schema, rows })
        })
    }

    fn header(&self) -> Result<TableHeader, Vec<Problem>> {
        if self.schema.len() > MOST_COLUMNS {
            return Err(vec![too_many_columns(self.schema.len(), None)]);
        }
        Ok(TableHeader {
            names: self.schema.iter_names().map(|name| name.to_string()).collect(),
            ..TableHeader::default()
        })
    }

    fn type_of(&self, column: &str) -> Option<&ArrowDataType> {
        self.schema.get(column).map(|field| &field.dtype)
    }

    /// Refuses columns of a type that runs cannot have.
    fn check_types(&self, layout: &TableLayout) -> Result<(), Vec<Problem>> {
        let mut problems = vec![];
        for (column, place) in wanted(layout) {
            let is_number = column.is_number();
            let is_yes_or_no = |given: &ArrowDataType| column == RunColumn::Exclude && given == &ArrowDataType::Boolean;
            let given = self.type_of(&place.name);
            if let Some(given) = given.filter(|given| !is_readable(given, is_number) && !is_yes_or_no(given)) {
                let expected = if is_number { "32- or 64-bit numbers" } else { "texts" };
                let problem = whole_file(&format!("column {}", place.name), expected);
                problems.push(problem.found(format!("type {given:?}")));
            }
        }
        unless_wrong(problems, ())
    }

    /// Checks that some columns hold the rows that are said to be there, so many of which are to be held at once.
    fn check_counts(&self, columns: &[String], at_once: usize) -> Result<(), Vec<Problem>> {
        polars(|| check_counts(self.file.try_clone()?, columns, at_once))
    }

    /// Some columns from a row on, of as many rows as are in memory at once.
    fn read(&self, columns: &[String], first: usize) -> Result<DataFrame, Vec<Problem>> {
        polars(|| {
            let reader = ParquetReader::new(self.file.try_clone()?).with_columns(Some(columns.to_vec()));
            let rows = ROWS_AT_ONCE.min(self.rows - first);
            reader.with_slice(Some((first, rows))).set_rechunk(true).finish()
        })
    }
}

/// Rows that are in memory at once as the file has them: a few of the blocks that `simulate` writes.
const ROWS_AT_ONCE: usize = 1 << 19;

/// Reads a Parquet table for what stands in its columns; of a column of a type that runs cannot have, only its name is told.
pub(super) fn survey_parquet(table: ParquetTable) -> Result<Survey, Vec<Problem>> {
    let header = table.header()?;
    let is_known = |name: &&String| {
        let given = table.type_of(name);
        given.is_some_and(|given| is_readable(given, true) || is_readable(given, false))
    };
    let known: Vec<String> = header.names.iter().filter(is_known).cloned().collect();
    table.check_counts(&known, table.rows)?;
    let mut survey = Survey::new(header);
    if known.is_empty() {
        survey.rows = table.rows;
        return Ok(survey);
    }
    for first in (0..table.rows).step_by(ROWS_AT_ONCE) {
        let frame = table.read(&known, first)?;
        let mut columns = vec![];
        for column in &survey.columns {
            let texts = |given: &Column| polars(|| given.cast(&DataType::String)?.str().cloned());
            columns.push(frame.column(&column.name).ok().map(texts).transpose()?);
        }
        for row in 0..frame.height() {
            let cells = columns.iter().map(|texts: &Option<StringChunked>| {
                let text = texts.as_ref().and_then(|texts| texts.get(row));
                text.unwrap_or_default()
            });
            survey.add((first + row + 1) as u64, cells);
        }
    }
    Ok(survey)
}

/// Reads the rows of a Parquet table. Fails with every bad cell named by row and column.
pub(super) fn read_parquet(table: &ParquetTable, scene: &Scene, take: TakeRuns) -> Result<Collected, Problems> {
    let header = table.header()?;
    let layout = TableLayout::new(&header, &scene.data.naming)?;
    table.check_types(&layout)?;
    // only what is used: another column may have a type this reader does not know
    let names: Vec<String> = wanted(&layout).iter().map(|(_, place)| place.name.clone()).collect();
    let is_whole = take.is_none();
    table.check_counts(&names, if is_whole { table.rows } else { ROWS_AT_ONCE })?;
    // what a few bytes may claim is not kept to be refused then
    if let Some(problem) = too_many_rows(table.rows, scene).filter(|_| is_whole) {
        return Err(vec![problem].into());
    }
    let mut checked = CheckedRows::new(&layout, scene, take);
    for first in (0..table.rows).step_by(ROWS_AT_ONCE) {
        let frame = table.read(&names, first)?;
        add_rows(&mut checked, &layout, &frame, first)?;
        checked.give_block();
    }
    checked.finish()
}

/// The values of a column.
enum Values {
    Numbers(Float64Chunked),
    Texts(StringChunked),
}

/// Adds the rows of a frame that begins after so many rows of the file.
fn add_rows(
    checked: &mut CheckedRows,
    layout: &TableLayout,
    frame: &DataFrame,
    before: usize,
) -> Result<(), Vec<Problem>> {
    let mut values: Vec<Option<Values>> = (0..layout.width).map(|_| None).collect();
    for (column, place) in wanted(layout) {
        values[place.index] = Some(polars(|| {
            let given = frame.column(&place.name)?;
            Ok(match column.is_number() && given.dtype() != &DataType::String {
                true => Values::Numbers(given.cast(&DataType::Float64)?.f64()?.clone()),
                false => Values::Texts(given.cast(&DataType::String)?.str()?.clone()),
            })
        })?);
    }
    for row in 0..frame.height() {
        let cell = |place: &ColumnPlace| match values[place.index].as_ref()? {
            Values::Numbers(numbers) => numbers.get(row).map(Cell::Number),
            Values::Texts(texts) => texts.get(row).map(Cell::Text),
        };
        checked.add(CellPlace::Row((before + row + 1) as u64), std::iter::empty(), cell);
    }
    Ok(())
}

/// Does a step of reading Parquet.
fn polars<T>(step: impl FnOnce() -> PolarsResult<T>) -> Result<T, Vec<Problem>> {
    readable("Parquet file", step)
}

/// Whether a Parquet column of some type can hold numbers or names.
fn is_readable(given: &ArrowDataType, is_number: bool) -> bool {
    match given {
        ArrowDataType::Null => true,
        ArrowDataType::Utf8 | ArrowDataType::LargeUtf8 | ArrowDataType::Utf8View => true,
        ArrowDataType::Int32 | ArrowDataType::Int64 | ArrowDataType::UInt32 | ArrowDataType::UInt64 => true,
        ArrowDataType::Float32 | ArrowDataType::Float64 => is_number,
        ArrowDataType::Dictionary(_, names, _) => !is_number && is_readable(names, false),
        _ => false,
    }
}

/// The columns in use; a label, which may be of any type, is not.
fn wanted<'l>(layout: &'l TableLayout) -> Vec<(RunColumn, &'l ColumnPlace)> {
    RunColumn::ALL
        .into_iter()
        .filter(|column| *column != RunColumn::Run)
        .filter_map(|column| layout.place(column).map(|place| (column, place)))
        .collect()
}

/// Runs as columns.
fn columns(runs: &[NewRun]) -> PolarsResult<DataFrame> {
    let particle: Vec<&str> = runs.iter().map(|run| run.particle).collect();
    let liquid: Vec<&str> = runs.iter().map(|run| run.liquid.unwrap_or(DRY)).collect();
    let mut columns = vec![
        Column::new("particle".into(), particle),
        Column::new("liquid".into(), liquid),
    ];
    for (place, name) in NewRun::NUMBERS.into_iter().enumerate() {
        let numbers: Vec<Option<f64>> = runs.iter().map(|run| run.numbers()[place]).collect();
        columns.push(Column::new(name.into(), numbers));
    }
    DataFrame::new(runs.len(), columns)
}

/// Writes Parquet a block of runs at a time, in constant memory.
pub(super) struct ParquetRuns<W: Write> {
    writer: polars::io::parquet::write::BatchedWriter<W>,
}

impl<W: Write> ParquetRuns<W> {
    pub fn new(sink: W) -> PolarsResult<Self> {
        // nobody asks such a table for its smallest value
        let writer = ParquetWriter::new(sink).with_statistics(StatisticsOptions::empty());
        let writer = writer.batched(columns(&[])?.schema())?;
        Ok(ParquetRuns { writer })
    }

    pub fn write(&mut self, runs: &[NewRun]) -> PolarsResult<()> {
        self.writer.write_batch(&columns(runs)?)
    }

    pub fn finish(self) -> PolarsResult<()> {
        self.writer.finish().map(|_| ())
    }
}
