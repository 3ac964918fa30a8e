//! Draws with replacement n − 1 of the n members of a stratum.
//!
//! With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
//! (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).

use rand::rngs::ChaCha8Rng;
use rand::Rng;

/// How many of so many members are drawn, each by a random word of 32 bits: a single member is always itself.
pub(super) fn drawn(members: usize) -> usize {
    members.saturating_sub(1).max(1)
}

/// Calls `chosen` with each of so many members that is drawn.
#[inline(always)] // with what is done with it
fn draw(members: usize, rng: &mut ChaCha8Rng, mut chosen: impl FnMut(usize)) {
    for _ in 0..drawn(members) {
        // the whole part of the word's share of 2³² times the members
        chosen(((u64::from(rng.next_u32()) * members as u64) >> u32::BITS) as usize);
    }
}

/// Draws the weights of the members.
pub(super) fn weigh(rng: &mut ChaCha8Rng, weights: &mut [f64]) {
    let members = weights.len();
    let weight = members as f64 / drawn(members) as f64;
    weights.fill(0.0);
    draw(members, rng, |member| weights[member] += weight);
}

/// Draws the mean of numbers of the members.
pub(super) fn mean(rng: &mut ChaCha8Rng, numbers: &[f64]) -> f64 {
    let mut sum = 0.0;
    draw(numbers.len(), rng, |member| sum += numbers[member]);
    sum / drawn(numbers.len()) as f64
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
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let made = 40_000;
            for _ in 0..made {
                weigh(&mut rng, &mut weights);
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

    #[test]
    fn a_mean_is_that_of_the_weights_drawn_from_the_same_stream() {
        let name = "a_mean_is_that_of_the_weights_drawn_from_the_same_stream";
        for members in [1usize, 2, 3, 4, 7, 8, 32, 33, 65] {
            let numbers: Vec<f64> = (0..members).map(|member| (3.0 * member as f64).sin()).collect();
            let [mut one, mut other] = [0, 0].map(|index| stream(1, name, index));
            let mut weights = vec![0.0; members];
            for made in 1..=20u128 {
                weigh(&mut other, &mut weights);
                let sum: f64 = numbers
                    .iter()
                    .zip(&weights)
                    .map(|(number, weight)| number * weight)
                    .sum();
                let apart = mean(&mut one, &numbers) - sum / members as f64;
                assert!(apart.abs() < 1e-12, "{members}: {apart}");
                assert_eq!(one.get_word_pos(), made * drawn(members) as u128, "{members}");
            }
        }
    }
}
