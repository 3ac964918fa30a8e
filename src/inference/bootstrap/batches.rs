//! Draws with replacement n − 1 of the n runs of every stratum, in batches of several draws.
//!
//! With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
//! (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::Rng;

use super::multisets::{batch_sizes, sequences, MemberCounts, Multisets, FEW};
use super::wide::{widest, Wide};

/// Replicates drawn at once.
pub(super) const TOGETHER: usize = 8;

/// Most sequences that one word of 64 bits decides among: none is then likelier than another by more than a share of 2⁻²¹,
/// which moves the mean of what a word draws by less than 10⁻⁶ of its standard deviation.
const MOST_SEQUENCES_OF_A_WORD: u64 = 1 << 43;

/// The weight of a member each time it is drawn; a single member is always itself.
pub(super) fn unit_weight(members: usize) -> f64 {
    if members == 1 {
        1.0
    } else {
        members as f64 / (members as f64 - 1.0)
    }
}

/// Draws of one stratum that a random word decides at once.
struct Batch {
    /// number of their sequences
    sequences: u32,
    /// where the multisets of a few members start in [`Multisets::of_sequence`]
    multisets: Option<u32>,
    /// whether a new word decides
    new_word: bool,
}

/// The batches of all strata.
pub(super) struct Batches {
    batches: Vec<Batch>,
    multisets: &'static Multisets,
    words: usize,
    /// batches of each stratum
    pub(super) strata: Vec<Range<usize>>,
}

/// What the batches of N replicates draw.
pub(super) struct Drawn<const N: usize> {
    bytes: Vec<u8>,
    /// by batch: the sequence drawn, of single members the member
    pub(super) of_batch: Vec<[u32; N]>,
}

impl Batches {
    pub(super) fn new(strata: &[Range<usize>]) -> Batches {
        let multisets = Multisets::all();
        let mut all = Batches {
            batches: vec![],
            multisets,
            words: 0,
            strata: vec![],
        };
        let mut decided = u64::MAX;
        for stratum in strata {
            let (first, n) = (all.batches.len(), stratum.len());
            for draws in batch_sizes(n) {
                let sequences = sequences(n, draws);
                decided = decided.saturating_mul(sequences as u64);
                let new_word = decided > MOST_SEQUENCES_OF_A_WORD;
                if new_word {
                    decided = sequences as u64;
                    all.words += 1;
                }
                all.batches.push(Batch {
                    // all multisets are a few thousand bytes
                    multisets: multisets.start(n, draws).map(|start| start as u32),
                    sequences: u32::try_from(sequences).unwrap_or(u32::MAX),
                    new_word,
                });
            }
            all.strata.push(first..all.batches.len());
        }
        all
    }

    /// Words of 32 bits that a replicate uses, always as many.
    pub(super) fn words(&self) -> u64 {
        2 * self.words as u64
    }

    /// Batches of a replicate.
    pub(super) fn len(&self) -> usize {
        self.batches.len()
    }

    /// Room for what some replicates draw.
    pub(super) fn room<const N: usize>(&self) -> Drawn<N> {
        Drawn {
            bytes: vec![0; N * size_of::<u64>() * self.words],
            of_batch: vec![[0; N]; self.len()],
        }
    }

    /// What the batches of a stratum drew in one of N replicates: the multiset of few members, the one member drawn from
    /// more.
    pub(super) fn drawn<'a, const N: usize>(
        &'a self,
        stratum: Range<usize>,
        drawn: &'a Drawn<N>,
        replicate: usize,
    ) -> impl Iterator<Item = u32> + use<'a, N> {
        let of_batch = drawn.of_batch[stratum.clone()].iter().zip(&self.batches[stratum]);
        of_batch.map(move |(drawn, batch)| match batch.multisets {
            Some(first) => u32::from(self.multisets.of_sequence[(first + drawn[replicate]) as usize]),
            None => drawn[replicate],
        })
    }

    /// Where the multisets of a batch's sequences start in [`Multisets::of_sequence`]; none for more than [`FEW`] members.
    pub(super) fn multisets(&self, batch: usize) -> Option<u32> {
        self.batches[batch].multisets
    }

    /// Draws some replicates.
    pub(super) fn draw<const N: usize>(&self, rng: &mut ChaCha8Rng, into: &mut Drawn<N>) {
        rng.fill_bytes(&mut into.bytes);
        widest(DecodeWords { batches: self, into });
    }
}

