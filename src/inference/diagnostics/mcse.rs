//! Gives the Monte Carlo standard error of a mean, a standard deviation and a quantile: what more draws would lower.

use super::{ess, quantile};
use crate::distributions::beta_quantile;

/// Probabilities between which a normal variable lies within one standard deviation of its mean.
///
/// Φ(∓1) as the reference implementations round it.
const ONE_SD: [f64; 2] = [0.158_655_3, 0.841_344_7];

/// Monte Carlo error of the standard deviation of draws about their mean, with `effective` draws for it.
///
/// By the delta method from the error of the variance, with no normality assumed. Source: Kenney & Keeping 1951.
pub(super) fn from_moments(draws: &[f64], centre: f64, effective: f64) -> f64 {
    let (mut second, mut fourth) = (0.0, 0.0);
    for x in draws {
        let square = (x - centre) * (x - centre);
        second += square;
        fourth += square * square;
    }
    let count = draws.len() as f64;
    let (second, fourth) = (second / count, fourth / count);
    ((fourth - second * second) / effective / second / 4.0).sqrt()
}

/// Monte Carlo error of the quantile at a probability inside (0, 1), in the draws' unit.
///
/// Half the distance between the draws that bound, with the probability of ±1 sd, where the quantile may lie.
/// Source: Vehtari et al. 2021 (Bayesian Analysis 16, 667), section 4.4.
pub fn of_quantile(chains: &[&[f64]], probability: f64) -> Option<f64> {
    let effective = ess::of_quantile(chains, probability)?;
    Some(from_order(&quantile::sorted(chains.concat()), probability, effective))
}

/// Monte Carlo error of a quantile of sorted draws, with `effective` draws for it.
pub(super) fn from_order(sorted: &[f64], probability: f64, effective: f64) -> f64 {
    let count = sorted.len() as f64;
    let (below, above) = (effective * probability + 1.0, effective * (1.0 - probability) + 1.0);
    let [low, high] = ONE_SD.map(|p| beta_quantile(p, (below, above)) * count - 1.0);
    let low = sorted[low.max(0.0).floor() as usize];
    let high = sorted[high.min(count - 1.0).ceil() as usize];
    (high - low) / 2.0
}
