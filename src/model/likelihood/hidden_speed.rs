//! Integrates over the true impact speed of a run whose measured one errs, or of repeats that share one.
//!
//! Symbols: q = v_t/v, the true speed over the measured one, q = q̄ + s̄ z with z standard normal; e = v_r/v as measured. At a
//! true speed the rebound speed is measured about m(r(q)) v_t with σ v_t and its own error, of which the error of the impact
//! speed, then known, explains a part where both are correlated: e is distributed about M = m(r(q)) q + c (1 − q) with
//! S² = σ² q² + (1 − ρ²) u², c = ρ u v/s. Whether a run sticks depends on its true speed alone. Repeats of one true speed
//! have one z, and their densities at it are multiplied: what their mean errs by is an error of all of them.
//!
//! Where nothing turns within reach the trapezoidal rule in z is exact to 1e-9. Where r has its zero there, at z₀, the
//! integral is taken in x with z = z₀ + m⁻¹(x)/r′(z₀), which makes m(r) as smooth as the rest, by Gauss's rule on panels
//! from the turn outwards.

use super::convolution::{self, Panel, GAUSS, MOST_PANELS};
use super::errors::Errors;
use super::run_density::{RunDensity, Seen, Side, Spreads};
use super::tails::Tails;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::{kept_and_slope, mean_and_slope, mean_restitution, TURN};

/// What is known of a run, and what its measurement errs by.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeasuredRun {
    pub seen: Seen,
    pub errors: Errors,
}

/// A run, or runs of one setting and one true speed, with what is known of them.
#[derive(Clone, Copy)]
pub(super) struct HiddenSpeed<'b> {
    pub tails: Tails,
    pub spreads: Spreads,
    pub balance: &'b Balance,
    /// at the measured speed of the first
    pub impact: Impact,
    /// whether there was a liquid
    pub wet: bool,
    /// at least one
    pub runs: &'b [MeasuredRun],
}

/// What runs are at one true speed.
#[derive(Clone, Copy)]
struct AtSpeed {
    impact: Impact,
    /// r; e_dry of a dry run
    kept: f64,
    /// its slope in k, that of e_dry² where there is a liquid
    kept_slope_k: f64,
    /// ln of what is integrated over z, without the constant of φ
    ln: f64,
    /// slopes of all factors but φ in r, σ, σ_r and ν
    of_kept: f64,
    of_sigma: f64,
    of_energy: f64,
    of_nu: f64,
}

/// The logarithm falls by this much from its largest value to where the rest is nothing.
const FALL: f64 = 25.0;

/// Distance in z from where a probability is largest, beyond which a turn is out of reach.
const REACH: f64 = 9.0;

/// Sums over nodes, all divided by the exponential of a value that the logarithm of the integrand has near its largest.
struct Sums {
    reference: f64,
    /// mass, and slopes in σ, σ_r, ν, r, −L and k
    of: [f64; 7],
}

impl Sums {
    fn add(&mut self, at: &AtSpeed, weight: f64) {
        /// well below what overflows
        const MOST: f64 = 300.0;
        if at.ln > self.reference + MOST {
            let shrink = (self.reference - at.ln).exp();
            self.of.iter_mut().for_each(|sum| *sum *= shrink);
            self.reference = at.ln;
        }
        let part = weight * (at.ln - self.reference).exp();
        let of_kept = part * at.of_kept;
        let parts = [
            part,
            part * at.of_sigma,
            part * at.of_energy,
            part * at.of_nu,
            of_kept,
            of_kept * at.impact.over_stokes,
            of_kept * at.kept_slope_k,
        ];
        for (sum, part) in self.of.iter_mut().zip(parts) {
            *sum += part;
        }
    }
}

/// Where an integrand over the true speed counts.
#[derive(Clone, Copy)]
struct Reach {
    /// z at which it is about as large as anywhere
    near: f64,
    /// its logarithm there
    ln: f64,
    /// distance of z from 0 beyond which it is nothing
    far: f64,
    /// the logarithm falls by this much to where it is nothing
    fall: f64,
    /// z₀, where r is zero, nearer than that
    turn: Option<f64>,
}

