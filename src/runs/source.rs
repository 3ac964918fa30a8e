//! Opens a table of runs, and reads no more of it than a table of its format may have.

use std::borrow::Cow;
use std::fs::{File, Metadata};
use std::io::{Read, Seek};
use std::path::Path;
use std::time::SystemTime;

use super::csv::separator;
use super::parquet::ParquetBytes;
use super::records::Records;
use super::refusals::whole_file;
use crate::encoding;
use crate::error::Error;
use crate::files::{self, Input, MOST_OF_LINE, MOST_OF_PIPE, MOST_OF_WORKBOOK};
use crate::scene::Naming;
use crate::seed::Hashed;

/// What is being done, as a verb.
const READ: &str = "read the runs";

/// A table that can be read from its start more than once.
pub(super) enum TableSource {
    /// a regular file, with what was said of it when it was opened
    File(File, Metadata),
    /// what a pipe held
    Held(Vec<u8>),
}

impl TableSource {
    pub fn open(path: &Path) -> Result<TableSource, Error> {
        Ok(match files::open(path, READ)? {
            Input::File(file, _) => {
                let about = file.metadata().map_err(|error| Error::io(path, READ, error))?;
                TableSource::File(file, about)
            }
            Input::Pipe(pipe) => TableSource::Held(pipe.read(path, MOST_OF_PIPE, READ)?),
        })
    }

    /// About how many bytes it has.
    pub fn length(&self) -> u64 {
        match self {
            TableSource::File(_, about) => about.len(),
            TableSource::Held(bytes) => bytes.len() as u64,
        }
    }

    /// From its start.
    pub fn reader(&mut self, path: &Path) -> Result<Box<dyn Read + '_>, Error> {
        Ok(match self {
            TableSource::File(file, _) => {
                file.rewind().map_err(|error| Error::io(path, READ, error))?;
                Box::new(file)
            }
            TableSource::Held(bytes) => Box::new(bytes.as_slice()),
        })
    }

    /// As a CSV from its start, once it is known to be text; its columns are separated as the line that names them tells.
    pub fn csv(&mut self, path: &Path, naming: &Naming) -> Result<Records<Box<dyn Read + '_>>, Error> {
        self.check_text(path)?;
        let separator = self.separator(path, naming)?;
        self.separated_by(separator, path)
    }

    /// What separates the columns of a text.
    pub fn separator(&mut self, path: &Path, naming: &Naming) -> Result<u8, Error> {
        separator(self.reader(path)?, naming).map_err(|error| Error::io(path, READ, error))
    }

    /// As a CSV from its start, with this between its columns.
    pub fn separated_by(&mut self, separator: u8, path: &Path) -> Result<Records<Box<dyn Read + '_>>, Error> {
        Records::new(self.reader(path)?, separator).map_err(|error| Error::io(path, READ, error))
    }

    /// Checks that it is text, and not none at all.
    pub fn check_text(&mut self, path: &Path) -> Result<(), Error> {
        let checked = encoding::check(self.reader(path)?, MOST_OF_LINE);
        let checked = checked.map_err(|error| Error::io(path, READ, error))?;
        let bytes = checked.map_err(|problem| Error::input(path, vec![problem]))?;
        if bytes == 0 {
            let problem = whole_file("the file is empty", "a header line and one line a run");
            return Err(Error::input(path, vec![problem]));
        }
        Ok(())
    }

    /// As a Parquet table of at most so many bytes.
    pub fn parquet(&self, path: &Path, most: u64) -> Result<ParquetBytes<'_>, Error> {
        if self.length() == 0 {
            let problem = whole_file("the file is empty", "a Parquet table with one row a run");
            return Err(Error::input(path, vec![problem]));
        }
        let bytes = match self {
            TableSource::File(file, _) => ParquetBytes::File(file),
            TableSource::Held(bytes) => ParquetBytes::Held(bytes),
        };
        // the end of the file says whether it is worth reading
        bytes.check_mark().map_err(|problems| Error::input(path, problems))?;
        files::check_length(path, self.length(), most)?;
        Ok(bytes)
    }

    /// The SHA-256 of all of it. Fails where it is no longer what it was when it was opened: what was read may then be of
    /// something else.
    pub fn sha256(&mut self, path: &Path) -> Result<String, Error> {
        let fail = |error: std::io::Error| Error::io(path, READ, error);
        let mut hashed = Hashed::new(self.reader(path)?);
        std::io::copy(&mut hashed, &mut std::io::sink()).map_err(fail)?;
        let sha256 = hashed.sha256();
        match self {
            TableSource::File(file, before) if state(&file.metadata().map_err(fail)?) != state(before) => {
                Err(changed(path))
            }
            _ => Ok(sha256),
        }
    }

    /// All of a workbook.
    pub fn workbook(&mut self, path: &Path) -> Result<Cow<'_, [u8]>, Error> {
        Ok(match self {
            TableSource::File(file, about) => {
                file.rewind().map_err(|error| Error::io(path, READ, error))?;
                files::read_file(file, about.len(), path, MOST_OF_WORKBOOK, READ)?.into()
            }
            TableSource::Held(bytes) => bytes.as_slice().into(),
        })
    }
}

/// Length of a file and when it was last written, where that is known.
pub(super) fn state(about: &Metadata) -> (u64, Option<SystemTime>) {
    (about.len(), about.modified().ok())
}

/// Says that a table was written while it was read.
pub(super) fn changed(path: &Path) -> Error {
    Error::io(path, READ, std::io::Error::other("it changed while it was read"))
}
