//! Takes e_dry at each run's own speed, where the scene asks for it, and carries k's uncertainty along.

use nalgebra::DMatrix;

use crate::inference::delta::Uncertain;
use crate::inference::least_squares::Fit;
use crate::inference::regression::Regression;
use crate::physics::dry::{speed_root, REFERENCE_SPEED};
use crate::physics::Order;

/// The run's own dry speed in the square-root law: e_dry(v)² − e_dry(reference)² is a known offset once k is.
pub(super) struct OwnDrySpeed {
    pub(super) dry_k: f64,
    pub(super) dry_k_se: f64,
    pub(super) order: Order,
}

impl OwnDrySpeed {
    pub fn offsets(&self, speeds: &[f64]) -> Vec<f64> {
        let reference = self.order.restitution(self.dry_k, REFERENCE_SPEED);
        let own = |v: &f64| self.order.restitution(self.dry_k, *v);
        speeds.iter().map(|v| own(v) * own(v) - reference * reference).collect()
    }

    /// v o′ and v² o″ of the offset o, in the speed.
    pub fn offset_slopes(&self, v: f64) -> [f64; 2] {
        self.order.square_in_log_speed(self.dry_k * speed_root(v))
    }

    /// Slopes in k of the parameters fitted to runs at these speeds, with these variances of the residuals if they have
    /// their own; 0 where the fit has no covariance.
    pub fn shift(&self, fit: &Fit, regression: &Regression, speeds: &[f64], variance: &[f64]) -> [f64; 2] {
        let slope = |v: f64| 2.0 * self.order.restitution(self.dry_k, v) * self.order.slope_dry_k(self.dry_k, v);
        let reference = slope(REFERENCE_SPEED);
        let slopes: Vec<f64> = speeds.iter().map(|v| slope(*v) - reference).collect();
        regression
            .offset_sensitivity(fit, &slopes, variance)
            .unwrap_or_default()
    }

    /// Adds k's own uncertainty to the covariance of parameters that move so with k.
    pub fn widen(&self, uncertain: &mut Uncertain, shift: [f64; 2]) {
        if let Ok(covariance) = &mut uncertain.covariance {
            let variance = self.dry_k_se * self.dry_k_se;
            *covariance += DMatrix::from_fn(2, 2, |i, j| shift[i] * shift[j] * variance);
        }
    }
}
