//! Runs `wetcor calibrate`: how often the intervals cover the truth, on simulated data.

use std::path::PathBuf;

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::ranks::Ranks;
use wetcor::staging::{self, Staging};
use wetcor::study::calibration::{self, DrawnSets};

use super::messages::print_after_writing;
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = include_str!("help/calibrate.txt").trim_ascii_end())]
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

pub(super) fn calibrate(request: &Calibrate, ranks: &Ranks) -> Result<u8, Error> {
    let Calibrate { ref out, sets, seed } = *request;
    let all = ranks.own(sets).len() as u64 * calibration::DESIGNS;
    let place = if ranks.is_first() {
        let place = staging::prepare(out)?;
        calibration::may_replace(&place)?;
        Some(place)
    } else {
        None
    };
    ranks.agree()?;
    let progress = Progress::bar("calibrate", all);
    let table = calibration::measure(DrawnSets {
        sets,
        seed,
        ranks,
        progress: &|| progress.add(1),
    })?;
    let Some(place) = place else {
        return Ok(0);
    };
    let staging = Staging::beside(&place)?;
    staging.write(calibration::markdown(&table)?.as_bytes())?;
    staging.put(calibration::may_replace)?;
    drop(progress);
    print_after_writing(out, &format!("table: {}\n", named(out)))?;
    Ok(0)
}
