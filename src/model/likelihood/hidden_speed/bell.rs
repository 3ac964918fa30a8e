//! Integrates over the true speed where the integrand is all but normal, by a Gauss–Hermite rule.

use super::lanes::RuleNodes;
use super::reach::Moved;
use super::{HiddenSpeed, SettingRuns, SettingSlopes, Sums};
use crate::model::likelihood::normal_nodes::Order;
use crate::model::likelihood::run_density::RunDensity;

/// Widths beyond which a bell has 2e-9 of its mass.
pub(super) const FAR: f64 = 6.0;

/// Steps of the secant rule towards a bell.
const STEPS: usize = 4;

/// The last of them that need not be taken once more, in widths.
const NEAR: f64 = 0.3;

/// The curvature of a bell, over that which the mean alone leaves.
pub(super) const LEAST: f64 = 0.3;

/// The largest last coefficient of a rule, of the mass: the integral is then off by less than 1e-7.
pub(super) fn most_of_last(order: Order) -> f64 {
    match order {
        Order::Eight => 1e-4,
        Order::Sixteen => 1e-5,
    }
}

/// An integrand that is all but normal.
struct Bell {
    /// about where it is largest
    z: f64,
    width: f64,
    /// whether what came out on a side would have for certain as far as there is something of it
    sides_are_certain: bool,
}

impl HiddenSpeed<'_> {
    /// The integral far from any turn, where the integrand is all but normal; `None` where it is not. For what
    /// [`HiddenSpeed::goes_side_by_side`].
    pub(super) fn over_bell(&self, of_settings: &mut [SettingSlopes]) -> Option<RunDensity> {
        let Bell {
            z,
            width,
            sides_are_certain,
        } = self.bell()?;
        // eight nodes end where a side that is certain at all of them may still become another
        let first = usize::from(!sides_are_certain);
        for order in &[Order::Eight, Order::Sixteen][first..] {
            let mut sums = Sums::new(f64::NEG_INFINITY, of_settings);
            let mut nodes = RuleNodes::NONE;
            for [node, weight] in order.pairs() {
                nodes.push(z - width * node, width * weight);
                nodes.push(z + width * node, width * weight);
            }
            let at = self.add_nodes(&nodes, &mut sums);
            if order.last_coefficient(at.parts.as_chunks::<2>().0) < most_of_last(*order) * sums.of[0] {
                return Some(sums.density());
            }
        }
        None
    }

    /// About where the integrand is largest; `None` where it may turn within reach.
    fn bell(&self) -> Option<Bell> {
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
        let ends = [-FAR, FAR].map(|far| z + far * width);
        let keeps_its_sign = |setting: &SettingRuns| {
            let [lo, hi] = ends.map(|end| self.kept(setting, &setting.impact(end)).0);
            // also where one is no number
            lo * hi > 0.0
        };
        let clear = !self.wet || self.settings.iter().all(keeps_its_sign);
        let is_certain = |setting: &SettingRuns| ends.iter().all(|end| self.sides_are_certain(setting, *end));
        clear.then(|| Bell {
            z,
            width,
            sides_are_certain: self.settings.iter().all(is_certain),
        })
    }
}
