//! Replaces draws by the normal scores of their ranks, so that heavy tails and infinite variances do no harm.

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
        let mut scores = vec![0.0; count];
        let mut below = 0.0;
        for tied in self.draws.chunk_by(|a, b| a.0 == b.0) {
            let several = tied.len() as f64;
            let rank = below + (several + 1.0) / 2.0;
            let score = normal_quantile((rank - 0.375) / (count as f64 + 0.25));
            for &(_, place) in tied {
                scores[place as usize] = score;
            }
            below += several;
        }
        Halves {
            draws: scores,
            length: self.length,
        }
    }
}
