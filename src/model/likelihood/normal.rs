//! Computes ln Φ and its slope over the whole line.

use crate::distributions::LN_ROOT_TWO_PI;
use crate::exponential::{exponential, logarithm};
use crate::roots::root_between;

/// 1/√(2π).
const ROOT_TWO_PI_INVERSE: f64 = 0.5 * std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_1_SQRT_2;

/// A run this many σ on one side of the limit came out there for certain: ln Φ(9) is −1e-19.
pub(super) const CERTAIN: f64 = 9.0;

/// exp(−x²), with a head of x whose square is exact: the rounding of x² would count x² times.
fn exp_minus_square(x: f64) -> f64 {
    let head = f64::from(x as f32);
    (-head * head).exp() * (-(x - head) * (x + head)).exp()
}

/// Φ(z); accurate to a few ulp, times z² below zero.
pub fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// ln Φ(z) and φ(z)/Φ(z), its slope; accurate from −∞ to ∞ to a few ulp, times z² for the slope above zero.
#[inline(always)] // where the slope is not read it is not computed
pub fn ln_normal_cdf(z: f64) -> (f64, f64) {
    /// below this, erfc nears the smallest numbers there are
    const FAR: f64 = -35.0;
    let ln_density = -0.5 * z * z - LN_ROOT_TWO_PI;
    if z > 0.0 {
        let above = normal_cdf(-z);
        ((-above).ln_1p(), ln_density.exp() / (1.0 - above))
    } else if z > FAR {
        // both of the slope's parts at the same rounded x: each alone feels its rounding z² times, their quotient once
        let x = -z * std::f64::consts::FRAC_1_SQRT_2;
        let below = 0.5 * libm::erfc(x);
        (below.ln(), ROOT_TWO_PI_INVERSE * exp_minus_square(x) / below)
    } else {
        // Φ(z) = φ(z)/(−z) (1 − 1/z² + 3/z⁴ − 15/z⁶ + …): at z = −35 the seventh term is below the last digit
        let w = 1.0 / (z * z);
        let series = 1.0 - w * (1.0 - 3.0 * w * (1.0 - 5.0 * w * (1.0 - 7.0 * w * (1.0 - 9.0 * w * (1.0 - 11.0 * w)))));
        (ln_density - (-z).ln() + series.ln(), -z / series)
    }
}

/// The same to 2e-14, times z² for the slope above zero, for |z| up to 1e150: without a branch or a call, so that a loop may
/// take several at a time; `fused` as of [`exponential`].
#[inline(always)]
pub(super) fn ln_normal_cdf_and_slope(z: f64, fused: bool) -> [f64; 2] {
    /// √(2/π)
    const ROOT_TWO_OVER_PI: f64 = 2.0 * ROOT_TWO_PI_INVERSE;
    let scaled = scaled_erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2, fused);
    let half_square = 0.5 * z * z;
    let density = exponential(-half_square, fused);
    // Φ(z) = exp(−z²/2) w/2 below zero, 1 less that of −z above; both are computed, since a branch would end a loop's lanes
    let below = f64::from(u8::from(z < 0.0));
    let choose = |of_below: f64, of_above: f64| below * of_below + (1.0 - below) * of_above;
    let other = 0.5 * scaled * density;
    let of_ln = choose(0.5 * scaled, 1.0 - other);
    // what rounding took off 1 − Φ(−z)
    let lost = (other + (of_ln - 1.0)) / of_ln;
    let slope = choose(ROOT_TWO_OVER_PI, ROOT_TWO_PI_INVERSE * density) / choose(scaled, of_ln);
    [logarithm(of_ln, fused) - choose(half_square, lost), slope]
}

/// ln(exp(z²/2) Φ(−z)) of z ≥ 0.
pub(super) fn ln_scaled_tail(z: f64) -> f64 {
    (0.5 * scaled_erfc(z * std::f64::consts::FRAC_1_SQRT_2, false)).ln()
}

/// w = exp(t²) erfc(t) of t ≥ 0, to 1e-15 of it.
///
/// (1 + 2t) w is smooth in (t − 4)/(t + 4) from −1 to 1; its Chebyshev series to the 23rd degree, from 80 nodes,
/// is off by 4e-17.
#[inline(always)]
fn scaled_erfc(t: f64, fused: bool) -> f64 {
    const CENTRE: f64 = 4.0;
    const HIGHEST: f64 = 9.311744978232572e-10;
    const OTHERS: [f64; 23] = [
        1.5738283774192037e-09,
        -1.234686604382353e-08,
        -1.6371779763566967e-08,
        1.0633855618594884e-07,
        7.115337800585303e-08,
        -8.210939042560568e-07,
        2.9801353803031333e-07,
        5.706604414895734e-06,
        -1.1225101875659178e-05,
        -2.4397746422436416e-05,
        0.00015062309720018628,
        -0.00019925714661091188,
        -0.000757773707063825,
        0.005031970067657489,
        -0.016197733981455194,
        0.03716751552655567,
        -0.06633036582031154,
        0.0937328349990944,
        -0.10103906603586531,
        0.06809705425466908,
        0.015379652102610473,
        -0.1396211168405623,
        1.2329951186255526,
    ];
    let y = (t - CENTRE) / (t + CENTRE);
    let mut series = HIGHEST;
    for term in OTHERS {
        series = if fused {
            series.mul_add(y, term)
        } else {
            series * y + term
        };
    }
    series / (1.0 + 2.0 * t)
}

/// z with these logarithms of Φ(z) and of Φ(−z): what a probability that is no normal's is as a normal's.
pub fn normal_score(ln_below: f64, ln_above: f64) -> f64 {
    /// where nothing is left of a side that can be computed
    const FAR: f64 = 40.0;
    let (ln, sign) = match (ln_below.is_finite(), ln_above.is_finite()) {
        (true, false) => return FAR,
        (false, true) => return -FAR,
        _ if ln_below < ln_above => (ln_below, 1.0),
        _ => (ln_above, -1.0),
    };
    // Φ(z) ≤ exp(−z²/2)/2 below zero
    let least = -(-2.0 * (ln + std::f64::consts::LN_2)).max(0.0).sqrt();
    sign * root_between([least, 0.0], |z| ln_normal_cdf(z).0 - ln).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_at_a_time_are_as_one() {
        for step in -3700..3700 {
            let z = 0.01 * f64::from(step);
            let (value, slope) = ln_normal_cdf(z);
            for fused in [false, true] {
                let [wide, wide_slope] = ln_normal_cdf_and_slope(z, fused);
                let allowed = 2e-14 + 1e-15 * z.max(0.0) * z;
                assert!((wide / value - 1.0).abs() < allowed, "{z}: {wide:e} {value:e}");
                assert!(
                    (wide_slope / slope - 1.0).abs() < allowed,
                    "{z}: {wide_slope:e} {slope:e}"
                );
            }
        }
    }

    #[test]
    fn a_score_comes_from_the_side_that_is_known() {
        let score = |z: f64| normal_score(ln_normal_cdf(z).0, ln_normal_cdf(-z).0);
        for z in [-60.0, -8.0, -1.5, -0.01, 0.0, 0.3, 4.0, 30.0] {
            assert!((score(z) - z).abs() < 1e-9, "{z} {}", score(z));
        }
        for lost in [f64::NAN, f64::NEG_INFINITY] {
            let (above, below) = (normal_score(0.0, lost), normal_score(lost, 0.0));
            assert!(above > 30.0 && below < -30.0, "{above} {below}");
        }
    }
}
