//! Integrates over the true speed where the integrand is all but normal, by a Gauss–Hermite rule.

use super::lanes::MOST_NODES;
use super::reach::Moved;
use super::{HiddenSpeed, SettingRuns, SettingSlopes, Sums};
use crate::model::likelihood::normal_nodes::Order;
use crate::model::likelihood::run_density::RunDensity;

impl HiddenSpeed<'_> {
    /// The integral far from any turn, where the integrand is all but normal; `None` where it is not. For what
    /// [`HiddenSpeed::goes_side_by_side`].
    pub(super) fn over_bell(&self, of_settings: &mut [SettingSlopes]) -> Option<RunDensity> {
        /// largest distance of the logarithm from that of a normal density at any but the two outermost nodes: the integral
        /// is then off by less than 1e-7 and by rounding
        const BEND: [(Order, f64); 2] = [(Order::Eight, 0.1), (Order::Sixteen, 0.4)];
        let (z, width) = self.bell()?;
        for (order, most) in BEND {
            let pairs = order.pairs();
            let mut sums = Sums::new(f64::NEG_INFINITY, of_settings);
            let mut inner = [f64::INFINITY, f64::NEG_INFINITY];
            let (mut places, mut weights, mut ln) = ([0.0; MOST_NODES], [0.0; MOST_NODES], [0.0; MOST_NODES]);
            for (pair, [node, weight]) in pairs.iter().enumerate() {
                (places[2 * pair], places[2 * pair + 1]) = (z - width * node, z + width * node);
                (weights[2 * pair], weights[2 * pair + 1]) = (width * weight, width * weight);
            }
            let count = 2 * pairs.len();
            self.add_nodes(&places[..count], &weights[..count], &mut sums, &mut ln[..count]);
            for ([node, _], ln) in pairs[..pairs.len() - 1].iter().zip(ln.as_chunks::<2>().0) {
                for ln in ln {
                    let bend = ln + 0.5 * node * node;
                    inner = [inner[0].min(bend), inner[1].max(bend)];
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
        let mut z = 0.0;
        let Moved {
            mut slope,
            curvature: least,
        } = self.moved(z);
        let mut curvature = least;
        for _ in 0..STEPS {
            let step = slope / curvature;
            let next = z + step;
            if (step * curvature.sqrt()).abs() < NEAR {
                z = next;
                break;
            }
            let there = self.moved(next).slope;
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
}
