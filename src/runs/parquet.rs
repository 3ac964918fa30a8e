//! Reads and writes Parquet with polars. The only file that names polars.

use std::fs::File;
use std::io::{Cursor, Write};

use polars::prelude::*;

use super::collect::{too_many_rows, Collected, Gathering};
use super::columns::{ColumnPlace, Header, TableLayout};
use super::csv::too_many_columns;
use super::decimals::Decimals;
use super::new_run::NewRun;
use super::parquet_footer;
use super::parquet_parts::ParquetParts;
use super::raw_row::BadCell;
use super::refusals::{readable, unreadable, CellPlace, Refusals, Refused};
use super::row::{check_row, RowChecker};
use super::survey::Survey;
use crate::error::{quoted, Problem};
use crate::files::MOST_COLUMNS;
use crate::scene::{Naming, RunColumn, Scene};

/// Checks the last bytes of a Parquet file, before it is read as a whole.
pub(super) fn parquet_ends(end: &[u8]) -> Result<(), Vec<Problem>> {
    polars(|| parquet_footer::check_mark(end))
}

/// The columns of a Parquet file with their types.
fn schema_of(bytes: &[u8]) -> Result<(Arc<ArrowSchema>, Vec<String>), Vec<Problem>> {
    polars(|| parquet_footer::check_footer(bytes))?;
    let schema = polars(|| ParquetReader::new(Cursor::new(bytes)).schema())?;
    let header: Vec<String> = schema.iter_names().map(|name| name.to_string()).collect();
    if header.len() > MOST_COLUMNS {
        return Err(vec![too_many_columns(header.len(), None)]);
    }
    Ok((schema, header))
}

/// Reads a Parquet file for what stands in its columns; of a column of a type that runs cannot have, only its name is told.
pub(super) fn survey_parquet(bytes: &[u8]) -> Result<Survey, Vec<Problem>> {
    let (schema, header) = schema_of(bytes)?;
    let is_known = |name: &&String| {
        let field = schema.get(name.as_str());
        field.is_some_and(|field| is_readable(&field.dtype, true) || is_readable(&field.dtype, false))
    };
    let known: Vec<String> = header.iter().filter(is_known).cloned().collect();
    polars(|| parquet_footer::check_counts(bytes, &known))?;
    let mut survey = Survey::new(Header {
        names: header,
        ..Header::default()
    });
    let rows_of_file = polars(|| ParquetReader::new(Cursor::new(bytes)).num_rows())?;
    if known.is_empty() {
        survey.rows = rows_of_file;
        return Ok(survey);
    }
    let to_read = rows_of_file;
    for first in (0..to_read).step_by(ROWS_AT_ONCE) {
        let frame = polars(|| {
            let reader = ParquetReader::new(Cursor::new(bytes)).with_columns(Some(known.clone()));
            let rows = ROWS_AT_ONCE.min(rows_of_file - first);
            reader.with_slice(Some((first, rows))).finish()
        })?;
        let mut columns = vec![];
        for column in &survey.columns {
            let texts = match frame.column(&column.name) {
                Ok(given) => {
                    let texts = polars(|| given.cast(&DataType::String))?;
                    Some(polars(|| texts.str().cloned())?)
                }
                Err(_) => None,
            };
            columns.push(texts);
        }
        for row in 0..frame.height() {
            let cells = columns.iter().map(|texts| texts.as_ref()?.get(row));
            survey.add((first + row + 1) as u64, cells);
        }
    }
    Ok(survey)
}

/// The parts of a Parquet file, of so many rows each or a few more.
///
/// `None` where it is to be read as a whole, as what separates the decimals of a text is told by all of them.
/// Fails where there is no telling.
pub(super) fn parts(
    file: &mut File,
    length: u64,
    rows: usize,
    naming: &Naming,
) -> Result<Option<ParquetParts>, Vec<Problem>> {
    let footer = polars(|| Ok(parquet_footer::footer(file, length)?))?;
    let (schema, header) = schema_of(&footer)?;
    let layout = layout(header, naming)?;
    let is_in_parts = !has_number_texts(&schema, &layout);
    Ok(is_in_parts
        .then(|| ParquetParts::of(&footer, length, rows, names(&layout)))
        .flatten())
}

