//! Gives derived quantities their standard errors and intervals by the delta method.

use nalgebra::DMatrix;

use crate::distributions::student_t_quantile;

/// Levels every interval is made for, besides the scene's own.
pub const LEVELS: [f64; 2] = [0.90, 0.95];

/// An interval for a quantity.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Interval {
    /// how it was made: `delta`, `delta_log` for one made on the logarithm, `profile`, or a kind of bootstrap, with
    /// `sandwich` of what that tends to
    pub method: &'static str,
    /// probability it was made for
    pub level: f64,
    /// lower end
    pub lo: f64,
    /// upper end
    pub hi: f64,
}

/// How the intervals of the delta method are named.
pub const DELTA: &str = "delta";
/// The same on the logarithm.
pub const DELTA_LOG: &str = "delta_log";

/// How an interval between the limits of a profile is named.
pub const PROFILE: &str = "profile";

impl Interval {
    /// Whether it is the delta method's.
    pub fn is_delta(&self) -> bool {
        matches!(self.method, DELTA | DELTA_LOG)
    }
}

/// Parameters with a covariance: what derived quantities are made of.
#[derive(Debug, Clone)]
pub struct Uncertain {
    /// the parameters' covariance, or why there is none
    pub covariance: Result<DMatrix<f64>, String>,
    /// degrees of freedom the spread was estimated with
    pub degrees_of_freedom: usize,
}

impl Uncertain {
    /// Standard error of a quantity with this gradient in the parameters: √(gᵀ Σ g).
    pub fn se(&self, gradient: &[f64]) -> Result<f64, String> {
        let covariance = self.covariance.as_ref().map_err(Clone::clone)?;
        let variance = bilinear(covariance, gradient, gradient);
        if variance > 0.0 && variance.is_finite() {
            Ok(variance.sqrt())
        } else {
            Err("its standard error is not a positive number".to_owned())
        }
    }

    /// Correlation of two quantities with these gradients; `None` where either has no standard error.
    pub fn correlation(&self, first: &[f64], second: &[f64]) -> Option<f64> {
        let covariance = self.covariance.as_ref().ok()?;
        let product = self.se(first).ok()? * self.se(second).ok()?;
        let correlation = bilinear(covariance, first, second) / product;
        correlation.is_finite().then(|| correlation.clamp(-1.0, 1.0))
    }
}

fn bilinear(covariance: &DMatrix<f64>, first: &[f64], second: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (i, a) in first.iter().enumerate() {
        for (j, b) in second.iter().enumerate() {
            sum += a * covariance[(i, j)] * b;
        }
    }
    sum
}

/// value ± t · se at one level; `None` without degrees of freedom.
pub fn interval(value: f64, se: f64, degrees_of_freedom: usize, level: f64) -> Option<Interval> {
    let t = student_t_quantile(0.5 + 0.5 * level, degrees_of_freedom as f64)?;
    finite(DELTA, level, [value - t * se, value + t * se])
}

/// The interval of a positive quantity, made on its logarithm: value · exp(± t · se/value).
pub fn log_interval(value: f64, se: f64, degrees_of_freedom: usize, level: f64) -> Option<Interval> {
    let plain = interval(value.ln(), se / value, degrees_of_freedom, level)?;
    finite(DELTA_LOG, level, [plain.lo.exp(), plain.hi.exp()])
}

fn finite(method: &'static str, level: f64, [lo, hi]: [f64; 2]) -> Option<Interval> {
    let made = Interval { method, level, lo, hi };
    (lo.is_finite() && hi.is_finite()).then_some(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Uncertain {
        Uncertain {
            covariance: Ok(DMatrix::from_row_slice(2, 2, &[0.04, -0.012, -0.012, 0.09])),
            degrees_of_freedom: 38,
        }
    }

    #[test]
    fn the_standard_error_of_a_ratio_is_the_textbook_one() {
        let (a, b): (f64, f64) = (2.0, 3.0);
        let gradient = [1.0 / b, -a / (b * b)];
        let expected = (0.04 / 9.0 + 0.09 * a * a / b.powi(4) - 2.0 * -0.012 * a / b.powi(3)).sqrt();
        assert!((two().se(&gradient).unwrap_or(0.0) / expected - 1.0).abs() < 1e-14);
    }

    #[test]
    fn correlation_of_a_quantity_with_itself_is_one() {
        let r = two().correlation(&[1.0, 0.0], &[0.0, 1.0]).unwrap_or(0.0);
        assert!((r - -0.012 / 0.06).abs() < 1e-14);
        assert_eq!(two().correlation(&[1.0, 2.0], &[1.0, 2.0]), Some(1.0));
    }

    #[test]
    fn an_interval_uses_t_and_needs_degrees_of_freedom() {
        let made = interval(1.0, 0.1, 38, 0.95).expect("38 degrees of freedom");
        assert!((made.hi - 1.202_439_416_391_197).abs() < 1e-10);
        assert!((made.lo + made.hi - 2.0).abs() < 1e-15);
        assert_eq!(interval(1.0, 0.1, 0, 0.95), None);
    }

    #[test]
    fn the_log_interval_stays_positive_and_is_symmetric_in_ratio() {
        let made = log_interval(2.0, 1.5, 10, 0.95).expect("10 degrees of freedom");
        assert!(made.lo > 0.0);
        assert!((made.lo * made.hi / 4.0 - 1.0).abs() < 1e-14);
    }
}
