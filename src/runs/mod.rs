//! Holds what was measured: runs as plain columns, checked cell by cell, screened with reasons, ordered by series.
//!
//! | file | job |
//! |---|---|
//! | `errors.rs` | holds the measurement errors of runs |
//! | `row.rs` | checks one run and says which cell is wrong |
//! | `columns.rs` | matches a table's header with the columns runs can have |
//! | `screen.rs` | says why a checked run is left out |
//! | `refusals.rs` | gathers what is wrong, cell by cell |
//! | `decimals.rs` | finds what separates columns and decimals |
//! | `collect.rs` | gathers checked runs into columns and counts what was left out |
//! | `text.rs` | reads CSV record by record, to accept what the fast reader refuses or to name the bad cell |
//! | `parquet_footer.rs` | checks the counts a Parquet file states before memory is allocated by them |
//! | `new_run.rs` | holds one run to be written |
//! | `parquet.rs` | reads and writes Parquet with polars; with `parquet_footer.rs` the only file that names it |
//! | `workbook.rs` | reads a sheet of a spreadsheet with calamine; the only file that names it |
//! | `stream.rs` | reads an ordinary CSV fast, a window of lines at a time on every thread |
//! | `film_groups.rs` | puts runs in groups of one film ratio, and measures how wide each is |
//! | `spheres.rs` | holds the spheres that have a k of their own |
//! | `series.rs` | orders runs by series |
//! | `impacts.rs` | computes of each run, once, what the laws and the energy balance read |
//! | `true_speeds.rs` | says how true speeds are distributed where measured ones err |
//! | `stated_errors.rs` | refuses runs without errors where errors are to be all that scatters them |
//! | `part.rs` | takes a part of the runs |
//! | `write.rs` | writes simulated runs, a row at a time |

mod collect;
mod columns;
mod decimals;
mod errors;
mod film_groups;
mod impacts;
mod new_run;
mod parquet;
mod parquet_footer;
mod part;
mod refusals;
mod row;
mod screen;
mod series;
mod spheres;
mod stated_errors;
mod stream;
mod text;
mod true_speeds;
mod workbook;
mod write;

pub use collect::Screened;
pub use errors::MeasurementErrors;
pub use film_groups::{rounded_film_ratio, FilmGroup, NEAR_NOMINAL, WIDEST};
pub use impacts::{by_film, Conditions};
pub use new_run::NewRun;
pub use series::{DryGroup, Impacts, Runs, Series};
pub use spheres::{diameter_in_mm, sphere_label, sphere_words, Sphere};
pub use true_speeds::{SharedSpeed, TrueSpeed, TrueSpeeds, GAP, MOST_SETTINGS};
pub use write::{Existing, RunWriter};

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use collect::Collected;
use refusals::{whole_file, Refused};

use crate::encoding;
use crate::error::{file_name, Error, Problem};
use crate::files::{self, Input, MOST_OF_LINE, MOST_OF_PARQUET, MOST_OF_PIPE, MOST_OF_WORKBOOK};
use crate::notice::Notice;
use crate::scene::{Scene, TableFile};
use crate::seed::{sha256, Hash};

/// Runs as read, with what a reader should know of them.
#[derive(Debug)]
pub struct Table {
    /// the runs in use, ordered by series
    pub runs: Runs,
    /// rows of the file
    pub rows: usize,
    /// rows left out, by reason
    pub screened: Vec<Screened>,
    /// what wants a second look
    pub notices: Vec<Notice>,
    /// SHA-256 of the file
    pub sha256: String,
}

