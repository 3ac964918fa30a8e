//! Draws what a replicate is fitted to: counts of runs, counts of series, or new noise on the fitted law.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::{Law, Target};
use crate::scene::ResamplingScheme;

/// Draws with replacement n − 1 of n members and tells each as `chosen(member)`; a single member is always itself.
///
/// With weights n/(n − 1) the variance of a mean is then s²/n, where n of n draws would give s²/n · (1 − 1/n)
/// (Rao & Wu 1988, doi:10.1080/01621459.1988.10478591).
fn draw_rescaled(rng: &mut ChaCha8Rng, members: usize, mut chosen: impl FnMut(usize)) {
    if members == 1 {
        return chosen(0);
    }
    // a word serves for several draws while what is left of it makes each of them even to 2⁻²⁰
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

/// The weight of a member each time it is drawn.
fn unit(members: usize) -> f64 {
    if members == 1 {
        1.0
    } else {
        members as f64 / (members as f64 - 1.0)
    }
}

/// Members whose counts fit into one word of 64 bits, four bits each.
const PACKED: usize = 16;

/// Weights of runs drawn inside each stratum.
pub(super) fn draw_cases(rng: &mut ChaCha8Rng, strata: &[Range<usize>], weights: &mut [f64]) {
    for stratum in strata {
        let runs = &mut weights[stratum.clone()];
        let unit = unit(runs.len());
        if runs.len() <= PACKED {
            // in a register: adding to memory just written would wait for it
            let mut counts = 0u64;
            draw_rescaled(rng, runs.len(), |run| counts += 1 << (4 * run));
            for weight in runs {
                *weight = (counts & 15) as f64 * unit;
                counts >>= 4;
            }
        } else {
            runs.fill(0.0);
            draw_rescaled(rng, runs.len(), |run| runs[run] += unit);
        }
    }
}

/// Weights of whole series drawn: every run weighs as its series does.
pub(super) fn draw_series(rng: &mut ChaCha8Rng, series: &[Range<usize>], first: usize, weights: &mut [f64]) {
    weights.fill(0.0);
    let unit = unit(series.len());
    draw_rescaled(rng, series.len(), |drawn| {
        for weight in &mut weights[series[drawn].start - first..series[drawn].end - first] {
            *weight += unit;
        }
    });
}

/// What the residual and parametric schemes draw from.
pub(super) struct Noise {
    fitted: Vec<f64>,
    /// residuals over √(1 − leverage), centred
    residuals: Vec<f64>,
    sd: f64,
}

impl Noise {
    pub(super) fn new(target: &Target) -> Noise {
        let fitted = target.fitted_restitution();
        let n = target.x.len() as f64;
        let p = target.law.parameters() as f64;
        let slope = |run: usize| match target.law {
            Law::Dry => [-target.x[run], 0.0],
            Law::Linear => [1.0, -target.x[run]],
            Law::SquareRoot => [0.5 / fitted[run], 0.5 * target.x[run] / fitted[run]],
        };
        let (mut j0, mut j1, mut j2) = (0.0, 0.0, 0.0);
        for run in 0..target.x.len() {
            let [a, b] = slope(run);
            j0 += a * a;
            j1 += a * b;
            j2 += b * b;
        }
        let determinant = j0 * j2 - j1 * j1;
        let leverage = |run: usize| {
            let [a, b] = slope(run);
            match target.law {
                Law::Dry => a * a / j0,
                _ => (a * a * j2 - 2.0 * a * b * j1 + b * b * j0) / determinant,
            }
        };
        let raw: Vec<f64> = target.restitution.iter().zip(&fitted).map(|(e, f)| e - f).collect();
        let sd = (raw.iter().map(|r| r * r).sum::<f64>() / (n - p)).sqrt();
        let mut residuals: Vec<f64> = raw
            .iter()
            .enumerate()
            .map(|(run, r)| r / (1.0 - leverage(run)).max(f64::EPSILON).sqrt())
            .collect();
        let mean = residuals.iter().sum::<f64>() / n;
        residuals.iter_mut().for_each(|r| *r -= mean);
        Noise { fitted, residuals, sd }
    }

    /// New restitutions about the fitted law. A run that would have stuck weighs nothing, as stuck runs are left out.
    pub(super) fn draw(
        &self,
        rng: &mut ChaCha8Rng,
        scheme: ResamplingScheme,
        restitution: &mut [f64],
        weights: &mut [f64],
    ) {
        for ((fitted, e), weight) in self.fitted.iter().zip(restitution).zip(weights) {
            let shift = if scheme == ResamplingScheme::Parametric {
                let z: f64 = StandardNormal.sample(rng);
                self.sd * z
            } else {
                self.residuals[rng.random_range(0..self.residuals.len())]
            };
            *e = (fitted + shift).max(0.0);
            *weight = if *e > 0.0 { 1.0 } else { 0.0 };
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
        for members in [2usize, 3, 5, 7, 16, 17, 40] {
            let mut rng = stream(1, "weights_have_the_moments_of_rescaled_draws", members as u64);
            let mut weights = vec![0.0; members];
            let (mut sums, mut squares, mut products) = (vec![0.0; members], 0.0, 0.0);
            let draws = 40_000;
            for _ in 0..draws {
                draw_cases(&mut rng, std::slice::from_ref(&(0..members)), &mut weights);
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
}
