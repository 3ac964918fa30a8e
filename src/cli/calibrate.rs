//! Runs `wetcor calibrate`: how often the intervals cover the truth, on simulated data.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::error::{named, Error};
use wetcor::ranks::Ranks;
use wetcor::staging::{self, Staging};
use wetcor::study::{calibration, main_coverage};

use super::messages::print_after_writing;
use crate::progress::Progress;

/// The page to make.
pub(super) struct PageOrder<'p> {
    pub out: &'p Path,
    /// data sets a design
    pub sets: u64,
    pub seed: u64,
}

pub(super) fn calibrate(order: &PageOrder, ranks: &Ranks, quiet: bool) -> Result<u8, Error> {
    let PageOrder { out, sets, seed } = *order;
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
    let table = calibration::measure(sets, calibration::REPLICATES, seed, ranks, &step)?;
    let main = main_coverage::measure(of_main, seed, ranks, &step)?;
    let Some(place) = place else {
        return Ok(0);
    };
    let text = calibration::markdown(&table) + "\n" + &main_coverage::markdown(&main);
    let staging = Staging::beside(&place)?;
    let result = staging
        .create_itself()
        .and_then(|mut file| file.write_all(text.as_bytes()));
    result.map_err(|error| Error::io(out, "write", error))?;
    staging.put(calibration::may_replace)?;
    drop(progress);
    if !quiet {
        print_after_writing(out, &format!("table: {}\n", named(out)))?;
    }
    Ok(0)
}
