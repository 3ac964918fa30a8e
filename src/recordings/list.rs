//! Reads the list of recordings: a line each, with what was known when it was taken.

use std::path::{Path, PathBuf};

use super::air::SphereInAir;
use super::frames::FFMPEG;
use crate::error::{unless_wrong, Error, Problem};
use crate::files::is_video;
use crate::remark::Remark;
use crate::runs::{column, rows_by_fields, whole_file, words_for_no, Column, Fields, Row};
use crate::scene::TableFile;
use crate::units::Dimension;

/// A recording, and what is known of it beside what it shows; lengths in m.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// line of the list, from 1
    pub line: u64,
    /// what it is called: its `run`, else its file as the list names it
    pub run: String,
    /// a folder of frames, a multi-page TIFF or a table of positions
    pub file: PathBuf,
    /// name of the particle
    pub particle: String,
    /// name of the liquid; `None` of a dry plate
    pub liquid: Option<String>,
    /// D
    pub diameter: f64,
    /// δ; 0 of a dry plate
    pub film: f64,
    /// frames per second
    pub frame_rate: Option<f64>,
    /// pixels per metre, where it was measured
    pub scale: Option<f64>,
    /// of the particle in kg/m³, for the drag of the air
    pub density: Option<f64>,
    /// where the heights of its table point
    pub axis: Option<Axis>,
    /// unit of a column `y` of its table: px, mm, cm or m
    pub y_unit: Option<String>,
    /// why it is left out, where it is
    pub exclude: Option<String>,
}

impl Recording {
    /// Its sphere in air, with a density.
    pub fn in_air(&self, density: f64) -> SphereInAir {
        SphereInAir {
            diameter: self.diameter,
            density,
        }
    }
}

/// Where an axis of heights points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// away from the ground
    Up,
    /// towards it, as rows of an image are counted
    Down,
}

impl Axis {
    /// The one that a table or the command line writes so.
    pub fn named(word: &str) -> Option<Axis> {
        match word {
            "up" => Some(Axis::Up),
            "down" => Some(Axis::Down),
            _ => None,
        }
    }
}

/// What the heights of a table may be in.
pub(super) const Y_UNITS: [&str; 4] = ["px", "mm", "cm", "m"];

/// Frame rates that a camera may have, in Hz.
const FRAME_RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e7;

/// Smallest density of a sphere, in kg/m³: a smaller number is one in g/cm³.
const LEAST_DENSITY: f64 = 25.0;

/// The columns of the list.
const COLUMNS: [Column; 12] = [
    column("file", Dimension::One, true),
    column("run", Dimension::One, false),
    column("particle", Dimension::One, true),
    column("liquid", Dimension::One, false),
    column("diameter", Dimension::Length, true),
    column("film", Dimension::Thickness, false),
    column("frame_rate", Dimension::Frequency, false),
    column("scale", Dimension::ImageScale, false),
    column("density", Dimension::Density, false),
    column("y_axis", Dimension::One, false),
    column("y_unit", Dimension::One, false),
    column("exclude", Dimension::One, false),
];

/// Reads the list; files in it are beside it. Remarks name columns that are not read.
///
/// Fails, too, where what is named is no list but a recording.
pub(super) fn read(path: &Path) -> Result<(Vec<Recording>, Vec<Remark>), Error> {
    if is_video(path) || path.is_dir() {
        let expected = format!(
            "expected a list of recordings, a .csv with columns `file`, `particle`, `diameter_mm` and more, whose `file` is \
             a folder of frames; make them of a video with `{FFMPEG}`"
        );
        let place = if path.is_dir() { "a folder" } else { "a video" };
        return Err(Error::input(path, vec![Problem::new(place, expected)]));
    }
    let table = TableFile::named(None, &path.to_string_lossy());
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut fields, mut recordings) = rows_by_fields(&table, &COLUMNS, |fields, row| recording(folder, fields, row))?;
    refuse_twins(&recordings, &mut fields);
    keep_by_no(&mut recordings);
    let (mut problems, unread) = fields.finish();
    if recordings.is_empty() && problems.is_empty() {
        problems.push(whole_file("no recordings below the header", "one line a recording"));
    }
    unless_wrong(problems, ()).map_err(|problems| Error::input(path, problems))?;
    let text = format!("columns not read: {}", unread.join(", "));
    let next = "`wetcor track --help` lists those that are";
    let notice = (!unread.is_empty()).then(|| Remark::new("unknown_column", unread.len(), text, next));
    Ok((recordings, notice.into_iter().collect()))
}

