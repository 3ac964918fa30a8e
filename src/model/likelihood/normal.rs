//! Computes ln Φ and its slope over the whole line.

use crate::distributions::LN_ROOT_TWO_PI;

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

/// z with these logarithms of Φ(z) and of Φ(−z): what a probability that is no normal's is as a normal's.
pub fn normal_score(ln_below: f64, ln_above: f64) -> f64 {
    /// Newton's steps on a concave function, from where none overshoots
    const STEPS: usize = 40;
    const ENOUGH: f64 = 1e-12;
    let (ln, sign) = if ln_below < ln_above {
        (ln_below, 1.0)
    } else {
        (ln_above, -1.0)
    };
    // Φ(z) ≤ exp(−z²/2)/2 below zero
    let mut z = -(-2.0 * (ln + std::f64::consts::LN_2)).max(0.0).sqrt();
    for _ in 0..STEPS {
        let (value, slope) = ln_normal_cdf(z);
        let step = (ln - value) / slope;
        z += step;
        if step.abs() < ENOUGH * (1.0 + z.abs()) {
            break;
        }
    }
    sign * z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_score_of_a_normal_probability_is_its_z() {
        for z in [-60.0, -8.0, -1.5, -0.01, 0.0, 0.3, 4.0, 30.0] {
            let found = normal_score(ln_normal_cdf(z).0, ln_normal_cdf(-z).0);
            assert!((found - z).abs() < 1e-9, "{z} {found}");
        }
    }

    /// mpmath, 50 digits: log(ncdf(z)) and npdf(z)/ncdf(z).
    #[test]
    fn values_are_those_of_fifty_digit_arithmetic() {
        for (z, expected, slope) in [
            (-40.0, -804.608_442_013_753_8, 40.024_968_847_207_26),
            (-35.5, -634.614_263_155_088_4, 35.528_124_486_560_97),
            (-10.0, -53.231_285_150_512_47, 10.098_093_233_962_512),
            (-1.0, -1.841_021_645_009_263_7, 1.525_135_276_160_981_3),
            (0.0, -std::f64::consts::LN_2, 0.797_884_560_802_865_4),
            (2.5, -0.006_229_025_485_860_002, 0.017_637_825_486_916_735),
            (8.0, -6.220_960_574_271_786e-16, 5.052_271_083_536_895e-15),
        ] {
            let (value, derivative) = ln_normal_cdf(z);
            // a tail's own condition number is z²
            let allowed = 1e-15 * (1.0 + z.max(0.0) * z);
            assert!((value / expected - 1.0).abs() < allowed, "{z}: {value:e} {expected:e}");
            assert!(
                (derivative / slope - 1.0).abs() < allowed,
                "{z}: {derivative:e} {slope:e}"
            );
        }
    }
}
