//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::ops::Range;
use std::path::Path;

use wetcor::error::{named, Error};
use wetcor::model::simulate::{SimulatedRuns, Simulation, BLOCK};
use wetcor::ranks::Ranks;
use wetcor::runs::{Existing, RunWriter, TableFormat, TableParts};
use wetcor::scene;
use wetcor::staging::{self, OutputPlace, Staging};

use super::messages::{print_after_writing, warn};
use crate::progress::Progress;

/// The runs to draw.
pub(super) struct RunsOrder<'p> {
    pub scene_file: &'p Path,
    /// file or folder to write
    pub out: &'p Path,
    /// in all; absent: the design's
    pub runs: Option<u64>,
    pub seed: u64,
}

/// Writes one file.
pub(super) fn simulate(order: &RunsOrder, existing: Existing, quiet: bool) -> Result<u8, Error> {
    let out = order.out;
    if TableFormat::of(out).is_none() {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(order.scene_file)?;
    if let Some(reason) = scene::why_not_overwritten(out, &scene) {
        return Err(Error::Out {
            path: out.to_path_buf(),
            reason,
        });
    }
    let simulation = Simulation::new(&scene, order.runs)?;
    let mut writer = RunWriter::create(out, existing)?;
    let runs = simulation.under(order.seed);
    let progress = Progress::bar("simulate", simulation.runs(), quiet);
    let mut blocks = 0..;
    runs.encode(0..runs.blocks(), writer.format(), |block| {
        progress.at(blocks.next().map_or(0, |block| block * BLOCK));
        writer.write(block)
    })?;
    writer.finish()?;
    drop(progress);
    told(&simulation, out, "", quiet)
}

/// Writes a folder of files; the ranks take a share of them each.
pub(super) fn simulate_parts(order: &RunsOrder, parts: u64, ranks: &Ranks, quiet: bool) -> Result<u8, Error> {
    let out = order.out;
    let scene = scene::read(order.scene_file)?;
    let simulation = Simulation::new(&scene, order.runs)?;
    let runs = simulation.under(order.seed);
    if parts > runs.blocks() {
        return Err(Error::Usage(format!(
            "--parts: found {parts}, expected at most {} for {} runs: all parts but the last have {BLOCK} runs or more",
            runs.blocks(),
            simulation.runs()
        )));
    }
    let fail = |error| Error::io(out, "write", error);
    let check = |place: &OutputPlace| place.check_free("folder");
    let making = if ranks.is_first() {
        let place = staging::prepare(out)?;
        check(&place)?;
        Some(Staging::beside(&place)?)
    } else {
        None
    };
    // the first rank makes the folder, and says where
    let folder = ranks.gather(1, |_| match &making {
        Some(making) => Ok(vec![TableParts::of(making, parts).map_err(fail)?]),
        None => Ok(vec![]),
    })?;
    let own = ranks.own(parts).into_iter().map(|part| blocks_of(part, &runs, parts));
    let own_blocks = own.map(|blocks| blocks.end - blocks.start).sum::<u64>();
    let progress = Progress::bar("simulate", own_blocks, quiet);
    let mut written = 0;
    ranks.gather(parts, |own| {
        own.into_iter()
            .map(|part| {
                let mut file = folder[0].begin(part).map_err(fail)?;
                runs.encode(blocks_of(part, &runs, parts), TableFormat::Parquet, |block| {
                    written += 1;
                    progress.at(written);
                    file.write(block).map_err(fail)
                })?;
                file.finish().map_err(fail)
            })
            .collect()
    })?;
    drop(progress);
    if let Some(making) = making {
        making.put(check)?;
        let names = [0, parts - 1].map(|part| folder[0].name(part));
        told(&simulation, out, &format!("/{} to {}", names[0], names[1]), quiet)?;
    }
    Ok(0)
}

/// The blocks of runs that a part holds.
fn blocks_of(part: u64, runs: &SimulatedRuns, parts: u64) -> Range<u64> {
    let begin = |part: u64| runs.blocks() * part / parts;
    begin(part)..begin(part + 1)
}

/// Says what was written, and what was not made.
fn told(simulation: &Simulation, out: &Path, inside: &str, quiet: bool) -> Result<u8, Error> {
    if !quiet {
        if simulation.left_out > 0 {
            warn(&format!(
                "{} combinations of film ratio and diameter not made: the scene's own screens would leave them out",
                simulation.left_out
            ));
        }
        let text = format!("{} simulated runs: {}{inside}\n", simulation.runs(), named(out));
        print_after_writing(out, &text)?;
    }
    Ok(0)
}
