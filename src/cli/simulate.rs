//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::path::Path;

use wetcor::error::{named, Error};
use wetcor::model::simulate::Simulation;
use wetcor::runs::{self, Existing, RunWriter};
use wetcor::scene;

use super::messages::{print_after_writing, warn};
use crate::progress::Progress;

/// The file to write.
pub(super) struct OutputFile<'p> {
    pub out: &'p Path,
    /// what becomes of a file that stands there
    pub existing: Existing,
}

pub(super) fn simulate(
    path: &Path,
    destination: OutputFile,
    runs: Option<u64>,
    seed: u64,
    quiet: bool,
) -> Result<u8, Error> {
    let OutputFile { out, existing } = destination;
    if !runs::can_write(out) {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(path)?;
    if let Some(reason) = scene::why_not_overwritten(out, &scene) {
        return Err(Error::Out {
            path: out.to_path_buf(),
            reason,
        });
    }
    let simulation = Simulation::new(&scene, runs)?;
    let mut writer = RunWriter::create(out, existing)?;
    let progress = Progress::bar("simulate", simulation.runs(), quiet);
    let mut count = 0u64;
    simulation.draw(seed, |run| {
        count += 1;
        if count.is_multiple_of(1 << 16) {
            progress.at(count);
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
        print_after_writing(out, &format!("{count} simulated runs: {}\n", named(out)))?;
    }
    Ok(0)
}
