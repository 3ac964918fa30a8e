//! Integrates over the true impact speed of a run whose measured one errs, or of repeats that share one.
//!
//! Symbols: q = v_t/v, the true speed over the measured one, q = q̄ + s̄ z with z standard normal; e = v_r/v as measured. At a
//! true speed the rebound speed is measured about m(r(q)) v_t with σ v_t and its own error, of which the error of the impact
//! speed, then known, explains a part where both are correlated: e is distributed about M = m(r(q)) q + c (1 − q) with
//! S² = σ² q² + (1 − ρ²) u², c = ρ u v/s. Whether a run sticks depends on its true speed alone. Repeats of one true speed
//! have one z, and their densities at it are multiplied: what their mean errs by is an error of all of them. Of other films
//! and diameters each has its own r(z).
//!
//! Where the integrand is all but normal a Gauss–Hermite rule of few nodes is exact to 1e-7, and where nothing turns within
//! reach the trapezoidal rule in z to 1e-9. Where r has its zero there, at z₀, the
//! integral is taken in x with z = z₀ + m⁻¹(x)/r′(z₀), which makes m(r) as smooth as the rest, by Gauss's rule on panels
//! from the turn outwards; where several settings turn, from each of them half the way to the next.

use super::convolution::{self, Panel, GAUSS, MOST_PANELS};
use super::errors::Errors;
use super::normal_nodes::Order;
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::tails::Tails;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::{kept_and_slope, mean_and_slope, mean_restitution, TURN};
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
    /// slope in z beside that by way of r, of noise on the restitution alone
    beside_kept: f64,
}

impl AtSpeed {
    /// Before any factor.
    const NONE: AtSpeed = AtSpeed {
        ln: 0.0,
        of_kept: 0.0,
        of_sigma: 0.0,
        of_energy: 0.0,
        of_nu: 0.0,
        beside_kept: 0.0,
    };
}

/// The logarithm falls by this much from its largest value to where the rest is nothing.
const FALL: f64 = 25.0;

/// Distance in z from where a probability is largest, beyond which a turn is out of reach.
const REACH: f64 = 9.0;

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
        /// well below what overflows
        const MOST: f64 = 300.0;
        if at.ln > self.reference + MOST {
            self.scale((self.reference - at.ln).exp());
            self.reference = at.ln;
        }
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

/// Where an integrand over the true speed counts.
struct Reach {
    /// z at which it is about as large as anywhere
    near: f64,
    /// its logarithm there
    ln: f64,
    /// distance of z from 0 beyond which it is nothing
    far: f64,
    /// the logarithm falls by this much to where it is nothing
    fall: f64,
    /// z₀, where the r of a setting is zero, nearer than that; each with its setting, in their order on the line
    turns: Vec<Turn>,
}

/// Where the r of a setting is zero.
#[derive(Clone, Copy)]
struct Turn {
    z: f64,
    setting: usize,
}

