//! Writes runs, simulated ones a row at a time and in constant memory, whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::new_run::NewRun;
use super::parquet::ParquetRuns;
use crate::error::Error;
use crate::staging::{self, OutputPlace, Staging};

/// Rows gathered before a Parquet batch is written.
const BATCH: usize = 65_536;

enum TableFormat {
    Csv(BufWriter<File>),
    Parquet(Box<ParquetRuns<BufWriter<File>>>),
}

/// What becomes of a file that is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// it is kept, and nothing is written
    Kept,
    /// it is replaced
    Replaced,
}

/// Writes runs to a file that appears only once it is complete.
pub struct RunWriter<'a> {
    path: PathBuf,
    staging: Staging,
    existing: Existing,
    format: TableFormat,
    batch: Vec<NewRun<'a>>,
}

/// Writes a whole table of runs that is CSV already.
///
/// Fails as [`RunWriter::create`] does.
pub fn write_csv_whole(path: &Path, existing: Existing, bytes: &[u8]) -> Result<(), Error> {
    let place = free_place(path, existing)?;
    let staging = Staging::beside(&place)?;
    let written = staging.create_itself().and_then(|mut file| file.write_all(bytes));
    written.map_err(|error| Error::io(path, "write", error))?;
    staging.put(|place| allow(place, existing))
}

/// The place of a file, where it may be written.
///
/// Fails where there is no such folder, and where something stands there that is not to be replaced.
pub fn free_place(path: &Path, existing: Existing) -> Result<OutputPlace, Error> {
    let place = staging::prepare(path)?;
    if !place.path().parent().is_some_and(Path::is_dir) {
        let folder = path.parent().unwrap_or(path).display();
        let reason = format!("there is no folder {folder}");
        return Err(Error::io(
            path,
            "write",
            std::io::Error::new(std::io::ErrorKind::NotFound, reason),
        ));
    }
    allow(&place, existing)?;
    Ok(place)
}

impl<'a> RunWriter<'a> {
    /// Opens a file beside `path`; `.parquet` makes Parquet, anything else CSV.
    ///
    /// Fails where there is no such folder, and where something stands there that is not to be replaced.
    pub fn create(path: &Path, existing: Existing) -> Result<Self, Error> {
        let fail = |error: std::io::Error| Error::io(path, "write", error);
        let place = free_place(path, existing)?;
        let staging = Staging::beside(&place)?;
        let mut sink = BufWriter::new(staging.create_itself().map_err(fail)?);
        let parquet = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet"));
        let format = if parquet {
            let writer = ParquetRuns::new(sink).map_err(|reason| parquet_error(path, reason))?;
            TableFormat::Parquet(Box::new(writer))
        } else {
            writeln!(sink, "particle,liquid,{}", NewRun::NUMBERS.join(",")).map_err(fail)?;
            TableFormat::Csv(sink)
        };
        Ok(RunWriter {
            path: path.to_path_buf(),
            staging,
            existing,
            format,
            batch: vec![],
        })
    }

    /// Adds a run.
    pub fn write(&mut self, run: NewRun<'a>) -> Result<(), Error> {
        match &mut self.format {
            TableFormat::Csv(sink) => write_csv(sink, &run).map_err(|error| Error::io(&self.path, "write", error)),
            TableFormat::Parquet(writer) => {
                self.batch.push(run);
                if self.batch.len() < BATCH {
                    return Ok(());
                }
                let written = writer.write(&self.batch);
                self.batch.clear();
                written.map_err(|reason| parquet_error(&self.path, reason))
            }
        }
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<(), Error> {
        let path = self.path;
        match self.format {
            TableFormat::Csv(mut sink) => sink.flush().map_err(|error| Error::io(&path, "write", error))?,
            TableFormat::Parquet(mut writer) => {
                let last = if self.batch.is_empty() {
                    Ok(())
                } else {
                    writer.write(&self.batch)
                };
                last.and_then(|()| writer.finish())
                    .map_err(|reason| parquet_error(&path, reason))?;
            }
        }
        self.staging.put(|place| allow(place, self.existing))
    }
}

/// Fails where something stands that is not to be replaced.
fn allow(place: &OutputPlace, existing: Existing) -> Result<(), Error> {
    let refuse = |reason: &str| {
        Err(Error::Out {
            path: place.named().to_path_buf(),
            reason: reason.to_owned(),
        })
    };
    match place.path().symlink_metadata() {
        Ok(of) if !of.is_file() => refuse("exists and is no file"),
        Ok(_) if existing == Existing::Kept => refuse("exists; --force replaces it"),
        _ => Ok(()),
    }
}

fn parquet_error(path: &Path, reason: String) -> Error {
    Error::io(path, "write", std::io::Error::other(reason))
}

fn write_csv(sink: &mut impl Write, run: &NewRun) -> std::io::Result<()> {
    write!(sink, "{},{}", run.particle, run.liquid.unwrap_or(crate::scene::DRY))?;
    for number in run.numbers() {
        match number {
            Some(number) => write!(sink, ",{number}")?,
            None => write!(sink, ",")?,
        }
    }
    writeln!(sink)
}
