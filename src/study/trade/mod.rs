//! Measures, on a scene's own runs, what each method for its parameters costs and how far off it is.
//!
//! | file | job |
//! |---|---|
//! | `results.rs` | holds the content of `trade.json` |
//! | `methods.rs` | names the methods |
//! | `setup.rs` | holds what all methods start from |
//! | `laws.rs` | parameters read off the fitted laws |
//! | `timed.rs` | runs one method and times it |
//! | `reference.rs` | makes the long run that the methods are held against |
//! | `errors.rs` | measures how far off a method is |
//! | `dominance.rs` | marks the methods that another beats |
//! | `report.rs` | writes the page, the figure and `trade.json` |
//!
//! The methods from the cheapest on: the two laws by least squares, the normal about the posterior's mode, the same with
//! importance weights, trajectories on few nodes, on as many as the default bound asks for, and on every row.

mod dominance;
mod errors;
mod laws;
mod methods;
mod reference;
pub mod report;
mod results;
mod setup;
mod timed;

use crate::error::Error;
use crate::findings;
use crate::findings::posterior::{effort, why_not_sampled, MethodChoice, SamplingSetup};
use crate::model::parameters::ModelParameters;
use crate::runs::Table;
use crate::scene::Scene;
use dominance::mark_dominated;
use errors::{linear_bias, rung};
use methods::TradedMethod;
use setup::TradeSetup;

pub use crate::report::folder::TRADE_SCHEMA as SCHEMA;
pub use methods::PATHS;
pub use results::{LinearBias, Marginal, MarginalError, NamedMarginal, Reference, Rung, Trade};

/// Runs every method on the runs of a scene and holds each against a long run. `progress` is called after each method.
///
/// Fails where a prior leaves a parameter no room, where the runs are such that no posterior should be sampled, or where
/// the long run does not come off; the text says why.
pub fn measure(scene: &Scene, table: &Table, seed: u64, progress: &dyn Fn()) -> Result<Trade, Error> {
    let runs = &table.runs;
    let least_squares = findings::fit_least_squares(scene, table, seed, false);
    let model = SamplingSetup {
        form: least_squares.form,
        method: MethodChoice::Nodes,
    };
    let parameters = ModelParameters::of(scene, runs, model.form)?;
    if let Some(declined) = why_not_sampled(runs, least_squares.least_squares(), &parameters) {
        return Err(Error::Usage(format!("nothing to trade: {}", declined.0.text)));
    }
    let ground = TradeSetup {
        scene,
        table,
        seed,
        model,
        parameters,
        effort: effort(scene),
    };
    let reference = ground.reference(&least_squares)?;
    progress();
    let mut rungs = vec![];
    for path in TradedMethod::ALL {
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