/// Reads, checks and screens the runs of a scene.
///
/// Fails with every bad cell named by line, column and value, and where runs without measurement errors have no other
/// spread; then nothing of the table is used.
pub fn read(scene: &Scene) -> Result<Table, Error> {
    let mut tables = vec![];
    for file in &scene.data.runs {
        tables.push(read_table(file, scene)?);
    }
    let paths: Vec<&Path> = scene.data.runs.iter().map(|file| file.path.as_path()).collect();
    let (collected, notices, sha256) = joined(tables, &paths)?;
    let (rows, screened) = (collected.rows, collected.screened());
    let runs = impacts::arrange(collected.columns, scene);
    stated_errors::check_stated_errors(scene, &runs)?;
    Ok(Table {
        rows,
        screened,
        notices,
        runs,
        sha256,
    })
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

/// All tables as one, whose rows count on from table to table; with what is to be said of them, and the SHA-256 of the file
/// or, of several, that of their SHA-256, a line each.
fn joined(tables: Vec<(Collected, String)>, paths: &[&Path]) -> Result<(Collected, Vec<Notice>, String), Error> {
    let of_header = |((table, _), path): (&(Collected, String), &&Path)| {
        [table.unknown_columns(path), table.unheeded_columns(path)]
    };
    let mut notices: Vec<Notice> = tables.iter().zip(paths).flat_map(of_header).flatten().collect();
    let mut tables = tables.into_iter();
    let (mut all, mut sha256) = tables.next().unwrap_or_default();
    let mut hashes = format!("{sha256}\n");
    for ((table, hash), path) in tables.zip(&paths[1..]) {
        if table.has_film_ratio != all.has_film_ratio {
            let [with, without] = if all.has_film_ratio {
                [&paths[0], path]
            } else {
                [path, &paths[0]]
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
        all.extend(std::slice::from_ref(&table));
        hashes.push_str(&format!("{hash}\n"));
        sha256 = crate::seed::sha256(hashes.as_bytes());
    }
    notices.extend(all.above_one());
    Ok((all, notices, sha256))
}

/// Puts simulated runs in order, as [`read`] does those of a file.
pub fn arrange(scene: &Scene, new: &[NewRun]) -> Runs {
    let mut columns = collect::RunsAsRead::default();
    let index = |position: Option<usize>| position.and_then(|i| u32::try_from(i).ok());
    for (run, row) in new.iter().zip(1..) {
        let particle = index(scene.particles.iter().position(|p| p.name == run.particle));
        let liquid = run
            .liquid
            .and_then(|name| index(scene.liquids.iter().position(|l| l.name == name)));
        columns.particle.push(particle.unwrap_or_default());
        columns.liquid.push(liquid.unwrap_or(collect::RunsAsRead::NO_LIQUID));
        columns.diameter.push(run.diameter);
        columns.film.push(run.film.map_or(0.0, |(film, _)| film));
        columns.film_ratio.push(run.film.map_or(f64::NAN, |(_, ratio)| ratio));
        columns.impact_speed.push(run.impact_speed);
        columns.restitution.push(run.restitution);
        columns.row.push(row);
    }
    impacts::arrange(columns, scene)
}

/// What is being done, as a verb.
const READ: &str = "read the runs";

/// A table that can be read from its start more than once.
enum TableSource {
    /// a regular file, with its length
    File(File, u64),
    /// what a pipe held
    Held(Vec<u8>),
}

impl TableSource {
    fn open(path: &Path) -> Result<TableSource, Error> {
        Ok(match files::open(path, READ)? {
            Input::File(file, length) => TableSource::File(file, length),
            Input::Pipe(pipe) => TableSource::Held(pipe.read(path, MOST_OF_PIPE, READ)?),
        })
    }

    /// About how many bytes it has.
    fn length(&self) -> u64 {
        match self {
            TableSource::File(_, length) => *length,
            TableSource::Held(bytes) => bytes.len() as u64,
        }
    }

    /// From its start.
    fn reader(&mut self) -> std::io::Result<Box<dyn Read + Send + '_>> {
        Ok(match self {
            TableSource::File(file, _) => {
                file.rewind()?;
                Box::new(file)
            }
            TableSource::Held(bytes) => Box::new(bytes.as_slice()),
        })
    }
}

/// The fast reader is strict; where it balks, the text reader decides and names what it refuses.
fn read_csv(source: &mut TableSource, path: &Path, scene: &Scene) -> Result<(Collected, String), Error> {
    let fail = |error: std::io::Error| Error::io(path, READ, error);
    let length = source.length();
    let streamed = stream::read_streamed(source.reader().map_err(fail)?, length, stream::WINDOW, scene);
    if let Some(read) = streamed {
        return Ok(read);
    }
    // once to see that it is text, of which every later step is then sure, and once more for the runs
    let (mut hash, mut bytes) = (Hash::default(), 0);
    let checked = encoding::check(source.reader().map_err(fail)?, MOST_OF_LINE, |piece| {
        hash.update(piece);
        bytes += piece.len();
    });
    let checked = checked.map_err(fail)?;
    if bytes == 0 {
        let problem = whole_file("the file is empty", "a header line and one line a run");
        return Err(Error::input(path, vec![problem]));
    }
    checked.map_err(|problem| Error::input(path, vec![problem]))?;
    let separator = text::separator(source.reader().map_err(fail)?, &scene.data.naming).map_err(fail)?;
    let collected = read_text(source.reader().map_err(fail)?, separator, scene);
    let collected = collected.map_err(|refused| refuse(path, refused))?;
    Ok((collected, hash.finish()))
}

/// The runs of a CSV that was checked to be text.
fn read_text(source: impl Read, separator: u8, scene: &Scene) -> Result<Collected, Refused> {
    let mut text = text::Text::new(source, separator);
    let header = text.header()?;
    let layout = columns::TableLayout::new(&header.names, Some(header.line), &scene.data.naming)?;
    text.rows(&layout, scene)
}

fn read_parquet(source: TableSource, path: &Path, scene: &Scene) -> Result<(Collected, String), Error> {
    let bytes = match source {
        TableSource::File(mut file, length) => {
            // the end of the file says whether it is worth reading
            let end = parquet_footer::last_bytes(&mut file, length).map_err(|error| Error::io(path, READ, error))?;
            parquet::parquet_ends(&end).map_err(|problems| refuse(path, problems.into()))?;
            file.rewind().map_err(|error| Error::io(path, READ, error))?;
            files::read_file(&file, length, path, MOST_OF_PARQUET, READ)?
        }
        TableSource::Held(bytes) => bytes,
    };
    if bytes.is_empty() {
        let problem = whole_file("the file is empty", "a Parquet table with one row a run");
        return Err(Error::input(path, vec![problem]));
    }
    let (collected, sha256) = rayon::join(|| parquet::read_parquet(&bytes, scene), || sha256(&bytes));
    Ok((collected.map_err(|refused| refuse(path, refused))?, sha256))
}

fn read_workbook(source: TableSource, file: &TableFile, scene: &Scene) -> Result<(Collected, String), Error> {
    let path = file.path.as_path();
    let bytes = match source {
        TableSource::File(file, length) => files::read_file(&file, length, path, MOST_OF_WORKBOOK, READ)?,
        TableSource::Held(bytes) => bytes,
    };
    let (collected, sha256) = rayon::join(
        || workbook::read_workbook(&bytes, file.sheet.as_deref(), scene),
        || sha256(&bytes),
    );
    Ok((collected.map_err(|refused| refuse(&file.shown(), refused))?, sha256))
}

fn refuse(path: &Path, refused: Refused) -> Error {
    Error::Input {
        file: path.to_path_buf(),
        problems: refused.problems,
        count: refused.count,
    }
}

/// Whether a path names a table of runs in a format that can be written.
pub fn can_write(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("csv") || e.eq_ignore_ascii_case("parquet"))
}

#[cfg(test)]
mod tests;
