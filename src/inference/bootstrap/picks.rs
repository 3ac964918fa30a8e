//! Draws with replacement n − 1 of the n runs of every stratum, several draws at a time.
//!
//! With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
//! (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::Rng;

use super::outcomes::{draws, ways, Counts, Outcomes, FEW};
use super::wide::{widest, Wide};

/// Most ways that one word of 64 bits decides: none is then likelier than another by more than a share of 2⁻²¹, which moves
/// the mean of what a word draws by less than 10⁻⁶ of its standard deviation.
const MOST_WAYS_OF_A_WORD: u64 = 1 << 43;

/// The weight of a member each time it is drawn; a single member is always itself.
pub(super) fn unit(members: usize) -> f64 {
    if members == 1 {
        1.0
    } else {
        members as f64 / (members as f64 - 1.0)
    }
}

/// Ways in which the draws of a pick fall.
struct Ways {
    count: u32,
    /// where the outcomes of a few members start in [`Outcomes::of`]
    listed: Option<u32>,
    /// whether a new word decides
    anew: bool,
}

/// Which draws are made at once, and which of them one random word decides.
pub(super) struct Picks {
    ways: Vec<Ways>,
    outcomes: &'static Outcomes,
    words: usize,
    /// picks of each stratum
    pub(super) strata: Vec<Range<usize>>,
}

/// What the picks of some replicates draw.
pub(super) struct Drawn<const N: usize> {
    bytes: Vec<u8>,
    /// by pick, an outcome of a few members, one of more
    pub(super) of: Vec<[u32; N]>,
}

impl Picks {
    pub(super) fn new(strata: &[Range<usize>]) -> Picks {
        let outcomes = Outcomes::all();
        let mut picks = Picks {
            ways: vec![],
            outcomes,
            words: 0,
            strata: vec![],
        };
        let mut decided = u64::MAX;
        for stratum in strata {
            let (first, n) = (picks.ways.len(), stratum.len());
            for draws in draws(n) {
                let ways = ways(n, draws);
                decided = decided.saturating_mul(ways as u64);
                let anew = decided > MOST_WAYS_OF_A_WORD;
                if anew {
                    decided = ways as u64;
                    picks.words += 1;
                }
                picks.ways.push(Ways {
                    // all outcomes are a few thousand bytes
                    listed: outcomes.start(n, draws).map(|start| start as u32),
                    count: u32::try_from(ways).unwrap_or(u32::MAX),
                    anew,
                });
            }
            picks.strata.push(first..picks.ways.len());
        }
        picks
    }

    /// Words of 32 bits that a replicate uses, always as many.
    pub(super) fn words(&self) -> u64 {
        2 * self.words as u64
    }

    /// Picks of a replicate.
    pub(super) fn len(&self) -> usize {
        self.ways.len()
    }

    /// Room for what some replicates draw.
    pub(super) fn room<const N: usize>(&self) -> Drawn<N> {
        Drawn {
            bytes: vec![0; N * size_of::<u64>() * self.words],
            of: vec![[0; N]; self.len()],
        }
    }

    /// Draws some replicates.
    pub(super) fn draw<const N: usize>(&self, rng: &mut ChaCha8Rng, into: &mut Drawn<N>) {
        rng.fill_bytes(&mut into.bytes);
        widest(Decide { picks: self, into });
    }
}

/// Tells from random words what picks draw.
struct Decide<'a, const N: usize> {
    picks: &'a Picks,
    into: &'a mut Drawn<N>,
}

impl<const N: usize> Wide for Decide<'_, N> {
    type Output = ();

    // several replicates at once
    #[inline(always)]
    fn run(self) {
        const HALF: u64 = u32::MAX as u64;
        let Decide { picks, into } = self;
        let (words, _) = into.bytes.as_chunks();
        let mut word = 0;
        let mut left = [0; N];
        for (drawn, ways) in into.of.iter_mut().zip(&picks.ways) {
            if ways.anew {
                for (replicate, left) in left.iter_mut().enumerate() {
                    *left = u64::from_le_bytes(words[replicate * picks.words + word]);
                }
                word += 1;
            }
            let count = u64::from(ways.count);
            let mut way = [0; N];
            for (way, left) in way.iter_mut().zip(&mut left) {
                // way and what is left of the word: the whole and the broken part of its share of 2⁶⁴ times the ways
                let below = (*left & HALF) * count;
                let scaled = (*left >> 32) * count + (below >> 32);
                *left = scaled << 32 | below & HALF;
                *way = scaled >> 32;
            }
            match ways.listed {
                Some(first) => {
                    let outcomes = &picks.outcomes.of[first as usize..];
                    for (drawn, way) in drawn.iter_mut().zip(way) {
                        *drawn = u32::from(outcomes[way as usize]);
                    }
                }
                None => *drawn = way.map(|way| way as u32),
            }
        }
    }
}

