//! Runs `wetcor track`: from recordings to a table of runs.

use std::path::PathBuf;

use clap::Args;
use wetcor::error::{file_name, named, Error};
use wetcor::recordings::{self, Axis, TrackOptions};
use wetcor::report::folder::{Contents, Destination};
use wetcor::report::tracking;
use wetcor::runs::{free_place, write_csv_whole, Existing};

use super::messages::{print_after_writing, print_notices, warn};
use crate::progress::Progress;

/// Recordings that are named on the terminal where they are left out; the table of runs and the report have all.
const MOST_NAMED: usize = 20;

/// Parts of the progress bar.
const PARTS: u64 = 1_000;

/// What `track` is asked.
#[derive(Args)]
#[command(after_help = "\
Example:
  wetcor track recordings.csv --out runs.csv --report tracking

The list has a line a recording: `file`, `particle`, `diameter_mm`, with a liquid `liquid` and `film_um`; `frame_rate_Hz` \
unless positions have times; if known `scale_px_per_mm` (else by the diameter or by gravity), `density_kg_m3` (to take off the \
drag of the air), `y_axis` (`up` or `down`), `run` (its name) and `exclude` (a reason to leave it out).

A `file` is a folder of PNG, JPEG or TIFF frames in order of name, a TIFF of several pages, or a table of positions with \
`frame`, `time_s` or `time_ms`, one of `y_px`, `y_mm` and `y_m`, and `object` where it follows several. Frames of a video: \
ffmpeg -i drop.mp4 drop/%06d.png")]
pub(super) struct Track {
    /// The list of recordings: .csv, .tsv, .txt or .xlsx
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
    let known = Axis::WORDS.iter().find(|(name, _)| *name == word);
    known
        .map(|(_, axis)| *axis)
        .ok_or_else(|| "expected up or down".to_owned())
}

pub(super) fn track(request: &Track, quiet: bool) -> Result<u8, Error> {
    let out = request.out.as_path();
    if !out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
        return Err(Error::Usage(format!("{}: expected a file ending in .csv", named(out))));
    }
    let existing = if request.force {
        Existing::Replaced
    } else {
        Existing::Kept
    };
    free_place(out, existing)?;
    let list = request.recordings.as_path();
    let same = |path: &std::path::Path| path.canonicalize().ok();
    if same(out).is_some() && same(out) == same(list) {
        return Err(Error::Out {
            path: out.to_path_buf(),
            reason: "is the list of recordings".to_owned(),
        });
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
    let progress = Progress::bar("track", PARTS, quiet);
    let campaign = recordings::track(list, options, &|share| progress.at((share * PARTS as f64) as u64))?;
    drop(progress);
    if let Some(destination) = &destination {
        destination.write(tracking::files(&title, &campaign)?)?;
    }
    write_csv_whole(out, existing, &recordings::runs_table(&campaign.outcomes)?)?;
    print_notices(&campaign.notices, quiet);
    if quiet {
        return Ok(0);
    }
    if let Some(left) = tracking::drag_left(&campaign) {
        warn(&left);
    }
    let left_out = tracking::left_out(&campaign);
    for line in left_out.iter().take(MOST_NAMED) {
        warn(line);
    }
    if left_out.len() > MOST_NAMED {
        warn(&format!("{} more are left out", left_out.len() - MOST_NAMED));
    }
    let mut text = tracking::summary(&campaign);
    text.push_str(&format!("runs: {}\n", named(out)));
    if let Some(folder) = &request.report {
        text.push_str(&format!("report: {}\n", named(&folder.join("report.md"))));
    }
    print_after_writing(out, &text)?;
    Ok(0)
}
