//! Maps a bounded parameter to the whole line and back, with the logarithm of the Jacobian; and the two spreads of wet runs to
//! their total and an angle.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use super::likelihood::normal::{ln_normal_cdf, normal_cdf};
use crate::distributions::normal_quantile;
use crate::roots::root_between;

/// How a parameter inside (lower, upper) is made unbounded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transform {
    /// x = lower + exp(u)
    Above(f64),
    /// x = lower + (upper − lower)/(1 + exp(−u))
    Between(f64, f64),
    /// x = u
    Free,
    /// x = π/2 Φ(u), for an angle whose ends are nothing special: a density that is even about them has the tails of a normal
    RightAngle,
    /// x = s (u Φ(u) + φ(u)) with the scale s, for a spread that may as well be 0: below some s it has the tail of a normal, and
    /// far above it is s u
    FromNought(f64),
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
            Transform::RightAngle => {
                let ln_jacobian = FRAC_PI_2.ln() - 0.5 * (u * u + (2.0 * PI).ln());
                Mapped {
                    value: FRAC_PI_2 * normal_cdf(u),
                    slope: ln_jacobian.exp(),
                    ln_jacobian,
                    ln_jacobian_slope: -u,
                }
            }
            Transform::FromNought(scale) => {
                let (ln_below, slope) = ln_normal_cdf(u);
                let below = ln_below.exp();
                Mapped {
                    // with the density as the slope has it, so that both nearly cancel without loss far below 0
                    value: scale * below * (u + slope),
                    slope: scale * below,
                    ln_jacobian: scale.ln() + ln_below,
                    ln_jacobian_slope: slope,
                }
            }
        }
    }

    /// The u of a parameter; one at or beyond a bound is taken inside by a thousandth of what there is.
    pub fn inverse(self, value: f64) -> f64 {
        const INSIDE: f64 = 1e-3;
        let inside = |share: f64| match share {
            inside if inside > 0.0 && inside < 1.0 => inside,
            outside => outside.clamp(INSIDE, 1.0 - INSIDE),
        };
        match self {
            Transform::Above(lower) if value > lower => (value - lower).ln(),
            Transform::Above(lower) => (INSIDE * (1.0 + lower.abs())).ln(),
            Transform::Between(lower, upper) => {
                let share = inside((value - lower) / (upper - lower));
                (share / (1.0 - share)).ln()
            }
            Transform::Free => value,
            Transform::RightAngle => normal_quantile(inside(value / FRAC_PI_2)),
            Transform::FromNought(scale) => {
                /// where nothing is left
                const FAR: f64 = -30.0;
                let of_scale = if value > 0.0 { value / scale } else { INSIDE };
                let nought = |u: f64| self.at(u).value / scale - of_scale;
                root_between([FAR, of_scale], nought).unwrap_or(of_scale)
            }
        }
    }
}

/// σ and σ_r of wet runs, from the total spread S = √(σ² + σ_r²/2) and an angle θ: σ = S cos θ, σ_r = √2 S sin θ.
///
/// Noise on the energy kept moves a restitution by σ_r/(2 e), of a typical e by σ_r/√2. Runs know the total and leave the angle
/// open: in σ and σ_r the posterior lies on an arc about a hole, into which a sampler's steps lead. dσ dσ_r = √2 S dS dθ.
pub fn spreads_at([total, angle]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [total * cosine, SQRT_2 * total * sine]
}

/// S and θ of two spreads: the inverse of [`spreads_at`].
pub fn total_and_angle([sigma, energy]: [f64; 2]) -> [f64; 2] {
    let own = energy / SQRT_2;
    [sigma.hypot(own), own.atan2(sigma)]
}

/// Slopes in S and θ, from those in the two spreads.
pub fn slopes_in_total_and_angle([sigma, energy]: [f64; 2], [of_sigma, of_energy]: [f64; 2]) -> [f64; 2] {
    let [total, _] = total_and_angle([sigma, energy]);
    [
        (of_sigma * sigma + of_energy * energy) / total,
        of_energy * SQRT_2 * sigma - of_sigma * energy / SQRT_2,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Transform; 5] = [
        Transform::Above(0.3),
        Transform::Between(-0.2, 1.7),
        Transform::Free,
        Transform::RightAngle,
        Transform::FromNought(0.02),
    ];

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
                // an angle near its end keeps fewer digits of its distance to it
                assert!((transform.inverse(here.value) - u).abs() < 1e-11, "{transform:?} {u}");
            }
        }
    }

    #[test]
    fn far_out_nothing_overflows() {
        for u in [-800.0, 800.0] {
            let here = Transform::Between(0.0, 0.87).at(u);
            assert!((0.0..=0.87).contains(&here.value) && here.ln_jacobian.is_finite());
        }
    }
}
