//! Reads runs from CSV and Parquet with polars, and writes Parquet. The only file that names polars.

use std::io::{Cursor, Write};
use std::ops::ControlFlow;
use std::sync::Arc;

use polars::prelude::*;
use rayon::prelude::*;

use super::collect::Collected;
use super::columns::{Column as RunColumn, Place, Plan};
use super::refusals::{At, Refusals};
use super::row::{check, Against, BadCell, RawRow};
use super::text::{is_missing, number};
use super::write::NewRun;
use crate::error::{quoted, Problem};
use crate::scene::{Scene, MISSING};

/// Reads a CSV with typed columns; `None` where anything is out of the ordinary, so that the text reader decides.
pub(super) fn read_csv(text: &str, header: &[String], plan: &Plan, scene: &Scene) -> Option<Collected> {
    let bytes = text.as_bytes();
    // the typed reader takes quotes, padded names and short rows in its own way
    let first_line = memchr::memchr(b'\n', bytes).map_or(text, |end| &text[..end]);
    if first_line.trim_end_matches('\r') != header.join(",") || memchr::memchr(b'"', bytes).is_some() {
        return None;
    }
    // a line may also end with CR alone
    if memchr::memchr_iter(b'\r', bytes).any(|at| bytes.get(at + 1) != Some(&b'\n')) {
        return None;
    }
    // it also knows columns by their names alone
    if (1..header.len()).any(|index| header[..index].contains(&header[index])) {
        return None;
    }
    let fields: Schema = header
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let number = RunColumn::NUMBERS
                .into_iter()
                .any(|column| plan.place(column).is_some_and(|place| place.index == index));
            let dtype = if number { DataType::Float64 } else { DataType::String };
            (PlSmallStr::from_str(name), dtype)
        })
        .collect();
    let wanted: Arc<[PlSmallStr]> = wanted(plan)
        .into_iter()
        .map(|(_, place)| PlSmallStr::from_str(&place.name))
        .collect();
    let frame = CsvReadOptions::default()
        .with_has_header(true)
        .with_schema(Some(Arc::new(fields)))
        .with_columns(Some(wanted))
        .with_rechunk(false)
        .map_parse_options(|options| options.with_null_values(Some(NullValues::AllColumnsSingle(MISSING.into()))))
        .into_reader_with_file_handle(Cursor::new(bytes))
        .finish()
        .ok()?;
    // a short row would be filled with missing cells: the commas tell
    let commas = memchr::memchr_iter(b',', bytes).count();
    if commas != (plan.width - 1) * (frame.height() + 1) {
        return None;
    }
    // rows do not depend on each other: a part a thread, joined in their order
    let parts = rayon::current_num_threads().max(1);
    let part = frame.height().div_ceil(parts).max(1);
    let collected: Option<Vec<Collected>> = (0..parts)
        .into_par_iter()
        .map(|index| {
            let rows = frame.slice((index * part) as i64, part);
            collect(&rows, plan, scene, &mut |_, _| ControlFlow::Break(())).ok()
        })
        .collect();
    drop(frame);
    collected?.into_iter().reduce(Collected::join)
}

