//! Divides tables into pieces that can be read each by itself.

use std::ops::Range;

use super::collect::{Collected, Gathering};
use super::csv::about_rows;
use super::read_run::ReadRun;
use super::source::TableSource;
use super::table::read_rows;
use crate::error::Error;
use crate::scene::{Scene, TableFile};

/// Rows of a piece of a Parquet file, about; a table of another format is one piece.
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
}

impl Pieces {
    /// `None` of tables that are to be read whole: one is a pipe, or cannot be read, which reading it will tell.
    pub fn of(scene: &Scene) -> Option<Pieces> {
        let mut pieces = Pieces { all: vec![], rows: 0 };
        for (file, table) in scene.data.runs.iter().enumerate() {
            let (rows, count) = rows_of_pieces(table)?;
            pieces.rows += count;
            pieces.all.extend(rows.into_iter().map(|rows| Piece { file, rows }));
        }
        Some(pieces)
    }
}

/// The rows of each piece of a table, and about how many it has together, at least one.
fn rows_of_pieces(table: &TableFile) -> Option<(Vec<Range<usize>>, usize)> {
    /// a workbook has no more
    const MOST_OF_SHEET: usize = 1 << 20;
    // a pipe can be read only once
    let is_file = std::fs::metadata(&table.path).is_ok_and(|about| about.is_file());
    let mut source = is_file.then(|| TableSource::open(&table.path).ok()).flatten()?;
    if table.ends_with(".parquet") {
        let parquet = source.parquet(&table.path, u64::MAX).ok()?;
        return (parquet.rows > 0).then(|| (parquet.ranges(ROWS_OF_PIECE), parquet.rows));
    }
    let rows = if table.ends_with(TableFile::WORKBOOK) {
        MOST_OF_SHEET
    } else {
        let length = source.length;
        about_rows(source.reader(&table.path).ok()?, length).ok()?
    };
    (rows > 0).then(|| (std::iter::once(0..rows).collect(), rows))
}

impl Piece {
    /// Reads it, and gives its runs away. Fails with every bad cell of the piece.
    pub fn read(&self, scene: &Scene, mut take: &mut (dyn FnMut(Vec<ReadRun>) + Send)) -> Result<Collected, Error> {
        let file = &scene.data.runs[self.file];
        let mut source = TableSource::open(&file.path)?;
        let mut gathering = Gathering::Blocks(&mut take);
        let mut collected = read_rows(&mut source, file, scene, Some(self.rows.clone()), &mut gathering)?;
        take(std::mem::take(&mut collected.in_use));
        Ok(collected)
    }
}
