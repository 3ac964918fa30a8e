//! Says what one run adds to the log likelihood: with the noise of its kind, its tails, and what its measurement errs by.

use super::convolution;
use super::errors::Errors;
use super::hidden_speed::{HiddenSpeed, MeasuredRun, SettingRuns, SettingSlopes};
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::tails::Tails;
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::mean_and_slope;

/// The noise of the runs of a kind, wet or dry, at a full vector of parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunNoise {
    pub tails: Tails,
    pub spreads: Spreads,
    /// whether there was a liquid
    pub wet: bool,
}

/// What noise on the energy kept moves e by, over σ, below which it is none: σ² + (m′σ_r)² is then σ² to rounding.
const NOTICED: f64 = 1e-7;

/// A run's impact as measured, with its energy balance.
#[derive(Debug, Clone, Copy)]
pub(super) struct RunImpact<'b> {
    pub balance: &'b Balance,
    pub impact: Impact,
    pub errors: Errors,
}

impl RunNoise {
    /// What a run adds of which this is known.
    pub fn density(&self, run: RunImpact, seen: Seen) -> RunDensity {
        let RunImpact {
            balance,
            impact,
            errors,
        } = run;
        if errors.speed > 0.0 {
            let setting = SettingRuns {
                balance,
                impact,
                runs: &[MeasuredRun { seen, errors }],
            };
            let mut slopes = [SettingSlopes::default()];
            let found = self.hidden(&[setting]).integrate(&mut slopes);
            return found.with(slopes[0]);
        }
        let mut found = if self.wet {
            let (r, of_k) = balance.kept(&impact);
            let (mean, slope) = mean_and_slope(r);
            let of = if slope * self.spreads.energy > NOTICED * self.spreads.sigma {
                self.on_both(r, seen, errors)
            } else {
                self.on_restitution(mean, slope, seen, errors)
            };
            RunDensity {
                dry_k: of.kept * of_k,
                ..of
            }
        } else {
            let [e_dry, slope_k, _] = balance.e_dry(impact.dry_root);
            let of = self.on_restitution(e_dry, 1.0, seen, errors);
            RunDensity {
                dry_k: of.kept * slope_k,
                ..of
            }
        };
        found.viscous = found.kept * impact.over_stokes;
        found
    }

    /// Runs that share a true speed.
    pub fn hidden<'b>(&self, settings: &'b [SettingRuns<'b>]) -> HiddenSpeed<'b> {
        HiddenSpeed {
            tails: self.tails,
            spreads: self.spreads,
            wet: self.wet,
            settings,
        }
    }

    /// With noise on the energy kept.
    fn on_both(&self, r: f64, seen: Seen, errors: Errors) -> RunDensity {
        let sigma = self.spreads.sigma;
        let (of, share) = match seen {
            Seen::Rebound(e) => {
                let spread = if errors.restitution > 0.0 {
                    sigma.hypot(errors.restitution)
                } else {
                    sigma
                };
                let spreads = Spreads {
                    sigma: spread,
                    ..self.spreads
                };
                (convolution::ln_density(self.tails, e, r, spreads), sigma / spread)
            }
            Seen::On(side, limit) => (
                convolution::ln_probability(self.tails, side, limit, r, self.spreads),
                1.0,
            ),
            Seen::Measured(side, e) => {
                let spread = sigma.hypot(errors.restitution);
                let spreads = Spreads {
                    sigma: spread,
                    ..self.spreads
                };
                let of = convolution::ln_probability(self.tails, side, e, r, spreads);
                (of, sigma / spread)
            }
        };
        RunDensity {
            value: of.value,
            sigma: of.sigma * share,
            energy: of.energy,
            nu: of.nu,
            kept: of.kept,
            ..RunDensity::default()
        }
    }

    /// With noise on the restitution alone, about this mean of this slope in r.
    fn on_restitution(&self, mean: f64, slope: f64, seen: Seen, errors: Errors) -> RunDensity {
        let sigma = self.spreads.sigma;
        match seen {
            Seen::Rebound(e) => {
                let variance = sigma * sigma + errors.restitution * errors.restitution;
                let density = self.tails.ln_density(e - mean, variance, 1.0);
                RunDensity {
                    value: density.value,
                    sigma: density.variance * 2.0 * sigma,
                    nu: density.nu,
                    kept: density.mean * slope,
                    ..RunDensity::default()
                }
            }
            Seen::On(side, limit) | Seen::Measured(side, limit) => {
                let spread = match seen {
                    Seen::Measured(..) => sigma.hypot(errors.restitution),
                    _ => sigma,
                };
                let sign = side.sign();
                let z = sign * (limit - mean) / spread;
                let probability = self.tails.ln_probability(z);
                RunDensity {
                    value: probability.value,
                    sigma: -probability.z * z * sigma / (spread * spread),
                    nu: probability.nu,
                    kept: -sign * probability.z / spread * slope,
                    ..RunDensity::default()
                }
            }
        }
    }
}

/// The probability of a wet run that keeps r on average to come out at or below a restitution, with its density there.
pub struct BelowRestitution {
    /// up to there
    pub probability: f64,
    /// per unit of e
    pub density: f64,
}

impl BelowRestitution {
    /// Where noise acts on the energy kept, too; `spreads` are above 0.
    pub fn of(tails: Tails, restitution: f64, r: f64, spreads: Spreads) -> BelowRestitution {
        BelowRestitution {
            probability: convolution::ln_probability(tails, Side::Below, restitution, r, spreads)
                .value
                .exp(),
            density: convolution::ln_density(tails, restitution, r, spreads).value.exp(),
        }
    }
}
