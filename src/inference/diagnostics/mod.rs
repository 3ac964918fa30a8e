//! Says how reliable draws of Markov chains are: convergence, effective sizes, Monte Carlo errors, PSIS-LOO.
//!
//! | file | job |
//! |---|---|
//! | `halves.rs` | cuts every chain into two |
//! | `ranks.rs` | replaces draws by the normal scores of their ranks |
//! | `quantile.rs` | interpolates a quantile of sorted draws |
//! | `rhat.rs` | compares the chains: rank-normalised split R-hat |
//! | `ess.rs` | counts how many independent draws they are worth |
//! | `mcse.rs` | gives the Monte Carlo error of mean, sd and quantiles |
//! | `energy.rs` | says whether the momenta reach all energies: E-BFMI |
//! | `pareto.rs` | fits a generalised Pareto tail |
//! | `psis.rs` | smooths importance weights by it |
//! | `loo.rs` | predicts each run from the others |
//! | `summary.rs` | makes the summary of one quantity |
//!
//! Draws come as one slice a chain, all of the same length. What cannot be had is `None`, by the rule of R's `posterior`
//! (1.7): a value that is not finite, or draws that are all the same, have no diagnostic. ArviZ (1.3)
//! differs in a few places: draws that are all the same, or differ by less than 1e-15 in whatever unit, it counts as that
//! many independent ones (ours are the same only if they are equal, in any unit); R-hat of a single chain it refuses;
//! infinite draws have ranks and so a bulk ESS; its default tail is 11 %/89 % where ours is 5 %/95 %. With an odd number
//! of draws the one in the middle belongs to neither half, and as in ArviZ the median that R-hat folds about leaves it
//! out (`posterior` does not).

pub mod energy;
pub mod ess;
mod halves;
pub mod loo;
pub mod mcse;
pub mod pareto;
pub mod psis;
pub mod quantile;
mod ranks;
mod rhat;
pub mod summary;

/// Fewest draws a chain: each half then has two.
pub const FEWEST_DRAWS: usize = 4;

/// Whether chains have diagnostics: of one length, long enough, finite, and not all the same.
fn have_diagnostics(chains: &[&[f64]]) -> bool {
    let length = chains.first().map_or(0, |chain| chain.len());
    let mut draws = chains.iter().copied().flatten();
    let first = draws.clone().next();
    length >= FEWEST_DRAWS
        && chains.iter().all(|chain| chain.len() == length)
        && draws.clone().all(|x| x.is_finite())
        && draws.any(|x| Some(x) != first)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Variance of a sample about its mean, by n − 1.
fn variance(values: &[f64]) -> f64 {
    let centre = mean(values);
    let squares: f64 = values.iter().map(|x| (x - centre) * (x - centre)).sum();
    squares / (values.len() as f64 - 1.0)
}
