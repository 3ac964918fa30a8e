//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::path::PathBuf;

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::model::simulate::{Simulation, BLOCK, MOST_RUNS};
use wetcor::runs::{RunWriter, TableFormat};
use wetcor::scene;

use super::messages::{print_after_writing, warn};
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = include_str!("help/simulate.txt").trim_ascii_end())]
pub(super) struct Simulate {
    /// The scene file
    scene: PathBuf,
    /// File to write, .csv or .parquet
    #[arg(long)]
    out: PathBuf,
    /// Runs in all, spread evenly over the design [default: the design's repeats]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=MOST_RUNS))]
    runs: Option<u64>,
    /// Seed of every use of chance
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

pub(super) fn simulate(request: &Simulate) -> Result<u8, Error> {
    let out = request.out.as_path();
    if TableFormat::of(out).is_none() {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(&request.scene)?;
    if let Some(reason) = scene::why_not_overwritten(out, &scene) {
        return Err(Error::out(out, reason));
    }
    let simulation = Simulation::new(&scene, request.runs)?;
    let mut writer = RunWriter::create(out, request.force)?;
    let runs = simulation.under(request.seed);
    let progress = Progress::bar("simulate", simulation.runs());
    for block in 0..runs.blocks() {
        progress.at(block * BLOCK);
        writer.write(&runs.block(block))?;
    }
    writer.finish()?;
    drop(progress);
    if simulation.left_out > 0 {
        warn(&format!(
            "{} combinations of film ratio and diameter not made: the scene's own screens would leave them out",
            simulation.left_out
        ));
    }
    let text = format!("{} simulated runs: {}\n", simulation.runs(), named(out));
    print_after_writing(out, &text)?;
    Ok(0)
}
