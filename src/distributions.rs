//! Computes quantiles, tails and peaks of distributions, and the median of numbers, each in bounded time and without a panic for
//! any number.
//!
//! The library below panics, or never comes back, on some numbers that a scene or its runs can lead to: it is called here
//! alone, and only where it was found to come back.

use statrs::distribution::{ContinuousCDF, FisherSnedecor, Normal, StudentsT};
use statrs::function::beta::{checked_beta_reg, inv_beta_reg};
use statrs::function::gamma::{checked_gamma_lr, checked_gamma_ur, digamma, ln_gamma};

use crate::roots::root_between;

/// ln √(2π)
pub const LN_ROOT_TWO_PI: f64 = 0.918_938_533_204_672_8;

/// sd of a normal over its median distance from the mean.
pub const SD_OF_MEDIAN_DISTANCE: f64 = 1.482_602_218_505_602;

/// Degrees of freedom above which Student's t is expanded about the normal: the library's inversion of it loses digits
/// there (1e-8 at 5,000, 7 % at 10⁷), differences of logarithms of Γ do too, and the expansions have none to lose (1e-15 at
/// 1,000).
const MANY: f64 = 1000.0;

/// Degrees of freedom from which the expansion leads near enough to a quantile within √n normal standard deviations.
const SOME: f64 = 5.0;

/// Degrees of freedom below which quantiles of Student's t are not asked for: the library's miss even the 0.1 % point.
pub const FEW: f64 = 0.5;

/// Probability of a tail below which they are not, either: the library's search for them may never end, or panic.
const FAR: f64 = 1e-20;

/// Middle of some numbers, which are put in another order; `None` without any.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let even = values.len().is_multiple_of(2);
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = below.iter().copied().reduce(f64::max).filter(|_| even);
    Some(lower.map_or(*upper, |lower| 0.5 * (lower + *upper)))
}

/// Quantile of the standard normal; no number outside \[0, 1\].
pub fn normal_quantile(probability: f64) -> f64 {
    if (0.0..=1.0).contains(&probability) {
        Normal::standard().inverse_cdf(probability)
    } else {
        f64::NAN
    }
}

/// Quantile of Student's t with `degrees_of_freedom` > 0 at a probability inside (0, 1).
///
/// `None` outside that domain, below 0.5 degrees of freedom, and for tails of less than 1e-20. Source of the expansion:
/// Abramowitz & Stegun 26.7.5.
pub fn student_t_quantile(probability: f64, degrees_of_freedom: f64) -> Option<f64> {
    if !((FAR..1.0).contains(&probability) && degrees_of_freedom >= FEW) {
        return None;
    }
    let z = normal_quantile(probability);
    let n = degrees_of_freedom;
    let about = z * student_t_over_normal(z * z, n);
    if n > MANY {
        return Some(about);
    }
    if n >= SOME && z * z <= n {
        // the library's own search takes several times as long
        let tail = probability.min(1.0 - probability);
        let near = [0.9 * about.abs(), 1.1 * about.abs()];
        return root_between(near, |t| student_t_tail(t, n) - tail).map(|t| t.copysign(z));
    }
    let of = StudentsT::new(0.0, 1.0, n).ok()?;
    Some(of.inverse_cdf(probability))
}