impl SettingRuns<'_> {
    /// The run whose measured speed impacts are counted from.
    fn first(&self) -> &Errors {
        &self.runs[0].errors
    }

    /// q of the first run, of which nothing below a hundredth is counted.
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
        let mut each = [SettingSlopes::default(); MOST_SETTINGS];
        let each = &mut each[..self.settings.len()];
        if let Some(found) = self.over_bell(each, of_settings) {
            return found;
        }
        let reach = self.reach(FALL);
        let mut sums = Sums::new(reach.ln, of_settings);
        self.over_nodes(&reach, each, &mut |_, at, each, weight| sums.add(at, each, weight));
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
        let mut all = 0.0;
        let mut without = vec![0.0; self.runs().count()];
        let mut unused = [SettingSlopes::default(); MOST_SETTINGS];
        let unused = &mut unused[..self.settings.len()];
        self.over_nodes(&reach, unused, &mut |z, at, _, weight| {
            all += weight * (at.ln - reach.ln).exp();
            let mut without = without.iter_mut();
            for setting in self.settings {
                let impact = setting.impact(z);
                let kept = self.kept(setting, &impact).0;
                for (run, sum) in setting.runs.iter().zip(&mut without) {
                    let mut own = AtSpeed::NONE;
                    self.add_run(&mut own, run, kept, z);
                    *sum += weight * (at.ln - own.ln - reach.ln).exp();
                }
            }
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
        let at = setting.impact(z);
        let balance = setting.balance;
        let in_log_speed = if self.wet {
            balance.in_log_speed(&at)[0]
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
        let of_ratio = density.variance * 2.0 * self.spreads.sigma * ratio;
        at.of_sigma += of_ratio * ratio;
        let of_mean = density.mean * (mean - errors.shared());
        at.beside_kept += (of_mean + of_ratio * self.spreads.sigma) * errors.true_speed.sd;
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

    /// By how much the other factors narrow φ: the root of the sum of squares of dM/dz over S.
    fn narrowing(&self, z: f64) -> f64 {
        let mut squares = 0.0;
        for setting in self.settings {
            let (mean, slope) = self.mean(self.kept(setting, &setting.impact(z)).0);
            let of_mean = slope * self.kept_slope(setting, z);
            let energy = if self.wet { self.spreads.energy * slope } else { 0.0 };
            let of_run = |MeasuredRun { seen, errors }: &MeasuredRun| match seen {
                Seen::Rebound(_) | Seen::Measured(..) => {
                    let ratio = errors.ratio(z);
                    let moved = ratio * of_mean + (mean - errors.shared()) * errors.true_speed.sd;
                    moved * moved / (self.variance(errors, ratio) + (ratio * energy).powi(2))
                }
                Seen::On(..) => (of_mean / self.spreads.sigma.hypot(energy)).powi(2),
            };
            squares += setting.runs.iter().map(of_run).sum::<f64>();
        }
        squares.sqrt()
    }

    /// Whether all that is known is on which side runs came out.
    fn is_of_sides(&self) -> bool {
        self.runs().all(|run| matches!(run.seen, Seen::On(..)))
    }

    /// Whether all runs were measured where they rebounded.
    fn is_of_rebounds(&self) -> bool {
        self.runs().all(|run| matches!(run.seen, Seen::Rebound(_)))
    }

    /// About where the integrand is largest: steps of Newton's with a curvature that is not too small.
    fn mode(&self) -> f64 {
        const STEPS: usize = 100;
        const ENOUGH: f64 = 0.05;
        /// a step beyond which the second factor may be another
        const FARTHEST: f64 = 2.0;
        let mut z = 0.0;
        let mut at = self.at(z);
        let mut share = 1.0;
        for _ in 0..STEPS {
            let narrowing = self.narrowing(z);
            // by differences: what moves with z is not in the slopes of one run
            let h = 1e-4 / (1.0 + narrowing.abs());
            let slope = (self.at(z + h).ln - self.at(z - h).ln) / (2.0 * h);
            let step = (share * slope / (1.0 + narrowing * narrowing)).clamp(-FARTHEST, FARTHEST);
            let next = self.at(z + step);
            if next.ln > at.ln {
                (z, at) = (z + step, next);
                share = (2.0f64 * share).min(1.0);
                if slope * step < ENOUGH * ENOUGH {
                    break;
                }
            } else {
                share *= 0.25;
                if slope * step < ENOUGH * ENOUGH {
                    break;
                }
            }
        }
        z
    }

    /// About where the integrand is large, and how far from z = 0 it counts.
    fn reach(&self, fall: f64) -> Reach {
        /// of the way from the measured speed to the turn
        const PLACES: usize = 8;
        let largest = self.largest();
        let far = |ln: f64| (2.0 * (fall + largest - ln)).max(0.0).sqrt();
        let at_zero = self.at(0.0).ln;
        let mut found = Reach {
            near: 0.0,
            ln: at_zero,
            far: far(at_zero),
            fall,
            turns: vec![],
        };
        let look_at = |z: f64, found: &mut Reach| {
            let ln = self.at(z).ln;
            if ln > found.ln {
                (found.near, found.ln, found.far) = (z, ln, far(ln));
            }
        };
        let mut turns = self.turns(far(at_zero));
        let is_side = self.is_of_sides();
        let turned = !turns.is_empty();
        if is_side && turned {
            // the mode lies between both, where there is hardly a slope to follow
            for turn in &turns {
                (1..=PLACES).for_each(|place| look_at(turn.z * place as f64 / PLACES as f64, &mut found));
            }
        } else {
            look_at(self.mode(), &mut found);
        }
        let of_rebounds = self.is_of_rebounds();
        turns.retain(|turn| {
            if of_rebounds {
                // what is nothing at the turn has all its mass on one side of it
                self.at(turn.z).ln > found.ln - fall
            } else {
                (turn.z - found.near).abs() < REACH
            }
        });
        if is_side && turned && turns.is_empty() {
            look_at(self.mode(), &mut found);
        }
        found.turns = turns;
        found
    }

    /// Where settings turn within reach, in order.
    fn turns(&self, reach: f64) -> Vec<Turn> {
        /// settings that turn within this share of the width of a turn turn as one
        const AS_ONE: f64 = 0.25;
        let mut turns = vec![];
        for (setting, of) in self.settings.iter().enumerate() {
            turns.extend(self.turn(of, reach).map(|z| Turn { z, setting }));
        }
        turns.sort_by(|a, b| a.z.total_cmp(&b.z));
        turns.dedup_by(|next, turn| {
            let slope = self.kept_slope(&self.settings[turn.setting], turn.z);
            (next.z - turn.z) * slope.abs() < AS_ONE * TURN * TURN
        });
        turns
    }

    /// z₀ where the r of a setting is zero within reach.
    fn turn(&self, setting: &SettingRuns, reach: f64) -> Option<f64> {
        /// r that is as good as zero beside the width of the turn
        const NEAR: f64 = 1e-3 * TURN * TURN;
        if !self.wet {
            return None;
        }
        let r = |z: f64| self.kept(setting, &setting.impact(z)).0;
        let (mut lo, mut hi) = (-reach, reach);
        let (mut at_lo, at_hi) = (r(lo), r(hi));
        if (at_lo * at_hi).is_nan() || at_lo * at_hi > 0.0 {
            return None;
        }
        let mut z = lo - at_lo * (hi - lo) / (at_hi - at_lo);
        for _ in 0..60 {
            let here = r(z);
            if here.abs() < NEAR {
                break;
            }
            if here * at_lo > 0.0 {
                (lo, at_lo) = (z, here);
            } else {
                hi = z;
            }
            let newton = z - here / self.kept_slope(setting, z);
            z = if newton > lo && newton < hi {
                newton
            } else {
                0.5 * (lo + hi)
            };
        }
        Some(z)
    }

    /// The integral far from any turn, where the integrand is all but normal, by a Gauss–Hermite rule; `None` where it is not.
    fn over_bell(&self, each: &mut [SettingSlopes], of_settings: &mut [SettingSlopes]) -> Option<RunDensity> {
        /// largest distance of the logarithm from that of a normal density at any but the two outermost nodes: the integral
        /// is then off by less than 1e-7 and by rounding
        const BEND: [(Order, f64); 2] = [(Order::Eight, 0.1), (Order::Sixteen, 0.4)];
        let is_measured = |run: &MeasuredRun| matches!(run.seen, Seen::Measured(..));
        if self.tails != Tails::Normal || self.both() || self.runs().any(is_measured) {
            return None;
        }
        let (z, width) = self.bell()?;
        for (order, most) in BEND {
            let pairs = order.pairs();
            let mut sums = Sums::new(f64::NAN, of_settings);
            let mut inner = [f64::INFINITY, f64::NEG_INFINITY];
            for (place, [node, weight]) in pairs.iter().enumerate() {
                for sign in [-1.0, 1.0] {
                    let at = self.node(z + sign * width * node, each);
                    if sums.reference.is_nan() {
                        sums.reference = at.ln;
                    }
                    if place + 1 < pairs.len() {
                        let bend = at.ln + 0.5 * node * node;
                        inner = [inner[0].min(bend), inner[1].max(bend)];
                    }
                    sums.add(&at, each, width * weight);
                }
            }
            if inner[1] - inner[0] < most {
                return Some(sums.density());
            }
        }
        None
    }

    /// About where the integrand is largest, and its width there; `None` where it may turn within reach.
    fn bell(&self) -> Option<(f64, f64)> {
        /// widths beyond which it is nothing
        const FAR: f64 = 7.0;
        /// steps of the secant rule, and the last one that need not be taken once more, in widths
        const STEPS: usize = 4;
        const NEAR: f64 = 0.3;
        /// of the curvature that the mean alone leaves
        const LEAST: f64 = 0.3;
        let (mut z, mut slope) = (0.0, self.slope(0.0));
        let least = 1.0 + self.narrowing(z).powi(2);
        let mut curvature = least;
        for _ in 0..STEPS {
            let step = slope / curvature;
            let next = z + step;
            if (step * curvature.sqrt()).abs() < NEAR {
                z = next;
                break;
            }
            let there = self.slope(next);
            curvature = (slope - there) / step;
            if curvature.is_nan() || curvature < LEAST * least {
                return None;
            }
            (z, slope) = (next, there);
        }
        let width = 1.0 / curvature.sqrt();
        let turns = |setting: &SettingRuns| {
            let ends = [-FAR, FAR].map(|far| self.kept(setting, &setting.impact(z + far * width)).0);
            ends.iter().any(|kept| kept.is_nan() || *kept <= 0.0)
        };
        let clear = !self.wet || !self.settings.iter().any(turns);
        clear.then_some((z, width))
    }

    /// d/dz of the logarithm of the integrand, of noise on the restitution alone and runs that are not asked what they would
    /// have been measured at.
    fn slope(&self, z: f64) -> f64 {
        let mut by_kept = 0.0;
        let at = self.at_with(z, &mut |place, of| {
            by_kept += of.kept * self.kept_slope(&self.settings[place], z);
        });
        at.beside_kept + by_kept - z
    }

    /// Gives every node, z with the integrand and the slopes of the settings there and its weight, to a sum; the slopes are
    /// written to `each`.
    fn over_nodes(
        &self,
        reach: &Reach,
        each: &mut [SettingSlopes],
        add: &mut impl FnMut(f64, &AtSpeed, &[SettingSlopes], f64),
    ) {
        if reach.turns.is_empty() {
            return self.over_steps(reach, each, add);
        }
        for (place, turn) in reach.turns.iter().enumerate() {
            let half_way = |other: &Turn| (0.5 * (turn.z + other.z)).clamp(-reach.far, reach.far);
            let before = place.checked_sub(1).map(|before| &reach.turns[before]);
            let ends = [
                before.map_or(-reach.far, half_way),
                reach.turns.get(place + 1).map_or(reach.far, half_way),
            ];
            self.over_panels(*turn, ends, reach, each, add);
        }
    }

    /// The integrand at a node, with the slopes of the settings.
    fn node(&self, z: f64, each: &mut [SettingSlopes]) -> AtSpeed {
        self.at_with(z, &mut |place, slopes| each[place] = slopes)
    }

    /// The trapezoidal rule from the mode to both sides, until nothing is left.
    fn over_steps(
        &self,
        reach: &Reach,
        each: &mut [SettingSlopes],
        add: &mut impl FnMut(f64, &AtSpeed, &[SettingSlopes], f64),
    ) {
        /// steps a width, of a normal integrand and of one with Student's tails
        const SHARE: [f64; 2] = [0.8, 0.3];
        let width = |z: f64| 1.0 / (1.0 + self.narrowing(z).powi(2)).sqrt();
        let mode = reach.near;
        let here = width(mode);
        let narrowest = here.min(width(mode - 5.0 * here)).min(width(mode + 5.0 * here));
        let step = narrowest * SHARE[usize::from(self.tails != Tails::Normal)];
        let at = self.node(mode, each);
        add(mode, &at, each, step);
        for sign in [-1.0, 1.0] {
            for index in 1..MOST_PANELS {
                let z = mode + sign * step * index as f64;
                let at = self.node(z, each);
                // also where it is no number
                if at.ln.is_nan() || at.ln <= reach.ln - reach.fall {
                    break;
                }
                add(z, &at, each, step);
            }
        }
    }

    /// Gauss's rule on panels from a turn outwards to both ends, which are values of z.
    fn over_panels(
        &self,
        turn: Turn,
        ends: [f64; 2],
        reach: &Reach,
        each: &mut [SettingSlopes],
        add: &mut impl FnMut(f64, &AtSpeed, &[SettingSlopes], f64),
    ) {
        let slope = self.kept_slope(&self.settings[turn.setting], turn.z);
        let place = |x: f64| turn.z + kept_and_slope(x).0 / slope;
        let range = ends.map(|z| mean_restitution((z - turn.z) * slope));
        let (lo, hi) = (range[0].min(range[1]), range[0].max(range[1]));
        // parameters beyond all numbers have no range, and so no density
        if lo.is_nan() || hi.is_nan() {
            return;
        }
        let inner = 0f64.clamp(lo, hi);
        for (end, sign) in [(lo, -1.0), (hi, 1.0)] {
            let mut from = inner;
            let mut before = self.at(place(from));
            for _ in 0..MOST_PANELS {
                let rest = sign * (end - from);
                if rest.is_nan() || rest <= 0.0 {
                    break;
                }
                let mut panel = self.panel(turn, slope, place(from));
                if self.is_certain(place(from), sign) {
                    panel.own = 0.0;
                }
                let length = panel.length(from, sign).min(rest);
                let to = if length < rest { from + sign * length } else { end };
                let after = self.at(place(to));
                if self.may_count(&before, &after, reach) {
                    let (half, middle) = (0.5 * length, from + 0.5 * sign * length);
                    for [node, weight] in GAUSS {
                        for x in [middle - half * node, middle + half * node] {
                            let (y, stretch) = kept_and_slope(x);
                            let z = turn.z + y / slope;
                            let at = self.node(z, each);
                            add(z, &at, each, half * weight * stretch / slope.abs());
                        }
                    }
                }
                (from, before) = (to, after);
            }
        }
    }

    /// How long a panel may be that begins at z, counted from a turn at which its setting has this slope of r.
    fn panel(&self, turn: Turn, slope: f64, z: f64) -> Panel {
        // what a run's factor moves by with x, and beside x with z, in its spreads
        let (mut own, mut beside) = (0.0, 0.0);
        for setting in self.settings {
            // nearer to its own turn no setting moves faster
            let with_x = (self.kept_slope(setting, turn.z) / slope).powi(2);
            for MeasuredRun { seen, errors } in setting.runs {
                let (ratio, sd, spread) = match seen {
                    Seen::Rebound(_) | Seen::Measured(..) => {
                        let ratio = errors.ratio(z);
                        (ratio, errors.true_speed.sd, self.variance(errors, ratio).sqrt())
                    }
                    Seen::On(..) => (1.0, 0.0, self.spreads.sigma),
                };
                own += with_x * (ratio / spread).powi(2);
                beside += (sd / spread).powi(2);
            }
        }
        Panel {
            own: own.sqrt(),
            of_energy: (1.0 + beside.sqrt()) / slope.abs(),
            widths: if self.tails == Tails::Normal { 5.0 } else { 2.0 },
        }
    }

    /// Whether runs came out on their side whatever their noise at this true speed and where r is farther on that way.
    fn is_certain(&self, z: f64, sign: f64) -> bool {
        /// spreads of normal noise
        const CERTAIN: f64 = 6.0;
        if self.tails != Tails::Normal || self.both() || !self.is_of_sides() {
            return false;
        }
        self.settings.iter().all(|setting| {
            let mean = self.mean(self.kept(setting, &setting.impact(z)).0).0;
            setting.runs.iter().all(|run| {
                let Seen::On(side, limit) = run.seen else {
                    return false;
                };
                sign == -side.sign() && side.sign() * (limit - mean) > CERTAIN * self.spreads.sigma
            })
        })
    }

    /// The largest value that the logarithm of all factors but φ has.
    fn largest(&self) -> f64 {
        self.runs().map(|run| self.largest_of(run)).sum()
    }

    fn largest_of(&self, MeasuredRun { seen, errors }: &MeasuredRun) -> f64 {
        match seen {
            Seen::Rebound(_) => {
                let least = self.variance(errors, errors.ratio(-REACH)).max(f64::MIN_POSITIVE);
                self.tails.ln_density(0.0, least, 1.0).value
            }
            Seen::On(..) | Seen::Measured(..) => 0.0,
        }
    }

    /// Whether something of the integrand may lie between two speeds: not where it is nothing at both and they lie on one
    /// side of what was seen.
    fn may_count(&self, a: &AtSpeed, b: &AtSpeed, reach: &Reach) -> bool {
        let nothing = reach.ln - reach.fall;
        let one_side = a.of_kept * b.of_kept > 0.0 || !self.runs().any(|run| matches!(run.seen, Seen::Rebound(_)));
        !(one_side && a.ln < nothing && b.ln < nothing)
    }
}

#[cfg(test)]
mod tests;