fn layout(names: Vec<String>, naming: &Naming) -> Result<TableLayout<'_>, Vec<Problem>> {
    let header = Header {
        names,
        ..Header::default()
    };
    TableLayout::new(&header, naming)
}

/// Whether a number is to be read from a text.
fn has_number_texts(schema: &ArrowSchema, layout: &TableLayout) -> bool {
    wanted(layout).into_iter().any(|(column, place)| {
        let given = schema.get(&place.name).map(|field| &field.dtype);
        column.is_number() && given.is_some_and(is_text)
    })
}

/// Reads a Parquet file, or a part of one after so many rows of it. Fails with every bad cell named by row and column.
pub(super) fn read_parquet(
    bytes: &[u8],
    scene: &Scene,
    rows_before: usize,
    gathering: &mut Gathering,
) -> Result<Collected, Refused> {
    let (schema, header) = schema_of(bytes)?;
    let layout = layout(header, &scene.data.naming)?;
    let wanted = wanted(&layout);
    let mut refusals = Refusals::new(&layout);
    for (column, place) in &wanted {
        let is_number = column.is_number();
        let given = schema.get(&place.name).map(|field| &field.dtype);
        let is_yes_or_no = |given: &ArrowDataType| *column == RunColumn::Exclude && given == &ArrowDataType::Boolean;
        if let Some(given) = given.filter(|given| !is_readable(given, is_number) && !is_yes_or_no(given)) {
            let expected = if is_number { "32- or 64-bit numbers" } else { "texts" };
            refusals.other(Problem {
                line: None,
                place: format!("column {}", place.name),
                found: Some(format!("type {given:?}")),
                expected: format!("expected {expected}"),
            });
        }
    }
    refusals.or(())?;
    // only what is used: another column may have a type this reader does not know
    let names = names(&layout);
    polars(|| parquet_footer::check_counts(bytes, &names))?;
    let rows = polars(|| ParquetReader::new(Cursor::new(bytes)).num_rows())?;
    // what a few bytes may claim is not kept to be refused then
    if let Some(problem) = gathering.is_whole().then(|| too_many_rows(rows, scene)).flatten() {
        return Err(vec![problem].into());
    }
    let at_once = if has_number_texts(&schema, &layout) {
        rows.max(1)
    } else {
        ROWS_AT_ONCE
    };
    let has_film_ratio = layout.gives(RunColumn::FilmRatio);
    let mut checker = RowChecker::new(scene, has_film_ratio);
    let mut collected = Collected::with_capacity(gathering.held(rows), has_film_ratio, &layout.remarks);
    let mut refusals = Refusals::new(&layout);
    let read = |first: usize| -> Result<DataFrame, Vec<Problem>> {
        polars(|| {
            let reader = ParquetReader::new(Cursor::new(bytes)).with_columns(Some(names.clone()));
            let rows = at_once.min(rows.saturating_sub(first));
            reader.with_slice(Some((first, rows))).finish()
        })
    };
    let (mut first, mut next) = (0, read(0)?);
    loop {
        let frame = typed(next, &layout)?;
        let after = first + at_once;
        let (collecting, following) = rayon::join(
            || {
                let before = rows_before + first;
                collect(&frame, &layout, &mut checker, &mut collected, (before, &mut refusals))?;
                gathering.after(&mut collected);
                Ok::<(), Vec<Problem>>(())
            },
            || (after < rows).then(|| read(after)).transpose(),
        );
        collecting?;
        match following? {
            Some(frame) => (first, next) = (after, frame),
            None => return refusals.or(collected),
        }
    }
}

/// Rows that are in memory at once as the file has them: a few of the blocks that `simulate` writes.
const ROWS_AT_ONCE: usize = 1 << 19;

