//! Says how probable what is known of one run is where nothing of it is hidden: at a true speed, with noise on the restitution.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::errors::Errors;
use super::normal::CERTAIN;
use super::run_density::{RunDensity, Seen, Side};
use super::tails::Tails;
use crate::physics::rebound::{mean_and_slope, mean_restitution, slope_mean_restitution};

/// The noise of the runs of a kind, wet or dry.
#[derive(Debug, Clone, Copy)]
pub struct RunNoise {
    /// its distribution
    pub tails: Tails,
    /// σ
    pub sigma: f64,
    /// σ_r; 0 where noise acts on the restitution alone
    pub energy: f64,
}

/// What is known of a run, and what its measurement errs by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeasuredRun {
    pub seen: Seen,
    pub errors: Errors,
}

/// What noise on the energy kept moves e by, over σ, below which it is none: σ² + (m′σ_r)² is then σ² to rounding.
const NOTICED: f64 = 1e-7;

/// A normal number of this spread; drawn only where there is some, so that draws that have none stay as they are.
pub fn normal_number<R: Rng + ?Sized>(spread: f64, rng: &mut R) -> f64 {
    if spread > 0.0 {
        let z: f64 = StandardNormal.sample(rng);
        spread * z
    } else {
        0.0
    }
}

impl RunNoise {
    /// e* of a run that keeps this, with what noise adds to the energy kept, and with noise on the restitution in units of its
    /// spread.
    pub fn restitution(&self, kept: f64, of_energy: f64, of_noise: f64) -> f64 {
        mean_restitution(kept + of_energy) + self.sigma * of_noise
    }

    /// Whether noise on the energy kept moves a run that keeps this by more than a rounding of its σ.
    pub fn acts_on_energy(&self, kept: f64) -> bool {
        let RunNoise { sigma, energy, .. } = *self;
        energy > 0.0 && slope_mean_restitution(kept) * energy > NOTICED * sigma
    }

    /// The log density or probability of a run that keeps this at so many times its measured speed, with its slopes in what is
    /// kept, σ and the shape of the noise: without noise on the energy kept.
    #[inline(always)] // where slopes are not read they are not computed
    pub(super) fn density(&self, MeasuredRun { seen, errors }: &MeasuredRun, kept: f64, ratio: f64) -> RunDensity {
        let (mean, slope) = mean_and_slope(kept);
        let sigma = self.sigma;
        // of the rebound speed over the measured impact speed
        let measured = |side: Side, e: f64| {
            let distance = e - errors.shared() * (1.0 - ratio) - mean * ratio;
            (side, distance, ratio, errors.variance(sigma * ratio).sqrt())
        };
        let (side, distance, ratio, spread) = match *seen {
            Seen::Rebound(e) => measured(Side::Below, e),
            Seen::Measured(side, e) => measured(side, e),
            // what sticks is not measured
            Seen::On(side, limit) => (side, limit - mean, 1.0, sigma),
        };
        let sign = side.sign();
        let z = sign * distance / spread;
        let is_density = matches!(seen, Seen::Rebound(_));
        if !is_density && self.tails == Tails::Normal && z > CERTAIN {
            return RunDensity::default();
        }
        // a density is per unit of e, not of z
        let (of, per_spread) = if is_density {
            (self.tails.ln_density(z), 1.0)
        } else {
            (self.tails.ln_probability_of(side, z), 0.0)
        };
        RunDensity {
            value: of.value - per_spread * spread.ln(),
            sigma: -(of.z * z + per_spread) * sigma * ratio * ratio / (spread * spread),
            shape: of.shape,
            kept: -sign * of.z * ratio / spread * slope,
            ..RunDensity::default()
        }
    }
}
