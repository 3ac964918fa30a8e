//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::model::simulate::{SimulatedRuns, Simulation, BLOCK, MOST_RUNS};
use wetcor::runs::{Existing, NewTable, RunWriter, TableFormat};
use wetcor::scene;
use wetcor::staging::{self, OutputPlace, Staging};

use super::messages::{print_after_writing, warn};
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = "\
Example:
  wetcor simulate datasets/mueller2016/scene.toml --runs 100000 --out runs.parquet
  wetcor simulate datasets/mueller2016/scene.toml --runs 100000000 --parts 16 --out runs

An existing file is kept unless --force is given; a scene, and the runs of a scene beside it, are never replaced.")]
pub(super) struct Simulate {
    /// The scene file
    scene: PathBuf,
    /// File to write, .csv or .parquet; with --parts, folder
    #[arg(long)]
    out: PathBuf,
    /// Write so many Parquet files, part-000.parquet and so on, into a new folder
    #[arg(long, value_name = "N", conflicts_with = "force", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    parts: Option<u64>,
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

/// Writes one file, or a folder of them.
pub(super) fn simulate(request: &Simulate, quiet: bool) -> Result<u8, Error> {
    match request.parts {
        Some(parts) => write_parts(request, parts, quiet),
        None => write_one(request, quiet),
    }
}

fn write_one(request: &Simulate, quiet: bool) -> Result<u8, Error> {
    let out = request.out.as_path();
    if TableFormat::of(out).is_none() {
        let text = format!("{}: expected a file ending in .csv or .parquet", out.display());
        return Err(Error::Usage(text));
    }
    let scene = scene::read(&request.scene)?;
    if let Some(reason) = scene::why_not_overwritten(out, &scene) {
        return Err(Error::Out {
            path: out.to_path_buf(),
            reason,
        });
    }
    let simulation = Simulation::new(&scene, request.runs)?;
    let existing = if request.force {
        Existing::Replaced
    } else {
        Existing::Kept
    };
    let mut writer = RunWriter::create(out, existing)?;
    let runs = simulation.under(request.seed);
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

/// Writes a folder of files, one after another, which together are one table.
fn write_parts(request: &Simulate, parts: u64, quiet: bool) -> Result<u8, Error> {
    let out = request.out.as_path();
    let scene = scene::read(&request.scene)?;
    let simulation = Simulation::new(&scene, request.runs)?;
    let runs = simulation.under(request.seed);
    if parts > runs.blocks() {
        return Err(Error::Usage(format!(
            "--parts: found {parts}, expected at most {} for {} runs: all parts but the last have {BLOCK} runs or more",
            runs.blocks(),
            simulation.runs()
        )));
    }
    let fail = |error| Error::io(out, "write", error);
    let check = |place: &OutputPlace| place.check_free("folder");
    let place = staging::prepare(out)?;
    check(&place)?;
    let making = Staging::beside(&place)?;
    // sorted, the names stand in the order of the parts
    let width = (parts - 1).to_string().len().max(3);
    let name = |part: u64| format!("part-{part:0width$}.parquet");
    let progress = Progress::bar("simulate", runs.blocks(), quiet);
    let mut written = 0;
    for part in 0..parts {
        let file = making.create(&name(part)).map_err(fail)?;
        let mut table = NewTable::begin(file, TableFormat::Parquet).map_err(fail)?;
        runs.encode(blocks_of(part, &runs, parts), TableFormat::Parquet, |block| {
            written += 1;
            progress.at(written);
            table.write(block).map_err(fail)
        })?;
        table.finish().map_err(fail)?;
    }
    drop(progress);
    making.put(check)?;
    told(&simulation, out, &format!("/{} to {}", name(0), name(parts - 1)), quiet)
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
