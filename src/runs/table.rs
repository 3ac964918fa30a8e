//! Reads the tables of a scene, every run of them.

use std::path::Path;

use super::averaged::MOST_AVERAGED;
use super::collect::{columns_not_read, too_many_rows, Collected, Gathering, Screened};
use super::impacts;
use super::refusals::{whole_file, Refused};
use super::series::Runs;
use super::source::{TableSource, READ};
use super::stated_errors::check_stated_errors;
use super::told_twice::ComparedColumns;
use super::{csv, parquet, windows, workbook};
use crate::error::{file_name, Error, Problem};
use crate::notice::Notice;
use crate::scene::{Scene, TableFile};
use crate::seed::sha256;

/// Runs as read, with what a reader should know of them.
#[derive(Debug)]
pub struct Table {
    /// the runs in use, ordered by series: all, or few that stand for all
    pub runs: Runs,
    /// rows of the file; a row that is a mean counts as the runs that it stands for
    pub rows: usize,
    /// rows left out, by reason
    pub screened: Vec<Screened>,
    /// columns that tell the same thing
    pub compared: Vec<ComparedColumns>,
    /// what wants a second look
    pub notices: Vec<Notice>,
    /// SHA-256 of the file
    pub sha256: String,
}

/// Reads, checks and screens the runs of a scene.
///
/// Fails with every bad cell named by line, column and value, where runs without measurement errors have no other spread,
/// and where there are more than are kept; then nothing of the table is used.
pub fn read(scene: &Scene) -> Result<Table, Error> {
    let mut joined = Joined::default();
    let mut rows = 0;
    for file in &scene.data.runs {
        let (table, sha256) = read_table(file, scene)?;
        rows += table.rows;
        if let Some(problem) = too_many_rows(rows, scene) {
            return Err(Error::input(&file.path, vec![problem]));
        }
        joined.add((table, sha256), &file.path)?;
    }
    let compared = std::mem::take(&mut joined.compared);
    let (mut collected, mut notices, sha256) = joined.finish();
    let (rows, screened) = (collected.runs(), collected.screened());
    notices.extend(collected.drop_own_film_ratios());
    let runs = impacts::arrange(collected.columns, scene);
    check_stated_errors(scene, &runs)?;
    Ok(Table {
        rows,
        screened,
        notices,
        compared,
        runs,
        sha256,
    })
}

impl Table {
    /// Runs that no file has.
    pub fn of(runs: Runs) -> Table {
        Table {
            rows: runs.len(),
            runs,
            screened: vec![],
            compared: vec![],
            notices: vec![],
            sha256: String::new(),
        }
    }
}

/// Reads and checks one table; gives the SHA-256 of the file, too.
fn read_table(file: &TableFile, scene: &Scene) -> Result<(Collected, String), Error> {
    let path = file.path.as_path();
    let (parquet, workbook) = (file.ends_with(".parquet"), file.ends_with(TableFile::WORKBOOK));
    let mut source = TableSource::open(path)?;
    let read = if parquet {
        read_parquet(source, path, scene)?
    } else if workbook {
        read_workbook(source, file, scene)?
    } else {
        read_csv(&mut source, path, scene)?
    };
    if read.0.rows == 0 {
        let problem = if parquet || workbook {
            whole_file("the table has no rows", "one row a run")
        } else {
            whole_file("no runs below the header", "one line a run")
        };
        return Err(Error::input(path, vec![problem]));
    }
    Ok(read)
}

/// All tables as one, whose rows count on from table to table.
#[derive(Default)]
pub(super) struct Joined<'p> {
    all: Collected,
    first: Option<&'p Path>,
    notices: Vec<Notice>,
    /// the columns of each table that were not read
    unknown: Vec<(String, Vec<String>)>,
    /// columns that tell the same thing, of each table
    pub compared: Vec<ComparedColumns>,
    /// SHA-256 of each file
    hashes: Vec<String>,
}

