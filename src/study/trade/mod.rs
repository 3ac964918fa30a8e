//! Measures, on a scene's own runs, what each way to its parameters costs and how far off it is.
//!
//! | file | job |
//! |---|---|
//! | `written.rs` | holds what is written to `trade.json` |
//! | `ways.rs` | names the ways |
//! | `ground.rs` | holds what all ways start from |
//! | `laws.rs` | parameters read off the fitted laws |
//! | `timed.rs` | goes one way and times it |
//! | `reference.rs` | makes the long run that the ways are held against |
//! | `misses.rs` | measures how far off a way is |
//! | `dominance.rs` | marks the ways that another beats |
//! | `report.rs` | writes the page, the figure and `trade.json` |
//!
//! The ways from the cheapest on: the two laws by least squares, the normal about the posterior's mode, the same with
//! importance weights, trajectories on few nodes, on as many as the default bound asks for, and on every row.

mod dominance;
mod ground;
mod laws;
mod misses;
mod reference;
pub mod report;
mod timed;
mod ways;
mod written;

use crate::error::Error;
use crate::findings;
use crate::findings::posterior::{decline, effort, Asked, Way};
use crate::model::parameters::Parameters;
use crate::runs::Table;
use crate::scene::Scene;
use dominance::mark_dominated;
use ground::Ground;
use misses::{linear_bias, rung};
use ways::Path;

pub use crate::report::folder::TRADE_SCHEMA as SCHEMA;
pub use ways::PATHS;
pub use written::{LinearBias, Marginal, Miss, Named, Reference, Rung, Trade};

/// Goes every way on the runs of a scene and holds each against a long run. `progress` is called after each way.
///
/// Fails where a prior leaves a parameter no room, where the runs are such that no posterior should be sampled, or where
/// the long run does not come off; the text says why.
pub fn measure(scene: &Scene, table: &Table, seed: u64, progress: &dyn Fn()) -> Result<Trade, Error> {
    let runs = &table.runs;
    let least_squares = findings::find(scene, table, seed, false);
    let asked = Asked {
        form: least_squares.form,
        way: Way::Nodes,
    };
    let parameters = Parameters::of(scene, runs, asked.form)?;
    if let Some(declined) = decline(runs, least_squares.least_squares(), &parameters) {
        return Err(Error::Usage(format!("nothing to trade: {}", declined.0.text)));
    }
    let ground = Ground {
        scene,
        table,
        seed,
        asked,
        parameters,
        effort: effort(scene),
    };
    let reference = ground.reference(&least_squares)?;
    progress();
    let mut rungs = vec![];
    for path in Path::ALL {
        let (seconds, answer) = ground.timed(path);
        rungs.push(rung(path, seconds, answer, &reference));
        progress();
    }
    mark_dominated(&mut rungs);
    Ok(Trade {
        schema: SCHEMA,
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        runs: runs.len(),
        threads: rayon::current_num_threads(),
        reference,
        rungs,
        linear_bias: least_squares.scaling.iter().filter_map(linear_bias).collect(),
    })
}
