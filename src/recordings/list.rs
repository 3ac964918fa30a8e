//! Reads the list of recordings: a line each, with what was known when it was taken.

use std::path::{Path, PathBuf};

use super::header::{find, Column, FoundColumns};
use crate::error::{quoted, Error, Problem};
use crate::notice::Notice;
use crate::runs::{each_row, word, CellNumbers, TakesRows};
use crate::scene::{name_is_allowed, TableFile, DRY, NAME_RULE};
use crate::units::{Dimension, MAGNITUDES, MAGNITUDE_EXPECTED};

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
    /// Both, as a table and the command line write them.
    pub const WORDS: [(&'static str, Axis); 2] = [("up", Axis::Up), ("down", Axis::Down)];

    fn named(word: &str) -> Option<Axis> {
        Self::WORDS
            .iter()
            .find(|(name, _)| *name == word)
            .map(|(_, axis)| *axis)
    }
}

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
    Exclude,
}

const fn column(base: &'static str, dimension: Dimension, needed: bool) -> Column {
    Column {
        base,
        dimension,
        needed,
    }
}

const COLUMNS: [Column; 11] = [
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
    column("exclude", Dimension::One, false),
];

/// Reads the list; files in it are beside it. Notices name columns that are not read.
pub(super) fn read(path: &Path) -> Result<(Vec<Recording>, Vec<Notice>), Error> {
    let table = TableFile::named(None, &path.to_string_lossy());
    let mut rows = Rows {
        folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
        found: FoundColumns::default(),
        numbers: CellNumbers::default(),
        recordings: vec![],
        problems: vec![],
    };
    each_row(&table, &mut rows)?;
    rows.problems.extend(rows.numbers.doubt());
    if rows.recordings.is_empty() && rows.problems.is_empty() {
        rows.problems.push(Problem {
            line: None,
            place: "no recordings below the header".to_owned(),
            found: None,
            expected: "expected one line a recording".to_owned(),
        });
    }
    rows.twins();
    if !rows.problems.is_empty() {
        return Err(Error::input(path, rows.problems));
    }
    let unread = rows.found.unread;
    let notice = (!unread.is_empty()).then(|| {
        Notice::new(
            "unknown_column",
            unread.len(),
            format!("columns not read: {}", unread.join(", ")),
            "`wetcor track --help` lists those that are",
        )
    });
    Ok((rows.recordings, notice.into_iter().collect()))
}

struct Rows {
    folder: PathBuf,
    found: FoundColumns,
    numbers: CellNumbers,
    recordings: Vec<Recording>,
    problems: Vec<Problem>,
}

impl TakesRows for Rows {
    fn header(&mut self, names: &[String], line: u64) -> Result<(), Vec<Problem>> {
        self.found = find(names, line, &COLUMNS)?;
        Ok(())
    }

    fn row(&mut self, line: u64, cells: &[&str]) {
        let before = self.problems.len();
        let recording = self.recording(line, cells);
        if let Some(recording) = recording.filter(|_| self.problems.len() == before) {
            self.recordings.push(recording);
        }
    }
}

impl Rows {
    fn problem(&mut self, line: u64, place: &str, found: Option<&str>, expected: String) {
        self.problems.push(Problem {
            line: Some(line),
            place: place.to_owned(),
            found: found.map(quoted),
            expected,
        });
    }

    fn word<'c>(&self, field: Field, cells: &[&'c str]) -> Option<&'c str> {
        let column = self.found.columns[field as usize].as_ref()?;
        word(cells.get(column.index)?)
    }

    /// The number in SI; a problem where it is none above zero.
    fn number(&mut self, field: Field, (line, cells): (u64, &[&str])) -> Option<f64> {
        let column = self.found.columns[field as usize].clone()?;
        let cell = cells.get(column.index)?;
        let expected = match self.numbers.read(cell, (line, &column.name)) {
            Ok(None) => return None,
            Ok(Some(value)) if value > 0.0 => {
                let value = column.to_si(value);
                if MAGNITUDES.contains(&value) {
                    return Some(value);
                }
                format!("expected {MAGNITUDE_EXPECTED}")
            }
            Ok(Some(_)) => "expected a number above 0".to_owned(),
            Err(expected) => expected,
        };
        self.problem(line, &column.name, Some(cell.trim()), expected);
        None
    }

    /// The name of a particle or a liquid; a problem where it may not be one.
    fn name(&mut self, field: Field, line: u64, name: &str) {
        if !name_is_allowed(name) {
            let place = COLUMNS[field as usize].base;
            self.problem(line, place, Some(name), format!("expected {NAME_RULE}"));
        }
    }

    fn recording(&mut self, line: u64, cells: &[&str]) -> Option<Recording> {
        let Some(file) = self.word(Field::File, cells) else {
            self.problem(
                line,
                "file",
                None,
                "expected a folder of frames, a TIFF or a table of positions".to_owned(),
            );
            return None;
        };
        let run = self.word(Field::Run, cells).unwrap_or(file).to_owned();
        let exclude = self.word(Field::Exclude, cells).map(str::to_owned);
        let particle = self.word(Field::Particle, cells);
        let Some(particle) = particle else {
            self.problem(line, "particle", None, format!("expected {NAME_RULE}"));
            return None;
        };
        self.name(Field::Particle, line, particle);
        let liquid = self.word(Field::Liquid, cells).filter(|liquid| *liquid != DRY);
        if let Some(liquid) = liquid {
            self.name(Field::Liquid, line, liquid);
        }
        let before = self.problems.len();
        let diameter = self.number(Field::Diameter, (line, cells));
        // the film of a dry plate is not read
        let film = if liquid.is_some() {
            self.number(Field::Film, (line, cells))
        } else {
            None
        };
        let frame_rate = self.number(Field::FrameRate, (line, cells));
        let scale = self.number(Field::Scale, (line, cells));
        let density = self.number(Field::Density, (line, cells));
        let axis = self.word(Field::YAxis, cells);
        let read_axis = axis.and_then(Axis::named);
        if axis.is_some() && read_axis.is_none() {
            self.problem(line, "y_axis", axis, "expected `up` or `down`".to_owned());
        }
        if self.problems.len() == before {
            if diameter.is_none() {
                self.problem(line, "diameter", None, "expected a number above 0".to_owned());
            }
            if liquid.is_some() && film.is_none() {
                self.problem(
                    line,
                    "film",
                    None,
                    "expected a number above 0, since there is a liquid".to_owned(),
                );
            }
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
            exclude,
        })
    }

    /// Refuses two recordings of one name: messages and figures are told apart by it.
    fn twins(&mut self) {
        let mut named = std::collections::BTreeMap::new();
        let mut twins = vec![];
        for recording in &self.recordings {
            match named.get(recording.run.as_str()) {
                Some(first) => twins.push((recording.line, recording.run.clone(), *first)),
                None => {
                    named.insert(recording.run.as_str(), recording.line);
                }
            }
        }
        for (line, run, first) in twins {
            self.problem(
                line,
                "run",
                Some(&run),
                format!("expected another name than that of line {first}"),
            );
        }
    }
}
