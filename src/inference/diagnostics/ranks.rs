//! Replaces draws by the normal scores of their ranks, so that heavy tails and infinite variances do no harm.

use std::sync::{Arc, Mutex, PoisonError};

use statrs::distribution::{ContinuousCDF, Normal};

/// Φ⁻¹((rank − 3/8)/(S + 1/4)) of each of S values, ties sharing their mean rank.
///
/// Source: Vehtari et al. 2021 (Bayesian Analysis 16, 667), eq. 14, with Blom's offset.
pub(super) fn normal_scores(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<(f64, u32)> = values.iter().copied().zip(0u32..).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let alone = untied(values.len());
    let mut scores = vec![0.0; values.len()];
    let mut below = 0;
    for tied in order.chunk_by(|a, b| a.0 == b.0) {
        let score = match tied.len() {
            1 => alone[below],
            several => score(below as f64 + (several as f64 + 1.0) / 2.0, values.len()),
        };
        for &(_, place) in tied {
            scores[place as usize] = score;
        }
        below += tied.len();
    }
    scores
}

fn score(rank: f64, count: usize) -> f64 {
    Normal::standard().inverse_cdf((rank - 0.375) / (count as f64 + 0.25))
}

/// The scores of the ranks 1 to S; kept for the next call, as all quantities of a posterior have as many draws.
fn untied(count: usize) -> Arc<[f64]> {
    static KEPT: Mutex<Option<Arc<[f64]>>> = Mutex::new(None);
    // what is kept is replaced whole, so that a panic elsewhere does not spoil it
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    match &*kept {
        Some(scores) if scores.len() == count => scores.clone(),
        _ => {
            let scores: Arc<[f64]> = (1..=count).map(|rank| score(rank as f64, count)).collect();
            *kept = Some(scores.clone());
            scores
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_share_a_rank_and_order_is_all_that_counts() {
        let scores = normal_scores(&[3.0, -0.0, 1e300, 0.0]);
        assert_eq!(scores[1], scores[3]);
        assert!(scores[1] < scores[0] && scores[0] < scores[2]);
        // scipy.stats.norm.ppf((4 - 3/8)/(4 + 1/4))
        assert!((scores[2] - 1.049_131_397_963_970_7).abs() < 1e-12, "{}", scores[2]);
        assert_eq!(normal_scores(&[5.0, 5.0, 5.0]), [0.0; 3]);
    }
}
