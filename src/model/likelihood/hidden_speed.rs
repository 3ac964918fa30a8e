//! Integrates over the true impact speed of a run whose measured one errs, or of repeats that share one.
//!
//! Symbols: q = v_t/v, the true speed over the measured one, q = q̄ + s̄ z with z standard normal; e = v_r/v as measured. At a
//! true speed the rebound speed is measured about m(r(q)) v_t with σ v_t and its own error, of which the error of the impact
//! speed, then known, explains a part where both are correlated: e is distributed about M = m(r(q)) q + c (1 − q) with
//! S² = σ² q² + (1 − ρ²) u², c = ρ u v/s. Whether a run sticks depends on its true speed alone. Repeats of one true speed
//! have one z, and their densities at it are multiplied: what their mean errs by is an error of all of them. Of other films
//! and diameters each has its own r(z).

mod bell;
mod lanes;
mod many;
mod near_turn;
mod reach;
mod rules;

pub(super) use many::{ManySpeeds, SpeedRuns, Together};

use super::convolution;
use super::errors::Errors;
use super::normal::CERTAIN;
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::tails::Tails;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::mean_and_slope;
use crate::runs::MOST_SETTINGS;

/// What is known of a run, and what its measurement errs by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeasuredRun {
    pub seen: Seen,
    pub errors: Errors,
}

/// Runs of one setting, with what is known of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct SettingRuns<'b> {
    pub balance: &'b Balance,
    /// at the measured speed of the first
    pub impact: Impact,
    /// at least one
    pub runs: &'b [MeasuredRun],
}

/// Runs of one true speed.
#[derive(Clone, Copy)]
pub(super) struct HiddenSpeed<'b> {
    pub tails: Tails,
    pub spreads: Spreads,
    /// whether there was a liquid
    pub wet: bool,
    /// at least one
    pub settings: &'b [SettingRuns<'b>],
}

/// Slopes of a log density in what a setting keeps.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SettingSlopes {
    /// in r; in e_dry of dry runs
    pub kept: f64,
    /// in −L
    pub viscous: f64,
    /// in k
    pub dry_k: f64,
}

impl RunDensity {
    /// With these slopes in what is kept.
    pub fn with(self, of: SettingSlopes) -> RunDensity {
        RunDensity {
            kept: of.kept,
            viscous: of.viscous,
            dry_k: of.dry_k,
            ..self
        }
    }
}

/// What runs are at one true speed.
#[derive(Clone, Copy)]
struct AtSpeed {
    /// ln of what is integrated over z, without the constant of φ
    ln: f64,
    /// slopes of all factors but φ in r, that of all settings together, in σ, σ_r and ν
    of_kept: f64,
    of_sigma: f64,
    of_energy: f64,
    of_nu: f64,
}

impl AtSpeed {
    /// Before any factor.
    const NONE: AtSpeed = AtSpeed {
        ln: 0.0,
        of_kept: 0.0,
        of_sigma: 0.0,
        of_energy: 0.0,
        of_nu: 0.0,
    };
}

/// The logarithm falls by this much from its largest value to where the rest is nothing.
const FALL: f64 = 25.0;

/// Sums over nodes, all divided by the exponential of a value that the logarithm of the integrand has near its largest.
struct Sums<'s> {
    reference: f64,
    /// mass, and slopes in σ, σ_r and ν
    of: [f64; 4],
    /// slopes in what each setting keeps
    settings: &'s mut [SettingSlopes],
}

