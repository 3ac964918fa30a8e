//! Reads a table of positions: where the sphere was, a line a frame.

use std::collections::BTreeMap;
use std::path::Path;

use super::campaign::Shown;
use super::list::{Axis, Recording};
use super::parabola::Kind;
use super::rounded_times::{many_are_one, rounded_to, spaced_evenly};
use super::segments::segments;
use super::track::Track;
use crate::error::{quoted, unless_wrong, Error, Problem};
use crate::rounding::significant;
use crate::runs::{column, text_rows, whole_file, Column, Fields, Row, TextRow};
use crate::scene::TableFile;
use crate::units::{milliseconds, Dimension};

/// The columns of the table.
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

/// What a table of positions holds.
pub(super) struct Reading {
    /// heights upwards
    pub shown: Shown,
    /// how many objects fall
    pub falling: usize,
    /// what its times were rounded to in s, where its frames are taken as evenly spaced
    pub spaced: Option<f64>,
}

/// Reads the table of a recording. `axis` says where its heights point, unless the recording does; else pixels are counted
/// downwards and lengths upwards.
///
/// Of several objects the one that falls farthest is taken. Fails where a frame has two positions of one.
pub(super) fn read(recording: &Recording, axis: Option<Axis>) -> Result<Reading, Error> {
    let table = TableFile::named(None, &recording.file.to_string_lossy());
    let refused = |problems: Vec<Problem>| Error::input(&recording.file, problems);
    let (first, mut lines) = text_rows(&table)?;
    lines.insert(0, first);
    let trimmed = |line: &TextRow| line.cells.iter().map(|cell| cell.trim().to_owned()).collect();
    let names: Vec<Vec<String>> = lines.iter().take(1 + MOST_WORDS).map(trimmed).collect();
    let y_unit = recording.y_unit.as_deref();
    let Some(at) = names.iter().position(|names| has_known(&ours(names, y_unit))) else {
        let expected = "expected columns `frame`, `time_s` or `time_ms`, and `y_px`, `y_mm` or `y_m`";
        let problem = Problem::new("header", expected).on(1u64);
        return Err(refused(vec![problem.found(shown(&names[0]))]));
    };
    let ours = ours(&names[at], y_unit);
    let fields = fields_of(&names[at], &ours, lines[at].line, recording.frame_rate);
    let mut fields = fields.map_err(refused)?;
    let (mut words, mut seen) = (at, vec![]);
    for line in &lines[at + 1..] {
        let Some(cells) = fields.cells(line, true) else {
            continue;
        };
        // a line of units
        if seen.is_empty() && words < MOST_WORDS && has_no_number(&fields, &cells) {
            words += 1;
            continue;
        }
        seen.extend(position(&mut fields, (line.line, &cells), recording.frame_rate));
    }
    let in_pixels = fields.has("y_px");
    let usual = if in_pixels { Axis::Down } else { Axis::Up };
    let axis = recording.axis.or(axis).unwrap_or(usual);
    let counted_from = (!fields.has("time")).then_some(0);
    let (problems, _) = fields.finish();
    unless_wrong(problems, ()).map_err(refused)?;
    let (mut track, object, falling) =
        farthest_falling(seen, axis, counted_from.is_none()).map_err(|problem| refused(vec![problem]))?;
    let rate = recording.frame_rate.filter(|_| counted_from.is_none());
    let even = rate.and_then(|rate| spaced_evenly(&track.times, rate));
    let spaced = even.map(|even| {
        track.times = even.times;
        even.step
    });
    let shown = Shown {
        frames: track.times.len(),
        track,
        in_pixels,
        diameter: None,
        counted_from,
        object,
    };
    Ok(Reading { shown, falling, spaced })
}

struct Seen {
    line: u64,
    time: f64,
    height: f64,
    object: String,
}

/// The columns of a header, with its names as they are ours. Fails where it lacks one.
fn fields_of(names: &[String], ours: &[String], line: u64, frame_rate: Option<f64>) -> Result<Fields, Vec<Problem>> {
    let fields = Fields::of(&COLUMNS, ours, line)?;
    let mut problems = vec![];
    let mut lacks = |expected: &str| {
        problems.push(Problem::new("header", expected).on(line).found(shown(names)));
    };
    if !fields.has("frame") && !fields.has("time") {
        lacks("expected a column `frame`, `time_s` or `time_ms`");
    } else if !fields.has("time") && frame_rate.is_none() {
        lacks("expected a column `time_s`, or `frame_rate_Hz` in the list of recordings");
    }
    if fields.has("y_px") == fields.has("y") {
        let without_unit = ours.iter().any(|name| name == "y");
        lacks(if without_unit {
            "expected the unit of `y`: px, mm, cm or m as `y_unit` in the list of recordings"
        } else {
            "expected one column of heights: `y_px`, `y_mm` or `y_m`"
        });
    }
    unless_wrong(problems, fields)
}

fn has_no_number(fields: &Fields, cells: &[&str]) -> bool {
    let mut read = fields.read_cells(cells);
    read.all(|cell| !cell.contains(|c: char| c.is_ascii_digit()))
}