/// Reads a Parquet file. Fails with every bad cell named by row and column.
pub(super) fn read_parquet(bytes: &[u8], scene: &Scene) -> Result<Collected, Vec<Problem>> {
    let schema = polars(|| ParquetReader::new(Cursor::new(bytes)).schema())?;
    let header: Vec<String> = schema.iter_names().map(|name| name.to_string()).collect();
    let plan = Plan::new(&header, None)?;
    let wanted = wanted(&plan);
    let mut refusals = Refusals::new(&plan);
    for (column, place) in &wanted {
        let is_number = RunColumn::NUMBERS.contains(column);
        let given = schema.get(&place.name).map(|field| &field.dtype);
        if let Some(given) = given.filter(|given| !is_readable(given, is_number)) {
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
    let names = wanted.iter().map(|(_, place)| place.name.clone()).collect();
    let frame = polars(|| {
        let reader = ParquetReader::new(Cursor::new(bytes));
        reader.with_columns(Some(names)).finish()
    })?;
    let mut refusals = Refusals::new(&plan);
    let mut columns = vec![];
    for (column, place) in wanted {
        let given = polars(|| frame.column(&place.name))?;
        let is_number = RunColumn::NUMBERS.contains(&column);
        columns.push(if is_number && given.dtype() == &DataType::String {
            numbers(given, column, &mut refusals)
        } else if is_number {
            polars(|| given.cast(&DataType::Float64))?
        } else {
            polars(|| given.cast(&DataType::String))?
        });
    }
    refusals.or(())?;
    let frame = polars(|| DataFrame::new(frame.height(), columns))?;
    let mut refusals = Refusals::new(&plan);
    let collected = collect(&frame, &plan, scene, &mut |row, bad| {
        refusals.cell(At::Row(row + 1), bad, |column| {
            let cell = frame.column(&plan.place(column)?.name).ok()?.get(row).ok()?;
            match cell {
                AnyValue::Null => None,
                AnyValue::String(text) => (!text.trim().is_empty()).then(|| quoted(text)),
                AnyValue::Float64(value) => Some(quoted(&value.to_string())),
                value => Some(quoted(&value.to_string())),
            }
        });
        ControlFlow::Continue(())
    });
    let collected = polars(|| collected)?;
    refusals.or(collected)
}

/// Does a step of reading Parquet. A damaged file may make polars panic: that too is only an unreadable file.
fn polars<T>(step: impl FnOnce() -> PolarsResult<T>) -> Result<T, Vec<Problem>> {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(step));
    std::panic::set_hook(hook);
    let reason = match done {
        Ok(Ok(value)) => return Ok(value),
        Ok(Err(error)) => error.to_string().lines().next().unwrap_or_default().to_owned(),
        Err(_) => "its parts contradict each other".to_owned(),
    };
    Err(vec![Problem {
        line: None,
        place: "not a readable Parquet file".to_owned(),
        found: None,
        expected: reason,
    }])
}

/// Whether a Parquet column of some type can hold numbers or names.
fn is_readable(given: &ArrowDataType, is_number: bool) -> bool {
    match given {
        ArrowDataType::Null | ArrowDataType::Utf8 | ArrowDataType::LargeUtf8 | ArrowDataType::Utf8View => true,
        ArrowDataType::Int32 | ArrowDataType::Int64 | ArrowDataType::UInt32 | ArrowDataType::UInt64 => true,
        ArrowDataType::Float32 | ArrowDataType::Float64 => is_number,
        ArrowDataType::Dictionary(_, names, _) => !is_number && is_readable(names, false),
        _ => false,
    }
}

/// The columns in use; a free label is not.
fn wanted(plan: &Plan) -> Vec<(RunColumn, &Place)> {
    RunColumn::ALL
        .into_iter()
        .filter(|column| *column != RunColumn::Run)
        .filter_map(|column| plan.place(column).map(|place| (column, place)))
        .collect()
}

/// Numbers that a column holds as text, by the rules of a text file.
fn numbers(given: &Column, column: RunColumn, refusals: &mut Refusals) -> Column {
    let texts = given
        .str()
        .map(|texts| texts.iter().collect::<Vec<_>>())
        .unwrap_or_default();
    let mut values: Vec<Option<f64>> = Vec::with_capacity(texts.len());
    for (row, text) in texts.into_iter().enumerate() {
        let text = text.map(str::trim).filter(|text| !is_missing(text));
        match text.map(number).transpose() {
            Ok(value) => values.push(value),
            Err(expected) => {
                values.push(None);
                refusals.cell(At::Row(row + 1), BadCell { column, expected }, |_| text.map(quoted));
            }
        }
    }
    Column::new(given.name().clone(), values)
}

/// A name as a cell holds it.
fn name(cell: Option<&str>) -> Option<&str> {
    cell.map(str::trim).filter(|text| !is_missing(text))
}

/// Checks every row of a frame. A refused row goes to `refused`, which says whether to go on.
fn collect(
    frame: &DataFrame,
    plan: &Plan,
    scene: &Scene,
    refused: &mut dyn FnMut(usize, BadCell) -> ControlFlow<()>,
) -> PolarsResult<Collected> {
    let rows = frame.height();
    let texts = |column: RunColumn| match plan.place(column) {
        Some(place) => Ok(Some(frame.column(&place.name)?.str()?)),
        None => Ok::<_, PolarsError>(None),
    };
    let particle = texts(RunColumn::Particle)?;
    let liquid = texts(RunColumn::Liquid)?;
    let mut particle = particle.map(|c| c.iter());
    let mut liquid = liquid.map(|c| c.iter());
    let mut numbers = vec![];
    for column in RunColumn::NUMBERS {
        if let Some(place) = plan.place(column) {
            let values = frame.column(&place.name)?.f64()?.iter();
            numbers.push((column, place, values));
        }
    }
    let has_film_ratio = plan.place(RunColumn::FilmRatio).is_some();
    let mut against = Against::new(scene, has_film_ratio);
    let mut bad = vec![];
    let mut collected = Collected::with_capacity(rows, has_film_ratio, &plan.unknown);
    for index in 0..rows {
        let mut raw = RawRow {
            particle: name(particle.as_mut().and_then(|c| c.next()).flatten()),
            liquid: name(liquid.as_mut().and_then(|c| c.next()).flatten()),
            ..RawRow::default()
        };
        for (column, place, values) in &mut numbers {
            let value = values.next().flatten();
            raw.set(*column, value.map(|x| place.to_si(x)));
        }
        if let Some(row) = check(&raw, &mut against, &mut bad) {
            collected.push(&row, has_film_ratio, scene);
        }
        for bad in bad.drain(..) {
            if refused(index, bad).is_break() {
                return Err(PolarsError::NoData("a row was refused".into()));
            }
        }
    }
    Ok(collected)
}

/// Writes Parquet a batch of runs at a time, in constant memory.
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
        let writer = ParquetWriter::new(sink)
            .batched(&schema())
            .map_err(|error| error.to_string())?;
        Ok(ParquetRuns { writer })
    }

    pub fn write(&mut self, runs: &[NewRun]) -> Result<(), String> {
        let particle: Vec<&str> = runs.iter().map(|run| run.particle).collect();
        let liquid: Vec<Option<&str>> = runs.iter().map(|run| run.liquid).collect();
        let mut columns = vec![
            Column::new("particle".into(), particle),
            Column::new("liquid".into(), liquid),
        ];
        for (index, name) in NewRun::NUMBERS.into_iter().enumerate() {
            let values: Vec<Option<f64>> = runs.iter().map(|run| run.numbers()[index]).collect();
            columns.push(Column::new(name.into(), values));
        }
        let frame = DataFrame::new(runs.len(), columns).map_err(|error| error.to_string())?;
        self.writer.write_batch(&frame).map_err(|error| error.to_string())
    }

    pub fn finish(self) -> Result<(), String> {
        self.writer.finish().map(|_| ()).map_err(|error| error.to_string())
    }
}