impl Sums<'_> {
    fn new(reference: f64, settings: &mut [SettingSlopes]) -> Sums<'_> {
        settings.fill(SettingSlopes::default());
        Sums {
            reference,
            of: [0.0; 4],
            settings,
        }
    }

    /// `each` are the slopes of the settings there.
    fn add(&mut self, at: &AtSpeed, each: &[SettingSlopes], weight: f64) {
        self.refer_to(at.ln);
        let part = weight * (at.ln - self.reference).exp();
        let parts = [part, part * at.of_sigma, part * at.of_energy, part * at.of_nu];
        for (sum, part) in self.of.iter_mut().zip(parts) {
            *sum += part;
        }
        for (sum, of) in self.settings.iter_mut().zip(each) {
            sum.kept += part * of.kept;
            sum.viscous += part * of.viscous;
            sum.dry_k += part * of.dry_k;
        }
    }

    /// Makes this logarithm the reference where its exponential would else be beyond all numbers.
    #[inline]
    fn refer_to(&mut self, ln: f64) {
        /// well below what overflows
        const MOST: f64 = 300.0;
        if ln > self.reference + MOST {
            self.scale((self.reference - ln).exp());
            self.reference = ln;
        }
    }

    /// The log density with its slopes; those of the settings are divided by the mass where they stand.
    fn density(mut self) -> RunDensity {
        let [mass, sigma, energy, nu] = self.of;
        self.scale(1.0 / mass);
        RunDensity {
            value: self.reference + mass.ln() - LN_ROOT_TWO_PI,
            sigma: sigma / mass,
            energy: energy / mass,
            nu: nu / mass,
            ..RunDensity::default()
        }
    }

    fn scale(&mut self, factor: f64) {
        self.of.iter_mut().for_each(|sum| *sum *= factor);
        for of in self.settings.iter_mut() {
            for sum in [&mut of.kept, &mut of.viscous, &mut of.dry_k] {
                *sum *= factor;
            }
        }
    }
}

impl SettingRuns<'_> {
    /// The run whose measured speed impacts are counted from.
    #[inline(always)]
    fn first(&self) -> &Errors {
        &self.runs[0].errors
    }

    /// q of the first run, of which nothing below a hundredth is counted.
    #[inline(always)]
    fn ratio(&self, z: f64) -> f64 {
        self.first().ratio(z)
    }

    fn impact(&self, z: f64) -> Impact {
        self.balance.at_speed_ratio(&self.impact, self.ratio(z))
    }

    /// The same setting with these of its runs.
    fn with<'r>(&self, runs: &'r [MeasuredRun]) -> SettingRuns<'r>
    where
        Self: 'r,
    {
        // speeds are as the mean of the true one over them
        let ratio = self.first().true_speed.mean / runs[0].errors.true_speed.mean;
        SettingRuns {
            balance: self.balance,
            impact: self.balance.at_speed_ratio(&self.impact, ratio),
            runs,
        }
    }
}

