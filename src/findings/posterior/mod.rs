//! Says what the posterior says: each parameter and what follows from it, and whether the sampling may be trusted.
//!
//! | file | job |
//! |---|---|
//! | `written.rs` | what is said, as `findings.json` writes it |
//! | `sampling.rs` | what is sampled and how |
//! | `tell.rs` | each parameter and what follows from it, in numbers |
//! | `contraction.rs` | the parameters that keep much of their prior |
//! | `derived.rs` | what follows from the parameters, draw by draw |
//! | `draws.rs` | the draws of a particle, for predictions and figures |
//! | `predictive.rs` | new runs beside the ones made |
//! | `trust.rs` | what must hold before the posterior is quoted |

pub(super) mod contraction;
pub mod derived;
mod draws;
pub mod predictive;
mod sampling;
mod tell;
pub(super) mod trust;
mod written;

use super::checks::Check;
use super::least_squares::LeastSquares;
use super::predict::Basis;
use crate::error::Error;
use crate::inference::accuracy::{sample_to_accuracy, AccuracyPlan};
use crate::inference::nuts::Watcher;
use crate::inference::sampling::{sample_posterior, Sampled, SamplingPlan};
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::Parameters;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::seed::StreamName;
use derived::Derived;
use tell::tell;

pub use sampling::{check_room, effort, start, Asked, Way, MOST_NUMBERS};
pub use trust::{decline, Declined};
pub use written::{Accuracy, Compression, LeftOut, PosteriorFindings, PriorTold, Quantity, Tried};

/// A posterior with its draws, for the report and the files of draws.
#[derive(Debug)]
pub struct Posterior {
    /// what was sampled
    pub asked: Asked,
    /// what is said
    pub findings: PosteriorFindings,
    /// the draws
    pub sampled: Sampled,
    /// the draws of what follows
    pub derived: Vec<Derived>,
    /// what must hold
    pub checks: Vec<Check>,
}

/// Samples the posterior from where least squares stands, and says what it says.
///
/// `Err` where a prior leaves no room, or the draws do not fit into memory; the inner `Err` where the runs are such that
/// nothing should be sampled.
pub fn find(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    asked: Asked,
    watcher: Watcher,
) -> Result<Result<Posterior, Declined>, Error> {
    let parameters = Parameters::of(scene, runs, asked.form)?;
    if let Some(declined) = trust::decline(runs, least_squares, &parameters) {
        return Ok(Err(declined));
    }
    let effort = effort(scene);
    check_room(effort, parameters.sampled.len() + derived::count(runs, asked.form))?;
    let rows = Likelihood::of_rows(scene, runs, asked.form);
    let stream = StreamName::new(least_squares.seed, "posterior");
    let plan = SamplingPlan {
        effort,
        stream,
        evaluation: asked.way.evaluation(),
    };
    let start = start(scene, least_squares);
    let sampled = match asked.way {
        Way::Accuracy(accuracy) => {
            let plan = AccuracyPlan {
                accuracy,
                effort,
                stream,
            };
            sample_to_accuracy(parameters, &rows, &start, plan, watcher)
        }
        Way::Nodes | Way::Rows => sample_posterior(parameters, &rows, &start, plan, watcher),
    };
    let sampled = match sampled {
        Ok(sampled) => sampled,
        Err(why) => return Ok(Err(trust::no_posterior(&why.to_string()))),
    };
    let derived = derived::find(scene, runs, asked.form, &sampled);
    let pointwise = Pointwise::new(scene, runs, asked.form);
    let predictive = predictive::find(scene, runs, &pointwise, &sampled.full_draws());
    let basis = Basis::of(scene, runs);
    let findings = tell(asked, effort, rows.nodes(), &sampled, &derived, (predictive, basis));
    let checks = trust::checks(&findings, least_squares);
    Ok(Ok(Posterior {
        asked,
        findings,
        sampled,
        derived,
        checks,
    }))
}
