//! Runs `wetcor calibrate`: how often the intervals cover the truth, on simulated data.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::error::{named, Error};
use wetcor::staging::{self, Staging};
use wetcor::study::{accuracy, calibration, main_coverage};

use super::messages::print_after_writing;
use crate::progress::Progress;

pub(super) fn calibrate(out: &Path, sets: u64, seed: u64, quiet: bool) -> Result<u8, Error> {
    let place = staging::prepare(out)?;
    calibration::may_replace(&place)?;
    // an accuracy takes about as long as a hundred data sets
    let of_accuracy = 100;
    let of_main = main_coverage::SETS.min(sets);
    let all = sets * calibration::DESIGNS + of_main * main_coverage::DESIGNS + of_accuracy * accuracy::SCENES;
    let progress = Progress::bar("calibrate", all, quiet);
    let done = AtomicU64::new(0);
    let step = || progress.at(1 + done.fetch_add(1, Relaxed));
    let table = calibration::measure(sets, calibration::REPLICATES, seed, &step)?;
    let main = main_coverage::measure(of_main, seed, &step)?;
    let kept = accuracy::measure(accuracy::SCENES, seed, &|| {
        progress.at(of_accuracy + done.fetch_add(of_accuracy, Relaxed));
    })?;
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
