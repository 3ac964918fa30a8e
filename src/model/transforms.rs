//! Maps a bounded parameter to the whole line and back, with the logarithm of the Jacobian.

use super::parameters::{ModelParameter, ParameterKind};
use crate::scene::Prior;

/// How a parameter inside (lower, upper) is made unbounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transform {
    /// x = lower + exp(u)
    Above(f64),
    /// x = lower + (upper − lower)/(1 + exp(−u))
    Between(f64, f64),
    /// x = u
    Free,
    /// x = |u|, for a spread that may be zero: what depends on its square alone goes smoothly through zero
    Either,
}

/// A parameter's value with what a density needs of the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapped {
    /// x
    pub value: f64,
    /// dx/du
    pub slope: f64,
    /// ln |dx/du|
    pub ln_jacobian: f64,
    /// its slope in u
    pub ln_jacobian_slope: f64,
}

impl Transform {
    /// The map of a parameter. Of the two spreads of wet runs either may be zero where the other is not, and the likelihood reads
    /// their squares: with a half-normal prior, which has no slope at zero, the density goes on smoothly below it.
    pub fn of_parameter(parameter: &ModelParameter, both: bool) -> Transform {
        let is_either = both && matches!(parameter.kind, ParameterKind::SigmaWet | ParameterKind::SigmaEnergy);
        match parameter.prior {
            Prior::HalfNormal(_) if is_either => Transform::Either,
            _ => Transform::of(parameter.bounds),
        }
    }

    /// The map for these bounds; no upper bound without a lower one.
    pub fn of((lower, upper): (f64, f64)) -> Transform {
        match (lower.is_finite(), upper.is_finite()) {
            (true, true) => Transform::Between(lower, upper),
            (true, false) => Transform::Above(lower),
            (false, _) => Transform::Free,
        }
    }

    /// The parameter at u.
    pub fn at(self, u: f64) -> Mapped {
        match self {
            Transform::Above(lower) => {
                let x = u.exp();
                Mapped {
                    value: lower + x,
                    slope: x,
                    ln_jacobian: u,
                    ln_jacobian_slope: 1.0,
                }
            }
            Transform::Between(lower, upper) => {
                let width = upper - lower;
                // exp of a negative number only: no overflow on either side
                let small = (-u.abs()).exp();
                let (share, rest) = if u >= 0.0 {
                    (1.0 / (1.0 + small), small / (1.0 + small))
                } else {
                    (small / (1.0 + small), 1.0 / (1.0 + small))
                };
                Mapped {
                    value: lower + width * share,
                    slope: width * share * rest,
                    ln_jacobian: width.ln() - u.abs() - 2.0 * small.ln_1p(),
                    ln_jacobian_slope: rest - share,
                }
            }
            Transform::Free => Mapped {
                value: u,
                slope: 1.0,
                ln_jacobian: 0.0,
                ln_jacobian_slope: 0.0,
            },
            Transform::Either => Mapped {
                value: u.abs(),
                slope: u.signum(),
                ..Transform::Free.at(u)
            },
        }
    }

    /// The u of a parameter; one at or beyond a bound is taken inside by a thousandth of what there is.
    pub fn inverse(self, value: f64) -> f64 {
        const INSIDE: f64 = 1e-3;
        match self {
            Transform::Above(lower) if value > lower => (value - lower).ln(),
            Transform::Above(lower) => (INSIDE * (1.0 + lower.abs())).ln(),
            Transform::Between(lower, upper) => {
                let share = (value - lower) / (upper - lower);
                let share = match share {
                    inside if inside > 0.0 && inside < 1.0 => inside,
                    outside => outside.clamp(INSIDE, 1.0 - INSIDE),
                };
                (share / (1.0 - share)).ln()
            }
            Transform::Free | Transform::Either => value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Transform; 3] = [Transform::Above(0.3), Transform::Between(-0.2, 1.7), Transform::Free];

    #[test]
    fn slopes_and_jacobians_agree_with_differences() {
        for transform in ALL {
            for u in [-3.1, -0.2, 0.7, 4.3] {
                let h = 1e-6;
                let (before, here, after) = (transform.at(u - h), transform.at(u), transform.at(u + h));
                let slope = (after.value - before.value) / (2.0 * h);
                assert!(
                    (slope - here.slope).abs() < 1e-8 * (1.0 + slope.abs()),
                    "{transform:?} {u}"
                );
                assert!((here.slope.ln() - here.ln_jacobian).abs() < 1e-13);
                let bend = (after.ln_jacobian - before.ln_jacobian) / (2.0 * h);
                assert!((bend - here.ln_jacobian_slope).abs() < 1e-8, "{transform:?} {u}");
                assert!((transform.inverse(here.value) - u).abs() < 1e-12, "{transform:?} {u}");
            }
        }
    }

    #[test]
    fn a_spread_is_the_same_on_either_side_of_zero() {
        let [below, above] = [-0.3, 0.3].map(|u| Transform::Either.at(u));
        assert_eq!((below.value, below.slope, above.slope), (above.value, -1.0, 1.0));
        assert_eq!(Transform::Either.inverse(below.value), 0.3);
    }

    #[test]
    fn far_out_nothing_overflows() {
        for u in [-800.0, 800.0] {
            let here = Transform::Between(0.0, 0.87).at(u);
            assert!((0.0..=0.87).contains(&here.value) && here.ln_jacobian.is_finite());
        }
    }
}
