//! Smooths importance weights: the largest become the order statistics of a Pareto tail fitted to them.

use super::pareto::{self, Pareto};

/// Smoothed weights of draws.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// logarithms of the weights, which sum to 1, in the order of the draws
    pub log_weights: Vec<f64>,
    /// the weights themselves
    pub weights: Vec<f64>,
    /// shape of the fitted tail, to be held against [`pareto::khat_threshold`]; `None` where no tail could be fitted
    /// (fewer than five draws in it, all of them the same, or its lower quarter tied): the weights are then the raw ones
    pub khat: Option<f64>,
}

/// Pareto-smoothed importance weights from the logarithms of density ratios, up to any constant.
///
/// `tail` is how many of the largest are smoothed: [`pareto::tail_length`]. A log ratio of −∞ is a weight of 0; with NaN, +∞
/// or no finite one there are none. Source: Vehtari et al. 2024 (JMLR 25, 72).
pub fn psis(log_ratios: &[f64], tail: usize) -> Option<Smoothed> {
    let largest = log_ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() || log_ratios.iter().any(|ratio| ratio.is_nan()) {
        return None;
    }
    let mut log_weights: Vec<f64> = log_ratios.iter().map(|ratio| ratio - largest).collect();
    let mut order: Vec<usize> = (0..log_weights.len()).collect();
    let start = order.len() - tail.min(order.len().saturating_sub(1));
    let by_weight = |a: &usize, b: &usize| log_weights[*a].total_cmp(&log_weights[*b]);
    // which of equal weights begin the tail changes nothing
    if start > 0 {
        order.select_nth_unstable_by(start - 1, by_weight);
    }
    order[start..].sort_unstable_by(by_weight);
    let cutoff = order[..start].last().map_or(0.0, |&draw| log_weights[draw].exp());
    let above = order[start..].iter().map(|&draw| log_weights[draw].exp() - cutoff);
    let khat = pareto::fit(&above.collect::<Vec<f64>>()).map(|pareto| {
        let tail = order.len() - start;
        for (rank, &draw) in order[start..].iter().enumerate() {
            log_weights[draw] = smoothed(pareto, cutoff, rank, tail).ln();
        }
        pareto.shape
    });
    let mut weights: Vec<f64> = log_weights.iter().map(|log| log.exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= sum);
    log_weights.iter_mut().for_each(|log| *log -= sum.ln());
    Some(Smoothed {
        log_weights,
        weights,
        khat,
    })
}

/// Smoothed weight of the tail's draw of this rank (from 0): never above the largest raw weight, 1.
fn smoothed(pareto: Pareto, cutoff: f64, rank: usize, tail: usize) -> f64 {
    let probability = (rank as f64 + 0.5) / tail as f64;
    (cutoff + pareto.quantile(probability)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_weights_have_no_tail_and_stay_equal() {
        let result = psis(&[-3.0; 100], 20).expect("finite");
        assert_eq!(result.khat, None);
        assert!(result.log_weights.iter().all(|log| (log + 100f64.ln()).abs() < 1e-12));
    }

    #[test]
    fn a_ratio_that_is_no_number_fails_and_a_weight_of_nothing_does_not() {
        let mut ratios: Vec<f64> = (0..50).map(f64::from).collect();
        ratios[3] = f64::NEG_INFINITY;
        let result = psis(&ratios, 10).expect("a weight of nothing");
        assert_eq!(result.log_weights[3], f64::NEG_INFINITY);
        ratios[3] = f64::NAN;
        assert_eq!(psis(&ratios, 10), None);
        ratios[3] = f64::INFINITY;
        assert_eq!(psis(&ratios, 10), None);
        assert_eq!(psis(&[], 10), None);
    }
}