/// Turns random words into the sequences that batches draw.
struct DecodeWords<'a, const N: usize> {
    batches: &'a Batches,
    into: &'a mut Drawn<N>,
}

impl<const N: usize> Wide for DecodeWords<'_, N> {
    type Output = ();

    // several replicates at once, as halves of 32 bits, whose products the registers hold; the multisets of the
    // sequences are read elsewhere: here the compiler would take each sequence out of the registers by itself
    #[inline(always)]
    fn run(self) {
        let DecodeWords { batches, into } = self;
        let (words, _) = into.bytes.as_chunks();
        let mut word = 0;
        // what is left of the words
        let (mut low, mut high) = ([0u32; N], [0u32; N]);
        for (drawn, batch) in into.of_batch.iter_mut().zip(&batches.batches) {
            if batch.new_word {
                for (replicate, (low, high)) in low.iter_mut().zip(&mut high).enumerate() {
                    let word = u64::from_le_bytes(words[replicate * batches.words + word]);
                    *low = word as u32;
                    *high = (word >> u32::BITS) as u32;
                }
                word += 1;
            }
            let count = u64::from(batch.sequences);
            for ((drawn, low), high) in drawn.iter_mut().zip(&mut low).zip(&mut high) {
                // the whole and the broken part of the word's share of 2⁶⁴ times the number of sequences
                let below = u64::from(*low) * count;
                let scaled = u64::from(*high) * count + (below >> u32::BITS);
                *low = below as u32;
                *high = scaled as u32;
                *drawn = (scaled >> u32::BITS) as u32;
            }
        }
    }
}

/// Weights of the members of one stratum, from what its batches drew.
pub(super) fn write_weights(drawn: impl Iterator<Item = u32>, weights: &mut [f64]) {
    let n = weights.len();
    let unit = unit_weight(n);
    if n == 1 {
        weights[0] = 1.0;
    } else if n <= FEW {
        let multisets = Multisets::all().counts(n);
        let drawn = drawn.map(|multiset| multisets[multiset as usize]);
        let drawn = drawn.fold(MemberCounts::default(), MemberCounts::and);
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
            let batches = Batches::new(std::slice::from_ref(&(0..members)));
            let mut drawn = batches.room::<1>();
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let draws = 40_000;
            for _ in 0..draws {
                batches.draw(&mut rng, &mut drawn);
                write_weights(batches.drawn(0..batches.len(), &drawn, 0), &mut weights);
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

    /// Strata share words, so that the draws of one must be independent of the next.
    #[test]
    fn strata_that_share_a_word_are_drawn_apart() {
        let strata = [0..7, 7..14, 14..18, 18..20];
        let batches = Batches::new(&strata);
        let number = batches.len();
        assert!(batches.words < number);
        let mut rng = stream(1, "strata_that_share_a_word_are_drawn_apart", 0);
        let draws = 40_000;
        let means = batches
            .batches
            .iter()
            .map(|batch| 0.5 * (f64::from(batch.sequences) - 1.0));
        let means: Vec<f64> = means.collect();
        let mut drawn = batches.room::<1>();
        let mut sums = vec![0.0; number * number];
        for _ in 0..draws {
            batches.draw(&mut rng, &mut drawn);
            let centred = drawn
                .of_batch
                .iter()
                .zip(&batches.batches)
                .zip(&means)
                .map(|(([drawn], batch), mean)| {
                    assert!(*drawn < batch.sequences);
                    (f64::from(*drawn) - mean) / f64::from(batch.sequences)
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