/// Student's quantile over the normal's, whose square is `z2`, expanded in 1/n.
fn student_t_over_normal(z2: f64, n: f64) -> f64 {
    let g1 = (z2 + 1.0) / 4.0;
    let g2 = ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let g3 = (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    let g4 = ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0;
    1.0 + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n
}

/// Log density of Student's t at 0, for ν > 0 degrees of freedom.
///
/// Source of the expansion: that of ln Γ(x + ½) − ln Γ(x), NIST Digital Library of Mathematical Functions, 5.11.
pub fn student_t_peak(nu: f64) -> f64 {
    let half = 0.5 * nu;
    if nu > MANY {
        let x = 1.0 / half;
        return -LN_ROOT_TWO_PI - x / 8.0 + x * x * x / 192.0;
    }
    ln_gamma(half + 0.5) - ln_gamma(half) - 0.5 * (nu * std::f64::consts::PI).ln()
}

/// Slope of [`student_t_peak`] in ν.
pub fn student_t_peak_slope(nu: f64) -> f64 {
    let half = 0.5 * nu;
    if nu > MANY {
        let x = 1.0 / half;
        return x * x / 16.0 * (1.0 - x * x / 8.0);
    }
    0.5 * (digamma(half + 0.5) - digamma(half) - 1.0 / nu)
}

/// Probability that Student's t exceeds t ≥ 0; no number unless it has degrees of freedom above 0.
pub fn student_t_tail(t: f64, degrees_of_freedom: f64) -> f64 {
    let share = degrees_of_freedom / (degrees_of_freedom + t * t);
    checked_beta_reg(0.5 * degrees_of_freedom, 0.5, share).map_or(f64::NAN, |both| 0.5 * both)
}

/// Quantile of the gamma distribution of a shape > 0 and rate 1 at a probability inside (0, 1).
///
/// `None` outside that domain, and where the quantile is below the smallest number. Searched in ln x between bounds of both
/// tails: what lies below x is at most x^a/Γ(a + 1) of a shape a, and what lies above a + √(2 a t) + t at most exp(−t) (Laurent &
/// Massart 2000, Ann. Statist. 28, 1302). Many shapes: Cornish–Fisher, Abramowitz & Stegun 26.4.
pub fn gamma_quantile(probability: f64, shape: f64) -> Option<f64> {
    /// a sum of the library takes some √shape steps below; what the expansion leaves out is beyond rounding above
    const LARGE: f64 = 1e4;
    /// logarithm of less than the smallest number
    const LEAST: f64 = -800.0;
    if !(probability > 0.0 && probability < 1.0 && shape > 0.0 && shape < f64::INFINITY) {
        return None;
    }
    if shape > LARGE {
        let z = normal_quantile(probability);
        let (z2, root) = (z * z, shape.sqrt());
        let fourth = ((9.0 * z2 + 256.0) * z2 - 433.0) * z / 38880.0;
        let third = -((3.0 * z2 + 7.0) * z2 - 16.0) / 810.0 + fourth / root;
        let second = (z2 - 7.0) * z / 36.0 + third / root;
        return Some(shape + root * z + (z2 - 1.0) / 3.0 + second / root);
    }
    let [ln_below, ln_above] = [probability.ln(), (-probability).ln_1p()];
    // of the smaller tail, whose digits are kept
    let beyond = |y: f64| match probability <= 0.5 {
        true => checked_gamma_lr(shape, y.exp()).map_or(f64::NAN, |below| below.ln() - ln_below),
        false => checked_gamma_ur(shape, y.exp()).map_or(f64::NAN, |above| ln_above - above.ln()),
    };
    let least = (ln_below + ln_gamma(shape + 1.0)) / shape;
    let most = (shape + (-2.0 * shape * ln_above).sqrt() - ln_above).ln();
    // a little wider, since a bound may be met to rounding
    let y = root_between([least.max(LEAST) - 0.1, most + 0.1], beyond)?;
    Some(y.exp()).filter(|x| x.is_normal())
}

/// Quantile of the beta distribution; no number unless both shapes are positive and the probability lies in \[0, 1\].
pub fn beta_quantile(probability: f64, (a, b): (f64, f64)) -> f64 {
    let usable = |shape: f64| shape > 0.0 && shape < f64::INFINITY;
    if usable(a) && usable(b) && (0.0..=1.0).contains(&probability) {
        inv_beta_reg(a, b, probability)
    } else {
        f64::NAN
    }
}

/// Probability that F with these degrees of freedom exceeds `f`; `None` outside f ≥ 0 or for no degrees of freedom.
pub fn f_tail(f: f64, between: f64, within: f64) -> Option<f64> {
    if f.is_nan() || f < 0.0 {
        return None;
    }
    let of = FisherSnedecor::new(between, within).ok()?;
    // beyond, the share of the two sums is no number
    Some(if (f * between).is_finite() { of.sf(f) } else { 0.0 })
}

/// Probability that χ² with these degrees of freedom exceeds `chi_squared`; `None` outside χ² ≥ 0 or for no degrees of freedom.
pub fn chi_squared_tail(chi_squared: f64, degrees_of_freedom: f64) -> Option<f64> {
    if !(chi_squared >= 0.0 && degrees_of_freedom > 0.0 && degrees_of_freedom < f64::INFINITY) {
        return None;
    }
    let (half, shape) = (0.5 * chi_squared, 0.5 * degrees_of_freedom);
    // so far above the mean shape, whose sd is its root, that nothing is left in a number
    let is_beyond = half > shape + 40.0 * (shape.sqrt() + 20.0);
    match half {
        0.0 => Some(1.0),
        _ if is_beyond => Some(0.0),
        _ => checked_gamma_ur(shape, half).ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_of_an_even_number_lies_between_two() {
        assert_eq!(median(&mut [3.0, 1.0, 10.0, 2.0]), Some(2.5));
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut []), None);
    }

    /// scipy.stats.t.ppf and scipy.stats.f.sf (SciPy 1.18.1)
    #[test]
    fn quantiles_and_tails_agree_with_scipy() {
        for (p, df, expected) in [
            (0.975, 3.0, 3.182_446_305_283_708),
            (0.975, 38.0, 2.024_394_163_911_969_4),
            (0.95, 999.0, 1.646_380_345_427_535),
            (0.975, 1001.0, 1.962_336_705_280_879_8),
            (0.975, 1e6, 1.959_966_356_814_107),
            (0.995, 1e7, 2.575_829_795_203_748_8),
        ] {
            let t = student_t_quantile(p, df).unwrap_or(f64::NAN);
            assert!((t / expected - 1.0).abs() < 1e-10, "{p} {df}: {t} {expected}");
        }
        for (f, a, b, expected) in [
            (3.2, 2.0, 57.0, 0.048_182_522_961_140_2),
            (0.4, 5.0, 11.0, 0.838_962_225_639_702_9),
        ] {
            let p = f_tail(f, a, b).unwrap_or(f64::NAN);
            assert!((p / expected - 1.0).abs() < 1e-9, "{p} {expected}");
        }
    }

    #[test]
    fn quantiles_of_students_t_have_their_probability_beyond_them() {
        for n in [5.0, 5.5, 7.0, 12.0, 38.0, 210.0, 1000.0] {
            let of = StudentsT::new(0.0, 1.0, n).expect("valid");
            for p in [1e-12, 1e-5, 0.001, 0.025, 0.2, 0.45, 0.7, 0.975, 0.9995] {
                let t = student_t_quantile(p, n).expect("inside");
                let tail: f64 = p.min(1.0 - p);
                let off = of.cdf(-t.abs()) / tail - 1.0;
                assert!(off.abs() < 1e-12 && (t > 0.0) == (p > 0.5), "{n} {p}: {t} {off:e}");
            }
        }
    }

    #[test]
    fn tails_of_chi_squared_are_sums_of_poisson_and_of_the_normal() {
        // of an even number of degrees of freedom: that of fewer than half of them at a mean of χ²/2
        for (chi_squared, terms) in [(1.3, 2), (30.0, 6), (150.0, 50), (520.0, 200), (90.0, 100)] {
            let mean: f64 = 0.5 * chi_squared;
            let sum = (0..terms).rev().fold(0.0, |sum, i| 1.0 + sum * mean / f64::from(i + 1));
            let expected = (-mean).exp() * sum;
            let tail = chi_squared_tail(chi_squared, 2.0 * f64::from(terms)).expect("inside");
            assert!(
                (tail / expected - 1.0).abs() < 1e-10,
                "{chi_squared} {terms}: {tail} {expected}"
            );
        }
        for x in [0.1, 4.0, 60.0] {
            let tail = chi_squared_tail(x, 1.0).expect("inside");
            assert!((tail / libm::erfc((0.5 * x).sqrt()) - 1.0).abs() < 1e-10, "{x}: {tail}");
        }
        assert_eq!(chi_squared_tail(0.0, 3.0), Some(1.0));
        assert_eq!(chi_squared_tail(f64::INFINITY, 3.0), Some(0.0));
        assert_eq!(chi_squared_tail(1e300, 1e6), Some(0.0));
        assert_eq!(chi_squared_tail(f64::NAN, 3.0), None);
        assert_eq!(chi_squared_tail(1.0, 0.0), None);
    }

    #[test]
    fn outside_the_domain_there_is_no_quantile() {
        assert_eq!(student_t_quantile(1.0, 5.0), None);
        assert_eq!(student_t_quantile(0.5, 0.0), None);
        assert_eq!(student_t_quantile(0.5, 1e-300), None);
        assert_eq!(student_t_quantile(f64::NAN, 5.0), None);
        assert_eq!(f_tail(f64::NAN, 2.0, 3.0), None);
        assert_eq!(f_tail(1.0, 0.0, 3.0), None);
        assert_eq!(f_tail(f64::INFINITY, 2.0, 3.0), Some(0.0));
        assert_eq!(f_tail(1e308, 20.0, 3.0), Some(0.0));
        assert!(normal_quantile(f64::NAN).is_nan() && normal_quantile(1.1).is_nan());
        assert!(beta_quantile(0.5, (f64::NAN, 1.0)).is_nan() && beta_quantile(0.5, (1.0, f64::INFINITY)).is_nan());
        for shape in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(gamma_quantile(0.5, shape), None);
        }
        assert_eq!(gamma_quantile(0.0, 2.0), None);
    }

    #[test]
    fn quantiles_of_gamma_of_large_shapes_agree_with_the_library() {
        for shape in [3000.0, 1e4, 1.1e4, 1e5] {
            let library = statrs::distribution::Gamma::new(shape, 1.0).expect("valid");
            for p in [0.001, 0.02, 0.5, 0.7, 0.975, 0.999] {
                let own = gamma_quantile(p, shape).expect("inside");
                let expected = library.inverse_cdf(p);
                assert!((own / expected - 1.0).abs() < 1e-10, "{shape} {p}: {own} {expected}");
            }
        }
    }

    /// What lies below a quantile is its probability, whatever the shape; the library's own quantile is off below 0.05.
    #[test]
    fn quantiles_of_gamma_have_their_probability_below_them() {
        for shape in [1e-3, 0.01, 0.2, 1.0, 40.0, 999.0, 9999.0] {
            for p in [1e-9, 0.001, 0.5, 0.999, 1.0 - 1e-9] {
                let Some(x) = gamma_quantile(p, shape) else {
                    assert!(shape < 0.03 && p < 0.5, "{shape} {p}");
                    continue;
                };
                let [below, above] =
                    [checked_gamma_lr(shape, x), checked_gamma_ur(shape, x)].map(|p| p.expect("inside"));
                let off = if p < 0.9 { below / p } else { above / (1.0 - p) };
                assert!((off - 1.0).abs() < 1e-9, "{shape} {p}: {x} {off}");
            }
        }
    }

    /// Every quantile is had at once: 500 numbers a side, within a second and without a panic.
    #[test]
    fn no_number_holds_a_quantile_up() {
        let began = std::time::Instant::now();
        let sizes = || (-323..=308).step_by(3).map(|e| 10f64.powi(e) * 1.7);
        for size in sizes() {
            for p in [1e-300, 1e-9, 0.001, 0.5, 0.7, 0.999, 1.0 - 1e-15] {
                let x = gamma_quantile(p, size);
                assert!(x.is_none_or(f64::is_normal), "{size} {p} {x:?}");
                assert!(x.is_some() || !(1.0..=1e300).contains(&size), "{size} {p}");
                let t = student_t_quantile(p, size);
                assert!(t.is_some() == (size >= FEW && p >= FAR), "{size} {p}");
                let tail = f_tail(size, 3.0, 57.0).expect("inside");
                assert!((0.0..=1.0).contains(&tail), "{size} {tail}");
            }
            let (peak, slope) = (student_t_peak(size), student_t_peak_slope(size));
            assert!(
                size < 1e-290 || peak.is_finite() && slope.is_finite(),
                "{size} {peak} {slope}"
            );
        }
        assert!(began.elapsed().as_secs_f64() < 5.0, "{:?}", began.elapsed());
    }

    /// SciPy 1.18.1 has no peak of that many degrees of freedom: the expansion meets the difference of logarithms.
    #[test]
    fn the_peak_of_students_t_does_not_jump_where_it_is_expanded() {
        let [below, above] = [MANY, MANY * (1.0 + 1e-12)].map(|nu| (student_t_peak(nu), student_t_peak_slope(nu)));
        assert!((below.0 - above.0).abs() < 1e-11, "{below:?} {above:?}");
        assert!((below.1 / above.1 - 1.0).abs() < 1e-5, "{below:?} {above:?}");
        for nu in [1e4, 1e9, 1e18, 1e100] {
            let (peak, slope) = (student_t_peak(nu), student_t_peak_slope(nu));
            let h = 1e-3 * nu;
            let difference = (student_t_peak(nu + h) - student_t_peak(nu - h)) / (2.0 * h);
            assert!((peak + LN_ROOT_TWO_PI).abs() < 0.26 / nu, "{nu} {peak}");
            assert!(
                slope * nu < 1e-4 && (slope - difference).abs() * nu < 1e-10,
                "{nu} {slope} {difference}"
            );
        }
    }
}
