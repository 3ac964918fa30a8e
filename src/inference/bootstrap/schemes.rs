//! Draws what a replicate is fitted to where runs keep no stratum: counts of series, or new noise on the fitted law.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

use super::batches::unit_weight;
use super::target::Target;
use crate::scene::ResamplingScheme;

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

/// What the residual and parametric schemes draw from.
pub(super) struct ResamplingNoise {
    fitted: Vec<f64>,
    /// residuals over √(1 − leverage), centred
    residuals: Vec<f64>,
    sd: f64,
    /// what a residual of each run is more than one of mean weight; empty where all weigh alike
    wider: Vec<f64>,
}

impl ResamplingNoise {
    pub(super) fn new(target: &Target) -> ResamplingNoise {
        let Target { regression, .. } = target;
        let fitted = regression.fitted(target.fitted);
        let p = regression.law.parameters() as f64;
        let wider: Vec<f64> = match target.run_weights {
            Some(own) => own.weights.iter().map(|weight| weight.sqrt().recip()).collect(),
            None => vec![],
        };
        // infinitely wider where a run is left out
        let counted = |run: usize| wider.get(run).is_none_or(|wider| wider.is_finite());
        let n = (0..fitted.len()).filter(|run| counted(*run)).count() as f64;
        let of_run = |run: usize| wider.get(run).copied().unwrap_or(1.0);
        let slope = |run: usize| match of_run(run) {
            // left out
            f64::INFINITY => 0.0,
            wider => regression.response(target.fitted, run).slope / wider,
        };
        let mut information = [0.0; 3];
        for (run, x) in regression.x.iter().enumerate() {
            let squared = slope(run) * slope(run);
            for (sum, product) in information.iter_mut().zip(regression.law.design_products(*x)) {
                *sum += squared * product;
            }
        }
        let leverage = |run: usize| {
            let row = regression.law.design(regression.x[run]).map(|c| slope(run) * c);
            let [a, b] = regression.law.solve(information, row);
            row[0] * a + row[1] * b
        };
        let residual = |(run, (e, f)): (usize, (&f64, &f64))| (e - f) / of_run(run);
        let raw: Vec<f64> = regression
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
        ResamplingNoise {
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
