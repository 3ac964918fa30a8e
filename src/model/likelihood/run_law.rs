//! Says what one run adds to the log likelihood: with the noise of its kind, its tails, and what its measurement errs by.

use super::energy::over_energy;
use super::errors::Errors;
use super::hidden::Hidden;
use super::run_density::{RunDensity, Seen, Side};
use super::run_noise::{MeasuredRun, RunNoise};
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::mean_and_slope;

/// A run's impact as measured, with its energy balance.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunImpact<'b> {
    pub balance: &'b Balance,
    pub impact: Impact,
    pub errors: Errors,
}

impl RunImpact<'_> {
    /// r with its slope in k.
    pub fn kept(&self) -> (f64, f64) {
        self.balance.kept(&self.impact)
    }

    /// The same with the slopes that follow from that in what is kept, whose slope in k is this.
    pub fn with_slopes(&self, of: RunDensity, slope_k: f64) -> RunDensity {
        RunDensity {
            viscous: of.kept * self.impact.over_stokes,
            dry_k: of.kept * slope_k,
            ..of
        }
    }

    /// What a run adds of which this is known, integrated over what is hidden of it.
    #[inline(always)] // where slopes are not read they are not computed
    pub fn density(&self, noise: &RunNoise, seen: Seen) -> RunDensity {
        let run = MeasuredRun {
            seen,
            errors: self.errors,
        };
        let (kept, slope_k) = self.kept();
        if self.errors.speed > 0.0 {
            Hidden::of_run(*noise, (self.balance, self.impact), &run)
        } else if noise.acts_on_energy(kept) {
            self.with_slopes(over_energy(*noise, kept, &run), slope_k)
        } else {
            self.with_slopes(noise.density(&run, kept, 1.0), slope_k)
        }
    }
}

/// A new run that is measured without error.
#[derive(Debug, Clone, Copy)]
pub struct NewImpact {
    noise: RunNoise,
    /// r
    kept: f64,
    /// m(r)
    mean: f64,
}

impl NewImpact {
    /// One that keeps this; the spread of noise on the restitution is above 0.
    pub fn new(noise: RunNoise, kept: f64) -> NewImpact {
        let (mean, _) = mean_and_slope(kept);
        NewImpact { noise, kept, mean }
    }

    /// The probability that it comes out at or below a restitution.
    pub fn probability_below(&self, restitution: f64) -> f64 {
        let NewImpact { noise, kept, mean } = *self;
        if !noise.acts_on_energy(kept) {
            return noise.tails.ln_below((restitution - mean) / noise.sigma).exp();
        }
        let run = MeasuredRun {
            seen: Seen::On(Side::Below, restitution),
            errors: Errors::NONE,
        };
        over_energy(noise, kept, &run).value.exp()
    }
}
