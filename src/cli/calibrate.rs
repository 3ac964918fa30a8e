//! Runs `wetcor calibrate`: how often the intervals cover the truth, on simulated data.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::error::{named, Error};
use wetcor::ranks::Ranks;
use wetcor::staging::{self, Staging};
use wetcor::study::{accuracy, calibration, main_coverage};

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
    // an accuracy takes about as long as a hundred data sets
    let of_accuracy = 100;
    let of_main = main_coverage::SETS.min(sets);
    let scenes = (sets.min(calibration::SETS) * accuracy::SCENES).div_ceil(calibration::SETS);
    let own = |pieces: u64| ranks.own(pieces).len() as u64;
    let all = own(sets) * calibration::DESIGNS + own(of_main) * main_coverage::DESIGNS + of_accuracy * own(scenes);
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
    let kept = accuracy::measure(scenes, seed, ranks, &|| {
        progress.at(of_accuracy + done.fetch_add(of_accuracy, Relaxed));
    })?;
    let Some(place) = place else {
        return Ok(0);
    };
    let text = calibration::markdown(&table) + "\n" + &main_coverage::markdown(&main) + &accuracy::markdown(&kept);
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
