//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::path::Path;

use wetcor::error::{named, Error};
use wetcor::model::simulate::Simulation;
use wetcor::runs::{self, Existing, RunWriter};
use wetcor::scene;

use super::said::{say_of, warn};
use crate::progress::Progress;

pub(super) fn simulate(
    path: &Path,
    (out, existing): (&Path, Existing),
    runs: Option<u64>,
    seed: u64,
    quiet: bool,
) -> Result<u8, Error> {
    if !runs::can_write(out) {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(path)?;
    if let Some(reason) = scene::claim(out, (path, &scene)) {
        return Err(Error::Out {
            path: out.to_path_buf(),
            reason,
        });
    }
    let simulation = Simulation::new(&scene, runs)?;
    let mut writer = RunWriter::create(out, existing)?;
    let progress = Progress::bar("simulate", simulation.runs(), quiet);
    let mut written = 0u64;
    simulation.draw(seed, |run| {
        written += 1;
        if written.is_multiple_of(1 << 16) {
            progress.at(written);
        }
        writer.write(run)
    })?;
    writer.finish()?;
    drop(progress);
    if !quiet {
        if simulation.left_out > 0 {
            warn(&format!(
                "{} combinations of film ratio and diameter not made: the scene's own screens would leave them out",
                simulation.left_out
            ));
        }
        say_of(out, &format!("{written} simulated runs: {}\n", named(out)))?;
    }
    Ok(0)
}
