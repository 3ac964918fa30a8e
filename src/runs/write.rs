//! Writes runs, simulated ones a block at a time and in constant memory, whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::new_run::NewRun;
use super::parquet::ParquetRuns;
use crate::error::Error;
use crate::scene::DRY;
use crate::staging::{self, OutputPlace, Staging};

/// Format of a table that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// text, separated by commas
    Csv,
    /// a row group a block
    Parquet,
}

impl TableFormat {
    /// The format that the ending of a file's name stands for; `None` for any other ending.
    pub fn of(path: &Path) -> Option<TableFormat> {
        match path.extension()?.to_ascii_lowercase().to_str()? {
            "csv" => Some(TableFormat::Csv),
            "parquet" => Some(TableFormat::Parquet),
            _ => None,
        }
    }
}

/// An open file that runs are written to, block after block.
enum OpenTable {
    Csv(BufWriter<File>),
    Parquet(Box<ParquetRuns<BufWriter<File>>>),
}

impl OpenTable {
    /// Begins a table in an empty file.
    fn begin(file: File, format: TableFormat) -> io::Result<OpenTable> {
        let mut sink = BufWriter::new(file);
        Ok(match format {
            TableFormat::Csv => {
                writeln!(sink, "particle,liquid,{}", NewRun::NUMBERS.join(","))?;
                OpenTable::Csv(sink)
            }
            TableFormat::Parquet => OpenTable::Parquet(Box::new(ParquetRuns::new(sink).map_err(io::Error::other)?)),
        })
    }

    /// Adds a block of runs.
    fn write(&mut self, runs: &[NewRun]) -> io::Result<()> {
        match self {
            OpenTable::Csv(sink) => runs.iter().try_for_each(|run| {
                let cell = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
                let numbers = run.numbers().map(cell);
                let liquid = run.liquid.unwrap_or(DRY);
                writeln!(sink, "{},{liquid},{}", run.particle, numbers.join(","))
            }),
            OpenTable::Parquet(writer) => writer.write(runs).map_err(io::Error::other),
        }
    }

    fn finish(self) -> io::Result<()> {
        match self {
            OpenTable::Csv(mut sink) => sink.flush(),
            OpenTable::Parquet(writer) => writer.finish().map_err(io::Error::other),
        }
    }
}

/// Writes runs to a file that appears only once it is complete.
pub struct RunWriter {
    path: PathBuf,
    staging: Staging,
    replaces: bool,
    table: OpenTable,
}

/// The place of a file, where it may be written.
///
/// Fails where there is no such folder, and where something stands there that is no file, or one that it does not replace.
pub fn free_place(path: &Path, replaces: bool) -> Result<OutputPlace, Error> {
    let place = staging::prepare(path)?;
    if !place.path().parent().is_some_and(Path::is_dir) {
        let folder = path.parent().unwrap_or(path).display();
        let missing = io::Error::new(io::ErrorKind::NotFound, format!("there is no folder {folder}"));
        return Err(Error::io(path, "write", missing));
    }
    place.check_replaceable(replaces)?;
    Ok(place)
}

impl RunWriter {
    /// Opens a file beside `path`; `.parquet` makes Parquet, anything else CSV.
    ///
    /// Fails as [`free_place`] does.
    pub fn create(path: &Path, replaces: bool) -> Result<Self, Error> {
        let place = free_place(path, replaces)?;
        let staging = Staging::beside(&place)?;
        let format = TableFormat::of(path).unwrap_or(TableFormat::Csv);
        let table = staging
            .create_itself()
            .and_then(|file| OpenTable::begin(file, format))
            .map_err(|error| Error::io(path, "write", error))?;
        Ok(RunWriter {
            path: path.to_path_buf(),
            staging,
            replaces,
            table,
        })
    }

    /// Adds a block of runs.
    pub fn write(&mut self, runs: &[NewRun]) -> Result<(), Error> {
        let written = self.table.write(runs);
        written.map_err(|error| Error::io(&self.path, "write", error))
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<(), Error> {
        let path = self.path;
        self.table.finish().map_err(|error| Error::io(&path, "write", error))?;
        self.staging.put(|place| place.check_replaceable(self.replaces))
    }
}
