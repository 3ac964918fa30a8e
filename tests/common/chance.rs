//! Seeds statistical tests and judges what they count.

// each test file uses its own part of this
#![allow(dead_code, reason = "shared by several test files")]

/// The seed of a statistical test: its own name, so that nobody picks it.
pub fn seed_of(test: &str) -> u64 {
    // FNV-1a
    test.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    }) >> 1
}

/// How many standard deviations a count of successes lies from its expectation.
pub fn binomial_z(successes: usize, of: usize, probability: f64) -> f64 {
    let n = of as f64;
    (successes as f64 - n * probability) / (n * probability * (1.0 - probability)).sqrt()
}

/// Mean and its standard error.
pub fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}
