//! Says what one run adds to the log likelihood: with the noise of its kind, its tails, and what its measurement errs by.

use super::convolution::{self, MOST_REBOUNDS};
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

/// Rebounds that were measured without errors, as columns.
pub(super) struct ReboundBatch {
    pub count: usize,
    pub restitution: [f64; MOST_REBOUNDS],
    /// r, and its slope in k
    pub kept: [f64; MOST_REBOUNDS],
    pub of_k: [f64; MOST_REBOUNDS],
    /// 4/St
    pub over_stokes: [f64; MOST_REBOUNDS],
}

impl ReboundBatch {
    pub const NONE: ReboundBatch = ReboundBatch {
        count: 0,
        restitution: [0.0; MOST_REBOUNDS],
        kept: [0.0; MOST_REBOUNDS],
        of_k: [0.0; MOST_REBOUNDS],
        over_stokes: [0.0; MOST_REBOUNDS],
    };

    pub fn push(&mut self, restitution: f64, balance: &Balance, impact: &Impact) {
        let to = self.count;
        self.restitution[to] = restitution;
        (self.kept[to], self.of_k[to]) = balance.kept(impact);
        self.over_stokes[to] = impact.over_stokes;
        self.count += 1;
    }
}

impl RunNoise {
    /// Whether rebounds may be taken several at a time: with normal noise on the energy kept as well, and that is noticed.
    pub fn goes_side_by_side(&self) -> bool {
        // m′ is above a half up to r = 1
        self.wet && self.tails == Tails::Normal && self.spreads.energy > 2.0 * NOTICED * self.spreads.sigma
    }

    /// Writes what each of some rebounds adds where noise [`RunNoise::goes_side_by_side`]; `None` where it has to be asked for by
    /// itself.
    pub fn densities(&self, of: &ReboundBatch, to: &mut [Option<RunDensity>; MOST_REBOUNDS]) {
        let mut found = [None; MOST_REBOUNDS];
        let seen = [&of.restitution, &of.kept].map(|column| &column[..of.count]);
        convolution::ln_densities(seen, self.spreads, &mut found[..of.count]);
        for ((to, found), (over_stokes, of_k)) in to.iter_mut().zip(found).zip(of.over_stokes.iter().zip(&of.of_k)) {
            *to = found.map(|found| RunDensity {
                value: found.value,
                sigma: found.sigma,
                energy: found.energy,
                nu: found.nu,
                kept: found.kept,
                viscous: found.kept * over_stokes,
                dry_k: found.kept * of_k,
            });
        }
    }

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
