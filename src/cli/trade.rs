//! Runs `wetcor trade`: what each method costs on a scene's runs, and how far off it is.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use wetcor::error::{named, Error};
use wetcor::report::folder::{Contents, Destination};
use wetcor::study::trade;
use wetcor::{runs, scene};

use super::messages::{print_after_writing, print_notices};
use crate::progress::Progress;

pub(super) fn run_trade(path: &Path, out: Option<PathBuf>, seed: u64, quiet: bool) -> Result<u8, Error> {
    let scene = scene::read(path)?;
    let out = out.unwrap_or_else(|| Path::new("reports").join(format!("{}-trade", scene.name)));
    let destination = Destination::prepare(&out, Contents::Trade, &scene.title, &scene.inputs())?;
    let table = runs::read(&scene)?;
    let progress = Progress::bar("trade", trade::STEPS, quiet);
    let done = AtomicU64::new(0);
    let measured = trade::measure(&scene, &table, seed, &|| progress.at(1 + done.fetch_add(1, Relaxed)))?;
    drop(progress);
    let files = trade::report::files(&scene, &measured)?;
    destination.write(files)?;
    print_notices(&table.notices, quiet);
    if !quiet {
        let page = out.join("trade.md");
        let text = format!("{}trade: {}\n", trade::report::summary(&measured), named(&page));
        print_after_writing(&page, &text)?;
    }
    Ok(0)
}
