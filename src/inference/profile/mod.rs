//! Finds the limits of a quantity at which the weighted squares, least over all else, have risen by t²s² above the fit's.
//!
//! Where a fit is a straight line in its parameters and the quantity is one of them, these are the delta method's limits.
//! Where a run pins a parameter at the edge of a square root, say, the delta method's lie within a thousandth of a
//! standard error and these do not.
//!
//! | file | job |
//! |---|---|
//! | `of_problem.rs` | profiles of a function of the parameters of any least-squares problem |
//!
//! Source: profile t of Bates & Watts 1988, Nonlinear Regression Analysis and Its Applications, section 6.1.

mod of_problem;

pub use of_problem::{first_parameter, ProblemProfile, Region, WithSlopes};

/// A point at which the weighted squares are least among those with its value of the quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ProfilePoint {
    /// the quantity
    value: f64,
    /// square root of the squares' rise over t²s²: 0 at the fit, 1 at a limit
    distance: f64,
}

impl ProfilePoint {
    /// From squares above those of the fit; where a fit ended short of the least squares they may lie below.
    fn new(value: f64, rise: f64, wanted: f64) -> ProfilePoint {
        ProfilePoint {
            value,
            distance: (rise.max(0.0) / wanted).sqrt(),
        }
    }
}

/// Where the squares have risen by t²s²; `None` where they do not, or where the quantity ends before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// below the estimate
    pub lo: Option<f64>,
    /// above it
    pub hi: Option<f64>,
}

impl Limits {
    /// Both, in their order.
    pub fn both(self) -> Option<[f64; 2]> {
        Some([self.lo?, self.hi?])
    }

    /// The same of a function of the quantity; falling ones change the sides.
    pub fn map(self, of: impl Fn(f64) -> Option<f64>, rises: bool) -> Limits {
        let [first, second] = [self.lo, self.hi].map(|limit| limit.and_then(&of));
        let (lo, hi) = if rises { (first, second) } else { (second, first) };
        Limits { lo, hi }
    }
}

/// Distance from 1 of the distances, and share of a half width, within which the delta method is taken to agree with the
/// profile without a search: three quarters of what its interval is given up for, as these are taken along the slopes at
/// the fit.
pub const AGREES: f64 = 0.15;

/// A distance this near to 1 is a limit; it is off by about as much of the half width.
const NEAR: f64 = 1e-4;

/// The limit on the side of a first guess. `profile` gives the point for a target, which lies at or somewhat short of it;
/// `None` where that is out of reach.
fn limit(value: f64, first: f64, mut profile: impl FnMut(f64) -> Option<ProfilePoint>) -> Option<f64> {
    /// expansions, by up to 8: a profile that has not risen by then is flat
    const EXPANSIONS: usize = 24;
    const STEPS: usize = 60;
    /// share of the way to its target that a point within reach has come
    const REACHED: f64 = 0.5;
    let at = |value: f64, distance: f64| ProfilePoint { value, distance };
    // targets, each with the point it led to; infinitely far where it is out of reach
    let mut inside = (value, at(value, 0.0));
    let mut outside: Option<(f64, ProfilePoint)> = None;
    let (mut target, mut expansions) = (first, 0);
    for step in 0..STEPS {
        let has_come =
            |point: &ProfilePoint| point.distance >= 1.0 || (point.value - value) / (target - value) > REACHED;
        let found = profile(target).filter(has_come);
        let found = found.unwrap_or_else(|| at(target, f64::INFINITY));
        if (found.distance - 1.0).abs() <= NEAR {
            return Some(found.value);
        }
        if found.distance < 1.0 {
            inside = (target, found);
        } else {
            outside = Some((target, found));
        }
        let Some((end, point)) = outside else {
            if expansions == EXPANSIONS {
                return None;
            }
            // mostly a little beyond the straight line does, which leaves a secant next to nothing
            let least = if expansions < 2 { 1.02 } else { 1.5 };
            expansions += 1;
            target = value + (target - value) * (1.02 / inside.1.distance).clamp(least, 8.0);
            continue;
        };
        let width = end - inside.0;
        if width.abs() <= NEAR * (end - value).abs() {
            // a jump of the profile is a limit, the end of what the quantity can be is none
            return point.distance.is_finite().then_some(inside.1.value);
        }
        // secants, and a half in between: profiles turn where runs do
        let part = match point.distance {
            far if (step > 4 && step % 3 == 2) || !far.is_finite() => 0.5,
            far => (1.0 - inside.1.distance) / (far - inside.1.distance),
        };
        target = inside.0 + width * part.clamp(0.02, 0.98);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_a_bent_profile_are_found_from_a_guess_that_is_far_off() {
        // squares rise as the distance itself to the right, as its fourth power to the left
        let profile = |value: f64| {
            let apart: f64 = value - 3.0;
            let rise = if apart > 0.0 { apart } else { apart.powi(4) };
            Some(ProfilePoint::new(value, rise, 0.25))
        };
        let [lo, hi] = [2.9999, 3.0001].map(|first| limit(3.0, first, profile).unwrap());
        assert!((hi - 3.25).abs() < 2e-3, "{hi}");
        assert!((3.0 - lo - 0.25f64.powf(0.25)).abs() < 2e-3, "{lo}");
    }

    #[test]
    fn a_flat_profile_and_the_end_of_a_quantity_have_no_limit() {
        let flat = |value: f64| Some(ProfilePoint::new(value, 1.0 - (-value * value).exp(), 2.0));
        assert_eq!([-0.1, 0.1].map(|first| limit(0.0, first, flat)), [None, None]);
        let ends = |value: f64| (value < 0.5).then(|| ProfilePoint::new(value, value * value, 1.0));
        let [lo, hi] = [-1.1, 1.1].map(|first| limit(0.0, first, ends));
        assert!(hi.is_none() && (lo.unwrap() + 1.0).abs() < 3e-3, "{lo:?} {hi:?}");
    }
}
