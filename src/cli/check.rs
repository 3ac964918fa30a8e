//! Runs `wetcor check`: what was read, and what it can identify.

use std::path::PathBuf;

use clap::Args;
use wetcor::error::Error;
use wetcor::findings::{self, overview};
use wetcor::model::parameters::ModelParameters;
use wetcor::ranks::Ranks;
use wetcor::report;
use wetcor::{runs, scene};

use super::messages::{print_notices, print_result};
use crate::progress::Progress;

#[derive(Args)]
#[command(after_help = include_str!("help/check.txt").trim_ascii_end())]
pub(super) struct Check {
    /// The scene file
    scene: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn check(request: &Check) -> Result<u8, Error> {
    let scene = scene::read(&request.scene)?;
    let progress = Progress::spinner("read");
    let table = runs::read_any_number(&scene, runs::MOST_KEPT, &Ranks::alone());
    drop(progress);
    let table = table?;
    let least_squares = findings::fit_least_squares(&scene, &table, 1, false);
    // a prior that leaves a parameter no room would fail the fit
    ModelParameters::of(&scene, &table.runs, least_squares.form)?;
    let overview = overview::summarise_runs(&scene, &table, &least_squares);
    if request.json {
        print_result(&report::json::text(&overview)?)?;
    } else {
        print_notices(&overview.notices);
        print_result(&report::overview(&overview)?)?;
    }
    Ok(0)
}
