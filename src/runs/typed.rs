//! Reads runs from CSV and Parquet with polars, and writes Parquet. The only file that names polars.

use std::io::{Cursor, Write};
use std::sync::Arc;

use polars::prelude::*;

use super::collect::Collected;
use super::columns::{Column as RunColumn, Plan};
use super::row::{check, BadCell, Names, RawRow};
use super::text::{is_missing, MIXED_FILM_RATIO};
use super::whole_file;
use super::write::NewRun;
use crate::error::Problem;
use crate::scene::Scene;

/// Reads a CSV with typed columns; `None` where anything is out of the ordinary, so that the text reader decides.
pub(super) fn read_csv(text: &str, header: &[String], plan: &Plan, scene: &Scene) -> Option<Collected> {
    let bytes = text.as_bytes();
    // the typed reader takes quotes, padded names and short rows in its own way
    let first_line = memchr::memchr(b'\n', bytes).map_or(text, |end| &text[..end]);
    if first_line.trim_end_matches('\r') != header.join(",") || memchr::memchr(b'"', bytes).is_some() {
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
    let wanted: Arc<[PlSmallStr]> = RunColumn::ALL
        .into_iter()
        .filter(|column| *column != RunColumn::Run)
        .filter_map(|column| plan.place(column))
        .map(|place| PlSmallStr::from_str(&place.name))
        .collect();
    let frame = CsvReadOptions::default()
        .with_has_header(true)
        .with_schema(Some(Arc::new(fields)))
        .with_columns(Some(wanted))
        .with_rechunk(false)
        .map_parse_options(|options| options.with_null_values(Some(NullValues::AllColumnsSingle("NA".into()))))
        .into_reader_with_file_handle(Cursor::new(bytes))
        .finish()
        .ok()?;
    // a short row would be filled with missing cells: the commas tell
    let commas = memchr::memchr_iter(b',', bytes).count();
    if commas != (plan.width - 1) * (frame.height() + 1) {
        return None;
    }
    collect(&frame, plan, scene, &mut |_, _, _| ControlFlow::Stop).ok()
}

/// Reads a Parquet file. Fails with every bad cell named by row and column.
pub(super) fn read_parquet(bytes: &[u8], scene: &Scene) -> Result<Collected, Vec<Problem>> {
    let refuse = |error: PolarsError| {
        let message = error.to_string();
        let line = message.lines().next().unwrap_or_default().to_owned();
        vec![whole_file("not a readable Parquet file", &format!("Parquet: {line}"))]
    };
    let frame = ParquetReader::new(Cursor::new(bytes)).finish().map_err(refuse)?;
    let header: Vec<String> = frame.get_column_names().iter().map(|n| n.to_string()).collect();
    let plan = Plan::new(&header, None)?;
    let mut problems = vec![];
    let mut columns = vec![];
    for column in RunColumn::ALL {
        let Some(place) = plan.place(column).filter(|_| column != RunColumn::Run) else {
            continue;
        };
        let number = RunColumn::NUMBERS.contains(&column);
        let dtype = if number { DataType::Float64 } else { DataType::String };
        let cast = frame.column(&place.name).and_then(|c| {
            // numbers written as text are still read; text that is no number is not
            c.strict_cast(&dtype)
        });
        match cast {
            Ok(column) => columns.push(column),
            Err(_) => problems.push(Problem {
                line: None,
                place: format!("column {}", place.name),
                found: frame.column(&place.name).ok().map(|c| format!("type {}", c.dtype())),
                expected: format!("expected {}", if number { "numbers" } else { "texts" }),
            }),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let frame = DataFrame::new(frame.height(), columns).map_err(refuse)?;
    let mut refused = |row: usize, bad: BadCell, raw: &RawRow| {
        let name = plan.name(bad.column);
        problems.push(Problem {
            line: Some(row as u64 + 1),
            place: format!("column {name} (lines are rows of the Parquet file)"),
            found: Some(found_in_frame(&frame, &name, row, raw)),
            expected: bad.expected,
        });
        ControlFlow::GoOn
    };
    let collected = collect(&frame, &plan, scene, &mut refused);
    match collected {
        Ok(collected) if problems.is_empty() => Ok(collected),
        _ => Err(problems),
    }
}

fn found_in_frame(frame: &DataFrame, name: &str, row: usize, _raw: &RawRow) -> String {
    match frame.column(name).and_then(|column| column.get(row)) {
        Ok(AnyValue::Null) | Err(_) => "an empty cell".to_owned(),
        Ok(AnyValue::String(text)) => format!("`{text}`"),
        Ok(value) => format!("`{value}`"),
    }
}

enum ControlFlow {
    GoOn,
    Stop,
}

/// Checks every row of a frame. A refused row goes to `refused`, which says whether to go on.
fn collect(
    frame: &DataFrame,
    plan: &Plan,
    scene: &Scene,
    refused: &mut dyn FnMut(usize, BadCell, &RawRow) -> ControlFlow,
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
    let mut names = Names::new(scene);
    let mut bad = vec![];
    let has_film_ratio = plan.place(RunColumn::FilmRatio).is_some();
    let mut collected = Collected::with_capacity(rows, has_film_ratio, &plan.unknown);
    for index in 0..rows {
        let mut raw = RawRow {
            particle: particle.as_mut().and_then(|c| c.next()).flatten(),
            liquid: liquid
                .as_mut()
                .and_then(|c| c.next())
                .flatten()
                .filter(|t| !is_missing(t)),
            ..RawRow::default()
        };
        for (column, place, values) in &mut numbers {
            let value = values.next().flatten();
            raw.set(*column, value.map(|x| place.to_si(x)));
        }
        let row = check(&raw, &mut names, &mut bad);
        match row {
            Some(row) if has_film_ratio && row.liquid.is_some() && row.film_ratio.is_none() => {
                bad.push(BadCell {
                    column: RunColumn::FilmRatio,
                    expected: MIXED_FILM_RATIO.to_owned(),
                });
            }
            Some(row) => collected.push(&row, has_film_ratio, scene),
            None => {}
        }
        for bad in bad.drain(..) {
            if let ControlFlow::Stop = refused(index, bad, &raw) {
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
