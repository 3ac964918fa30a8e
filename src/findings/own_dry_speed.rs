//! Takes e_dry at each run's own speed, where the scene asks for it, and carries k's uncertainty along.

use nalgebra::DMatrix;

use crate::inference::delta::Uncertain;
use crate::inference::laws::square_root_shift;
use crate::inference::least_squares::Fit;
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::impact::DrySpeed;
use crate::scene::{Scene, DEFAULT_DRY_SPEED};

/// The run's own dry speed in the square-root law: e_dry(v)² − e_dry(reference)² is a known offset once k is.
pub(super) struct OwnDrySpeed {
    pub(super) dry_k: f64,
    pub(super) dry_k_se: f64,
    pub(super) order: Order,
}

/// The speed at which e_inf is quoted, m/s.
pub fn reference_dry_speed(scene: &Scene) -> f64 {
    match scene.model.dry_speed {
        DrySpeed::Reference(speed) => speed,
        DrySpeed::Impact => DEFAULT_DRY_SPEED,
    }
}

impl OwnDrySpeed {
    pub fn offsets(&self, speeds: &[f64]) -> Vec<f64> {
        let reference = self.order.restitution(self.dry_k, DEFAULT_DRY_SPEED);
        let own = |v: &f64| self.order.restitution(self.dry_k, *v);
        speeds.iter().map(|v| own(v) * own(v) - reference * reference).collect()
    }

    /// v o′ and v² o″ of the offset o, in the speed.
    pub fn offset_slopes(&self, v: f64) -> [f64; 2] {
        let second = match self.order {
            Order::First => 0.0,
            Order::Second => SECOND_ORDER,
        };
        // with z = k v^(1/5), e = 1 − z + (3/5) z²; v z′ = z/5, v² z″ = −4 z/25
        let loss = self.dry_k * v.powf(0.2);
        let restitution = self.order.restitution(self.dry_k, v);
        let falls = 2.0 * second * loss - 1.0;
        let slope = 0.2 * falls * loss;
        let bend = -0.16 * falls * loss + 0.08 * second * loss * loss;
        [2.0 * restitution * slope, 2.0 * (slope * slope + restitution * bend)]
    }

    /// The same at some speeds.
    pub fn all_offset_slopes(&self, speeds: &[f64]) -> Vec<[f64; 2]> {
        speeds.iter().map(|v| self.offset_slopes(*v)).collect()
    }

    fn shift(&self, fit: &Fit, x: &[f64], offset: &[f64], speeds: &[f64], weighed: Option<&[f64]>) -> Option<[f64; 2]> {
        let slope = |v: f64| 2.0 * self.order.restitution(self.dry_k, v) * self.order.slope_dry_k(self.dry_k, v);
        let reference = slope(DEFAULT_DRY_SPEED);
        let slopes: Vec<f64> = speeds.iter().map(|v| slope(*v) - reference).collect();
        square_root_shift(fit, x, offset, &slopes, weighed)
    }

    /// Adds k's own uncertainty to the covariance; returns how the parameters move with k.
    pub fn widen(
        &self,
        uncertain: &mut Uncertain,
        fit: &Fit,
        [x, offset, speeds]: [&[f64]; 3],
        weighed: Option<&[f64]>,
    ) -> [f64; 2] {
        let shift = self.shift(fit, x, offset, speeds, weighed).unwrap_or_default();
        if let Ok(covariance) = &mut uncertain.covariance {
            let variance = self.dry_k_se * self.dry_k_se;
            *covariance += DMatrix::from_fn(2, 2, |i, j| shift[i] * shift[j] * variance);
        }
        shift
    }
}
