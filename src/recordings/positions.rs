//! Reads a table of positions: where the sphere was, a line a frame.

use std::path::Path;

use super::list::{Axis, Recording};
use super::track::Track;
use crate::error::{file_name, quoted, Error, Problem};
use crate::runs::{column, each_row, find, CellNumbers, Column, FoundColumns, TakesRows};
use crate::scene::TableFile;
use crate::units::Dimension;

/// A track as a table has it.
#[derive(Debug, Clone)]
pub(super) struct Positions {
    /// heights upwards
    pub track: Track,
    /// whether heights are pixels, not metres
    pub in_pixels: bool,
}

/// The columns of the table, by their place in [`COLUMNS`].
#[derive(Clone, Copy)]
enum Field {
    Frame,
    Time,
    Pixels,
    Height,
    Object,
}

const COLUMNS: [Column; 5] = [
    column("frame", Dimension::One, false),
    column("time", Dimension::Time, false),
    column("y_px", Dimension::One, false),
    column("y", Dimension::Length, false),
    column("object", Dimension::One, false),
];

/// Reads the table of a recording. `axis` says where its heights point, unless the recording does; else pixels are counted
/// downwards and lengths upwards.
///
/// Of several objects the one that moves farthest in all is taken. Fails where a frame has two positions of one.
pub(super) fn read(recording: &Recording, axis: Option<Axis>) -> Result<Positions, Error> {
    let table = TableFile::named(None, &recording.file.to_string_lossy());
    let mut rows = Rows {
        frame_rate: recording.frame_rate,
        found: FoundColumns::default(),
        numbers: CellNumbers::default(),
        seen: vec![],
        problems: vec![],
    };
    each_row(&table, &mut rows)?;
    rows.problems.extend(rows.numbers.doubt());
    let in_pixels = rows.found.columns[Field::Pixels as usize].is_some();
    let mut problems = std::mem::take(&mut rows.problems);
    if problems.is_empty() {
        let usual = if in_pixels { Axis::Down } else { Axis::Up };
        let axis = recording.axis.or(axis).unwrap_or(usual);
        match rows.track(axis) {
            Ok(track) => return Ok(Positions { track, in_pixels }),
            Err(problem) => problems.push(problem),
        }
    }
    Err(Error::input(&recording.file, problems))
}

struct Seen {
    line: u64,
    time: f64,
    height: f64,
    object: String,
}

struct Rows {
    frame_rate: Option<f64>,
    found: FoundColumns,
    numbers: CellNumbers,
    seen: Vec<Seen>,
    problems: Vec<Problem>,
}

impl TakesRows for Rows {
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.found = find(names, line, &COLUMNS)?;
        let has = |field: Field| self.found.columns[field as usize].is_some();
        let problem = |expected: &str| Problem {
            line: Some(line),
            place: "header".to_owned(),
            found: None,
            expected: expected.to_owned(),
        };
        let mut problems = vec![];
        if !has(Field::Frame) && !has(Field::Time) {
            problems.push(problem("expected a column `frame`, `time_s` or `time_ms`"));
        } else if !has(Field::Time) && self.frame_rate.is_none() {
            problems.push(problem(
                "expected a column `time_s`, or `frame_rate_Hz` in the list of recordings",
            ));
        }
        if has(Field::Pixels) == has(Field::Height) {
            problems.push(problem("expected one column of heights: `y_px`, `y_mm` or `y_m`"));
        }
        if problems.is_empty() {
            Ok(())
        } else {
            Err(problems)
        }
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        let field = if self.found.columns[Field::Time as usize].is_some() {
            Field::Time
        } else {
            Field::Frame
        };
        let time = self
            .number(field, line, cells)
            .map(|value| match (field, self.frame_rate) {
                (Field::Frame, Some(rate)) => value / rate,
                _ => value,
            });
        let of_height = if self.found.columns[Field::Pixels as usize].is_some() {
            Field::Pixels
        } else {
            Field::Height
        };
        // a frame in which nothing was found has no position
        if let (Some(time), Some(height)) = (time, self.number(of_height, line, cells)) {
            let object = self.found.columns[Field::Object as usize].as_ref();
            let object = object
                .and_then(|column| cells.get(column.index))
                .map_or("", |cell| cell.trim());
            self.seen.push(Seen {
                line,
                time,
                height,
                object: object.to_owned(),
            });
        }
    }
}

impl Rows {
    fn number(&mut self, field: Field, line: u64, cells: &[&str]) -> Option<f64> {
        let column = self.found.columns[field as usize].clone()?;
        let cell = cells.get(column.index)?;
        // what a tracker writes where it found nothing
        if cell.trim().eq_ignore_ascii_case("nan") {
            return None;
        }
        match self.numbers.read(cell, (line, &column.name)) {
            Ok(value) => value.map(|value| column.to_si(value)),
            Err(expected) => {
                self.problems.push(Problem {
                    line: Some(line),
                    place: column.name,
                    found: Some(quoted(cell.trim())),
                    expected,
                });
                None
            }
        }
    }

    /// The track of the object that moves most.
    fn track(self, axis: Axis) -> Result<Track, Problem> {
        let mut objects: std::collections::BTreeMap<String, Vec<Seen>> = std::collections::BTreeMap::new();
        for seen in self.seen {
            objects.entry(seen.object.clone()).or_default().push(seen);
        }
        let mut found: Option<(f64, Track)> = None;
        for mut seen in objects.into_values() {
            seen.sort_by(|a, b| a.time.total_cmp(&b.time));
            if let Some(pair) = seen.windows(2).find(|pair| pair[0].time == pair[1].time) {
                return Err(Problem {
                    line: Some(pair[1].line),
                    place: String::new(),
                    found: None,
                    expected: format!(
                        "the frame of line {} has another position: expected one, or a column `object` that tells two things apart",
                        pair[0].line
                    ),
                });
            }
            let moved: f64 = seen
                .windows(2)
                .map(|pair| (pair[1].height - pair[0].height).abs())
                .sum();
            if found.as_ref().is_none_or(|(most, _)| moved > *most) {
                let sign = if axis == Axis::Up { 1.0 } else { -1.0 };
                let track = Track {
                    times: seen.iter().map(|seen| seen.time).collect(),
                    heights: seen.iter().map(|seen| sign * seen.height).collect(),
                };
                found = Some((moved, track));
            }
        }
        found.map(|(_, track)| track).ok_or_else(|| Problem {
            line: None,
            place: "no positions below the header".to_owned(),
            found: None,
            expected: "expected one line a frame".to_owned(),
        })
    }
}

/// Whether a recording is a table by its name, and not frames.
pub(super) fn is_table(file: &Path) -> bool {
    !file.is_dir() && TableFile::named(None, &file_name(file)).has_known_ending()
}
