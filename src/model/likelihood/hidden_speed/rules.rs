//! Chooses the nodes of an integral over the true speed.
//!
//! Where nothing turns within reach the trapezoidal rule in z is exact to 1e-9. Where r has its zero there, at z₀, the integral is taken in x with
//! z = z₀ + m⁻¹(x)/r′(z₀), which makes m(r) as smooth as the rest, by Gauss's rule on panels from the turn outwards; where
//! several settings turn, from each of them half the way to the next.

use super::reach::{Reach, Turn};
use super::{AtSpeed, HiddenSpeed, MeasuredRun};
use crate::model::likelihood::convolution::{Panel, GAUSS, MOST_PANELS};
use crate::model::likelihood::run_density::Seen;
use crate::model::likelihood::tails::Tails;
use crate::physics::rebound::{kept_and_slope, mean_restitution};
use crate::runs::MOST_SETTINGS;

/// How large the integrand is at a node.
#[derive(Clone, Copy)]
pub(super) struct Height {
    /// its logarithm
    pub ln: f64,
    /// the slope of that in what is kept, that of all settings together
    pub of_kept: f64,
}

impl HiddenSpeed<'_> {
    /// Gives every node, z with its weight, to a sum, which tells the logarithm of the integrand there, or that it is
    /// infinite where it is not known yet.
    pub(super) fn over_nodes(&self, reach: &Reach, add: &mut impl FnMut(f64, f64) -> f64) {
        if reach.turns.is_empty() {
            return self.over_steps(reach, add);
        }
        for (place, turn) in reach.turns.iter().enumerate() {
            let half_way = |other: &Turn| (0.5 * (turn.z + other.z)).clamp(-reach.far, reach.far);
            let before = place.checked_sub(1).map(|before| &reach.turns[before]);
            let ends = [
                before.map_or(-reach.far, half_way),
                reach.turns.get(place + 1).map_or(reach.far, half_way),
            ];
            self.over_panels(*turn, ends, reach, add);
        }
    }

    /// The trapezoidal rule from the mode to both sides, until nothing is left.
    fn over_steps(&self, reach: &Reach, add: &mut impl FnMut(f64, f64) -> f64) {
        /// steps a width, of a normal integrand and of one with Student's tails
        const SHARE: [f64; 2] = [0.9, 0.3];
        /// of the fall, where the nodes beyond have no more than is nothing
        const ENOUGH: f64 = 0.9;
        let width = |z: f64| 1.0 / (1.0 + self.narrowing(z).powi(2)).sqrt();
        let mode = reach.near;
        let here = width(mode);
        let narrowest = here.min(width(mode - 5.0 * here)).min(width(mode + 5.0 * here));
        let step = narrowest * SHARE[usize::from(self.tails != Tails::Normal)];
        for sign in [-1.0, 1.0] {
            for index in 0..MOST_PANELS {
                let ln = add(mode + sign * step * (index as f64 + 0.5), step);
                // also where it is no number
                if ln.is_nan() || ln <= reach.ln - ENOUGH * reach.fall {
                    break;
                }
            }
        }
    }

    /// Gauss's rule on panels from a turn outwards to both ends, which are values of z.
    fn over_panels(&self, turn: Turn, ends: [f64; 2], reach: &Reach, add: &mut impl FnMut(f64, f64) -> f64) {
        let slope = self.kept_slope(&self.settings[turn.setting], turn.z);
        let over_slope = 1.0 / slope;
        let place = |x: f64| turn.z + kept_and_slope(x).0 / slope;
        let range = ends.map(|z| mean_restitution((z - turn.z) * slope));
        let (lo, hi) = (range[0].min(range[1]), range[0].max(range[1]));
        // parameters beyond all numbers have no range, and so no density
        if lo.is_nan() || hi.is_nan() {
            return;
        }
        let inner = 0f64.clamp(lo, hi);
        // nearer to its own turn no setting moves faster
        let mut with_x = [0.0; MOST_SETTINGS];
        for (with_x, setting) in with_x.iter_mut().zip(self.settings) {
            *with_x = self.kept_slope(setting, turn.z) / slope;
        }
        for (end, sign) in [(lo, -1.0), (hi, 1.0)] {
            let mut ends = vec![inner];
            let mut from = inner;
            while ends.len() <= MOST_PANELS {
                let rest = sign * (end - from);
                if rest.is_nan() || rest <= 0.0 {
                    break;
                }
                let mut panel = self.panel(&with_x, slope, place(from));
                if self.is_certain(place(from), sign) {
                    panel.own = 0.0;
                }
                let length = panel.length(from, sign).min(rest);
                from = if length < rest { from + sign * length } else { end };
                ends.push(from);
            }
            let places: Vec<f64> = ends.iter().map(|x| place(*x)).collect();
            let at = self.at_each(&places);
            for (ends, at) in ends.windows(2).zip(at.windows(2)) {
                if self.may_count(&at[0], &at[1], reach) {
                    let (half, middle) = (0.5 * (ends[1] - ends[0]).abs(), 0.5 * (ends[0] + ends[1]));
                    // first without what is done with them, so that several are taken at a time
                    let mut nodes = [[[0.0; 2]; 2]; GAUSS.len()];
                    for (nodes, [node, weight]) in nodes.iter_mut().zip(GAUSS) {
                        for (to, x) in nodes.iter_mut().zip([middle - half * node, middle + half * node]) {
                            let (y, stretch) = kept_and_slope(x);
                            *to = [turn.z + y * over_slope, half * weight * stretch * over_slope.abs()];
                        }
                    }
                    for [z, weight] in nodes.into_iter().flatten() {
                        add(z, weight);
                    }
                }
            }
        }
    }

    /// How large the integrand is at each of these places.
    fn at_each(&self, places: &[f64]) -> Vec<Height> {
        if self.goes_side_by_side() {
            return self.heights(places);
        }
        let height = |z: &f64| {
            let AtSpeed { ln, of_kept, .. } = self.at(*z);
            Height { ln, of_kept }
        };
        places.iter().map(height).collect()
    }

    /// How long a panel may be that begins at z, counted from a turn at which its setting has this slope of r, of which each
    /// setting has so many times as much.
    fn panel(&self, with_x: &[f64; MOST_SETTINGS], slope: f64, z: f64) -> Panel {
        // what a run's factor moves by with x, and beside x with z, in its spreads
        let (mut own, mut beside) = (0.0, 0.0);
        for (setting, with_x) in self.settings.iter().zip(with_x) {
            for MeasuredRun { seen, errors } in setting.runs {
                let (ratio, sd, spread) = match seen {
                    Seen::Rebound(_) | Seen::Measured(..) => {
                        let ratio = errors.ratio(z);
                        (ratio, errors.true_speed.sd, self.variance(errors, ratio).sqrt())
                    }
                    Seen::On(..) => (1.0, 0.0, self.spreads.sigma),
                };
                own += (with_x * ratio / spread).powi(2);
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

    /// Whether something of the integrand may lie between two speeds: not where it is nothing at both and they lie on one
    /// side of what was seen.
    fn may_count(&self, a: &Height, b: &Height, reach: &Reach) -> bool {
        let nothing = reach.ln - reach.fall;
        let one_side = a.of_kept * b.of_kept > 0.0 || !self.runs().any(|run| matches!(run.seen, Seen::Rebound(_)));
        !(one_side && a.ln < nothing && b.ln < nothing)
    }
}
