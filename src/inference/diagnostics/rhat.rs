//! Compares the chains: rank-normalised split R-hat.

use super::halves::Halves;
use super::ranks::OrderedDraws;
use super::{mean, variance};

/// R-hat of one quantity, by its halves and their normal scores: 1 where all halves of all chains look alike, above 1.01 not
/// reliable.
///
/// The larger of the split R-hat of the normal scores (do the chains agree in location?) and of the normal scores of
/// |x − median| (do they agree in spread?). A single chain is compared with itself, half against half. `None` where every half
/// stands still. Source: Vehtari et al. 2021 (Bayesian Analysis 16, 667), section 4.
pub(super) fn of_scores(ordered: &OrderedDraws, bulk_scores: &Halves) -> Option<f64> {
    let bulk = split_rhat(bulk_scores)?;
    let spread = ordered.folded().scores();
    if spread.stand_still() {
        // draws at two values equally far from the median have no spread to compare
        return Some(bulk);
    }
    split_rhat(&spread).map(|tail| bulk.max(tail))
}

/// √((B/W + n − 1)/n) of halves of n draws: B is n times the variance of their means, W the mean of their variances; `None`
/// where W is 0.
fn split_rhat(halves: &Halves) -> Option<f64> {
    if halves.iter().all(|half| half.iter().all(|x| *x == half[0])) {
        return None;
    }
    let means: Vec<f64> = halves.iter().map(mean).collect();
    let variances: Vec<f64> = halves.iter().map(variance).collect();
    let n = halves.length as f64;
    Some(((n * variance(&means) / mean(&variances) + n - 1.0) / n).sqrt())
}
