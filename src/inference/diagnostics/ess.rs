//! Counts how many independent draws the chains are worth.
//!
//! Symbols: n draws in a half, S in all; γ_t the autocovariance at lag t, mean over the halves; ρ_t = 1 − (W − γ_t)/V
//! with the mean variance W within the halves and V = W (n − 1)/n + variance of their means. S/τ with
//! τ = −1 + 2 Σ ρ_t over Geyer's initial monotone sequence. Source: Vehtari et al. 2021 (Bayesian Analysis 16, 667),
//! section 3.2, with the refined end of the sum and the bound τ ≥ 1/log10 S for antithetic chains.

use super::halves::Halves;
use super::{have_diagnostics, mean, quantile, variance};
use crate::lanes::sums;

/// Probability of each tail whose ESS is reported.
pub const TAIL: f64 = 0.05;

/// Effective draws for the standard deviation about a mean computed already.
pub(super) fn of_sd_about(chains: &[&[f64]], centre: f64) -> Option<f64> {
    of_halves(&Halves::map(chains, |x| (x - centre) * (x - centre)))
}

/// Effective draws for the quantile at a probability inside (0, 1): those of whether a draw lies at or below it.
pub fn of_quantile(chains: &[&[f64]], probability: f64) -> Option<f64> {
    let sorted = have_diagnostics(chains).then(|| quantile::sorted(chains.concat()))?;
    below(chains, quantile::of_sorted(&sorted, probability))
}

/// Effective draws for whether a draw lies at or below `limit`; `None` where all do.
pub(super) fn below(chains: &[&[f64]], limit: f64) -> Option<f64> {
    of_halves(&Halves::map(chains, |x| f64::from(u8::from(x <= limit))))
}

/// Effective draws of halves of chains, of at least two draws each; `None` where all are the same.
pub(super) fn of_halves(halves: &Halves) -> Option<f64> {
    if halves.stand_still() {
        return None;
    }
    let n = halves.length;
    let means: Vec<f64> = halves.iter().map(mean).collect();
    let mut centred = halves.draws.clone();
    for (half, centre) in centred.chunks_exact_mut(n).zip(&means) {
        half.iter_mut().for_each(|x| *x -= centre);
    }
    let count = halves.draws.len() as f64;
    let covariance = |lag: usize| {
        let products = |half: &[f64]| sums([&half[..n - lag], &half[lag..]], |[early, late]| [early * late])[0];
        centred.chunks_exact(n).map(products).sum::<f64>() / count
    };
    let biased = covariance(0);
    let within = biased * n as f64 / (n as f64 - 1.0);
    let spread = biased + variance(&means);
    let correlation = |lag: usize| 1.0 - (within - covariance(lag)) / spread;
    let (mut pairs, last) = initial_positive(n, correlation);
    make_monotone(&mut pairs);
    let sum: f64 = pairs.iter().sum();
    let tau = (2.0 * sum - 1.0 + last).max(1.0 / count.log10());
    Some(count / tau)
}

/// Sums of the autocorrelations at lags (0, 1), (2, 3), … while they are positive, and the even one of the last pair.
///
/// The last pair itself is not among the sums: only its even lag counts, and only once. Autocovariances are summed
/// directly, lag by lag, because a chain that mixes needs a few dozen of them and no transform.
fn initial_positive(n: usize, correlation: impl Fn(usize) -> f64) -> (Vec<f64>, f64) {
    let mut pairs = vec![];
    let (mut even, mut odd) = (1.0, correlation(1));
    let mut lag = 1;
    while lag + 3 < n && even + odd > 0.0 {
        pairs.push(even + odd);
        even = correlation(lag + 1);
        odd = correlation(lag + 2);
        lag += 2;
    }
    // a last pair with a negative sum counts as nothing, except for a positive even lag
    let last = if even > 0.0 || even + odd >= 0.0 { even } else { 0.0 };
    (pairs, last)
}

/// Lowers each pair to the one before it where it is larger.
fn make_monotone(pairs: &mut [f64]) {
    for i in 1..pairs.len() {
        pairs[i] = pairs[i].min(pairs[i - 1]);
    }
}
