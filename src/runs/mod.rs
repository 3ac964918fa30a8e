//! Holds what was measured: runs as plain columns, checked cell by cell, screened with reasons, ordered by series.
//!
//! | file | job |
//! |---|---|
//! | `columns.rs` | matches a table's header with the columns runs can have |
//! | `row.rs` | checks one run and says which cell is wrong |
//! | `errors.rs` | holds the measurement errors of runs |
//! | `refusals.rs` | gathers what is wrong, cell by cell |
//! | `collect.rs` | gathers checked runs into columns and counts what was left out |
//! | `stream.rs` | reads an ordinary CSV a window of lines at a time |
//! | `claims.rs` | checks what a Parquet file claims to hold before memory is asked for |
//! | `typed.rs` | reads CSV and Parquet with polars, writes Parquet; with `claims.rs` the only file that names it |
//! | `text.rs` | reads CSV as text, to accept what a typed reader refuses or to name the bad cell |
//! | `series.rs` | orders runs by series |
//! | `part.rs` | takes a part of the runs |
//! | `write.rs` | writes simulated runs, a row at a time |

mod claims;
mod collect;
mod columns;
mod errors;
mod part;
mod refusals;
mod row;
mod series;
mod stream;
mod text;
mod typed;
mod write;

pub use collect::Screened;
pub use errors::MeasurementErrors;
pub use series::{DryGroup, FilmGroup, Runs, Series};
pub use write::{Existing, NewRun, RunWriter};

use std::path::Path;

use collect::Collected;

use crate::encoding::decode;
use crate::error::{Error, Problem};
use crate::notice::Notice;
use crate::scene::Scene;
use crate::seed::sha256;

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
/// Fails with every bad cell named by line, column and value; then nothing of the table is used.
pub fn read(scene: &Scene) -> Result<Table, Error> {
    let path = scene.data.runs.as_path();
    let parquet = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("parquet"));
    // the typed reader is fast and strict; where it balks, the text reader decides and names what it refuses
    let streamed = if parquet { None } else { read_stream(path, scene) };
    let (collected, sha256) = match streamed {
        Some(read) => read,
        None => read_whole(path, parquet, scene)?,
    };
    if collected.rows == 0 {
        let problem = if parquet {
            whole_file("the table has no rows", "one row a run")
        } else {
            whole_file("no runs below the header", "one line a run")
        };
        return Err(Error::input(path, vec![problem]));
    }
    Ok(Table {
        rows: collected.rows,
        screened: collected.screened(),
        notices: collected.notices(path),
        runs: series::arrange(collected.columns, scene),
        sha256,
    })
}

/// Puts simulated runs in order, as [`read`] does those of a file.
pub fn arrange(scene: &Scene, new: &[NewRun]) -> Runs {
    let mut columns = collect::Columns::default();
    let index = |position: Option<usize>| position.and_then(|i| u32::try_from(i).ok());
    for (run, row) in new.iter().zip(1..) {
        let particle = index(scene.particles.iter().position(|p| p.name == run.particle));
        let liquid = run
            .liquid
            .and_then(|name| index(scene.liquids.iter().position(|l| l.name == name)));
        columns.particle.push(particle.unwrap_or_default());
        columns.liquid.push(liquid.unwrap_or(collect::Columns::NO_LIQUID));
        columns.diameter.push(run.diameter);
        columns.film.push(run.film.map_or(0.0, |(film, _)| film));
        columns.film_ratio.push(run.film.map_or(f64::NAN, |(_, ratio)| ratio));
        columns.impact_speed.push(run.impact_speed);
        columns.restitution.push(run.restitution);
        columns.row.push(row);
    }
    series::arrange(columns, scene)
}

/// A problem of the file as a whole.
fn whole_file(found: &str, expected: &str) -> Problem {
    Problem {
        line: None,
        place: found.to_owned(),
        found: None,
        expected: format!("expected {expected}"),
    }
}

fn read_stream(path: &Path, scene: &Scene) -> Option<(Collected, String)> {
    // what is no file, a pipe say, can be read only once
    let about = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    let file = std::fs::File::open(path).ok()?;
    stream::read(file, about.len(), stream::WINDOW, scene)
}

fn read_whole(path: &Path, parquet: bool, scene: &Scene) -> Result<(Collected, String), Error> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read the runs", e))?;
    let refuse = |problems: Vec<Problem>| Error::input(path, problems);
    if bytes.is_empty() {
        let expected = if parquet {
            "a Parquet table with one row a run"
        } else {
            "a header line and one line a run"
        };
        return Err(refuse(vec![whole_file("the file is empty", expected)]));
    }
    let (collected, sha256) = rayon::join(
        || {
            if parquet {
                typed::read_parquet(&bytes, scene)
            } else {
                read_text(&bytes, scene)
            }
        },
        || sha256(&bytes),
    );
    Ok((collected.map_err(refuse)?, sha256))
}

fn read_text(bytes: &[u8], scene: &Scene) -> Result<Collected, Vec<Problem>> {
    let text = decode(bytes).map_err(|problem| vec![problem])?;
    let header = text::header(text)?;
    let plan = columns::Plan::new(&header.names, Some(header.line))?;
    text::read(text, &plan, scene)
}

/// Whether a path names a table of runs in a format that can be written.
pub fn can_write(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("csv") || e.eq_ignore_ascii_case("parquet"))
}

#[cfg(test)]
mod tests;
