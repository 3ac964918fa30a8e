//! Draws with replacement n − 1 of the n members of a stratum.
//!
//! With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
//! (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).

use rand::rngs::ChaCha8Rng;
use rand::Rng;

/// Sequences of choices up to which one word of 32 bits decides among them: none is then likelier than another by more than
/// a share of 2⁻²⁰.
const MOST_SEQUENCES: usize = 1 << 12;

/// Members up to which two are drawn at once, as one of their pairs.
const MOST_PAIRED: usize = 32;

/// How the members of a stratum are drawn: two at a time where they are few, which halves the time, and what is left singly.
#[derive(Debug)]
pub(super) struct Draws {
    members: usize,
    /// 1 over how many are drawn
    share: f64,
    pairs: Choices,
    singles: Choices,
}

impl Draws {
    pub(super) fn new(members: usize) -> Draws {
        // a single member is always itself
        let draws = members.saturating_sub(1).max(1);
        let pairs = if members <= MOST_PAIRED { draws / 2 } else { 0 };
        Draws {
            members,
            share: 1.0 / draws as f64,
            pairs: Choices::new(pairs, members * members),
            singles: Choices::new(draws - 2 * pairs, members),
        }
    }

    /// Random words of 32 bits that a replicate uses, always as many.
    pub(super) fn words(&self) -> u64 {
        (self.pairs.words() + self.singles.words()) as u64
    }

    /// Draws the weights of the members.
    pub(super) fn weigh(&self, rng: &mut ChaCha8Rng, weights: &mut [f64]) {
        let weight = self.members as f64 * self.share;
        weights.fill(0.0);
        self.pairs.draw(rng, |pair| {
            weights[pair / self.members] += weight;
            weights[pair % self.members] += weight;
        });
        self.singles.draw(rng, |member| weights[member] += weight);
    }

    /// Sums of two numbers of the members, by pair; empty where none is drawn.
    pub(super) fn sums_of_pairs(&self, numbers: &[f64]) -> Vec<f64> {
        let paired = if self.pairs.draws > 0 { numbers } else { &[] };
        let with_each = |one| paired.iter().map(move |other| one + other);
        paired.iter().flat_map(with_each).collect()
    }

    /// Draws the mean of numbers of the members, of which the sums of pairs are known.
    #[inline(always)] // a call takes as long as a few draws
    pub(super) fn mean(&self, rng: &mut ChaCha8Rng, numbers: &[f64], sums_of_pairs: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.pairs.draw(rng, |pair| sum += sums_of_pairs[pair]);
        self.singles.draw(rng, |member| sum += numbers[member]);
        self.share * sum
    }
}

/// Some draws, each of as many choices.
#[derive(Debug)]
struct Choices {
    draws: usize,
    choices: usize,
    /// draws that one word decides
    of_word: usize,
}

impl Choices {
    fn new(draws: usize, choices: usize) -> Choices {
        let few = |draws: &usize| choices.pow(*draws as u32) <= MOST_SEQUENCES;
        Choices {
            draws,
            choices,
            of_word: (1..=draws).take_while(few).last().unwrap_or(1),
        }
    }

    fn words(&self) -> usize {
        self.draws.div_ceil(self.of_word)
    }

    /// Calls `chosen` with each choice that is drawn.
    #[inline(always)] // with what is done with it
    fn draw(&self, rng: &mut ChaCha8Rng, mut chosen: impl FnMut(usize)) {
        let mut left = self.draws;
        while left > 0 {
            let of_word = left.min(self.of_word);
            let mut word = rng.next_u32();
            for _ in 0..of_word {
                // the whole and the broken part of the word's share of 2³² times the choices
                let scaled = u64::from(word) * self.choices as u64;
                word = scaled as u32;
                chosen((scaled >> u32::BITS) as usize);
            }
            left -= of_word;
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
        for members in [1usize, 2, 3, 4, 5, 6, 7, 8, 9, 16, 17, 40] {
            let mut rng = stream(1, "weights_have_the_moments_of_rescaled_draws", members as u64);
            let draws = Draws::new(members);
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let made = 40_000;
            for _ in 0..made {
                draws.weigh(&mut rng, &mut weights);
                let total: f64 = weights.iter().sum();
                assert!((total - members as f64).abs() < 1e-9, "{members}: {total}");
                for (sum, weight) in sums.iter_mut().zip(&weights) {
                    *sum += weight;
                }
                squares += (weights[0] - 1.0).powi(2);
                products += (weights[0] - 1.0) * (weights[members - 1] - 1.0);
            }
            let (n, made) = (members as f64, f64::from(made));
            if members == 1 {
                assert_eq!((weights[0], squares), (1.0, 0.0));
                continue;
            }
            // counts are multinomial: (n − 1)/n · (1 − 1/n) is their variance, times (n/(n − 1))² it is one
            assert!((squares / made - 1.0).abs() < 0.06, "{members}: {squares}");
            assert!(
                (products / made + 1.0 / (n - 1.0)).abs() < 0.03,
                "{members}: {products}"
            );
            for sum in sums {
                assert!((sum / made - 1.0).abs() < 4.5 / made.sqrt(), "{members}: {sum}");
            }
        }
    }

    /// Members drawn one after the other are independent, in a pair or not: any two are as likely as any other two.
    #[test]
    fn draws_of_a_word_are_independent() {
        let draws = Draws::new(6);
        assert_eq!((draws.pairs.draws, draws.pairs.of_word), (2, 2));
        let mut rng = stream(1, "draws_of_a_word_are_independent", 0);
        let (made, mut counts) = (50_000, [[0usize; 36]; 4]);
        for _ in 0..made {
            let mut drawn = vec![];
            draws.pairs.draw(&mut rng, |pair| drawn.extend([pair / 6, pair % 6]));
            draws.singles.draw(&mut rng, |member| drawn.push(member));
            for (counts, two) in counts.iter_mut().zip(drawn.windows(2)) {
                counts[6 * two[0] + two[1]] += 1;
            }
        }
        let expected = f64::from(made) / 36.0;
        for counts in counts {
            let apart = |count: usize| (count as f64 - expected).powi(2) / expected;
            let chi_squared: f64 = counts.into_iter().map(apart).sum();
            // mean 35, variance 70
            assert!((chi_squared - 35.0).abs() < 4.5 * 70f64.sqrt(), "{chi_squared}");
        }
    }

    #[test]
    fn a_mean_is_that_of_the_weights_drawn_from_the_same_stream() {
        let name = "a_mean_is_that_of_the_weights_drawn_from_the_same_stream";
        for members in [1usize, 2, 3, 4, 7, 8, 32, 33, 65] {
            let numbers: Vec<f64> = (0..members).map(|member| (3.0 * member as f64).sin()).collect();
            let draws = Draws::new(members);
            let sums_of_pairs = draws.sums_of_pairs(&numbers);
            let [mut one, mut other] = [0, 0].map(|index| stream(1, name, index));
            let mut weights = vec![0.0; members];
            for made in 1..=20 {
                draws.weigh(&mut other, &mut weights);
                let sum: f64 = numbers
                    .iter()
                    .zip(&weights)
                    .map(|(number, weight)| number * weight)
                    .sum();
                let apart = draws.mean(&mut one, &numbers, &sums_of_pairs) - sum / members as f64;
                assert!(apart.abs() < 1e-12, "{members}: {apart}");
                assert_eq!(one.get_word_pos(), u128::from(made * draws.words()), "{members}");
            }
        }
    }
}
