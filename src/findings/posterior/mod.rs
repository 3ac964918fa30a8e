//! Says what the posterior says: each parameter and what follows from it, and whether the sampling may be trusted.
//!
//! | file | job |
//! |---|---|
//! | `written.rs` | what is said, as `findings.json` writes it |
//! | `tell.rs` | each parameter and what follows from it, in numbers |
//! | `contraction.rs` | the parameters that keep much of their prior |
//! | `derived.rs` | what follows from the parameters, draw by draw |
//! | `predictive.rs` | new runs beside the ones made |
//! | `trust.rs` | what must hold before the posterior is quoted |

mod contraction;
pub mod derived;
pub mod predictive;
mod tell;
pub(super) mod trust;
mod written;

use super::predict::Basis;
use super::verdicts::Check;
use super::Findings;
use crate::error::Error;
use crate::inference::accuracy::sample_to;
use crate::inference::nuts::{Effort, Watcher, TARGET_ACCEPT};
use crate::inference::posed::{Evaluation, Start};
use crate::inference::sampling::{sample_posterior, Plan, Sampled};
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{Kind, Parameters};
use crate::notice::Notice;
use crate::physics::impact::Form;
use crate::runs::Runs;
use crate::scene::Scene;
use derived::Derived;
use tell::tell;

pub use trust::decline;
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
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// Why no posterior was sampled, though it was asked for; the check fails and gates.
#[derive(Debug)]
pub struct Declined(pub Check);

impl Declined {
    /// Its check among all, if nothing was sampled.
    pub fn among(checks: &[Check]) -> Option<&Check> {
        checks.iter().find(|check| trust::DECLINED.contains(&check.check))
    }
}

/// What is sampled, and how.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// the terms of the energy balance
    pub form: Form,
    /// how
    pub way: Way,
}

/// The way to the draws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Way {
    /// as the scene's `[sampler]` says, on nodes
    #[default]
    Nodes,
    /// the same, on every row
    Rows,
    /// the cheapest that vouches for this accuracy
    Accuracy(f64),
}

impl Way {
    /// What stands for the runs where trajectories are followed.
    pub fn evaluation(self) -> Evaluation {
        match self {
            Way::Rows => Evaluation::Rows,
            Way::Nodes | Way::Accuracy(_) => Evaluation::default(),
        }
    }
}

/// The scene's sampling effort.
pub fn effort(scene: &Scene) -> Effort {
    let count = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    Effort {
        chains: count(scene.sampler.chains),
        warmup: count(scene.sampler.warmup),
        draws: count(scene.sampler.draws),
        target_accept: TARGET_ACCEPT,
    }
}

/// Numbers, draws times quantities, that a posterior may hold: 400 MB, which are held some six times over while it is
/// sampled, checked and written.
pub const MOST_NUMBERS: usize = 50_000_000;

/// Checks that the draws of a posterior fit into memory, each of them with so many quantities.
///
/// Fails with the largest number of draws that do.
pub fn check_room(effort: Effort, quantities: usize) -> Result<(), Error> {
    let Effort { chains, draws, .. } = effort;
    let all = chains.saturating_mul(draws).saturating_mul(quantities);
    if all <= MOST_NUMBERS {
        return Ok(());
    }
    let most = MOST_NUMBERS / (chains * quantities).max(1);
    Err(Error::Usage(format!(
        "[sampler] draws: found {draws} in {chains} chains, each with {quantities} quantities of this scene; expected at \
         most {most}, so that no more than {MOST_NUMBERS} numbers are held"
    )))
}

/// Samples the posterior from where least squares stands, and says what it says.
///
/// `Err` where a prior leaves no room, or the draws do not fit into memory; the inner `Err` where the runs are such that
/// nothing should be sampled.
pub fn find(
    scene: &Scene,
    runs: &Runs,
    least_squares: &Findings,
    asked: Asked,
    seed: u64,
    watcher: Watcher,
) -> Result<Result<Posterior, Declined>, Error> {
    let parameters = Parameters::of(scene, runs, asked.form)?;
    if let Some(declined) = trust::decline(runs, least_squares, &parameters) {
        return Ok(Err(declined));
    }
    let effort = effort(scene);
    check_room(effort, parameters.sampled.len() + derived::count(runs, asked.form))?;
    let rows = Likelihood::of_rows(scene, runs, asked.form);
    let plan = Plan {
        effort,
        stream: (seed, "posterior"),
        evaluation: asked.way.evaluation(),
    };
    let start = start(scene, least_squares);
    let sampled = match asked.way {
        Way::Accuracy(x) => sample_to(x, parameters, &rows, &start, plan, watcher),
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
    let notices = contraction::notices(&findings, least_squares);
    Ok(Ok(Posterior {
        asked,
        findings,
        sampled,
        derived,
        checks,
        notices,
    }))
}

/// Where least squares stands, by parameter.
pub fn start(scene: &Scene, least_squares: &Findings) -> Start {
    let mut start = vec![];
    let particle = |name: &str| scene.particles.iter().position(|p| p.name == name);
    for dry in &least_squares.dry {
        if let (Some(particle), Some(k)) = (particle(&dry.particle), dry.dry_k.value) {
            start.push((Kind::DryK(particle), k));
        }
    }
    let spreads: Vec<(f64, f64)> = least_squares
        .dry
        .iter()
        .filter_map(|dry| Some((dry.residual_sd?, dry.runs as f64)))
        .collect();
    let runs: f64 = spreads.iter().map(|(_, runs)| runs).sum();
    if runs > 0.0 {
        let pooled = spreads.iter().map(|(sd, runs)| sd * sd * runs).sum::<f64>() / runs;
        start.push((Kind::SigmaDry, pooled.sqrt()));
    }
    let Some(balance) = &least_squares.energy_balance else {
        return start;
    };
    for kind in [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale] {
        let found = balance.parameters.iter().find(|parameter| parameter.name == kind.key());
        if let Some(value) = found.and_then(|parameter| parameter.estimate.value) {
            start.push((kind, value));
        }
    }
    if let Some(sd) = balance.residual_sd {
        start.push((Kind::SigmaWet, sd));
    }
    // a value at or below zero is on no parameter's way
    start.retain(|(_, value)| *value > 0.0);
    start
}