/// The columns in use as numbers and texts; fails with every text that is no number.
fn typed(frame: DataFrame, layout: &TableLayout) -> Result<DataFrame, Refused> {
    let mut refusals = Refusals::new(layout);
    let mut columns = vec![];
    let mut decimals = Decimals::default();
    for (column, place) in wanted(layout) {
        let given = polars(|| frame.column(&place.name))?;
        let is_number = column.is_number();
        columns.push(if is_number && given.dtype() == &DataType::String {
            numbers(given, (column, layout), &mut decimals, &mut refusals)
        } else if is_number {
            polars(|| given.cast(&DataType::Float64))?
        } else {
            polars(|| given.cast(&DataType::String))?
        });
    }
    decimals.finish(&mut refusals);
    refusals.or(())?;
    let mut frame = polars(|| DataFrame::new(frame.height(), columns))?;
    frame.align_chunks_par();
    Ok(frame)
}

/// Collects the checked runs of a frame that begins with this row of the file.
fn collect(
    frame: &DataFrame,
    layout: &TableLayout,
    checker: &mut RowChecker,
    collected: &mut Collected,
    (first, refusals): (usize, &mut Refusals),
) -> Result<(), Vec<Problem>> {
    let mut refused = |row: usize, bad: BadCell| {
        refusals.cell(CellPlace::Row(first + row + 1), bad, |column| {
            let cell = frame.column(&layout.place(column)?.name).ok()?.get(row).ok()?;
            match cell {
                AnyValue::Null => None,
                AnyValue::String(text) => (!text.trim().is_empty()).then(|| quoted(text)),
                AnyValue::Float64(value) => Some(quoted(&value.to_string())),
                value => Some(quoted(&value.to_string())),
            }
        });
    };
    // the frame is in memory: a panic here is none of a damaged file
    collect_rows(frame, layout, checker, collected, &mut refused).map_err(|error| unreadable(PARQUET, &error))
}

/// What a file is called that is to be Parquet.
const PARQUET: &str = "Parquet file";

/// Does a step of reading Parquet.
fn polars<T>(step: impl FnOnce() -> PolarsResult<T>) -> Result<T, Vec<Problem>> {
    readable(PARQUET, step)
}

fn is_text(given: &ArrowDataType) -> bool {
    matches!(
        given,
        ArrowDataType::Utf8 | ArrowDataType::LargeUtf8 | ArrowDataType::Utf8View
    )
}