/// The position of a row; `None` of a frame in which nothing was found.
fn position(fields: &mut Fields, row: Row, frame_rate: Option<f64>) -> Option<Seen> {
    let of_time = if fields.has("time") { "time" } else { "frame" };
    let of_height = if fields.has("y_px") { "y_px" } else { "y" };
    let rate = frame_rate.filter(|_| of_time == "frame");
    let (time, height) = (number(fields, of_time, row), number(fields, of_height, row));
    let object = fields.word("object", row.1);
    Some(Seen {
        line: row.0,
        time: time? / rate.unwrap_or(1.0),
        height: height?,
        object: object.unwrap_or_default().to_owned(),
    })
}

fn number(fields: &mut Fields, field: &'static str, row: Row) -> Option<f64> {
    // what a tracker writes where it found nothing
    let word = fields.word(field, row.1)?;
    if word.eq_ignore_ascii_case("nan") {
        return None;
    }
    fields.checked_number(field, row, |number, unit| {
        let is_large = number.abs() > LARGEST;
        (!is_large)
            .then(|| unit.to_si(number))
            .ok_or_else(|| format!("expected a number from -{LARGEST:e} to {LARGEST:e}"))
    })
}

/// Whether one of some names, as they are ours, is that of a column, or would be if its unit were known.
fn has_known(names: &[String]) -> bool {
    let is_of = |name: &str| COLUMNS.iter().any(|column| column.unit_of(name).is_some());
    names.iter().any(|name| name == "y" || is_of(name))
}

/// The names of a header as ours, where they are those of a program that tracks; a `y` is in this unit.
fn ours(names: &[String], y_unit: Option<&str>) -> Vec<String> {
    let ours = names.iter().map(|name| {
        let lower = name.to_lowercase();
        let known = THEIRS.iter().find(|(theirs, _)| *theirs == lower);
        let our = match known {
            Some((_, "y")) => format!("y{}", y_unit.map_or(String::new(), |unit| format!("_{unit}"))),
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

/// The names of a header in one message.
fn shown(names: &[String]) -> String {
    let named: Vec<&str> = names
        .iter()
        .map(String::as_str)
        .filter(|name| !name.is_empty())
        .collect();
    quoted(&named.join(", "))
}

/// The track of the object that falls farthest, where none does of the one that moves most; its name among several; and how
/// many fall.
fn farthest_falling(all: Vec<Seen>, axis: Axis, has_times: bool) -> Result<(Track, Option<String>, usize), Problem> {
    /// of the farthest fall, that another object's is no speck's
    const AS_FAR: f64 = 0.3;
    let mut objects: BTreeMap<String, Vec<Seen>> = BTreeMap::new();
    for seen in all {
        objects.entry(seen.object.clone()).or_default().push(seen);
    }
    let several = objects.len() > 1;
    let mut falls = vec![];
    let mut best: Option<([f64; 2], Track, String)> = None;
    for (object, mut seen) in objects {
        seen.sort_by(|a, b| a.time.total_cmp(&b.time));
        if let Some(pair) = seen.windows(2).find(|pair| pair[0].time == pair[1].time) {
            let [times, heights] =
                [|of: &Seen| of.time, |of: &Seen| of.height].map(|of| seen.iter().map(of).collect::<Vec<_>>());
            let step = rounded_to(&times).filter(|_| has_times && many_are_one(&times, &heights));
            let expected = match step {
                Some(step) => format!(
                    "has the time of line {}, since times are rounded to {} ms: expected more digits, or a column `frame` and \
                     `frame_rate_Hz` in the list of recordings",
                    pair[0].line,
                    significant(milliseconds(step), 1)
                ),
                None => format!(
                    "the frame of line {} has another position: expected one, or a column `object` that tells two things apart",
                    pair[0].line
                ),
            };
            return Err(Problem::new("", expected).on(pair[1].line));
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
        if best.as_ref().is_none_or(|(most, ..)| moves > *most) {
            best = Some((moves, track, object));
        }
    }
    let Some(([farthest, _], track, object)) = best else {
        return Err(whole_file("no positions below the header", "one line a frame"));
    };
    let falling = falls.iter().filter(|fall| **fall > 0.0 && **fall > AS_FAR * farthest);
    Ok((track, several.then_some(object), falling.count()))
}

/// How far a track falls in one flight; 0 where it has none.
fn farthest_fall(track: &Track) -> f64 {
    let Some(sigma) = track.noise() else { return 0.0 };
    let flights = segments(track, sigma)
        .into_iter()
        .filter(|segment| segment.kind == Kind::Flight);
    let far = flights.map(|flight| {
        let [lowest, highest] = track.ends_within(&flight.frames);
        highest - lowest
    });
    far.fold(0.0, f64::max)
}

/// Whether a recording is a table by its name, and not frames.
pub(super) fn is_table(file: &Path) -> bool {
    !file.is_dir() && TableFile::named(None, &file.to_string_lossy()).has_known_ending()
}
