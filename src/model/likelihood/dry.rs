//! Computes the log likelihood of the dry runs, from a few sums over those of each particle.

use super::normal::ln_normal_cdf;
use super::{e_dry, Likelihood, CERTAIN};
use crate::distributions::LN_ROOT_TWO_PI;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::dry::{Order, SECOND_ORDER};

/// The dry runs of a particle: their rebounds need four numbers, with y = 1 − e = k p + σ z.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct DryRuns {
    pub rebounds: f64,
    /// Σ p y / Σ p²
    pub slope: f64,
    /// Σ p²
    pub weight: f64,
    /// Σ (y − slope p)²
    pub leftover: f64,
    /// Σ p³, Σ p⁴ and Σ p² (y − slope p), which the second order wants
    pub bent: [f64; 3],
    /// stuck runs, by p
    pub stuck: Vec<f64>,
    /// rebounds, by p, where stuck runs were not logged
    pub logged: Vec<f64>,
}

impl DryRuns {
    /// Σ (e − e_dry)² over the rebounds, and its slope in k.
    fn squares(&self, order: Order, k: f64) -> (f64, f64) {
        let distance = k - self.slope;
        let first = (
            self.leftover + self.weight * distance * distance,
            2.0 * self.weight * distance,
        );
        match order {
            Order::First => first,
            // with y − k p + a k² p² = u − distance p + a k² p², where Σ p u = 0
            Order::Second => {
                let [cubes, fourth, bend] = self.bent;
                let a = SECOND_ORDER;
                let square = k * k;
                (
                    first.0 + a * square * (a * square * fourth + 2.0 * (bend - distance * cubes)),
                    first.1 + 4.0 * a * k * (a * square * fourth + bend - distance * cubes) - 2.0 * a * square * cubes,
                )
            }
        }
    }
}

impl Likelihood {
    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn dry(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        if let Some(own) = self.own.as_ref().filter(|own| !own.dry.is_empty()) {
            return self.of_dry_rows(own, self.tails(full), full, slopes);
        }
        let sigma = full[Kind::SigmaDry.slot()];
        let precision = 1.0 / (sigma * sigma);
        let mut value = 0.0;
        for (particle, runs) in self.dry.iter().enumerate() {
            if runs.rebounds == 0.0 && runs.stuck.is_empty() {
                continue;
            }
            let k = full[COMMON_SLOTS + particle];
            let (squares, slope) = runs.squares(self.form.dry, k);
            value -= runs.rebounds * (sigma.ln() + LN_ROOT_TWO_PI) + 0.5 * squares * precision;
            slopes[COMMON_SLOTS + particle] -= 0.5 * slope * precision;
            slopes[Kind::SigmaDry.slot()] += (squares * precision - runs.rebounds) / sigma;
            for p in &runs.logged {
                let (e_dry, fall) = e_dry(self.form.dry, k, *p);
                let z = (e_dry - self.limit) / sigma;
                if z > CERTAIN {
                    continue;
                }
                let (ln_cdf, mills) = ln_normal_cdf(z);
                value -= ln_cdf;
                slopes[COMMON_SLOTS + particle] += mills * fall / sigma;
                slopes[Kind::SigmaDry.slot()] += mills * z / sigma;
            }
            for p in &runs.stuck {
                let (e_dry, fall) = e_dry(self.form.dry, k, *p);
                let z = (self.limit - e_dry) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                value += ln_cdf;
                slopes[COMMON_SLOTS + particle] += mills * fall / sigma;
                slopes[Kind::SigmaDry.slot()] -= mills * z / sigma;
            }
        }
        value
    }
}
