//! Draws with replacement n − 1 of the n runs of every stratum, several draws at a time.
//!
//! With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
//! (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::Rng;

/// Most ways in which draws made at once may fall, so that what is known of each way stays in the nearest cache.
const MOST_WAYS: usize = 64;

/// Most ways that one word of 64 bits decides: none is then likelier than another by more than a share of 2⁻³².
const MOST_WAYS_OF_A_WORD: u64 = 1 << 32;

/// The weight of a member each time it is drawn; a single member is always itself.
pub(super) fn unit(members: usize) -> f64 {
    if members == 1 {
        1.0
    } else {
        members as f64 / (members as f64 - 1.0)
    }
}

/// Draws made at once from so many members: as many as have no more than [`MOST_WAYS`], one at least.
fn at_once(members: usize) -> usize {
    let (mut draws, mut ways) = (1, members);
    while draws + 1 < members && ways * members <= MOST_WAYS {
        draws += 1;
        ways *= members;
    }
    draws
}

/// Draws made by each pick of a stratum of so many members, n − 1 in all.
pub(super) fn draws(members: usize) -> impl Iterator<Item = usize> {
    let all = members.saturating_sub(1);
    let at_once = at_once(members);
    (0..all).step_by(at_once).map(move |made| at_once.min(all - made))
}

/// Ways in which so many draws of so many members fall.
pub(super) fn ways(members: usize, draws: usize) -> usize {
    (0..draws).map(|_| members).product()
}

/// The members drawn where draws fell in this way: its digits to the base of the members.
pub(super) fn drawn(way: usize, members: usize, draws: usize) -> impl Iterator<Item = usize> {
    (0..draws).scan(way, move |left, _| {
        let member = *left % members;
        *left /= members;
        Some(member)
    })
}

/// Members whose counts fit into one word of 64 bits, four bits each.
const PACKED: usize = 16;

/// Weights of the members of one stratum, from how its draws fell.
pub(super) fn weigh(fell: &[u32], weights: &mut [f64]) {
    let n = weights.len();
    let unit = unit(n);
    if n == 1 {
        weights[0] = 1.0;
    } else if n <= PACKED {
        // in a register: adding to memory just written would wait for it
        let mut counts = 0u64;
        for (way, draws) in fell.iter().zip(draws(n)) {
            drawn(*way as usize, n, draws).for_each(|member| counts += 1 << (4 * member));
        }
        for weight in weights {
            *weight = (counts & 15) as f64 * unit;
            counts >>= 4;
        }
    } else {
        weights.fill(0.0);
        for (way, draws) in fell.iter().zip(draws(n)) {
            drawn(*way as usize, n, draws).for_each(|member| weights[member] += unit);
        }
    }
}

/// Ways in which the draws of a pick fall, numbered from the first on.
#[derive(Clone, Copy)]
struct Ways {
    first: u32,
    count: u32,
}

/// Which draws are made at once, and which of them one random word decides.
pub(super) struct Picks {
    ways: Vec<Ways>,
    /// picks that one word decides
    words: Vec<Range<usize>>,
    /// picks of each stratum
    pub(super) strata: Vec<Range<usize>>,
}

impl Picks {
    pub(super) fn new(strata: &[Range<usize>]) -> Picks {
        let mut picks = Picks {
            ways: vec![],
            words: vec![],
            strata: vec![],
        };
        let mut decided = u64::MAX;
        for stratum in strata {
            let (first, n) = (picks.ways.len(), stratum.len());
            for draws in draws(n) {
                let (pick, ways) = (picks.ways.len(), ways(n, draws));
                decided = decided.saturating_mul(ways as u64);
                match picks.words.last_mut().filter(|_| decided <= MOST_WAYS_OF_A_WORD) {
                    Some(word) => word.end = pick + 1,
                    None => {
                        picks.words.push(pick..pick + 1);
                        decided = ways as u64;
                    }
                }
                picks.ways.push(Ways {
                    first: 0,
                    count: u32::try_from(ways).unwrap_or(u32::MAX),
                });
            }
            picks.strata.push(first..picks.ways.len());
        }
        picks
    }

    /// Numbers the ways of a pick from here on, which a table over them wants.
    pub(super) fn number_from(&mut self, pick: usize, first: u32) {
        self.ways[pick].first = first;
    }

    /// Picks of a replicate.
    pub(super) fn len(&self) -> usize {
        self.ways.len()
    }

    /// Words of 32 bits that a replicate uses, always as many.
    pub(super) fn words(&self) -> u64 {
        2 * self.words.len() as u64
    }

    /// How the draws of a replicate fall.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng, fell: &mut [u32]) {
        for word in &self.words {
            let mut left = rng.next_u64();
            for (way, ways) in fell[word.clone()].iter_mut().zip(&self.ways[word.clone()]) {
                let scaled = u128::from(left) * u128::from(ways.count);
                *way = ways.first + (scaled >> 64) as u32;
                left = scaled as u64;
            }
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
            let mut fell = vec![0; picks.len()];
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let draws = 40_000;
            for _ in 0..draws {
                picks.draw(&mut rng, &mut fell);
                weigh(&fell, &mut weights);
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
        assert!(picks.words.len() < picks.len());
        let mut rng = stream(1, "strata_that_share_a_word_are_drawn_apart", 0);
        let mut fell = vec![0; picks.len()];
        let draws = 40_000;
        let mut sums = vec![0.0; picks.len() * picks.len()];
        let centred = |way: u32, ways: u32| (f64::from(way) + 0.5) / f64::from(ways) - 0.5;
        for _ in 0..draws {
            picks.draw(&mut rng, &mut fell);
            for a in 0..fell.len() {
                assert!(fell[a] < picks.ways[a].count);
                for b in 0..a {
                    sums[a * fell.len() + b] +=
                        centred(fell[a], picks.ways[a].count) * centred(fell[b], picks.ways[b].count);
                }
            }
        }
        // each product has a standard deviation of at most 1/4
        let limit = 4.5 * 0.25 / f64::from(draws).sqrt();
        for sum in sums {
            assert!((sum / f64::from(draws)).abs() < limit, "{sum}");
        }
    }

    #[test]
    fn draws_are_made_at_once_while_there_are_few_ways() {
        let of = |members: usize| draws(members).collect::<Vec<_>>();
        assert_eq!(of(1), [0; 0]);
        assert_eq!(of(2), [1]);
        assert_eq!(of(3), [2]);
        assert_eq!(of(4), [3]);
        assert_eq!(of(5), [2, 2]);
        assert_eq!(of(6), [2, 2, 1]);
        assert_eq!(of(8), [2, 2, 2, 1]);
        assert_eq!(of(9), [1; 8]);
        assert_eq!(drawn(47, 7, 2).collect::<Vec<_>>(), [5, 6]);
    }
}
