//! Integrates over the true speed of runs of one setting that turns nearby, by the trapezoidal rule.
//!
//! With z = z₀ + m⁻¹(x)/r′(z₀), where r is zero at z₀, m(r) is all but x, and the integrand is analytic as far as the poles of
//! m⁻¹ at τ(±1 ± i): steps of a share of τ are exact to 1e-7. Farther out, where φ and the runs are what is narrow, they grow:
//! x = a sinh(w/a) with steps of w.

use std::sync::LazyLock;

use super::bell::FAR;
use super::lanes::NodeBatch;
use super::reach::REACH;
use super::{HiddenSpeed, SettingRuns, SettingSlopes, FALL};
use crate::model::likelihood::run_density::{RunDensity, Seen};
use crate::physics::rebound::{kept_and_slope, kept_of_mean_restitution, mean_restitution, TURN};

/// a, from where steps grow.
const GROWS: f64 = 10.0 * TURN;

/// The longest step of w.
const LONGEST: f64 = 0.375 * TURN;

/// The shortest is the longest over this.
const SHORTER: usize = 4;

/// The shortest steps of w to either side, a multiple of the longest.
const MOST: usize = 320;

/// m⁻¹(x) at the shortest steps, and its slope in w.
static PLACES: LazyLock<[[f64; 2]; 2 * MOST + 1]> = LazyLock::new(|| {
    std::array::from_fn(|index| {
        let w = (index as f64 - MOST as f64) * LONGEST / SHORTER as f64;
        let (kept, slope) = kept_and_slope(GROWS * (w / GROWS).sinh());
        [kept, slope * (w / GROWS).cosh()]
    })
});

/// Where a setting turns, and how its r moves.
struct Turning {
    z: f64,
    /// dr/dz there
    slope: f64,
    /// the most that a slope within reach is of that, or that of a slope
    bend: f64,
    /// distance of z from 0 beyond which the integrand is nothing
    far: f64,
}

impl HiddenSpeed<'_> {
    /// The integral where it is a bell or one over runs of one setting; `None` where neither rule does for it. For what
    /// [`HiddenSpeed::goes_side_by_side`].
    pub(super) fn over_bell_or_turn(&self, of_settings: &mut [SettingSlopes]) -> Option<RunDensity> {
        if let Some(found) = self.near_turn(FAR, of_settings) {
            return Some(found);
        }
        if let Some(found) = self.over_bell(of_settings) {
            return Some(found);
        }
        // what is no bell there is bent by a turn farther off
        self.near_turn(3.0 * REACH, of_settings)
    }

    /// The integral over wet runs of one setting that turns within so many standard deviations; for what
    /// [`HiddenSpeed::goes_side_by_side`]. `None` where it does not or this rule would not do.
    pub(super) fn near_turn(&self, within: f64, of_settings: &mut [SettingSlopes]) -> Option<RunDensity> {
        let [setting] = self.settings else {
            return None;
        };
        let turning = self.turning(setting, within)?;
        let [lo, hi] = self.kept_within(setting, &turning);
        let places = &*PLACES;
        let first = places.partition_point(|[kept, _]| *kept < lo);
        let end = places.partition_point(|[kept, _]| *kept < hi);
        if first == 0 || first == end || end == places.len() {
            return None;
        }
        let stride = self.stride(setting, &turning, mean_restitution(lo.abs().max(hi.abs())))?;
        let over_slope = 1.0 / turning.slope;
        let weight = stride as f64 * LONGEST / SHORTER as f64 * over_slope.abs();
        let mut nodes = NodeBatch::new(self, f64::NEG_INFINITY, of_settings);
        for index in (first.next_multiple_of(stride)..end).step_by(stride) {
            let [kept, slope] = places[index];
            nodes.add(turning.z + kept * over_slope, weight * slope);
        }
        Some(nodes.finish().density())
    }

    fn turning(&self, setting: &SettingRuns, within: f64) -> Option<Turning> {
        /// of the measured speed, well above where no slower one is counted
        const SLOWEST: f64 = 0.1;
        let z = self.turn(setting, within)?;
        let slope = self.kept_slope(setting, z);
        let far = (2.0 * (FALL + self.largest() - self.at(0.0).ln)).max(0.0).sqrt();
        let slopes = [-far, far].map(|z| self.kept_slope(setting, z) / slope);
        let bend = slopes
            .into_iter()
            .fold(1.0, |bend: f64, ratio| bend.max(ratio).max(1.0 / ratio));
        let keeps_its_way = slopes.iter().all(|ratio| *ratio > 0.0);
        let is_slow = setting.ratio(z.min(-far)) < SLOWEST;
        (keeps_its_way && !is_slow).then_some(Turning { z, slope, bend, far })
    }

    /// r, as if it were linear, beyond which the integrand is nothing.
    fn kept_within(&self, setting: &SettingRuns, turning: &Turning) -> [f64; 2] {
        let Turning { z, slope, bend, far } = *turning;
        let ends = [-far, far];
        let mut kept = ends.map(|end| (end - z) * slope);
        kept.sort_by(f64::total_cmp);
        let [mut lo, mut hi] = kept;
        for run in setting.runs {
            if let Seen::Rebound(e) = run.seen {
                let ratios = ends.map(|end| run.errors.ratio(end));
                let farthest = far * self.variance(&run.errors, ratios[1]).sqrt();
                let mean = |ratio: f64, far: f64| (e - run.errors.shared() * (1.0 - ratio) + far) / ratio;
                let least = mean(ratios[0], -farthest).min(mean(ratios[1], -farthest));
                let most = mean(ratios[0], farthest).max(mean(ratios[1], farthest));
                let [least, most] = [least, most].map(kept_of_mean_restitution);
                lo = lo.max((least * bend).min(least / bend));
                hi = hi.min((most * bend).max(most / bend));
            }
        }
        [lo, hi]
    }

    /// The longest steps, in the shortest, that tell what is narrow up to |x|.
    fn stride(&self, setting: &SettingRuns, turning: &Turning, x: f64) -> Option<usize> {
        /// of the width
        const SHARE: f64 = 0.95;
        /// beyond the turn, or on this side of it, so far in z that little is left
        const LITTLE: f64 = 3.0;
        let Turning { z, slope, bend, far } = *turning;
        let x = x.min(mean_restitution((z.abs() + LITTLE) * slope.abs()));
        let (mut own, mut beside) = (0.0, 1.0);
        for run in setting.runs {
            match run.seen {
                Seen::Rebound(_) | Seen::Measured(..) => {
                    let ratio = run.errors.ratio(-far);
                    let variance = self.variance(&run.errors, ratio);
                    own += bend * bend * ratio * ratio / variance;
                    let sd = run.errors.true_speed.sd;
                    beside += sd * sd * (1.0 + run.errors.shared().abs()).powi(2) / variance;
                }
                Seen::On(..) => own += (bend / self.spreads.sigma).powi(2),
            }
        }
        let with_x = kept_and_slope(x).1 / slope;
        let narrowness = (own + beside * with_x * with_x).sqrt();
        let longest = LONGEST * (x / GROWS).hypot(1.0) * narrowness / SHARE;
        let strides = [SHORTER, SHORTER / 2, SHORTER / 4];
        strides
            .into_iter()
            .find(|stride| longest * (*stride as f64) < SHORTER as f64)
    }
}
