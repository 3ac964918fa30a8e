//! Runs `wetcor trade`: what each method costs on a scene's runs, and how far off it is.

use std::path::{Path, PathBuf};

use clap::Args;
use wetcor::error::{named, Error};
use wetcor::report::folder::{Contents, Destination};
use wetcor::study::trade;
use wetcor::{runs, scene};

use super::messages::{print_after_writing, print_notices};
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = include_str!("help/trade.txt").trim_ascii_end())]
pub(super) struct Trade {
    /// The scene file
    scene: PathBuf,
    /// Folder to write [default: reports/<the scene's folder name>-trade]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Seed of every use of chance
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

pub(super) fn trade(request: &Trade) -> Result<u8, Error> {
    let scene = scene::read(&request.scene)?;
    let usual = || Path::new("reports").join(format!("{}-trade", scene.name));
    let out = request.out.clone().unwrap_or_else(usual);
    let destination = Destination::prepare(&out, Contents::Trade, &scene.title, &scene.inputs())?;
    let table = runs::read(&scene)?;
    let progress = Progress::bar("trade", trade::STEPS);
    let measured = trade::measure(&scene, &table, request.seed, &|| progress.add(1))?;
    drop(progress);
    let files = trade::report::files(&scene, &measured)?;
    destination.write(files)?;
    print_notices(&table.notices);
    let page = out.join("trade.md");
    let text = format!("{}trade: {}\n", trade::report::summary(&measured), named(&page));
    print_after_writing(&page, &text)?;
    Ok(0)
}