/// The recording of a row; `None`, and a problem, where it cannot be read.
fn recording(folder: &Path, fields: &mut Fields, row: Row) -> Option<Recording> {
    let (line, cells) = row;
    let Some(file) = fields.word("file", cells) else {
        let expected = "expected a folder of frames, a TIFF or a table of positions";
        fields.problem(line, "file", None, expected.to_owned());
        return None;
    };
    // they go into the table of runs, which a spreadsheet may open
    for column in ["run", "exclude"] {
        let formula = fields
            .word(column, cells)
            .filter(|word| word.starts_with(['=', '+', '@']));
        if formula.is_some() {
            let expected = "expected a word that no spreadsheet takes for a formula".to_owned();
            fields.problem(line, column, formula, expected);
        }
    }
    let run = fields.word("run", cells).unwrap_or(file).to_owned();
    let exclude = fields.word("exclude", cells).map(str::to_owned);
    let of = fields.setting(row)?;
    let frame_rate = fields.number("frame_rate", row);
    if let Some(rate) = frame_rate.filter(|rate| !FRAME_RATES.contains(rate)) {
        let expected = "expected a rate from 0.001 to 1e7 Hz".to_owned();
        fields.problem(line, "frame_rate", Some(&rate.to_string()), expected);
    }
    let scale = fields.number("scale", row);
    let density = fields.number("density", row);
    if let Some(density) = density.filter(|density| *density < LEAST_DENSITY) {
        let expected = format!("expected at least {LEAST_DENSITY} kg/m^3: 2.15 g/cm^3 are 2150");
        fields.problem(line, "density", Some(&density.to_string()), expected);
    }
    let axis = fields.word("y_axis", cells);
    let read_axis = axis.and_then(Axis::named);
    if axis.is_some() && read_axis.is_none() {
        fields.problem(line, "y_axis", axis, "expected `up` or `down`".to_owned());
    }
    let y_unit = fields.word("y_unit", cells);
    if y_unit.is_some_and(|unit| !Y_UNITS.contains(&unit)) {
        let expected = format!("expected one of {}", Y_UNITS.join(", "));
        fields.problem(line, "y_unit", y_unit, expected);
    }
    Some(Recording {
        line,
        run,
        file: folder.join(file),
        particle: of.particle.to_owned(),
        liquid: of.liquid.map(str::to_owned),
        diameter: of.diameter?,
        film: of.film.unwrap_or(0.0),
        frame_rate,
        scale,
        density,
        axis: read_axis,
        y_unit: y_unit.map(str::to_owned),
        exclude,
    })
}

/// Keeps recordings whose `exclude` says no, where every word there says yes or no.
fn keep_by_no(recordings: &mut [Recording]) {
    let no = words_for_no(recordings.iter().filter_map(|recording| recording.exclude.as_deref()));
    for recording in recordings {
        recording.exclude = recording.exclude.take().filter(|word| !no.contains(word));
    }
}

/// Refuses two recordings of one name: messages and figures are told apart by it.
fn refuse_twins(recordings: &[Recording], fields: &mut Fields) {
    let mut named = std::collections::BTreeMap::new();
    for Recording { run, line, .. } in recordings {
        let first = *named.entry(run).or_insert(*line);
        if first != *line {
            let expected = format!("expected another name than that of line {first}");
            fields.problem(*line, "run", Some(run), expected);
        }
    }
}
