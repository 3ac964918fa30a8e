//! Runs `wetcor calibrate`: how often the intervals cover the truth, on simulated data.

use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::ranks::Ranks;
use wetcor::staging::{self, Staging};
use wetcor::study::coverage::DrawnSets;
use wetcor::study::{calibration, main_coverage};

use super::messages::print_after_writing;
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = "\
Examples:
  wetcor calibrate --out reports/calibration.md
  mpirun -n 4 wetcor calibrate --out reports/calibration.md

With mpirun, in a build with the feature `mpi`, the ranks take a share of the data sets each; the page is the same.")]
pub(super) struct Calibrate {
    /// File to write
    #[arg(long)]
    out: PathBuf,
    /// Data sets a design
    #[arg(long, default_value_t = calibration::SETS, value_parser = clap::value_parser!(u64).range(1..=calibration::MOST_SETS))]
    sets: u64,
    /// Seed of every use of chance
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(super) fn calibrate(request: &Calibrate, ranks: &Ranks, quiet: bool) -> Result<u8, Error> {
    let Calibrate { ref out, sets, seed } = *request;
    let of_main = main_coverage::SETS.min(sets);
    let own = |pieces: u64| ranks.own(pieces).len() as u64;
    let all = own(sets) * calibration::DESIGNS + own(of_main) * main_coverage::DESIGNS;
    let place = if ranks.is_first() {
        let place = staging::prepare(out)?;
        calibration::may_replace(&place)?;
        Some(place)
    } else {
        None
    };
    ranks.agree()?;
    let progress = Progress::bar("calibrate", all, quiet);
    let done = AtomicU64::new(0);
    let step = || progress.at(1 + done.fetch_add(1, Relaxed));
    let drawn = |sets| DrawnSets {
        sets,
        seed,
        ranks,
        progress: &step,
    };
    let table = calibration::measure(drawn(sets))?;
    let main = main_coverage::measure(drawn(of_main))?;
    let Some(place) = place else {
        return Ok(0);
    };
    let text = calibration::markdown(&table)? + "\n" + &main_coverage::markdown(&main)?;
    let staging = Staging::beside(&place)?;
    staging.write(text.as_bytes())?;
    staging.put(calibration::may_replace)?;
    drop(progress);
    if !quiet {
        print_after_writing(out, &format!("table: {}\n", named(out)))?;
    }
    Ok(0)
}