impl HiddenSpeed<'_> {
    /// The log density or probability, with slopes but for those in what is kept, which are written setting by setting.
    pub fn integrate(&self, of_settings: &mut [SettingSlopes]) -> RunDensity {
        if self.goes_side_by_side() {
            return self.integrate_side_by_side(of_settings);
        }
        let reach = self.reach(FALL);
        let mut sums = Sums::new(reach.ln, of_settings);
        let mut each = [SettingSlopes::default(); MOST_SETTINGS];
        let each = &mut each[..self.settings.len()];
        self.over_nodes(&reach, &mut |z, weight| {
            let at = self.at_with(z, &mut |place, slopes| each[place] = slopes);
            sums.add(&at, each, weight);
            at.ln
        });
        sums.density()
    }

    /// The log density alone.
    pub fn value(&self) -> f64 {
        let mut unused = [SettingSlopes::default(); MOST_SETTINGS];
        self.integrate(&mut unused[..self.settings.len()]).value
    }

    /// The log density of each run given the others, in their order: that of all less that of the others.
    pub fn given_the_others(&self) -> Vec<f64> {
        /// twice as far down as is seen of all: a run that is off leaves the others where all together have little
        const FAR: f64 = 2.0 * FALL;
        /// a run that is farther off than this leaves them where all together have nothing
        const OFF: f64 = 12.0;
        let reach = self.reach(FAR);
        let count = self.runs().count();
        let (mut all, mut own, mut without) = (0.0, vec![0.0; count], vec![0.0; count]);
        self.over_nodes(&reach, &mut |z, weight| {
            let mut ln = -0.5 * z * z;
            let mut each = own.iter_mut();
            for setting in self.settings {
                let kept = self.kept(setting, &setting.impact(z)).0;
                for (run, own) in setting.runs.iter().zip(&mut each) {
                    let mut at = AtSpeed::NONE;
                    self.add_run(&mut at, run, kept, z);
                    *own = at.ln;
                    ln += at.ln;
                }
            }
            all += weight * (ln - reach.ln).exp();
            for (sum, own) in without.iter_mut().zip(&own) {
                *sum += weight * (ln - own - reach.ln).exp();
            }
            ln
        });
        let each = self.runs().zip(without).enumerate();
        each.map(|(place, (run, without))| {
            let given = all.ln() - without.ln();
            if self.largest_of(run) - given < OFF {
                given
            } else {
                all.ln() + reach.ln - LN_ROOT_TWO_PI - self.without(place)
            }
        })
        .collect()
    }

    /// Every run, setting by setting.
    fn runs(&self) -> impl Iterator<Item = &MeasuredRun> + Clone {
        self.settings.iter().flat_map(|setting| setting.runs)
    }

    /// The log density of all runs but one.
    fn without(&self, place: usize) -> f64 {
        let mut first = 0;
        let others = self.settings.iter().map(|setting| {
            let mut runs = setting.runs.to_vec();
            if (first..first + runs.len()).contains(&place) {
                runs.remove(place - first);
            }
            first += setting.runs.len();
            runs
        });
        let others: Vec<Vec<MeasuredRun>> = others.collect();
        let settings = self.settings.iter().zip(&others).filter(|(_, runs)| !runs.is_empty());
        let settings: Vec<SettingRuns> = settings.map(|(setting, runs)| setting.with(runs)).collect();
        if settings.is_empty() {
            return 0.0;
        }
        let others = HiddenSpeed {
            tails: self.tails,
            spreads: self.spreads,
            wet: self.wet,
            settings: &settings,
        };
        others.value()
    }

    /// r of a setting, or e_dry, at a true speed, and its slope in k, that of e_dry² where there is a liquid.
    fn kept(&self, setting: &SettingRuns, at: &Impact) -> (f64, f64) {
        if self.wet {
            setting.balance.kept(at)
        } else {
            let [e_dry, slope, _] = setting.balance.e_dry(at.dry_root);
            (e_dry, slope)
        }
    }

    /// dr/dz, or that of e_dry.
    fn kept_slope(&self, setting: &SettingRuns, z: f64) -> f64 {
        self.kept_slope_at(setting, &setting.impact(z), z)
    }

    /// The same from the impact there.
    fn kept_slope_at(&self, setting: &SettingRuns, at: &Impact, z: f64) -> f64 {
        let balance = setting.balance;
        let in_log_speed = if self.wet {
            balance.in_log_speed(at)[0]
        } else {
            // v d/dv is a fifth of k d/dk
            0.2 * balance.dry_k * balance.e_dry(at.dry_root)[1]
        };
        in_log_speed * setting.first().true_speed.sd / setting.ratio(z)
    }

    /// m(r) and its slope; of a dry run r is its mean restitution already.
    fn mean(&self, kept: f64) -> (f64, f64) {
        if self.wet {
            mean_and_slope(kept)
        } else {
            (kept, 1.0)
        }
    }

    /// S² of a run, without noise on the energy kept.
    #[inline(always)]
    fn variance(&self, errors: &Errors, ratio: f64) -> f64 {
        let Errors {
            restitution,
            correlation,
            ..
        } = errors;
        let sigma = self.spreads.sigma * ratio;
        sigma * sigma + (1.0 - correlation * correlation) * restitution * restitution
    }

    fn at(&self, z: f64) -> AtSpeed {
        self.at_with(z, &mut |_, _| ())
    }

    /// Gives the slopes of each setting to a function, too.
    fn at_with(&self, z: f64, each: &mut impl FnMut(usize, SettingSlopes)) -> AtSpeed {
        let mut found = AtSpeed {
            ln: -0.5 * z * z,
            ..AtSpeed::NONE
        };
        for (place, setting) in self.settings.iter().enumerate() {
            let impact = setting.impact(z);
            let (kept, slope_k) = self.kept(setting, &impact);
            let before = found.of_kept;
            for run in setting.runs {
                self.add_run(&mut found, run, kept, z);
            }
            let of_kept = found.of_kept - before;
            each(
                place,
                SettingSlopes {
                    kept: of_kept,
                    viscous: of_kept * impact.over_stokes,
                    dry_k: of_kept * slope_k,
                },
            );
        }
        found
    }

    /// Adds the factor of a run whose setting keeps this.
    fn add_run(&self, found: &mut AtSpeed, run: &MeasuredRun, kept: f64, z: f64) {
        let MeasuredRun { seen, errors } = run;
        match *seen {
            Seen::Rebound(e) => self.add_rebound(found, (kept, e), errors, errors.ratio(z)),
            Seen::On(side, limit) => self.add_side(found, kept, side, limit),
            Seen::Measured(side, e) => self.add_measured(found, (kept, e), side, (errors, errors.ratio(z))),
        }
    }

    fn add_rebound(&self, at: &mut AtSpeed, (kept, e): (f64, f64), errors: &Errors, ratio: f64) {
        let variance = self.variance(errors, ratio);
        // of the rebound speed over the true one
        let e = e - errors.shared() * (1.0 - ratio);
        if self.both() {
            let spread = variance.sqrt();
            let spreads = Spreads {
                sigma: spread / ratio,
                ..self.spreads
            };
            let of = convolution::ln_density(self.tails, e / ratio, kept, spreads);
            at.ln += of.value - ratio.ln();
            at.of_kept += of.kept;
            at.of_sigma += of.sigma * self.spreads.sigma * ratio / spread;
            at.of_energy += of.energy;
            at.of_nu += of.nu;
            return;
        }
        let (mean, slope) = self.mean(kept);
        let density = self.tails.ln_density(e - mean * ratio, variance, 1.0);
        at.ln += density.value;
        at.of_kept += density.mean * ratio * slope;
        at.of_sigma += 2.0 * density.variance * self.spreads.sigma * ratio * ratio;
        at.of_nu += density.nu;
    }

    fn add_side(&self, at: &mut AtSpeed, kept: f64, side: Side, limit: f64) {
        if self.both() {
            let of = convolution::ln_probability(self.tails, side, limit, kept, self.spreads);
            at.ln += of.value;
            at.of_kept += of.kept;
            at.of_sigma += of.sigma;
            at.of_energy += of.energy;
            at.of_nu += of.nu;
            return;
        }
        let (mean, slope) = self.mean(kept);
        let sign = side.sign();
        let sigma = self.spreads.sigma;
        let z = sign * (limit - mean) / sigma;
        if self.tails == Tails::Normal && z > CERTAIN {
            return;
        }
        let probability = self.tails.ln_probability(z);
        at.ln += probability.value;
        at.of_kept -= sign * probability.z / sigma * slope;
        at.of_sigma -= probability.z * z / sigma;
        at.of_nu += probability.nu;
    }

    /// The probability that it is measured on a side; without slopes in the spreads and in ν.
    fn add_measured(&self, at: &mut AtSpeed, (kept, e): (f64, f64), side: Side, (errors, ratio): (&Errors, f64)) {
        let spread = self.variance(errors, ratio).sqrt();
        let e = e - errors.shared() * (1.0 - ratio);
        if self.both() {
            let spreads = Spreads {
                sigma: spread / ratio,
                ..self.spreads
            };
            let of = convolution::ln_probability(self.tails, side, e / ratio, kept, spreads);
            at.ln += of.value;
            at.of_kept += of.kept;
            return;
        }
        let (mean, slope) = self.mean(kept);
        let sign = side.sign();
        let probability = self.tails.ln_probability(sign * (e - mean * ratio) / spread);
        at.ln += probability.value;
        at.of_kept -= sign * probability.z * ratio / spread * slope;
    }

    /// Whether noise acts on the energy kept, too.
    fn both(&self) -> bool {
        self.wet && self.spreads.energy > 0.0
    }
}

#[cfg(test)]
mod tests;
