//! Interpolates a quantile of sorted draws.

/// Quantile at a probability in [0, 1] of draws in increasing order, at least one.
///
/// Linear between the order statistics at (S − 1)·probability (type 7 of Hyndman & Fan), rounded as NumPy rounds it:
/// a tail ESS counts the draws up to and including the quantile, so that the last bit matters where it is a draw.
pub(crate) fn of_sorted(sorted: &[f64], probability: f64) -> f64 {
    let place = (sorted.len() - 1) as f64 * probability;
    let below = place.floor();
    let low = sorted[below as usize];
    let high = sorted[(below as usize + 1).min(sorted.len() - 1)];
    let between = place - below;
    if between >= 0.5 {
        high - (high - low) * (1.0 - between)
    } else {
        low + (high - low) * between
    }
}

/// The central interval of probability `level` of the draws of all chains; `None` where one is not finite or there is none.
pub fn central_interval(chains: &[Vec<f64>], level: f64) -> Option<[f64; 2]> {
    let draws = sorted(chains.concat());
    let finite = !draws.is_empty() && draws.iter().all(|draw| draw.is_finite());
    let beyond = 0.5 * (1.0 - level);
    finite.then(|| [beyond, 1.0 - beyond].map(|probability| of_sorted(&draws, probability)))
}

/// All draws in increasing order.
pub(crate) fn sorted(mut draws: Vec<f64>) -> Vec<f64> {
    draws.sort_unstable_by(f64::total_cmp);
    draws
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_central_interval_pools_chains_and_wants_numbers() {
        let chains: [Vec<f64>; 2] = [(0..=50).map(f64::from).collect(), (51..=100).map(f64::from).collect()];
        let [lo, hi] = central_interval(&chains, 0.9).expect("numbers");
        assert!((lo - 5.0).abs() < 1e-12 && (hi - 95.0).abs() < 1e-12, "{lo} {hi}");
        assert_eq!(central_interval(&[vec![1.0, f64::NAN]], 0.9), None);
        assert_eq!(central_interval(&[], 0.9), None);
    }
}
