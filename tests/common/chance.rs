//! Seeds statistical tests, simulates their sets and judges what they count.

use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

/// The seed of a statistical test: its own name, so that nobody picks it.
pub fn seed_of(test: &str) -> u64 {
    // FNV-1a
    test.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    }) >> 1
}

/// What becomes of so many simulated sets, each with a seed of its own, in their order.
pub fn study<T: Send>(test: &str, sets: u64, outcome: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let seed = seed_of(test);
    let of_set = |set: u64| outcome(seed.wrapping_add(set));
    (0..sets).into_par_iter().map(of_set).collect()
}

/// In how many outcomes each of some things is so.
pub fn counts<const N: usize>(outcomes: &[[bool; N]]) -> [usize; N] {
    std::array::from_fn(|place| outcomes.iter().filter(|outcome| outcome[place]).count())
}

/// Whether an interval holds the truth; one that is missing does not.
pub fn holds(interval: Option<[f64; 2]>, truth: f64) -> bool {
    interval.is_some_and(|[lo, hi]| (lo..=hi).contains(&truth))
}

/// How many standard deviations a count of successes lies from its expectation.
pub fn binomial_z(successes: usize, of: usize, probability: f64) -> f64 {
    let n = of as f64;
    (successes as f64 - n * probability) / (n * probability * (1.0 - probability)).sqrt()
}

/// Holds a count of successes to what is expected, within four standard deviations.
#[track_caller]
pub fn assert_expected(what: &str, successes: usize, of: u64, probability: f64) {
    let z = binomial_z(successes, of as usize, probability);
    assert!(z.abs() < 4.0, "{what}: {successes} of {of}, z = {z:.1}");
}

/// Holds a count to be no more than is expected.
#[track_caller]
pub fn assert_seldom(what: &str, successes: usize, of: u64, probability: f64) {
    let z = binomial_z(successes, of as usize, probability);
    assert!(z < 4.0, "{what}: {successes} of {of}, z = {z:.1}");
}

/// Mean and its standard error.
pub fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}

/// A number drawn from the standard normal distribution.
pub fn normal(rng: &mut impl rand::Rng) -> f64 {
    StandardNormal.sample(rng)
}
