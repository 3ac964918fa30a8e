//! Writes simulated runs a row at a time, in constant memory, whole or not at all.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::typed::ParquetRuns;
use crate::error::Error;
use crate::unfinished;
use crate::units;

/// One run to be written; lengths in m, speeds in m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewRun<'a> {
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid; `None` for a dry run
    pub liquid: Option<&'a str>,
    /// D
    pub diameter: f64,
    /// δ and its nominal ratio to D; `None` for a dry run
    pub film: Option<(f64, f64)>,
    /// v
    pub impact_speed: f64,
    /// e; 0 where the run stuck
    pub restitution: f64,
}

impl NewRun<'_> {
    /// Names of the columns that hold numbers, in order.
    pub(super) const NUMBERS: [&'static str; 5] = [
        "diameter_mm",
        "film_um",
        "film_ratio",
        "impact_speed_m_s",
        "restitution",
    ];

    /// The numbers of a run in the units of [`NewRun::NUMBERS`].
    pub(super) fn numbers(&self) -> [Option<f64>; 5] {
        [
            Some(round(units::millimetres(self.diameter))),
            self.film.map(|(film, _)| round(units::micrometres(film))),
            self.film.map(|(_, ratio)| ratio),
            Some(self.impact_speed),
            Some(self.restitution),
        ]
    }
}

/// Twelve significant digits: undoes the last-digit noise of a change of unit.
fn round(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// Rows gathered before a Parquet batch is written.
const BATCH: usize = 65_536;

enum Format {
    Csv(BufWriter<tempfile::NamedTempFile>),
    Parquet(Box<ParquetRuns<BufWriter<std::fs::File>>>, tempfile::NamedTempFile),
}

/// Writes runs to a file that appears only once it is complete.
pub struct RunWriter<'a> {
    path: PathBuf,
    format: Format,
    batch: Vec<NewRun<'a>>,
    mark: unfinished::Mark,
}

impl<'a> RunWriter<'a> {
    /// Opens a file beside `path`; `.parquet` makes Parquet, anything else CSV.
    pub fn create(path: &Path) -> Result<Self, Error> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        // without the temporary file's name, which means nothing to anybody
        let fail = |error: std::io::Error| Error::io(path, "write", error.kind().into());
        if !folder.is_dir() {
            let reason = format!("there is no folder {}", folder.display());
            let error = std::io::Error::new(std::io::ErrorKind::NotFound, reason);
            return Err(Error::io(path, "write", error));
        }
        let file = tempfile::Builder::new()
            .prefix(".wetcor-")
            .tempfile_in(folder)
            .map_err(fail)?;
        let mark = unfinished::mark(file.path());
        let parquet = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet"));
        let format = if parquet {
            let sink = BufWriter::new(file.reopen().map_err(fail)?);
            let writer = ParquetRuns::new(sink).map_err(|reason| parquet_error(path, reason))?;
            Format::Parquet(Box::new(writer), file)
        } else {
            let mut sink = BufWriter::new(file);
            writeln!(sink, "particle,liquid,{}", NewRun::NUMBERS.join(",")).map_err(fail)?;
            Format::Csv(sink)
        };
        Ok(RunWriter {
            path: path.to_path_buf(),
            format,
            batch: vec![],
            mark,
        })
    }

    /// Adds a run.
    pub fn write(&mut self, run: NewRun<'a>) -> Result<(), Error> {
        match &mut self.format {
            Format::Csv(sink) => write_csv(sink, &run).map_err(|error| Error::io(&self.path, "write", error)),
            Format::Parquet(writer, _) => {
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
        let file = match self.format {
            Format::Csv(sink) => sink
                .into_inner()
                .map_err(|error| Error::io(&path, "write", error.into_error()))?,
            Format::Parquet(mut writer, file) => {
                if !self.batch.is_empty() {
                    writer
                        .write(&self.batch)
                        .map_err(|reason| parquet_error(&path, reason))?;
                }
                writer.finish().map_err(|reason| parquet_error(&path, reason))?;
                file
            }
        };
        let _hold = self.mark.hold();
        persist(file, &path)
    }
}

/// Gives a finished temporary file its name, readable as any new file is.
fn persist(file: tempfile::NamedTempFile, path: &Path) -> Result<(), Error> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // temporary files are made for their owner alone
        let permissions = std::fs::Permissions::from_mode(0o644);
        std::fs::set_permissions(file.path(), permissions).map_err(|error| Error::io(path, "write", error))?;
    }
    file.persist(path)
        .map(|_| ())
        .map_err(|error| Error::io(path, "write", error.error))
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
