//! Holds what the measurement of a run errs by.

use crate::physics::balance::{Balance, Impact};
use crate::runs::MeasurementErrors;

/// What the measurement of a run errs by.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Errors {
    /// 1/v, s/m
    pub slowness: f64,
    /// s, the standard deviation of the impact speed, m/s
    pub speed: f64,
    /// u², of the restitution beyond its share of the speed
    pub restitution: f64,
}

/// The share of its energy that a run keeps on average.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeanKept {
    /// r
    pub r: f64,
    /// dr/dv, s/m
    pub speed_slope: f64,
}

impl Errors {
    /// Those of a run with this impact speed; `None` where no run has any.
    pub fn of(errors: Option<&MeasurementErrors>, run: usize, impact_speed: f64) -> Option<Errors> {
        let [speed, own] = errors?.of(run);
        Some(Errors {
            slowness: 1.0 / impact_speed,
            speed,
            restitution: own * own,
        })
    }

    /// What a run keeps by a balance; its slope in the speed is 0 where the speed does not err.
    #[inline]
    pub fn mean_kept(self, balance: &Balance, at: &Impact) -> MeanKept {
        let speed_slope = if self.speed > 0.0 {
            balance.in_log_speed(at)[0] * self.slowness
        } else {
            0.0
        };
        MeanKept {
            r: balance.kept(at).0,
            speed_slope,
        }
    }

    /// Those of a run whose restitution was not measured.
    pub fn of_speed_alone(self) -> Errors {
        Errors {
            restitution: 0.0,
            ..self
        }
    }
}
