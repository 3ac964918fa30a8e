//! Draws whole series.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::Rng;

use super::batches::unit_weight;

/// Draws with replacement n − 1 of n members and calls `chosen(member)` for each; a single member is always itself.
fn draw_rescaled(rng: &mut ChaCha8Rng, members: usize, mut chosen: impl FnMut(usize)) {
    if members == 1 {
        return chosen(0);
    }
    // a word decides several draws while what is left of it makes each of them even to 2⁻²⁰
    const EVEN: u64 = 1 << 12;
    let (mut word, mut used) = (0u32, EVEN);
    for _ in 1..members {
        used *= members as u64;
        if used > EVEN {
            word = rng.next_u32();
            used = members as u64;
        }
        let scaled = u64::from(word) * members as u64;
        word = scaled as u32;
        chosen((scaled >> 32) as usize);
    }
}

/// Weights of whole series drawn: every run weighs as its series does.
pub(super) fn draw_series(rng: &mut ChaCha8Rng, series: &[Range<usize>], first: usize, weights: &mut [f64]) {
    weights.fill(0.0);
    let unit = unit_weight(series.len());
    draw_rescaled(rng, series.len(), |drawn| {
        for weight in &mut weights[series[drawn].start - first..series[drawn].end - first] {
            *weight += unit;
        }
    });
}