impl HiddenSpeed<'_> {
    /// The log density or probability, with slopes.
    pub fn integrate(&self) -> RunDensity {
        let reach = self.reach(FALL);
        let mut sums = Sums {
            reference: reach.ln,
            of: [0.0; 7],
        };
        self.over_nodes(reach, &mut |_, at, weight| sums.add(at, weight));
        let Sums {
            reference,
            of: [mass, sigma, energy, nu, kept, viscous, dry_k],
        } = sums;
        RunDensity {
            value: reference + mass.ln() - LN_ROOT_TWO_PI,
            sigma: sigma / mass,
            energy: energy / mass,
            nu: nu / mass,
            kept: kept / mass,
            viscous: viscous / mass,
            dry_k: dry_k / mass,
        }
    }

    /// The log density of each run given the others: that of all less that of the others.
    pub fn given_the_others(&self) -> Vec<f64> {
        /// twice as far down as is seen of all: a run that is off leaves the others where all together have little
        const FAR: f64 = 2.0 * FALL;
        /// a run that is farther off than this leaves them where all together have nothing
        const OFF: f64 = 12.0;
        let reach = self.reach(FAR);
        let mut all = 0.0;
        let mut without = vec![0.0; self.runs.len()];
        self.over_nodes(reach, &mut |z, at, weight| {
            all += weight * (at.ln - reach.ln).exp();
            for (sum, run) in without.iter_mut().zip(self.runs) {
                let own = self.of(run).factors(z, at.impact).ln;
                *sum += weight * (at.ln - own - reach.ln).exp();
            }
        });
        let each = self.runs.iter().zip(without).enumerate();
        each.map(|(place, (run, without))| {
            let given = all.ln() - without.ln();
            if self.of(run).largest() - given < OFF {
                given
            } else {
                all.ln() + reach.ln - LN_ROOT_TWO_PI - self.without(place)
            }
        })
        .collect()
    }

    /// The same with one of the runs alone, at the impact of the first.
    fn of<'r>(&self, run: &'r MeasuredRun) -> HiddenSpeed<'r>
    where
        Self: 'r,
    {
        HiddenSpeed {
            runs: std::slice::from_ref(run),
            tails: self.tails,
            spreads: self.spreads,
            balance: self.balance,
            impact: self.impact,
            wet: self.wet,
        }
    }

    /// The log density of all runs but one.
    fn without(&self, place: usize) -> f64 {
        let mut others = self.runs.to_vec();
        others.remove(place);
        let Some(first) = others.first() else {
            return 0.0;
        };
        // speeds are as the mean of the true one over them
        let ratio = self.first().true_speed.mean / first.errors.true_speed.mean;
        let others = HiddenSpeed {
            impact: self.balance.at_speed_ratio(&self.impact, ratio),
            runs: &others,
            ..*self
        };
        others.integrate().value
    }

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

    /// r, or e_dry, at a true speed, and its slope in k.
    fn kept(&self, at: &Impact) -> (f64, f64) {
        if self.wet {
            self.balance.kept(at)
        } else {
            let [e_dry, slope, _] = self.balance.e_dry(at.dry_root);
            (e_dry, slope)
        }
    }

    /// dr/dz, or that of e_dry.
    fn kept_slope(&self, z: f64) -> f64 {
        let at = self.impact(z);
        let in_log_speed = if self.wet {
            self.balance.in_log_speed(&at)[0]
        } else {
            // v d/dv is a fifth of k d/dk
            0.2 * self.balance.dry_k * self.balance.e_dry(at.dry_root)[1]
        };
        in_log_speed * self.first().true_speed.sd / self.ratio(z)
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
        let mut found = self.factors(z, self.impact(z));
        found.ln -= 0.5 * z * z;
        found
    }

    /// All factors but φ, at an impact with the true speed of z.
    fn factors(&self, z: f64, impact: Impact) -> AtSpeed {
        let (kept, kept_slope_k) = self.kept(&impact);
        let mut found = AtSpeed {
            impact,
            kept,
            kept_slope_k,
            ln: 0.0,
            of_kept: 0.0,
            of_sigma: 0.0,
            of_energy: 0.0,
            of_nu: 0.0,
        };
        for MeasuredRun { seen, errors } in self.runs {
            match *seen {
                Seen::Rebound(e) => self.add_rebound(&mut found, errors, errors.ratio(z), e),
                Seen::On(side, limit) => self.add_side(&mut found, side, limit),
                Seen::Measured(side, e) => self.add_measured(&mut found, errors, errors.ratio(z), (side, e)),
            }
        }
        found
    }

    fn add_rebound(&self, at: &mut AtSpeed, errors: &Errors, ratio: f64, e: f64) {
        let variance = self.variance(errors, ratio);
        // of the rebound speed over the true one
        let e = e - errors.shared() * (1.0 - ratio);
        if self.both() {
            let spread = variance.sqrt();
            let spreads = Spreads {
                sigma: spread / ratio,
                ..self.spreads
            };
            let of = convolution::ln_density(self.tails, e / ratio, at.kept, spreads);
            at.ln += of.value - ratio.ln();
            at.of_kept += of.kept;
            at.of_sigma += of.sigma * self.spreads.sigma * ratio / spread;
            at.of_energy += of.energy;
            at.of_nu += of.nu;
            return;
        }
        let (mean, slope) = self.mean(at.kept);
        let density = self.tails.ln_density(e - mean * ratio, variance, 1.0);
        at.ln += density.value;
        at.of_kept += density.mean * ratio * slope;
        at.of_sigma += density.variance * 2.0 * self.spreads.sigma * ratio * ratio;
        at.of_nu += density.nu;
    }

    fn add_side(&self, at: &mut AtSpeed, side: Side, limit: f64) {
        if self.both() {
            let of = convolution::ln_probability(self.tails, side, limit, at.kept, self.spreads);
            at.ln += of.value;
            at.of_kept += of.kept;
            at.of_sigma += of.sigma;
            at.of_energy += of.energy;
            at.of_nu += of.nu;
            return;
        }
        let (mean, slope) = self.mean(at.kept);
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
    fn add_measured(&self, at: &mut AtSpeed, errors: &Errors, ratio: f64, (side, e): (Side, f64)) {
        let spread = self.variance(errors, ratio).sqrt();
        let e = e - errors.shared() * (1.0 - ratio);
        if self.both() {
            let spreads = Spreads {
                sigma: spread / ratio,
                ..self.spreads
            };
            let of = convolution::ln_probability(self.tails, side, e / ratio, at.kept, spreads);
            at.ln += of.value;
            at.of_kept += of.kept;
            return;
        }
        let (mean, slope) = self.mean(at.kept);
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
        let (mean, slope) = self.mean(self.kept(&self.impact(z)).0);
        let of_mean = slope * self.kept_slope(z);
        let energy = if self.wet { self.spreads.energy * slope } else { 0.0 };
        let of_run = |MeasuredRun { seen, errors }: &MeasuredRun| match seen {
            Seen::Rebound(_) | Seen::Measured(..) => {
                let ratio = errors.ratio(z);
                let moved = ratio * of_mean + (mean - errors.shared()) * errors.true_speed.sd;
                moved * moved / (self.variance(errors, ratio) + (ratio * energy).powi(2))
            }
            Seen::On(..) => (of_mean / self.spreads.sigma.hypot(energy)).powi(2),
        };
        self.runs.iter().map(of_run).sum::<f64>().sqrt()
    }

    /// Whether all that is known is on which side runs came out.
    fn is_of_sides(&self) -> bool {
        self.runs.iter().all(|run| matches!(run.seen, Seen::On(..)))
    }

    /// Whether all runs were measured where they rebounded.
    fn is_of_rebounds(&self) -> bool {
        self.runs.iter().all(|run| matches!(run.seen, Seen::Rebound(_)))
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
            turn: None,
        };
        let look_at = |z: f64, found: &mut Reach| {
            let ln = self.at(z).ln;
            if ln > found.ln {
                (found.near, found.ln, found.far) = (z, ln, far(ln));
            }
        };
        let turn = self.turn(far(at_zero));
        let is_side = self.is_of_sides();
        match turn.filter(|_| is_side) {
            // the mode lies between both, where there is hardly a slope to follow
            Some(turn) => (1..=PLACES).for_each(|place| look_at(turn * place as f64 / PLACES as f64, &mut found)),
            None => look_at(self.mode(), &mut found),
        }
        let of_rebounds = self.is_of_rebounds();
        found.turn = turn.filter(|turn| {
            if of_rebounds {
                // what is nothing at the turn has all its mass on one side of it
                self.at(*turn).ln > found.ln - fall
            } else {
                (turn - found.near).abs() < REACH
            }
        });
        if is_side && turn.is_some() && found.turn.is_none() {
            look_at(self.mode(), &mut found);
        }
        found
    }

    /// z₀ where r is zero within reach.
    fn turn(&self, reach: f64) -> Option<f64> {
        /// r that is as good as zero beside the width of the turn
        const NEAR: f64 = 1e-3 * TURN * TURN;
        if !self.wet {
            return None;
        }
        let r = |z: f64| self.kept(&self.impact(z)).0;
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
            let newton = z - here / self.kept_slope(z);
            z = if newton > lo && newton < hi {
                newton
            } else {
                0.5 * (lo + hi)
            };
        }
        Some(z)
    }

    /// Gives every node, z with the integrand there and its weight, to a sum.
    fn over_nodes(&self, reach: Reach, add: &mut impl FnMut(f64, &AtSpeed, f64)) {
        match reach.turn {
            Some(turn) => self.over_panels(turn, reach, add),
            None => self.over_steps(reach, add),
        }
    }

    /// The trapezoidal rule from the mode to both sides, until nothing is left.
    fn over_steps(&self, reach: Reach, add: &mut impl FnMut(f64, &AtSpeed, f64)) {
        /// steps a width, of a normal integrand and of one with Student's tails
        const SHARE: [f64; 2] = [0.8, 0.3];
        let width = |z: f64| 1.0 / (1.0 + self.narrowing(z).powi(2)).sqrt();
        let mode = reach.near;
        let here = width(mode);
        let narrowest = here.min(width(mode - 5.0 * here)).min(width(mode + 5.0 * here));
        let step = narrowest * SHARE[usize::from(self.tails != Tails::Normal)];
        add(mode, &self.at(mode), step);
        for sign in [-1.0, 1.0] {
            for index in 1..MOST_PANELS {
                let z = mode + sign * step * index as f64;
                let at = self.at(z);
                // also where it is no number
                if at.ln.is_nan() || at.ln <= reach.ln - reach.fall {
                    break;
                }
                add(z, &at, step);
            }
        }
    }

    /// Gauss's rule on panels from the turn outwards.
    fn over_panels(&self, turn: f64, reach: Reach, add: &mut impl FnMut(f64, &AtSpeed, f64)) {
        let slope = self.kept_slope(turn);
        let place = |x: f64| turn + kept_and_slope(x).0 / slope;
        let ends = [-reach.far, reach.far].map(|z| mean_restitution((z - turn) * slope));
        let (lo, hi) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        // parameters beyond all numbers have no range, and so no density
        if lo.is_nan() || hi.is_nan() {
            return;
        }
        // what a run's factor moves by with x, and beside x with z, in its spreads
        let (mut own, mut beside) = (0.0, 0.0);
        for MeasuredRun { seen, errors } in self.runs {
            let (ratio, sd, least) = match seen {
                Seen::Rebound(_) | Seen::Measured(..) => {
                    let ratios = [-reach.far, reach.far].map(|z| errors.ratio(z));
                    let least = self.variance(errors, ratios[0].min(ratios[1])).sqrt();
                    (ratios[0].max(ratios[1]), errors.true_speed.sd, least)
                }
                Seen::On(..) => (1.0, 0.0, self.spreads.sigma),
            };
            own += (ratio / least).powi(2);
            beside += (sd / least).powi(2);
        }
        let panel = Panel {
            own: own.sqrt(),
            of_energy: (1.0 + beside.sqrt()) / slope.abs(),
            widths: if self.tails == Tails::Normal { 5.0 } else { 2.0 },
        };
        let sure = Panel { own: 0.0, ..panel };
        let inner = 0f64.clamp(lo, hi);
        for (end, sign) in [(lo, -1.0), (hi, 1.0)] {
            let mut from = inner;
            let mut before = self.at(place(from));
            for _ in 0..MOST_PANELS {
                let rest = sign * (end - from);
                if rest.is_nan() || rest <= 0.0 {
                    break;
                }
                let length = if self.is_certain(from, sign) { sure } else { panel }
                    .length(from, sign)
                    .min(rest);
                let to = if length < rest { from + sign * length } else { end };
                let after = self.at(place(to));
                if self.may_count(&before, &after, reach) {
                    let (half, middle) = (0.5 * length, from + 0.5 * sign * length);
                    for [node, weight] in GAUSS {
                        for x in [middle - half * node, middle + half * node] {
                            let (y, stretch) = kept_and_slope(x);
                            let z = turn + y / slope;
                            add(z, &self.at(z), half * weight * stretch / slope.abs());
                        }
                    }
                }
                (from, before) = (to, after);
            }
        }
    }

    /// Whether runs that would rebound with x, or farther on, came out on their side whatever their noise.
    fn is_certain(&self, x: f64, sign: f64) -> bool {
        /// spreads of normal noise
        const CERTAIN: f64 = 6.0;
        let clear = |run: &MeasuredRun| {
            let Seen::On(side, limit) = run.seen else {
                return false;
            };
            sign == -side.sign() && side.sign() * (limit - x) > CERTAIN * self.spreads.sigma
        };
        self.tails == Tails::Normal && !self.both() && self.runs.iter().all(clear)
    }

    /// The largest value that the logarithm of all factors but φ has.
    fn largest(&self) -> f64 {
        let of_run = |MeasuredRun { seen, errors }: &MeasuredRun| match seen {
            Seen::Rebound(_) => {
                let least = self.variance(errors, errors.ratio(-REACH)).max(f64::MIN_POSITIVE);
                self.tails.ln_density(0.0, least, 1.0).value
            }
            Seen::On(..) | Seen::Measured(..) => 0.0,
        };
        self.runs.iter().map(of_run).sum()
    }

    /// Whether something of the integrand may lie between two speeds: not where it is nothing at both and they lie on one
    /// side of what was seen.
    fn may_count(&self, a: &AtSpeed, b: &AtSpeed, reach: Reach) -> bool {
        let nothing = reach.ln - reach.fall;
        let one_side = a.of_kept * b.of_kept > 0.0 || !self.runs.iter().any(|run| matches!(run.seen, Seen::Rebound(_)));
        !(one_side && a.ln < nothing && b.ln < nothing)
    }
}

#[cfg(test)]
mod tests;
