//! Computes the log likelihood of the dry runs, from a few sums over those of each sphere.

use super::normal::{ln_normal_cdf, CERTAIN};
use super::prepared::Likelihood;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;

impl Likelihood {
    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn dry(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        if let Some(own) = self.own.as_ref().filter(|own| !own.dry.is_empty()) {
            return self.of_dry_rows(own, self.tails(full), full, slopes);
        }
        let sigma = full[ParameterKind::SigmaDry.slot()];
        let precision = 1.0 / (sigma * sigma);
        let mut value = 0.0;
        for (sphere, runs) in self.dry.iter().enumerate() {
            if runs.rebounds == 0.0 && runs.stuck.is_empty() {
                continue;
            }
            let k = full[COMMON_SLOTS + sphere];
            let balance = Balance::dry(self.form.dry, k);
            let (squares, slope) = runs.squares(self.form.dry, k);
            value -= runs.rebounds * (sigma.ln() + LN_ROOT_TWO_PI) + 0.5 * squares * precision;
            slopes[COMMON_SLOTS + sphere] -= 0.5 * slope * precision;
            slopes[ParameterKind::SigmaDry.slot()] += (squares * precision - runs.rebounds) / sigma;
            for [p, count] in &runs.logged {
                let [e_dry, slope, _] = balance.e_dry(*p);
                let z = (e_dry - self.limit) / sigma;
                if z > CERTAIN {
                    continue;
                }
                let (ln_cdf, mills) = ln_normal_cdf(z);
                let mills = count * mills;
                value -= count * ln_cdf;
                slopes[COMMON_SLOTS + sphere] -= mills * slope / sigma;
                slopes[ParameterKind::SigmaDry.slot()] += mills * z / sigma;
            }
            for [p, count] in &runs.stuck {
                let [e_dry, slope, _] = balance.e_dry(*p);
                let z = (self.limit - e_dry) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                let mills = count * mills;
                value += count * ln_cdf;
                slopes[COMMON_SLOTS + sphere] -= mills * slope / sigma;
                slopes[ParameterKind::SigmaDry.slot()] -= mills * z / sigma;
            }
        }
        value
    }
}
