//! Divides tables into pieces that can be read each by itself.

use std::ops::Range;
use std::time::SystemTime;

use super::collect::{Collected, Gathering, RunsAsRead};
use super::csv::about_rows;
use super::parquet::{read_parquet, ParquetTable};
use super::source::{TableSource, READ};
use super::table::{read_workbook, refuse};
use crate::error::Error;
use crate::scene::{Scene, TableFile};

/// Rows of a piece of a Parquet file, at most; a table of another format is one piece.
const ROWS_OF_PIECE: usize = 1 << 21;

/// A piece of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// which of the scene's tables
    pub file: usize,
    /// of a Parquet table, its rows
    rows: Range<usize>,
}

/// The pieces of the tables of a scene, in their order.
pub(super) struct Pieces {
    pub all: Vec<Piece>,
    /// about how many rows they have together, rather too many than too few: of a workbook, as many as a sheet can have
    pub rows: usize,
    /// length of each file and when it was last written
    states: Vec<Option<FileState>>,
}

/// Length of a file and when it was last written.
type FileState = (u64, SystemTime);

fn state(table: &TableFile) -> Option<FileState> {
    let about = std::fs::metadata(&table.path).ok()?;
    Some((about.len(), about.modified().ok()?))
}

impl Pieces {
    /// `None` of tables that are to be read whole: one is a pipe, has numbers as texts in Parquet, or cannot be read, which
    /// reading it will tell.
    pub fn of(scene: &Scene) -> Option<Pieces> {
        let mut pieces = Pieces {
            all: vec![],
            rows: 0,
            states: scene.data.runs.iter().map(state).collect(),
        };
        for (file, table) in scene.data.runs.iter().enumerate() {
            let (parts, rows) = parts_with_rows(table, scene)?;
            pieces.rows += rows;
            // of equal length, as whoever reads them may take turns
            pieces.all.extend((0..parts).map(|part| Piece {
                file,
                rows: part * rows / parts..(part + 1) * rows / parts,
            }));
        }
        Some(pieces)
    }

    /// Fails where a file is no longer what it was before it was read: readings of it may then differ.
    pub fn check_unchanged(&self, scene: &Scene) -> Result<(), Error> {
        let mut tables = scene.data.runs.iter().zip(&self.states);
        match tables.find(|(table, before)| state(table) != **before) {
            Some((table, _)) => Err(changed(table)),
            None => Ok(()),
        }
    }
}

/// Says that a table was written while it was read.
fn changed(table: &TableFile) -> Error {
    Error::io(&table.path, READ, std::io::Error::other("it changed while it was read"))
}

/// How many parts a table has, and how many rows, about but one at least.
fn parts_with_rows(table: &TableFile, scene: &Scene) -> Option<(usize, usize)> {
    /// a workbook has no more
    const MOST_OF_SHEET: usize = 1 << 20;
    /// polars counts no more
    const MOST_OF_PARQUET: usize = u32::MAX as usize;
    // a pipe can be read only once
    let is_file = std::fs::metadata(&table.path).is_ok_and(|about| about.is_file());
    let mut source = is_file.then(|| TableSource::open(&table.path).ok()).flatten()?;
    let length = source.length();
    let (parts, rows) = if table.ends_with(TableFile::WORKBOOK) {
        (1, MOST_OF_SHEET)
    } else if table.ends_with(".parquet") {
        let parquet = ParquetTable::open(source.parquet(&table.path, u64::MAX).ok()?).ok()?;
        if parquet.rows > MOST_OF_PARQUET || parquet.has_number_texts(&scene.data.naming).ok()? {
            return None;
        }
        (parquet.rows.div_ceil(ROWS_OF_PIECE), parquet.rows)
    } else {
        (1, about_rows(source.reader().ok()?, length).ok()?)
    };
    (rows > 0).then_some((parts, rows))
}

impl Piece {
    /// Reads it, and gives its runs away; `None` where the table is to be read whole.
    ///
    /// Fails with every bad cell of the piece.
    pub fn read(
        &self,
        scene: &Scene,
        mut take: &mut (dyn FnMut(RunsAsRead) + Send),
    ) -> Result<Option<Collected>, Error> {
        let table = &scene.data.runs[self.file];
        let path = table.path.as_path();
        let mut gathering = Gathering::Blocks(&mut take);
        let mut source = TableSource::open(path)?;
        let read = if table.ends_with(TableFile::WORKBOOK) {
            Some(read_workbook(source, table, scene)?.0)
        } else if table.ends_with(".parquet") {
            let parquet = ParquetTable::open(source.parquet(path, u64::MAX)?);
            let parquet = parquet.map_err(|problems| Error::input(path, problems))?;
            let read = read_parquet(&parquet, scene, self.rows.clone(), &mut gathering);
            Some(read.map_err(|refused| refuse(path, refused))?)
        } else {
            let table = source.csv(path, &scene.data.naming).ok();
            let read = table.and_then(|table| table.runs(scene, &mut gathering).ok());
            read.map(|(collected, _)| collected)
        };
        // what is wrong, if anything, the whole tells
        Ok(read.map(|mut collected| {
            take(std::mem::take(&mut collected.columns));
            collected
        }))
    }

    /// What is wrong where it could be read once, and no more.
    pub fn changed(&self, scene: &Scene) -> Error {
        changed(&scene.data.runs[self.file])
    }
}
