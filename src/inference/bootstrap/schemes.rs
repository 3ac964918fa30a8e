//! Draws what a replicate is fitted to where runs keep no stratum: counts of series, or new noise on the fitted law.

use crate::physics::dry::{Order, SECOND_ORDER};
use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::picks::unit;
use super::{Law, Target};
use crate::scene::ResamplingScheme;

/// Draws with replacement n − 1 of n members and tells each as `chosen(member)`; a single member is always itself.
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
    /// what a residual of each run is more than one of mean weight; empty where all weigh alike
    wider: Vec<f64>,
}

impl Noise {
    pub(super) fn new(target: &Target) -> Noise {
        let fitted = target.fitted_restitution();
        let p = target.law.parameters() as f64;
        let wider: Vec<f64> = match target.kept {
            Some(kept) => kept.weights.iter().map(|weight| weight.sqrt().recip()).collect(),
            None => vec![],
        };
        // infinitely wider where a run is left out
        let counted = |run: usize| wider.get(run).is_none_or(|wider| wider.is_finite());
        let n = (0..target.x.len()).filter(|run| counted(*run)).count() as f64;
        let of_run = |run: usize| wider.get(run).copied().unwrap_or(1.0);
        let plain = |run: usize| match target.law {
            Law::Dry(Order::First) => [-target.x[run], 0.0],
            Law::Dry(Order::Second) => {
                let s = target.x[run];
                [-s * (1.0 - 2.0 * SECOND_ORDER * target.fitted[0] * s), 0.0]
            }
            Law::Linear => [1.0, -target.x[run]],
            Law::SquareRoot => [0.5 / fitted[run], 0.5 * target.x[run] / fitted[run]],
        };
        let slope = |run: usize| match of_run(run) {
            // left out
            f64::INFINITY => [0.0; 2],
            wider => plain(run).map(|slope| slope / wider),
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
                Law::Dry(_) => a * a / j0,
                _ => (a * a * j2 - 2.0 * a * b * j1 + b * b * j0) / determinant,
            }
        };
        let residual = |(run, (e, f)): (usize, (&f64, &f64))| (e - f) / of_run(run);
        let raw: Vec<f64> = target
            .restitution
            .iter()
            .zip(&fitted)
            .enumerate()
            .map(residual)
            .collect();
        let sd = (raw.iter().map(|r| r * r).sum::<f64>() / (n - p)).sqrt();
        let mut residuals: Vec<f64> = raw
            .iter()
            .enumerate()
            .filter(|(run, _)| counted(*run))
            .map(|(run, r)| r / (1.0 - leverage(run)).max(f64::EPSILON).sqrt())
            .collect();
        let mean = residuals.iter().sum::<f64>() / n;
        residuals.iter_mut().for_each(|r| *r -= mean);
        Noise {
            fitted,
            residuals,
            sd,
            wider,
        }
    }

    /// New restitutions about the fitted law. A run that would have stuck weighs nothing, as stuck runs are left out.
    pub(super) fn draw(
        &self,
        rng: &mut ChaCha8Rng,
        scheme: ResamplingScheme,
        restitution: &mut [f64],
        weights: &mut [f64],
    ) {
        for (run, ((fitted, e), weight)) in self.fitted.iter().zip(restitution).zip(weights).enumerate() {
            let shift = if scheme == ResamplingScheme::Parametric {
                let z: f64 = StandardNormal.sample(rng);
                self.sd * z
            } else {
                self.residuals[rng.random_range(0..self.residuals.len())]
            };
            let wider = self.wider.get(run).copied().unwrap_or(1.0);
            let shift = if wider.is_finite() { wider * shift } else { 0.0 };
            *e = (fitted + shift).max(0.0);
            *weight = if *e > 0.0 { 1.0 } else { 0.0 };
        }
    }
}
