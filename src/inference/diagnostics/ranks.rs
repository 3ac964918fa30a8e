//! Replaces draws by the normal scores of their ranks, so that heavy tails and infinite variances do no harm.

use std::sync::{Arc, Mutex, PoisonError};

use super::halves::Halves;
use super::quantile;
use crate::distributions::normal_quantile;

/// The draws of all halves from the smallest up, each with its place among them.
///
/// Sorting costs more than anything else that is computed of a quantity: what needs their order shares it.
pub(super) struct OrderedDraws {
    draws: Vec<(f64, u32)>,
    /// draws in each half
    length: usize,
}

impl OrderedDraws {
    pub fn of(halves: &Halves) -> OrderedDraws {
        let draws = halves.draws.iter().copied().zip(0u32..).collect();
        OrderedDraws::sort(draws, halves.length)
    }

    fn sort(mut draws: Vec<(f64, u32)>, length: usize) -> OrderedDraws {
        draws.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        OrderedDraws { draws, length }
    }

    /// The same of |x − median|.
    pub fn folded(&self) -> OrderedDraws {
        let values: Vec<f64> = self.draws.iter().map(|(x, _)| *x).collect();
        let median = quantile::of_sorted(&values, 0.5);
        let far = |&(x, place): &(f64, u32)| ((x - median).abs(), place);
        OrderedDraws::sort(self.draws.iter().map(far).collect(), self.length)
    }

    /// The halves with each draw replaced by its normal score: Φ⁻¹((rank − 3/8)/(S + 1/4)), ties sharing their mean rank.
    ///
    /// Source: Vehtari et al. 2021 (Bayesian Analysis 16, 667), eq. 14, with Blom's offset.
    pub fn scores(&self) -> Halves {
        let count = self.draws.len();
        let alone = untied(count);
        let mut scores = vec![0.0; count];
        let mut below = 0;
        for tied in self.draws.chunk_by(|a, b| a.0 == b.0) {
            let score = match tied.len() {
                1 => alone[below],
                several => score(below as f64 + (several as f64 + 1.0) / 2.0, count),
            };
            for &(_, place) in tied {
                scores[place as usize] = score;
            }
            below += tied.len();
        }
        Halves {
            draws: scores,
            length: self.length,
        }
    }
}

fn score(rank: f64, count: usize) -> f64 {
    normal_quantile((rank - 0.375) / (count as f64 + 0.25))
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
