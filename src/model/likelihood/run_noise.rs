//! Says how probable what is known of one run is where nothing of it is hidden: at a true speed, with noise on the restitution.

use super::errors::Errors;
use super::normal::CERTAIN;
use super::run_density::{RunDensity, Seen, Spreads};
use super::tails::Tails;
use crate::physics::rebound::{mean_and_slope, slope_mean_restitution};

/// The noise of the runs of a kind, wet or dry, at a full vector of parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunNoise {
    pub tails: Tails,
    pub spreads: Spreads,
    /// whether there was a liquid
    pub wet: bool,
}

/// What is known of a run, and what its measurement errs by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeasuredRun {
    pub seen: Seen,
    pub errors: Errors,
}

/// What noise on the energy kept moves e by, over σ, below which it is none: σ² + (m′σ_r)² is then σ² to rounding.
const NOTICED: f64 = 1e-7;

impl RunNoise {
    /// m(r) and its slope; of a dry run what is kept is its mean restitution already.
    #[inline(always)]
    pub fn mean(&self, kept: f64) -> (f64, f64) {
        if self.wet {
            mean_and_slope(kept)
        } else {
            (kept, 1.0)
        }
    }

    /// Whether noise on the energy kept moves a run that keeps this by more than a rounding of its σ.
    pub fn acts_on_energy(&self, kept: f64) -> bool {
        self.wet && slope_mean_restitution(kept) * self.spreads.energy > NOTICED * self.spreads.sigma
    }

    /// Whether normal noise on the energy kept moves every run by more than that.
    pub fn acts_on_every_energy(&self) -> bool {
        // m′ is above a half up to r = 1
        self.wet && self.tails == Tails::Normal && self.spreads.energy > 2.0 * NOTICED * self.spreads.sigma
    }

    /// The log density or probability of a run that keeps this at so many times its measured speed, with its slopes in what is
    /// kept, σ and the shape of the noise: without noise on the energy kept.
    #[inline]
    pub fn density(&self, MeasuredRun { seen, errors }: &MeasuredRun, kept: f64, ratio: f64) -> RunDensity {
        let (mean, slope) = self.mean(kept);
        let sigma = self.spreads.sigma;
        // of the rebound speed over the measured impact speed
        let measured = |e: f64| e - errors.shared() * (1.0 - ratio);
        let on_side = |sign: f64, distance: f64, ratio: f64, spread: f64| {
            let z = sign * distance / spread;
            if self.tails == Tails::Normal && z > CERTAIN {
                return RunDensity::default();
            }
            let probability = self.tails.ln_probability(z);
            RunDensity {
                value: probability.value,
                sigma: -probability.z * z * sigma * ratio * ratio / (spread * spread),
                shape: probability.shape,
                kept: -sign * probability.z * ratio / spread * slope,
                ..RunDensity::default()
            }
        };
        match *seen {
            Seen::Rebound(e) => {
                let variance = errors.variance(sigma * ratio);
                let density = self.tails.ln_density(measured(e) - mean * ratio, variance, 1.0);
                RunDensity {
                    value: density.value,
                    sigma: 2.0 * density.variance * sigma * ratio * ratio,
                    shape: density.shape,
                    kept: density.mean * ratio * slope,
                    ..RunDensity::default()
                }
            }
            // what sticks is not measured
            Seen::On(side, limit) => on_side(side.sign(), limit - mean, 1.0, sigma),
            Seen::Measured(side, e) => {
                let spread = errors.variance(sigma * ratio).sqrt();
                on_side(side.sign(), measured(e) - mean * ratio, ratio, spread)
            }
        }
    }
}
