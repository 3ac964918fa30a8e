//! Runs `wetcor simulate`: runs drawn from a scene's truth and design.

use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::model::simulate::{SimulatedRuns, Simulation, BLOCK, MOST_RUNS};
use wetcor::ranks::Ranks;
use wetcor::runs::{Existing, RunWriter, TableFormat, TableParts};
use wetcor::scene;
use wetcor::staging::{self, OutputPlace, Staging};

use super::messages::{print_after_writing, warn};
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = "\
Example:
  wetcor simulate datasets/mueller2016/scene.toml --runs 100000 --out runs.parquet
  mpirun -n 4 wetcor simulate datasets/mueller2016/scene.toml --runs 100000000 --parts 16 --out runs

An existing file is kept unless --force is given; a scene, and the runs of a scene beside it, are never replaced. With \
mpirun, in a build with the feature `mpi`, the ranks write a share of the parts each; the files are the same.")]
pub(super) struct Simulate {
    /// The scene file
    scene: PathBuf,
    /// File to write, .csv or .parquet; with --parts, folder
    #[arg(long)]
    out: PathBuf,
    /// Write so many Parquet files, part-000.parquet and so on, into a new folder
    #[arg(long, value_name = "N", conflicts_with = "force", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    pub(super) parts: Option<u64>,
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
pub(super) fn simulate(request: &Simulate, ranks: &Ranks, quiet: bool) -> Result<u8, Error> {
    match request.parts {
        Some(parts) => write_parts(request, parts, ranks, quiet),
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

/// Writes a folder of files; the ranks take a share of them each.
fn write_parts(request: &Simulate, parts: u64, ranks: &Ranks, quiet: bool) -> Result<u8, Error> {
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
