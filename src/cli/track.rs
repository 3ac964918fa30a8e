//! Runs `wetcor track`: from recordings to a table of runs.

use std::path::{Path, PathBuf};

use clap::Args;
use wetcor::error::{file_name, named, Error};
use wetcor::recordings::{self, Axis, TrackOptions};
use wetcor::report::folder::{Contents, Destination};
use wetcor::report::tracking;
use wetcor::runs::free_place;
use wetcor::staging::Staging;

use super::messages::{print_after_writing, print_notices, status, warn};
use crate::progress::Progress;

/// Recordings of a kind that are named on the terminal; the report has all.
const MOST_NAMED: usize = 20;

/// Parts of the progress bar.
const PARTS: u64 = 1_000;

/// What `track` is asked.
#[derive(Args)]
#[command(after_help = include_str!("help/track.txt").trim_ascii_end())]
pub(super) struct Track {
    /// The list of recordings: .csv, .tsv, .txt or .xlsx (`book.xlsx#May` of several sheets)
    recordings: PathBuf,
    /// File to write, .csv
    #[arg(long)]
    out: PathBuf,
    /// Folder of a report to write, with a figure of every recording
    #[arg(long)]
    report: Option<PathBuf>,
    /// Where heights point that do not say so [default: pixels down, lengths up]
    #[arg(long, value_parser = read_axis)]
    y_axis: Option<Axis>,
    /// Make a run of every rebound, not of the first alone
    #[arg(long)]
    all_rebounds: bool,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

fn read_axis(word: &str) -> Result<Axis, String> {
    Axis::named(word).ok_or_else(|| "expected up or down".to_owned())
}

pub(super) fn track(request: &Track) -> Result<u8, Error> {
    let out = request.out.as_path();
    if !out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        return Err(Error::Usage(format!("{}: expected a file ending in .csv", named(out))));
    }
    let place = free_place(out, request.force)?;
    let list = request.recordings.as_path();
    let refuse = |reason: String| Error::out(out, reason);
    let same = |path: &Path| path.canonicalize().is_ok_and(|path| path == place.path());
    if same(list) {
        return Err(refuse("is the list of recordings".to_owned()));
    }
    if request
        .report
        .as_ref()
        .is_some_and(|folder| lies_in(place.path(), folder))
    {
        return Err(refuse("lies in the folder of the report".to_owned()));
    }
    let title = file_name(list);
    let destination = request
        .report
        .as_ref()
        .map(|folder| Destination::prepare(folder, Contents::Tracking, &title, &[list]))
        .transpose()?;
    let options = TrackOptions {
        axis: request.y_axis,
        all_rebounds: request.all_rebounds,
    };
    let progress = Progress::bar("track", PARTS);
    let campaign = recordings::track(list, options, &|share| progress.at((share * PARTS as f64) as u64))?;
    drop(progress);
    let mut listed = campaign.outcomes.iter().map(|outcome| &outcome.recording);
    if let Some(recording) = listed.find(|recording| same(&recording.file)) {
        return Err(refuse(format!(
            "is the recording of line {} in the list",
            recording.line
        )));
    }
    // both are written whole before either has its name
    let report = match &destination {
        Some(destination) => Some(destination.beside(tracking::files(&title, &campaign)?)?),
        None => None,
    };
    let table = Staging::beside(&place)?;
    table.write(&recordings::runs_table(&campaign.outcomes)?)?;
    if let Some((destination, report)) = destination.as_ref().zip(report) {
        destination.put(report)?;
    }
    table.put(|place| place.check_replaceable(request.force))?;
    let status = status(tracking::is_usable(&campaign));
    print_notices(&campaign.notices);
    if let Some(left) = tracking::drag_left(&campaign) {
        warn(&left);
    }
    warn_each(&tracking::doubts(&campaign), "such lines are in the report");
    warn_each(&tracking::left_out(&campaign), "are left out");
    let mut text = tracking::summary(&campaign)?;
    text.push_str(&format!("runs: {}\n", named(out)));
    if let Some(folder) = &request.report {
        text.push_str(&format!("report: {}\n", named(&folder.join("report.md"))));
    }
    print_after_writing(out, &text)?;
    Ok(status)
}

/// Names the first recordings of a kind, and counts the others.
fn warn_each(lines: &[String], what: &str) {
    for line in lines.iter().take(MOST_NAMED) {
        warn(line);
    }
    if lines.len() > MOST_NAMED {
        warn(&format!("{} more {what}", lines.len() - MOST_NAMED));
    }
}

/// Whether a file, from the root, is a folder or lies in it, whether they are there or not.
fn lies_in(file: &Path, folder: &Path) -> bool {
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let mut above = folder.ancestors();
    let there = above.find_map(|above| Some((folder.strip_prefix(above).ok()?, above.canonicalize().ok()?)));
    there.map_or_else(
        || file.starts_with(&folder),
        |(rest, found)| file.starts_with(found.join(rest)),
    )
}
