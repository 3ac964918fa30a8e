//! Opens a table of runs, and reads no more of it than a table of its format may have.

use std::fs::File;
use std::io::{Seek, Write};
use std::path::Path;

use super::csv::separator;
use super::parquet::ParquetTable;
use super::records::Records;
use super::refusals::whole_file;
use crate::encoding;
use crate::error::Error;
use crate::files::{self, Input, MOST_OF_LINE, MOST_OF_PIPE, MOST_OF_WORKBOOK};
use crate::scene::Naming;
use crate::seed::sha256_of;

/// What is being done, as a verb.
const READ: &str = "read the runs";

/// A table that can be read from its start more than once: a file, or a copy of what a pipe held.
pub(super) struct TableSource {
    file: File,
    /// how many bytes it has
    pub length: u64,
}

impl TableSource {
    pub fn open(path: &Path) -> Result<TableSource, Error> {
        Ok(match files::open(path, READ)? {
            Input::File(file, length) => TableSource { file, length },
            Input::Pipe(pipe) => {
                let bytes = files::read_pipe(&pipe, path, MOST_OF_PIPE, READ)?;
                let copied = tempfile::tempfile().and_then(|mut file| file.write_all(&bytes).map(|()| file));
                TableSource {
                    file: copied.map_err(|error| Error::io(path, READ, error))?,
                    length: bytes.len() as u64,
                }
            }
        })
    }

    /// From its start.
    pub fn reader(&mut self, path: &Path) -> Result<&mut File, Error> {
        self.file.rewind().map_err(|error| Error::io(path, READ, error))?;
        Ok(&mut self.file)
    }

    /// As a CSV from its start, once it is known to be text; its columns are separated as the line that names them tells.
    pub fn csv(&mut self, path: &Path, naming: &Naming) -> Result<Records<&mut File>, Error> {
        self.check_text(path)?;
        let separator = self.separator(path, naming)?;
        self.separated_by(separator, path)
    }

    /// What separates the columns of a text.
    pub fn separator(&mut self, path: &Path, naming: &Naming) -> Result<u8, Error> {
        separator(self.reader(path)?, naming).map_err(|error| Error::io(path, READ, error))
    }

    /// As a CSV from its start, with this between its columns.
    pub fn separated_by(&mut self, separator: u8, path: &Path) -> Result<Records<&mut File>, Error> {
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

    /// As a Parquet table of at most so many bytes, whose footer says whether it is one.
    pub fn parquet(&self, path: &Path, most: u64) -> Result<ParquetTable<'_>, Error> {
        if self.length == 0 {
            let problem = whole_file("the file is empty", "a Parquet table with one row a run");
            return Err(Error::input(path, vec![problem]));
        }
        let table = ParquetTable::open(&self.file).map_err(|problems| Error::input(path, problems))?;
        files::check_length(path, self.length, most)?;
        Ok(table)
    }

    /// The SHA-256 of all of it.
    pub fn sha256(&mut self, path: &Path) -> Result<String, Error> {
        sha256_of(self.reader(path)?).map_err(|error| Error::io(path, READ, error))
    }

    /// All of a workbook.
    pub fn workbook(&mut self, path: &Path) -> Result<Vec<u8>, Error> {
        let length = self.length;
        files::read_file(self.reader(path)?, length, path, MOST_OF_WORKBOOK, READ)
    }
}