/// Whether a Parquet column of some type can hold numbers or names.
fn is_readable(given: &ArrowDataType, is_number: bool) -> bool {
    match given {
        ArrowDataType::Null => true,
        given if is_text(given) => true,
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

/// The names in the file of the columns in use.
fn names(layout: &TableLayout) -> Vec<String> {
    let wanted = wanted(layout).into_iter();
    wanted.map(|(_, place)| place.name.clone()).collect()
}

/// Numbers that a column holds as text, by the rules of a text file.
fn numbers(
    given: &Column,
    (column, layout): (RunColumn, &TableLayout),
    decimals: &mut Decimals,
    refusals: &mut Refusals,
) -> Column {
    let texts = given
        .str()
        .map(|texts| texts.iter().collect::<Vec<_>>())
        .unwrap_or_default();
    let mut values: Vec<Option<f64>> = Vec::with_capacity(texts.len());
    for (row, text) in texts.into_iter().enumerate() {
        let place = CellPlace::Row(row + 1);
        let cell = text.and_then(|text| layout.read(column, text));
        match cell.map(|cell| decimals.read(cell, column, place)).transpose() {
            Ok(value) => values.push(value),
            Err(expected) => {
                values.push(None);
                refusals.cell(place, BadCell { column, expected }, |_| cell.map(quoted));
            }
        }
    }
    Column::new(given.name().clone(), values)
}

type NumberArray = <Float64Type as PolarsDataType>::Array;

fn number_at(array: &NumberArray, row: usize) -> Option<f64> {
    let present = array.validity().is_none_or(|present| present.get(row) == Some(true));
    array.values().get(row).copied().filter(|_| present)
}

/// Checks every row of a frame whose chunks are aligned. Every wrong cell goes to `refused` with its row.
fn collect_rows(
    frame: &DataFrame,
    layout: &TableLayout,
    checker: &mut RowChecker,
    collected: &mut Collected,
    refused: &mut dyn FnMut(usize, BadCell),
) -> PolarsResult<()> {
    let mut words = vec![];
    let mut numbers = vec![];
    for (column, place) in wanted(layout) {
        let given = frame.column(&place.name)?;
        if column.is_number() {
            numbers.push((column, place, given.f64()?.downcast_iter().collect::<Vec<_>>()));
        } else {
            words.push((column, given.str()?.downcast_iter().collect::<Vec<_>>()));
        }
    }
    let has_film_ratio = layout.gives(RunColumn::FilmRatio);
    let before = layout.row_before_its_cells();
    let mut bad = vec![];
    let mut rows_before = 0;
    let lengths = frame
        .columns()
        .first()
        .map(|column| column.as_materialized_series().chunk_lengths().collect::<Vec<_>>());
    for (chunk, rows) in lengths.unwrap_or_default().into_iter().enumerate() {
        for row in 0..rows {
            let mut raw = before;
            for (column, chunks) in &words {
                raw.set_word(
                    *column,
                    chunks[chunk].get(row).and_then(|cell| layout.read(*column, cell)),
                );
            }
            for (column, place, chunks) in &numbers {
                let number = number_at(chunks[chunk], row).and_then(|x| layout.read_number(*column, x));
                raw.set(*column, number.map(|x| place.to_si(x)));
            }
            collected.count(collected.rows as u64 + 1, None);
            if let Some(reason) = raw.exclude {
                collected.exclude(reason);
                continue;
            }
            if let Some(row) = check_row(&raw, checker, &mut bad) {
                collected.push(&row, has_film_ratio, checker.scene);
            }
            for bad in bad.drain(..) {
                refused(rows_before + row, bad);
            }
        }
        rows_before += rows;
    }
    Ok(())
}

/// A block of runs as columns.
pub(super) struct ParquetBlock(Vec<Column>);

impl ParquetBlock {
    pub fn of(runs: &[NewRun]) -> ParquetBlock {
        let mut numbers = NewRun::NUMBERS.map(|_| Vec::with_capacity(runs.len()));
        for run in runs {
            for (column, number) in numbers.iter_mut().zip(run.numbers()) {
                column.push(number);
            }
        }
        let particle: Vec<&str> = runs.iter().map(|run| run.particle).collect();
        let liquid: Vec<Option<&str>> = runs.iter().map(|run| run.liquid).collect();
        let words = [
            Column::new("particle".into(), particle),
            Column::new("liquid".into(), liquid),
        ];
        let numbers = NewRun::NUMBERS.into_iter().zip(numbers);
        let numbers = numbers.map(|(name, column)| Column::new(name.into(), column));
        ParquetBlock(words.into_iter().chain(numbers).collect())
    }
}

/// Writes Parquet a block of runs at a time, in constant memory.
pub(super) struct ParquetRuns<W: Write> {
    writer: polars::io::parquet::write::BatchedWriter<W>,
}

fn schema() -> Schema {
    let text = ["particle", "liquid"].map(|name| (name, DataType::String));
    let numbers = NewRun::NUMBERS.map(|name| (name, DataType::Float64));
    text.into_iter()
        .chain(numbers)
        .map(|(name, dtype)| (PlSmallStr::from_static(name), dtype))
        .collect()
}

impl<W: Write> ParquetRuns<W> {
    pub fn new(sink: W) -> Result<Self, String> {
        // nobody asks such a table for its smallest value
        let writer = ParquetWriter::new(sink)
            .with_statistics(StatisticsOptions::empty())
            .batched(&schema())
            .map_err(|error| error.to_string())?;
        Ok(ParquetRuns { writer })
    }

    pub fn write(&mut self, ParquetBlock(columns): ParquetBlock) -> Result<(), String> {
        let rows = columns.first().map_or(0, Column::len);
        DataFrame::new(rows, columns)
            .and_then(|frame| self.writer.write_batch(&frame))
            .map_err(|error| error.to_string())
    }

    pub fn finish(self) -> Result<(), String> {
        self.writer.finish().map(|_| ()).map_err(|error| error.to_string())
    }
}
