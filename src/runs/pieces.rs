//! Divides tables into pieces that can be read each by itself.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::collect::{Collected, Gathering, RunsAsRead};
use super::source::{TableSource, READ};
use super::table::{read_workbook, refuse};
use super::{csv, parquet, windows};
use crate::error::Error;
use crate::scene::{Scene, TableFile};
use crate::seed::Hash;

/// Rows of a piece of a Parquet file; a table of another format is one piece.
const ROWS_OF_PIECE: usize = 1 << 23;

/// A piece of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// which of the scene's tables
    pub file: usize,
    rows: Range<usize>,
}

/// The pieces of the tables of a scene, in their order.
pub(super) struct Pieces {
    pub all: Vec<Piece>,
    /// about how many rows they have together
    pub rows: usize,
}

impl Pieces {
    /// `None` of tables that are to be read whole: one is a pipe, has numbers as texts in Parquet, or cannot be read, which
    /// reading it will tell.
    pub fn of(scene: &Scene) -> Option<Pieces> {
        let mut pieces = Pieces { all: vec![], rows: 0 };
        for (file, table) in scene.data.runs.iter().enumerate() {
            let rows = about_rows(table, scene)?;
            pieces.rows += rows;
            let step = if table.ends_with(".parquet") {
                ROWS_OF_PIECE
            } else {
                usize::MAX
            };
            let starts = (0..rows).step_by(step);
            pieces.all.extend(starts.map(|start| Piece {
                file,
                rows: start..start.saturating_add(step),
            }));
        }
        Some(pieces)
    }
}

/// About how many rows a table has, one at least.
fn about_rows(table: &TableFile, scene: &Scene) -> Option<usize> {
    /// a workbook has no more
    const MOST_OF_SHEET: usize = 1 << 20;
    // a pipe can be read only once
    let is_file = std::fs::metadata(&table.path).is_ok_and(|about| about.is_file());
    let mut source = is_file.then(|| TableSource::open(&table.path).ok()).flatten()?;
    let length = source.length();
    let rows = if table.ends_with(TableFile::WORKBOOK) {
        MOST_OF_SHEET
    } else if let (TableSource::File(file, _), true) = (&mut source, table.ends_with(".parquet")) {
        parquet::rows_in_parts(file, length, &scene.data.naming).ok()??
    } else {
        let separator = csv::separator(source.reader().ok()?, &scene.data.naming).ok()?;
        csv::Csv::new(source.reader().ok()?, windows::WINDOW, separator).about_rows(length)
    };
    (rows > 0).then_some(rows)
}

/// Reads pieces of tables.
#[derive(Default)]
pub(super) struct PieceReader {
    /// the Parquet file that was read last, and which it is: more than one piece may be of it
    held: Mutex<Option<(usize, Arc<Vec<u8>>)>>,
}

impl PieceReader {
    /// Reads a piece, and gives its runs away; `None` where a text is to be read whole.
    ///
    /// Fails with every bad cell of the piece.
    pub fn read(
        &self,
        piece: &Piece,
        scene: &Scene,
        mut take: &mut (dyn FnMut(RunsAsRead) + Send),
    ) -> Result<Option<Collected>, Error> {
        let table = &scene.data.runs[piece.file];
        let path = table.path.as_path();
        let mut gathering = Gathering::Blocks(&mut take);
        let mut collected = if table.ends_with(".parquet") {
            let bytes = self.parquet(piece.file, table)?;
            let read = parquet::read_parquet(&bytes, scene, piece.rows.clone(), &mut gathering);
            read.map_err(|refused| refuse(path, refused))?
        } else if table.ends_with(TableFile::WORKBOOK) {
            read_workbook(TableSource::open(path)?, table, scene)?.0
        } else {
            let fail = |error: std::io::Error| Error::io(path, READ, error);
            let mut source = TableSource::open(path)?;
            let length = source.length();
            let separator = csv::separator(source.reader().map_err(fail)?, &scene.data.naming).map_err(fail)?;
            let text = csv::Csv::new(source.reader().map_err(fail)?, windows::WINDOW, separator);
            match text.runs_at_once(scene, length, &mut gathering) {
                Some((collected, _)) => collected,
                // what is wrong, if anything, the whole tells
                None => return Ok(None),
            }
        };
        take(std::mem::take(&mut collected.columns));
        Ok(Some(collected))
    }

    fn parquet(&self, file: usize, table: &TableFile) -> Result<Arc<Vec<u8>>, Error> {
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, bytes)) = held.as_ref().filter(|(held, _)| *held == file) {
            return Ok(Arc::clone(bytes));
        }
        // no two are read at once, which a disk would not be the faster for
        let bytes = Arc::new(TableSource::open(&table.path)?.parquet(&table.path)?);
        *held = Some((file, Arc::clone(&bytes)));
        Ok(bytes)
    }
}

/// SHA-256 of a table.
pub(super) fn sha256_of(table: &TableFile) -> Result<String, Error> {
    const AT_ONCE: usize = 1 << 20;
    let fail = |error: std::io::Error| Error::io(&table.path, READ, error);
    let mut source = TableSource::open(&table.path)?;
    let mut reader = source.reader().map_err(fail)?;
    let (mut hash, mut bytes) = (Hash::default(), vec![0; AT_ONCE]);
    loop {
        match reader.read(&mut bytes) {
            Ok(0) => return Ok(hash.finish()),
            Ok(read) => hash.update(&bytes[..read]),
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(fail(error)),
        }
    }
}
