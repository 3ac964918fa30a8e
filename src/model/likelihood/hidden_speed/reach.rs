//! Finds where an integrand over the true speed is large, and where settings turn.

use super::{HiddenSpeed, MeasuredRun, SettingRuns};
use crate::model::likelihood::normal::CERTAIN;
use crate::model::likelihood::run_density::Seen;
use crate::model::likelihood::tails::normal_density;
use crate::physics::rebound::TURN;

/// Distance in z from where a probability is largest, beyond which a turn is out of reach.
pub(super) const REACH: f64 = 9.0;

/// Where an integrand over the true speed counts.
pub(super) struct Reach {
    /// z at which it is about as large as anywhere
    pub near: f64,
    /// its logarithm there
    pub ln: f64,
    /// distance of z from 0 beyond which it is nothing
    pub far: f64,
    /// the logarithm falls by this much to where it is nothing
    pub fall: f64,
    /// z₀, where the r of a setting is zero, nearer than that; each with its setting, in their order on the line
    pub turns: Vec<Turn>,
}

/// Where the r of a setting is zero.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub z: f64,
    pub setting: usize,
}

/// How the logarithm of the integrand moves at a node.
#[derive(Clone, Copy)]
pub(super) struct Moved {
    /// d/dz
    pub slope: f64,
    /// minus d²/dz², of what M moves by alone
    pub curvature: f64,
}

impl HiddenSpeed<'_> {
    /// By how much the other factors narrow φ: the root of the sum of squares of dM/dz over S.
    pub(super) fn narrowing(&self, z: f64) -> f64 {
        let mut squares = 0.0;
        for setting in self.settings {
            let impact = setting.impact(z);
            let (mean, slope) = self.mean(self.kept(setting, &impact).0);
            let of_mean = slope * self.kept_slope_at(setting, &impact, z);
            let energy = if self.wet { self.spreads.energy * slope } else { 0.0 };
            let of_run = |MeasuredRun { seen, errors }: &MeasuredRun| match seen {
                Seen::Rebound(_) | Seen::Measured(..) => {
                    let ratio = errors.ratio(z);
                    let moved = errors.moved(ratio, mean, of_mean);
                    moved * moved / (self.variance(errors, ratio) + (ratio * energy).powi(2))
                }
                Seen::On(..) => (of_mean / self.spreads.sigma.hypot(energy)).powi(2),
            };
            squares += setting.runs.iter().map(of_run).sum::<f64>();
        }
        squares.sqrt()
    }

    /// Whether all that is known is on which side runs came out.
    pub(super) fn is_of_sides(&self) -> bool {
        self.runs().all(|run| matches!(run.seen, Seen::On(..)))
    }

    /// Whether runs came out on their side for certain wherever the true speed may be.
    pub(super) fn is_certain_within_reach(&self) -> bool {
        let at_all = |z: f64| self.settings.iter().all(|setting| self.sides_are_certain(setting, z));
        // r grows or falls with the speed, or has its largest value between
        self.is_of_sides() && [-REACH, 0.0, REACH].into_iter().all(at_all)
    }

    /// Whether all runs of a setting of which the side is known would come out there for certain at a true speed.
    pub(super) fn sides_are_certain(&self, setting: &SettingRuns, z: f64) -> bool {
        let mut mean = None;
        setting.runs.iter().all(|run| match run.seen {
            Seen::Rebound(_) => true,
            Seen::On(side, limit) | Seen::Measured(side, limit) => {
                let mean = *mean.get_or_insert_with(|| self.mean(self.kept(setting, &setting.impact(z)).0).0);
                side.sign() * (limit - mean) > CERTAIN * self.spreads.sigma
            }
        })
    }

    /// Whether all runs were measured where they rebounded.
    pub(super) fn is_of_rebounds(&self) -> bool {
        self.runs().all(|run| matches!(run.seen, Seen::Rebound(_)))
    }

    /// About where the integrand is largest: steps of Newton's with a curvature that is not too small.
    pub(super) fn mode(&self) -> f64 {
        const STEPS: usize = 100;
        const ENOUGH: f64 = 0.05;
        /// a step beyond which the second factor may be another
        const FARTHEST: f64 = 2.0;
        let mut z = 0.0;
        let mut at = self.at(z);
        let mut share = 1.0;
        let is_simple = self.goes_side_by_side();
        for _ in 0..STEPS {
            let Moved { slope, curvature } = if is_simple {
                self.moved(z)
            } else {
                self.moved_by_differences(z)
            };
            let step = (share * slope / curvature).clamp(-FARTHEST, FARTHEST);
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

    /// Of noise on the restitution alone and runs that are not asked what they would have been measured at.
    pub(super) fn moved(&self, z: f64) -> Moved {
        let (mut slope, mut curvature) = (-z, 1.0);
        let sigma = self.spreads.sigma;
        for setting in self.settings {
            let impact = setting.impact(z);
            let (mean, of_kept) = self.mean(self.kept(setting, &impact).0);
            let of_mean = of_kept * self.kept_slope_at(setting, &impact, z);
            for run in setting.runs {
                let errors = &run.errors;
                match run.seen {
                    Seen::Rebound(e) => {
                        let ratio = errors.ratio(z);
                        let variance = self.variance(errors, ratio);
                        let distance = e - errors.shared() * (1.0 - ratio) - mean * ratio;
                        let density = normal_density(distance, variance, 0.0);
                        let moved = errors.moved(ratio, mean, of_mean);
                        let of_variance = 2.0 * sigma * sigma * ratio * errors.true_speed.sd;
                        slope += density.mean * moved + density.variance * of_variance;
                        curvature += moved * moved / variance;
                    }
                    Seen::On(side, limit) | Seen::Measured(side, limit) => {
                        let moved = side.sign() * of_mean / sigma;
                        let z = side.sign() * (limit - mean) / sigma;
                        let of_z = self.tails.ln_probability(z).z;
                        slope -= moved * of_z;
                        // nothing where the side is certain
                        curvature += moved * moved * of_z * (z + of_z);
                    }
                }
            }
        }
        Moved { slope, curvature }
    }

    /// The same of any: what moves with z is not in the slopes of one run.
    fn moved_by_differences(&self, z: f64) -> Moved {
        let narrowing = self.narrowing(z);
        let h = 1e-4 / (1.0 + narrowing);
        Moved {
            slope: (self.at(z + h).ln - self.at(z - h).ln) / (2.0 * h),
            curvature: 1.0 + narrowing * narrowing,
        }
    }

    /// About where the integrand is large, and how far from z = 0 it counts.
    pub(super) fn reach(&self, fall: f64) -> Reach {
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
    pub(super) fn turn(&self, setting: &SettingRuns, reach: f64) -> Option<f64> {
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

    /// The largest value that the logarithm of all factors but φ has.
    pub(super) fn largest(&self) -> f64 {
        self.runs().map(|run| self.largest_of(run)).sum()
    }

    pub(super) fn largest_of(&self, MeasuredRun { seen, errors }: &MeasuredRun) -> f64 {
        match seen {
            Seen::Rebound(_) => {
                let least = self.variance(errors, errors.ratio(-REACH)).max(f64::MIN_POSITIVE);
                self.tails.ln_density(0.0, least, 1.0).value
            }
            Seen::On(..) | Seen::Measured(..) => 0.0,
        }
    }
}
