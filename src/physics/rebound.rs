//! Turns the energy kept into a restitution: the square-root law, its smooth continuation, the linear law.
//!
//! Symbols: r kept share of the impact energy, e restitution, α and β of e = √(α + β/v) (eq. envi).

use super::jet::Number;

/// Width τ of the turn at r = 0 in [`mean_restitution`].
pub const TURN: f64 = 0.01;

const TURN4: f64 = TURN * TURN * TURN * TURN;

/// m(r) = r (r² + τ⁴)^(-1/4): the mean restitution, defined for every r.
///
/// √r for r ≫ τ² (within 1e-6 for r ≥ 0.05), −√|r| below zero, smooth between with slope 1/τ at zero.
pub fn mean_restitution(kept: f64) -> f64 {
    kept / (kept * kept + TURN.powi(4)).sqrt().sqrt()
}

/// dm/dr.
pub fn slope_mean_restitution(kept: f64) -> f64 {
    let turn4 = TURN.powi(4);
    let square = kept * kept + turn4;
    (0.5 * kept * kept + turn4) / (square * square.sqrt().sqrt())
}

/// m(r) and m′(r) with two roots and one division.
#[inline(always)]
pub fn mean_and_slope(kept: f64) -> (f64, f64) {
    let square = kept * kept + TURN4;
    let inverse = 1.0 / (square * square.sqrt().sqrt());
    (kept * square * inverse, (0.5 * kept * kept + TURN4) * inverse)
}

/// d²m/dr².
pub fn bend_mean_restitution(kept: f64) -> f64 {
    let turn4 = TURN.powi(4);
    let square = kept * kept + turn4;
    -kept * (0.25 * kept * kept + 1.5 * turn4) / (square * square * square.sqrt().sqrt())
}

/// The r at which m(r) is this: the inverse of [`mean_restitution`].
pub fn kept_of_mean_restitution(mean: f64) -> f64 {
    kept_and_slope(mean).0
}

/// m⁻¹ and its slope with two roots and two divisions; the slope is τ at zero and 2 |m| far from it.
#[inline(always)]
pub fn kept_and_slope(mean: f64) -> (f64, f64) {
    let square = mean * mean;
    // r⁴ = m⁴ (r² + τ⁴), a quadratic in r²
    let root = (square * square + 4.0 * TURN4).sqrt();
    let ratio = (0.5 * (square + root)).sqrt();
    (mean * ratio, ratio * (1.0 + square / root))
}

/// e = √(α + β/v), or `None` where the energy kept is not positive.
pub fn square_root_law(alpha: f64, beta: f64, impact_speed: f64) -> Option<f64> {
    let kept = alpha + beta / impact_speed;
    (kept > 0.0).then(|| kept.sqrt())
}

/// Speed below which the square-root law gives no rebound, −β/α, m/s; NaN unless α > 0 > β.
pub fn threshold_speed<T: Number>(alpha: T, beta: T) -> T {
    (-beta / alpha).only_if(alpha.value() > 0.0 && beta.value() < 0.0)
}

/// e = e_inf (1 − St_c/St) (eq. en2): first order of the square root in 1/St.
pub fn linear_law(e_inf: f64, st_c: f64, stokes: f64) -> f64 {
    e_inf * (1.0 - st_c / stokes)
}

/// Coefficients of √(α + β/v) in powers 1/v⁰, 1/v, 1/v² for α > 0.
///
/// The third is −β²/(8 α²) √α; eq. envi prints −β/(8 α).
pub fn square_root_expansion(alpha: f64, beta: f64) -> [f64; 3] {
    let (root, ratio) = (alpha.sqrt(), beta / alpha);
    [root, root * ratio / 2.0, -root * ratio * ratio / 8.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slip 1 of the paper: the third term of eq. envi is −β²/(8 α² v²), not −β/(8 α v²).
    #[test]
    fn the_expansion_converges_to_third_order() {
        let (alpha, beta) = (0.52, -0.11);
        let [c0, c1, c2] = square_root_expansion(alpha, beta);
        let error = |v: f64| {
            let exact = square_root_law(alpha, beta, v).expect("above the threshold");
            (exact - (c0 + c1 / v + c2 / (v * v))).abs()
        };
        let printed = |v: f64| {
            let exact = square_root_law(alpha, beta, v).expect("above the threshold");
            let third = -alpha.sqrt() * beta / (8.0 * alpha);
            (exact - (c0 + c1 / v + third / (v * v))).abs()
        };
        // the next term falls as 1/v³: ten times the speed, a thousandth of the error
        let order = (error(10.0) / error(100.0)).log10();
        assert!((order - 3.0).abs() < 0.05, "{order}");
        let printed_order = (printed(10.0) / printed(100.0)).log10();
        assert!((printed_order - 2.0).abs() < 0.05, "{printed_order}");
    }

    /// Values with their slopes, and the bend; tests/stability holds the formulas alone.
    #[test]
    fn slopes_agree_with_differences_and_the_inverse_comes_back() {
        for r in [-0.3_f64, -2e-4, 3.1e-5, 1.7e-4, 0.013, 0.62] {
            let h = 1e-6 * f64::max(r.abs(), 1e-4);
            let (mean, slope) = mean_and_slope(r);
            assert!((mean / mean_restitution(r) - 1.0).abs() < 1e-15);
            assert!((slope / slope_mean_restitution(r) - 1.0).abs() < 1e-15);
            let of_slope = (slope_mean_restitution(r + h) - slope_mean_restitution(r - h)) / (2.0 * h);
            assert!((of_slope / bend_mean_restitution(r) - 1.0).abs() < 1e-6, "{r}");
        }
        for r in [-0.7, -3e-4, -1e-9, 0.0, 2e-5, 0.013, 0.62] {
            let (back, slope) = kept_and_slope(mean_restitution(r));
            assert!((back - r).abs() <= 1e-14 * (1.0 + r.abs()), "{r} {back}");
            assert!((slope * slope_mean_restitution(r) - 1.0).abs() < 1e-12, "{r} {slope}");
        }
    }
}