impl<'p> Joined<'p> {
    /// Adds a table; only one is held beside those before it.
    pub fn add(&mut self, (table, sha256): (Collected, String), path: &'p Path) -> Result<(), Error> {
        self.unknown.push((file_name(path), table.unknown_columns().to_vec()));
        self.notices.extend(table.unheeded_columns(path));
        self.compared.extend(table.compared_columns());
        self.hashes.push(sha256);
        let Some(first) = self.first else {
            (self.first, self.all) = (Some(path), table);
            return check_averaged(&self.all, path);
        };
        if table.has_film_ratio != self.all.has_film_ratio {
            let [with, without] = if self.all.has_film_ratio {
                [first, path]
            } else {
                [path, first]
            };
            let expected = format!(
                "expected a column `film_ratio`, as {} has: runs of one scene all belong to nominal film ratios, or none does",
                file_name(with)
            );
            let problem = Problem {
                line: None,
                place: "header".to_owned(),
                found: None,
                expected,
            };
            return Err(Error::input(without, vec![problem]));
        }
        self.all.extend(std::slice::from_ref(&table));
        check_averaged(&self.all, path)
    }

    /// The runs, what is to be said of them, and the SHA-256 of the file or, of several, that of their SHA-256, a line each.
    pub fn finish(mut self) -> (Collected, Vec<Notice>, String) {
        self.notices.extend(self.all.labelled_rows());
        self.notices.extend(self.all.averaged_rows());
        self.notices.extend(self.all.above_one());
        self.notices.extend(columns_not_read(&self.unknown));
        let sha256 = match self.hashes.as_slice() {
            [only] => only.clone(),
            several => {
                let lines: String = several.iter().map(|hash| format!("{hash}\n")).collect();
                crate::seed::sha256(lines.as_bytes())
            }
        };
        (self.all, self.notices, sha256)
    }
}

/// Refuses tables whose means stand for more runs than are kept.
fn check_averaged(collected: &Collected, path: &Path) -> Result<(), Error> {
    if collected.has_too_many_averaged() {
        let found = "the rows are means of too many runs";
        let expected = format!("at most {MOST_AVERAGED} together");
        return Err(Error::input(path, vec![whole_file(found, &expected)]));
    }
    Ok(())
}

/// Where something is refused, the table is read once more: to see that it is text, and then in its order.
fn read_csv(source: &mut TableSource, path: &Path, scene: &Scene) -> Result<(Collected, String), Error> {
    let fail = |error: std::io::Error| Error::io(path, READ, error);
    let length = source.length();
    let separator = csv::separator(source.reader().map_err(fail)?, &scene.data.naming).map_err(fail)?;
    let table = csv::Csv::new(source.reader().map_err(fail)?, windows::WINDOW, separator);
    if let Some(read) = table.runs_at_once(scene, length, &mut Gathering::Whole) {
        return Ok(read);
    }
    source.check_text(path)?;
    let table = csv::Csv::new(source.reader().map_err(fail)?, windows::WINDOW, separator);
    table.runs_in_order(scene).map_err(|refused| refuse(path, refused))
}

fn read_parquet(source: TableSource, path: &Path, scene: &Scene) -> Result<(Collected, String), Error> {
    let bytes = source.parquet(path)?;
    let read = || parquet::read_parquet(&bytes, scene, 0, &mut Gathering::Whole);
    let (collected, sha256) = rayon::join(read, || sha256(&bytes));
    Ok((collected.map_err(|refused| refuse(path, refused))?, sha256))
}

pub(super) fn read_workbook(
    source: TableSource,
    file: &TableFile,
    scene: &Scene,
) -> Result<(Collected, String), Error> {
    let bytes = source.workbook(&file.path)?;
    let sheet = sheet(&bytes, file)?;
    let shown = file.of_sheet(&sheet.name).shown();
    let (collected, sha256) = rayon::join(|| workbook::read_sheet(sheet, scene), || sha256(&bytes));
    Ok((collected.map_err(|refused| refuse(&shown, refused))?, sha256))
}

pub(super) fn sheet(bytes: &[u8], file: &TableFile) -> Result<workbook::Sheet, Error> {
    let sheet = workbook::Sheet::read(bytes, file.sheet.as_deref());
    sheet.map_err(|problems| Error::input(&file.shown(), problems))
}

pub(super) fn refuse(path: &Path, refused: Refused) -> Error {
    Error::Input {
        file: path.to_path_buf(),
        problems: refused.problems,
        count: refused.count,
    }
}