/// Weights of the members of one stratum, from what its picks drew.
pub(super) fn weigh(drawn: impl Iterator<Item = u32>, weights: &mut [f64]) {
    let n = weights.len();
    let unit = unit(n);
    if n == 1 {
        weights[0] = 1.0;
    } else if n <= FEW {
        let outcomes = Outcomes::all().counts(n);
        let drawn = drawn.map(|outcome| outcomes[outcome as usize]);
        let drawn = drawn.fold(Counts::default(), Counts::and);
        for (weight, count) in weights.iter_mut().zip(drawn.each()) {
            *weight = count * unit;
        }
    } else {
        weights.fill(0.0);
        for member in drawn {
            weights[member as usize] += unit;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::stream;

    /// Counts of n − 1 draws of n: mean 1 and variance 1 − 1/n after weighting, as a mean of n runs needs.
    #[test]
    fn weights_have_the_moments_of_rescaled_draws() {
        for members in [2usize, 3, 4, 5, 6, 7, 8, 9, 16, 17, 40] {
            let mut rng = stream(1, "weights_have_the_moments_of_rescaled_draws", members as u64);
            let picks = Picks::new(std::slice::from_ref(&(0..members)));
            let mut drawn = picks.room::<1>();
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let draws = 40_000;
            for _ in 0..draws {
                picks.draw(&mut rng, &mut drawn);
                weigh(drawn.of.iter().map(|[drawn]| *drawn), &mut weights);
                let total: f64 = weights.iter().sum();
                assert!((total - members as f64).abs() < 1e-9, "{members}: {total}");
                for (sum, weight) in sums.iter_mut().zip(&weights) {
                    *sum += weight;
                }
                squares += (weights[0] - 1.0).powi(2);
                products += (weights[0] - 1.0) * (weights[members - 1] - 1.0);
            }
            let (n, draws) = (members as f64, f64::from(draws));
            // counts are multinomial: (n − 1)/n · (1 − 1/n) is their variance, times (n/(n − 1))² it is one
            assert!((squares / draws - 1.0).abs() < 0.06, "{members}: {squares}");
            assert!(
                (products / draws + 1.0 / (n - 1.0)).abs() < 0.03,
                "{members}: {products}"
            );
            for sum in sums {
                assert!((sum / draws - 1.0).abs() < 4.5 / draws.sqrt(), "{members}: {sum}");
            }
        }
    }

    /// Strata share words, so that what one drew must tell nothing of the next.
    #[test]
    fn strata_that_share_a_word_are_drawn_apart() {
        let strata = [0..7, 7..14, 14..18, 18..20];
        let picks = Picks::new(&strata);
        let number = picks.len();
        assert!(picks.words < number);
        let mut rng = stream(1, "strata_that_share_a_word_are_drawn_apart", 0);
        let draws = 40_000;
        let means = picks.ways.iter().map(|ways| match ways.listed {
            Some(first) => {
                let outcomes = &picks.outcomes.of[first as usize..(first + ways.count) as usize];
                outcomes.iter().map(|outcome| f64::from(*outcome)).sum::<f64>() / f64::from(ways.count)
            }
            None => 0.5 * (f64::from(ways.count) - 1.0),
        });
        let means: Vec<f64> = means.collect();
        let mut drawn = picks.room::<1>();
        let mut sums = vec![0.0; number * number];
        for _ in 0..draws {
            picks.draw(&mut rng, &mut drawn);
            let centred = drawn
                .of
                .iter()
                .zip(&picks.ways)
                .zip(&means)
                .map(|(([drawn], ways), mean)| {
                    assert!(*drawn < ways.count);
                    // outcomes are fewer than ways
                    (f64::from(*drawn) - mean) / f64::from(ways.count)
                });
            let centred: Vec<f64> = centred.collect();
            for a in 0..number {
                for b in 0..a {
                    sums[a * number + b] += centred[a] * centred[b];
                }
            }
        }
        // each product has a standard deviation of at most 1/4
        let limit = 4.5 * 0.25 / f64::from(draws).sqrt();
        for sum in sums {
            assert!((sum / f64::from(draws)).abs() < limit, "{sum}");
        }
    }
}
