//! Reads the list of recordings: a line each, with what was known when it was taken.

use std::path::{Path, PathBuf};

use super::frames::{is_video, FFMPEG};
use crate::error::{Error, Problem};
use crate::remark::Remark;
use crate::runs::{column, each_row, words_for_no, Column, Fields, TakesRows};
use crate::scene::{TableFile, DRY, NAME_RULE};
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
const FRAME_RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e9;

/// The columns of the list, by their place in [`COLUMNS`].
#[derive(Clone, Copy)]
enum Field {
    File,
    Run,
    Particle,
    Liquid,
    Diameter,
    Film,
    FrameRate,
    Scale,
    Density,
    YAxis,
    YUnit,
    Exclude,
}

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

/// Reads the list; files in it are beside it. Notices name columns that are not read.
///
/// Fails, too, where what is named is no list but a recording.
pub(super) fn read(path: &Path) -> Result<(Vec<Recording>, Vec<Remark>), Error> {
    if is_video(path) || path.is_dir() {
        let expected = format!(
            "expected a list of recordings, a .csv with columns `file`, `particle`, `diameter_mm` and more, whose `file` is \
             a folder of frames; make them of a video with `{FFMPEG}`"
        );
        let problem = Problem {
            line: None,
            place: if path.is_dir() { "a folder" } else { "a video" }.to_owned(),
            found: None,
            expected,
        };
        return Err(Error::input(path, vec![problem]));
    }
    let table = TableFile::named(None, &path.to_string_lossy());
    let mut rows = Rows {
        folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
        fields: Fields::new(&COLUMNS),
        recordings: vec![],
    };
    each_row(&table, &mut rows)?;
    rows.twins();
    rows.keep_by_no();
    let Rows { fields, recordings, .. } = rows;
    let (mut problems, unread) = fields.finish();
    if recordings.is_empty() && problems.is_empty() {
        problems.push(Problem {
            line: None,
            place: "no recordings below the header".to_owned(),
            found: None,
            expected: "expected one line a recording".to_owned(),
        });
    }
    if !problems.is_empty() {
        return Err(Error::input(path, problems));
    }
    let notice = (!unread.is_empty()).then(|| {
        Remark::new(
            "unknown_column",
            unread.len(),
            format!("columns not read: {}", unread.join(", ")),
            "`wetcor track --help` lists those that are",
        )
    });
    Ok((recordings, notice.into_iter().collect()))
}

struct Rows {
    folder: PathBuf,
    fields: Fields,
    recordings: Vec<Recording>,
}

impl TakesRows for Rows {
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.fields.header(names, line)
    }

    fn width(&self) -> Option<usize> {
        Some(self.fields.width())
    }

    fn refuse(&mut self, problem: Problem) {
        self.fields.refuse(problem);
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        let before = self.fields.problems();
        let recording = self.recording(line, cells);
        if let Some(recording) = recording.filter(|_| self.fields.problems() == before) {
            self.recordings.push(recording);
        }
    }
}

impl Rows {
    fn recording(&mut self, line: u64, cells: &[&str]) -> Option<Recording> {
        let row = (line, cells);
        let fields = &mut self.fields;
        let Some(file) = fields.word(Field::File as usize, cells) else {
            let expected = "expected a folder of frames, a TIFF or a table of positions";
            fields.problem(line, "file", None, expected.to_owned());
            return None;
        };
        let run = fields.word(Field::Run as usize, cells).unwrap_or(file).to_owned();
        let exclude = fields.word(Field::Exclude as usize, cells).map(str::to_owned);
        let Some(particle) = fields.name(Field::Particle as usize, row) else {
            fields.problem(line, "particle", None, format!("expected {NAME_RULE}"));
            return None;
        };
        let liquid = fields.name(Field::Liquid as usize, row).filter(|liquid| *liquid != DRY);
        let diameter = fields.needed_number(Field::Diameter as usize, row, "");
        // the film of a dry plate is not read
        let film = match liquid {
            Some(_) => fields.needed_number(Field::Film as usize, row, ", since there is a liquid"),
            None => None,
        };
        let frame_rate = fields.number(Field::FrameRate as usize, row);
        if let Some(rate) = frame_rate.filter(|rate| !FRAME_RATES.contains(rate)) {
            let expected = "expected a rate from 0.001 to 1e9 Hz".to_owned();
            fields.problem(line, "frame_rate", Some(&rate.to_string()), expected);
        }
        let scale = fields.number(Field::Scale as usize, row);
        let density = fields.number(Field::Density as usize, row);
        let axis = fields.word(Field::YAxis as usize, cells);
        let read_axis = axis.and_then(Axis::named);
        if axis.is_some() && read_axis.is_none() {
            fields.problem(line, "y_axis", axis, "expected `up` or `down`".to_owned());
        }
        let y_unit = fields.word(Field::YUnit as usize, cells);
        if y_unit.is_some_and(|unit| !Y_UNITS.contains(&unit)) {
            let expected = format!("expected one of {}", Y_UNITS.join(", "));
            fields.problem(line, "y_unit", y_unit, expected);
        }
        Some(Recording {
            line,
            run,
            file: self.folder.join(file),
            particle: particle.to_owned(),
            liquid: liquid.map(str::to_owned),
            diameter: diameter?,
            film: film.unwrap_or(0.0),
            frame_rate,
            scale,
            density,
            axis: read_axis,
            y_unit: y_unit.map(str::to_owned),
            exclude,
        })
    }

    /// Keeps recordings whose `exclude` says no, where every word there says yes or no.
    fn keep_by_no(&mut self) {
        let words = self
            .recordings
            .iter()
            .filter_map(|recording| recording.exclude.as_deref());
        let no = words_for_no(words);
        for recording in &mut self.recordings {
            recording.exclude = recording.exclude.take().filter(|word| !no.contains(word));
        }
    }

    /// Refuses two recordings of one name: messages and figures are told apart by it.
    fn twins(&mut self) {
        let mut named = std::collections::BTreeMap::new();
        for Recording { run, line, .. } in &self.recordings {
            let first = *named.entry(run).or_insert(*line);
            if first != *line {
                let expected = format!("expected another name than that of line {first}");
                self.fields.problem(*line, "run", Some(run), expected);
            }
        }
    }
}
