//! Holds what the measurement of a run errs by.

use crate::runs::{Runs, SharedSpeed, TrueSpeed, TrueSpeeds};
use crate::scene::Scene;

/// What the measurement of a run errs by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors {
    /// s/v, the standard deviation of the impact speed as a share of it
    pub speed: f64,
    /// u, of the restitution beyond its share of the impact speed
    pub restitution: f64,
    /// of the errors of both speeds
    pub correlation: f64,
    /// the true impact speed over the measured one
    pub true_speed: TrueSpeed,
    /// whether other runs have the same true speed
    pub is_shared: bool,
}

impl Errors {
    /// Of a run that was measured without any.
    pub const NONE: Errors = Errors {
        speed: 0.0,
        restitution: 0.0,
        correlation: 0.0,
        true_speed: TrueSpeed::EXACT,
        is_shared: false,
    };

    /// The true impact speed over the measured one, at so many standard deviations from its mean; nothing below a hundredth
    /// is counted.
    #[inline(always)]
    pub fn ratio(&self, z: f64) -> f64 {
        (self.true_speed.mean + self.true_speed.sd * z).max(0.01)
    }

    /// By how much M moves with z where m does by `of_mean`.
    #[inline(always)]
    pub fn moved(&self, ratio: f64, mean: f64, of_mean: f64) -> f64 {
        ratio * of_mean + (mean - self.shared()) * self.true_speed.sd
    }

    /// S², about which a restitution is measured with so much noise of its own: (1 − ρ²) u² beside its square.
    #[inline(always)]
    pub fn variance(&self, noise: f64) -> f64 {
        noise * noise + (1.0 - self.correlation * self.correlation) * self.restitution * self.restitution
    }

    /// c = ρ u v/s: by how much of 1 − v_t/v the restitution errs with the impact speed; 0 where that does not err.
    pub fn shared(&self) -> f64 {
        if self.speed > 0.0 {
            self.correlation * self.restitution / self.speed
        } else {
            0.0
        }
    }
}

/// The errors of every run, with what is known of its true speed, and the groups that share one; none where no run has any.
pub(super) fn errors_of(scene: &Scene, runs: &Runs) -> (Vec<Errors>, Vec<SharedSpeed>) {
    let Some(measured) = runs.errors_with_medians() else {
        return (vec![], vec![]);
    };
    let TrueSpeeds { of_run, shared } = runs.true_speeds(scene, &measured);
    let of = |(run, true_speed): (usize, TrueSpeed)| Errors {
        speed: measured[run].impact_speed_sd / runs.impact_speed[run],
        restitution: measured[run].restitution_sd,
        correlation: measured[run].speed_correlation,
        true_speed,
        is_shared: false,
    };
    let mut errors: Vec<Errors> = of_run.into_iter().enumerate().map(of).collect();
    for run in shared.iter().flat_map(SharedSpeed::runs) {
        errors[run].is_shared = true;
    }
    (errors, shared)
}
