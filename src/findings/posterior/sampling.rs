//! Says what is sampled and how: the terms, the method, the effort, and where the chains start.

use crate::error::Error;
use crate::findings::dry::Dry;
use crate::findings::least_squares::LeastSquares;
use crate::inference::nuts::{Effort, TARGET_ACCEPT};
use crate::inference::prepared_posterior::Start;
use crate::inference::sampling::MOST_TIMES;
use crate::model::parameters::ParameterKind;
use crate::physics::Form;
use crate::scene::Scene;

/// Which model is sampled, and by which method.
#[derive(Debug, Clone, Copy)]
pub struct SamplingSetup {
    /// the terms of the energy balance
    pub form: Form,
    /// what makes the draws
    pub method: MethodChoice,
}

/// The method that makes the draws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MethodChoice {
    /// as the scene's `[sampler]` says; few stand for very many runs
    #[default]
    Sampler,
    /// the same of every run, however many
    Rows,
    /// the cheapest that vouches for this accuracy
    Accuracy(f64),
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

/// The most draws that a chain of a scene's posterior makes until the chains have mixed, each with so many quantities: as far as
/// they fit into memory.
pub fn most_draws(Effort { chains, draws, .. }: Effort, quantities: usize) -> usize {
    let room = MOST_NUMBERS / chains.saturating_mul(quantities).max(1);
    draws.saturating_mul(MOST_TIMES).min(room)
}

/// Where least squares stands, by parameter.
pub fn start(least_squares: &LeastSquares) -> Start {
    let mut start = vec![];
    let with_k = least_squares.dry.iter().filter_map(|dry| Some((dry, dry.dry_k.value?)));
    start.extend(with_k.map(|(dry, k)| (ParameterKind::DryK(dry.sphere), k)));
    let spread = |dry: &Dry| Some((dry.residual_sd?, dry.runs as f64));
    let spreads: Vec<(f64, f64)> = least_squares.dry.iter().filter_map(spread).collect();
    let runs: f64 = spreads.iter().map(|(_, runs)| runs).sum();
    if runs > 0.0 {
        let pooled = spreads.iter().map(|(sd, runs)| sd * sd * runs).sum::<f64>() / runs;
        start.push((ParameterKind::SigmaDry, pooled.sqrt()));
    }
    let Some(balance) = &least_squares.energy_balance else {
        return start;
    };
    for parameter in &balance.parameters {
        if let (ParameterKind::Shared(_), Some(value)) = (parameter.kind, parameter.estimate.value) {
            start.push((parameter.kind, value));
        }
    }
    if let Some(sd) = balance.residual_sd {
        start.push((ParameterKind::SigmaWet, sd));
    }
    // a value at or below zero is outside every parameter's range
    start.retain(|(_, value)| *value > 0.0);
    start
}
