//! Reads a table of positions: where the sphere was, a line a frame.

use std::collections::BTreeMap;
use std::path::Path;

use super::campaign::Shown;
use super::list::{Axis, Recording};
use super::parabola::Kind;
use super::segments::segments;
use super::track::Track;
use crate::error::{quoted, Error, Problem};
use crate::runs::{column, each_row, find, Column, FoundColumns, TakesRows};
use crate::scene::TableFile;
use crate::units::Dimension;

/// A track as a table has it.
#[derive(Debug, Clone)]
pub(super) struct Positions {
    /// heights upwards
    pub shown: Shown,
    /// objects that fall
    pub falling: usize,
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

/// What programs that track call these columns, in small letters: Tracker, trackpy, TrackMate and ImageJ. A `y` has the unit
/// that the list of recordings says.
const THEIRS: [(&str, &str); 7] = [
    ("t", "time_s"),
    ("frame", "frame"),
    ("slice", "frame"),
    ("particle", "object"),
    ("track_id", "object"),
    ("y", "y"),
    ("position_y", "y"),
];

/// Lines above the header, as a title, and below it, as units, that may hold no numbers.
const MOST_WORDS: usize = 10;

/// Largest number of a table: nothing that is filmed has another.
const LARGEST: f64 = 1e12;

/// Reads the table of a recording. `axis` says where its heights point, unless the recording does; else pixels are counted
/// downwards and lengths upwards.
///
/// Of several objects the one that falls farthest is taken. Fails where a frame has two positions of one.
pub(super) fn read(recording: &Recording, axis: Option<Axis>) -> Result<Positions, Error> {
    let table = TableFile::named(None, &recording.file.to_string_lossy());
    let mut rows = Rows {
        frame_rate: recording.frame_rate,
        y_unit: recording.y_unit.as_deref(),
        found: FoundColumns::none(),
        width: None,
        first_line: None,
        words: 0,
        seen: vec![],
        problems: vec![],
    };
    each_row(&table, &mut rows)?;
    rows.problems.extend(rows.found.doubt());
    rows.problems.extend(rows.no_header());
    let mut problems = std::mem::take(&mut rows.problems);
    if problems.is_empty() {
        let usual = if rows.has(Field::Pixels) { Axis::Down } else { Axis::Up };
        let axis = recording.axis.or(axis).unwrap_or(usual);
        match rows.positions(axis) {
            Ok(positions) => return Ok(positions),
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

struct Rows<'r> {
    frame_rate: Option<f64>,
    y_unit: Option<&'r str>,
    /// of a header that is yet to come without columns
    found: FoundColumns,
    /// cells of that header
    width: Option<usize>,
    /// the first line, where it is no header
    first_line: Option<Vec<String>>,
    /// lines that hold no numbers
    words: usize,
    seen: Vec<Seen>,
    problems: Vec<Problem>,
}

impl TakesRows for Rows<'_> {
    const MAY_END_BLANK: bool = true;

    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        let ours = self.ours(names);
        let is_known = |name: &String| {
            let named = |column: &Column| {
                let units = column.dimension.units().iter();
                units
                    .map(|unit| unit.suffix)
                    .any(|suffix| name.strip_prefix(column.base) == Some(suffix))
            };
            name == "y" || COLUMNS.iter().any(named)
        };
        if !ours.iter().any(is_known) {
            self.first_line.get_or_insert_with(|| names.to_vec());
            return Ok(());
        }
        self.found = find(&ours, line, &COLUMNS)?;
        let problem = |expected: &str| Problem {
            line: Some(line),
            place: "header".to_owned(),
            found: Some(shown(names)),
            expected: expected.to_owned(),
        };
        let mut problems = vec![];
        if !self.has(Field::Frame) && !self.has(Field::Time) {
            problems.push(problem("expected a column `frame`, `time_s` or `time_ms`"));
        } else if !self.has(Field::Time) && self.frame_rate.is_none() {
            problems.push(problem(
                "expected a column `time_s`, or `frame_rate_Hz` in the list of recordings",
            ));
        }
        if self.has(Field::Pixels) == self.has(Field::Height) {
            let without_unit = ours.iter().any(|name| name == "y");
            problems.push(problem(if without_unit {
                "expected the unit of `y`: px, mm, cm or m as `y_unit` in the list of recordings"
            } else {
                "expected one column of heights: `y_px`, `y_mm` or `y_m`"
            }));
        }
        if problems.is_empty() {
            self.width = Some(names.len());
            Ok(())
        } else {
            Err(problems)
        }
    }

    fn width(&self) -> Option<usize> {
        self.width
    }

    fn refuse(&mut self, problem: Problem) {
        self.problems.push(problem);
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        if !self.problems.is_empty() && self.found.columns.is_empty() {
            return;
        }
        if self.found.columns.is_empty() {
            self.words += 1;
            if self.words > MOST_WORDS {
                self.problems.extend(self.no_header());
                return;
            }
            let names: Vec<String> = cells.iter().map(|cell| cell.trim().to_owned()).collect();
            if let Err(problems) = self.header(&names, line) {
                self.problems.extend(problems);
            }
            return;
        }
        if self.seen.is_empty() && self.words < MOST_WORDS && self.has_no_number(cells) {
            self.words += 1;
            return;
        }
        let (of_time, of_height) = (
            self.first_of(Field::Time, Field::Frame),
            self.first_of(Field::Pixels, Field::Height),
        );
        let rate = self.frame_rate.filter(|_| matches!(of_time, Field::Frame));
        let time = self.number(of_time, line, cells);
        let time = time.map(|value| value / rate.unwrap_or(1.0));
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

/// The names of a header in one message.
fn shown(names: &[String]) -> String {
    let named: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|name| !name.is_empty())
        .collect();
    quoted(&named.join(", "))
}

impl Rows<'_> {
    fn has(&self, field: Field) -> bool {
        matches!(self.found.columns.get(field as usize), Some(Some(_)))
    }

    fn first_of(&self, first: Field, second: Field) -> Field {
        if self.has(first) {
            first
        } else {
            second
        }
    }

    /// The names of a header as ours, where they are those of a program that tracks.
    fn ours(&self, names: &[String]) -> Vec<String> {
        let ours = names.iter().map(|name| {
            let lower = name.to_lowercase();
            let known = THEIRS.iter().find(|(theirs, _)| *theirs == lower);
            let our = match known {
                Some((_, "y")) => format!("y{}", self.y_unit.map_or(String::new(), |unit| format!("_{unit}"))),
                Some((_, our)) => (*our).to_owned(),
                None => return name.clone(),
            };
            // not beside one that has our name already
            if names.contains(&our) {
                name.clone()
            } else {
                our
            }
        });
        ours.collect()
    }

    /// The problem of a table in which no line is a header.
    fn no_header(&self) -> Option<Problem> {
        let first = self
            .first_line
            .as_ref()
            .filter(|_| self.found.columns.is_empty() && self.problems.is_empty())?;
        Some(Problem {
            line: Some(1),
            place: "header".to_owned(),
            found: Some(shown(first)),
            expected: "expected columns `frame`, `time_s` or `time_ms`, and `y_px`, `y_mm` or `y_m`".to_owned(),
        })
    }

    /// Whether a line holds words alone, as a line of units does.
    fn has_no_number(&self, cells: &[&str]) -> bool {
        let columns = self.found.columns.iter().flatten();
        let cells = columns.filter_map(|column| cells.get(column.index));
        cells
            .into_iter()
            .all(|cell| !cell.contains(|c: char| c.is_ascii_digit()))
    }

    fn number(&mut self, field: Field, line: u64, cells: &[&str]) -> Option<f64> {
        let column = self.found.columns[field as usize].clone()?;
        let cell = cells.get(column.index)?;
        // what a tracker writes where it found nothing
        if cell.trim().eq_ignore_ascii_case("nan") {
            return None;
        }
        let expected = match self.found.number(field as usize, cell, line) {
            Ok(Some(value)) if value.abs() > LARGEST => format!("expected a number from -{LARGEST:e} to {LARGEST:e}"),
            Ok(value) => return value.map(|value| column.to_si(value)),
            Err(expected) => expected,
        };
        self.problems.push(Problem {
            line: Some(line),
            place: column.name,
            found: Some(quoted(cell.trim())),
            expected,
        });
        None
    }

    /// The track of the object that falls farthest; where none does, of the one that moves most.
    fn positions(self, axis: Axis) -> Result<Positions, Problem> {
        let in_pixels = self.has(Field::Pixels);
        let counted_from = (!self.has(Field::Time)).then_some(0);
        let mut objects: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
        for seen in self.seen {
            objects.entry(seen.object.clone()).or_default().push(seen);
        }
        let several = objects.len() > 1;
        let mut falls = vec![];
        let mut best: Option<([f64; 2], Shown)> = None;
        for (object, mut seen) in objects {
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
            let sign = if axis == Axis::Up { 1.0 } else { -1.0 };
            let track = Track {
                times: seen.iter().map(|seen| seen.time).collect(),
                heights: seen.iter().map(|seen| sign * seen.height).collect(),
            };
            // one object needs no comparison
            let fall = if several { farthest_fall(&track) } else { 0.0 };
            falls.push(fall);
            let [lowest, highest] = track.ends_of_heights();
            let moves = [fall, highest - lowest];
            if best.as_ref().is_none_or(|(most, _)| moves > *most) {
                let shown = Shown {
                    frames: track.times.len(),
                    track,
                    in_pixels,
                    diameter: None,
                    counted_from,
                    object: several.then_some(object),
                };
                best = Some((moves, shown));
            }
        }
        let Some(([farthest, _], shown)) = best else {
            return Err(Problem {
                line: None,
                place: "no positions below the header".to_owned(),
                found: None,
                expected: "expected one line a frame".to_owned(),
            });
        };
        /// of the farthest fall, that another object's is no speck's
        const AS_FAR: f64 = 0.3;
        let falling = falls.iter().filter(|fall| **fall > 0.0 && **fall > AS_FAR * farthest);
        Ok(Positions {
            falling: falling.count(),
            shown,
        })
    }
}

/// How far a track falls in one flight; 0 where it has none.
fn farthest_fall(track: &Track) -> f64 {
    let Some(sigma) = track.noise() else { return 0.0 };
    let flights = segments(track, sigma)
        .into_iter()
        .filter(|segment| segment.kind == Kind::Flight);
    let far = flights.map(|flight| {
        let heights = || flight.frames.iter().map(|frame| track.heights[*frame]);
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min)
    });
    far.fold(0.0, f64::max)
}

/// Whether a recording is a table by its name, and not frames.
pub(super) fn is_table(file: &Path) -> bool {
    !file.is_dir() && TableFile::named(None, &file.to_string_lossy()).has_known_ending()
}
