//! Checks error bars against a second way to them, and that runs which determine nothing get none.

mod domain;

use super::*;
use nalgebra::DMatrix;

/// e = √(α + β u) against u = 1 / speed, undefined where the root's argument is not positive.
struct SqrtLaw {
    u: Vec<f64>,
    e: Vec<f64>,
    /// how often residuals were computed
    evaluations: std::cell::Cell<usize>,
}

impl SqrtLaw {
    fn new(speeds: &[f64], e: &[f64]) -> Self {
        Self {
            u: speeds.iter().map(|v| 1.0 / v).collect(),
            e: e.to_vec(),
            evaluations: 0.into(),
        }
    }

    /// Runs on the law itself, every other one `off` above it, the rest below.
    fn about(alpha: f64, beta: f64, off: f64, speeds: &[f64]) -> Self {
        let e = speeds
            .iter()
            .enumerate()
            .map(|(i, v)| (alpha + beta / v).sqrt() + if i % 2 == 0 { off } else { -off });
        Self::new(speeds, &e.collect::<Vec<_>>())
    }
}

impl ResidualProblem for SqrtLaw {
    fn parameters(&self) -> usize {
        2
    }
    fn runs(&self) -> usize {
        self.u.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        self.evaluations.set(self.evaluations.get() + 1);
        for (i, r) in residuals.iter_mut().enumerate() {
            let square = b[0] + b[1] * self.u[i];
            if square <= 0.0 {
                return Err(OutOfDomain);
            }
            *r = square.sqrt() - self.e[i];
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        for (i, u) in self.u.iter().enumerate() {
            jacobian[(i, 0)] = 0.5 / (b[0] + b[1] * u).sqrt();
            jacobian[(i, 1)] = u * jacobian[(i, 0)];
        }
        Ok(())
    }
}

/// A problem given by closures for the model's value and slopes, against observed values.
struct Curve<F, G> {
    observed: Vec<f64>,
    parameters: usize,
    value: F,
    slope: G,
    scale: f64,
}

fn curve<F, G>(observed: &[f64], parameters: usize, value: F, slope: G) -> Curve<F, G>
where
    F: Fn(&[f64], usize) -> f64,
    G: Fn(&[f64], usize, usize) -> f64,
{
    Curve {
        observed: observed.to_vec(),
        parameters,
        value,
        slope,
        scale: 0.0,
    }
}

impl<F: Fn(&[f64], usize) -> f64, G: Fn(&[f64], usize, usize) -> f64> ResidualProblem for Curve<F, G> {
    fn parameters(&self) -> usize {
        self.parameters
    }
    fn runs(&self) -> usize {
        self.observed.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        for (i, r) in residuals.iter_mut().enumerate() {
            *r = (self.value)(b, i) - self.observed[i];
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        for j in 0..self.parameters {
            for i in 0..self.observed.len() {
                jacobian[(i, j)] = (self.slope)(b, i, j);
            }
        }
        Ok(())
    }
    fn scale(&self) -> f64 {
        self.scale
    }
}

fn speeds(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.6 + 1.2 * i as f64 / (n - 1) as f64).collect()
}

/// A fit without error bars must say why, and never has a half of them.
fn assert_no_bars(fit: &Fit, stop: Stop, why: &str) {
    assert_eq!(fit.stop, stop, "{fit:?}");
    assert!(fit.se(0).is_none());
    let reason = fit.covariance.as_ref().expect_err("no bars");
    assert!(reason.contains(why), "{reason}");
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs()
}

#[test]
fn runs_without_scatter_get_no_error_bars() {
    // All restitutions equal: β is 0 exactly.
    let equal = fit(&SqrtLaw::new(&speeds(12), &[0.7; 12]), &[0.7, -0.2]);
    assert_no_bars(&equal, Stop::Converged, "no scatter");
    assert!(close(equal.parameters[0], 0.49, 1e-12) && equal.parameters[1].abs() < 1e-12);
    let exact = fit(&SqrtLaw::about(0.8, -0.3, 0.0, &speeds(12)), &[0.7, -0.2]);
    assert_no_bars(&exact, Stop::Converged, "no scatter");
    assert!(close(exact.parameters[1], -0.3, 1e-12));
    // Scatter of 1e-12 is scatter: √(12 / 10) of it, as two parameters are fitted.
    let faint = fit(&SqrtLaw::about(0.8, -0.3, 1e-12, &speeds(12)), &[0.7, -0.2]);
    assert!(close(faint.residual_sd.unwrap(), 1e-12 * (12.0_f64 / 10.0).sqrt(), 0.1));
    assert!(faint.se(0).is_some());
}

#[test]
fn a_known_part_of_the_model_counts_by_its_stated_scale() {
    // b · 0.1 + 1e9, observed at b = 0.3: the residuals are rounding errors of 1e9
    let at = |i: usize| 0.1 * (i + 1) as f64;
    let off = |b: &[f64], i: usize| (b[0] * at(i) + 1e9) - (0.3 * at(i) + 1e9);
    let offset = Curve {
        scale: 1e9,
        ..curve(&[0.0, -1e-7, 0.0, -1e-7], 1, off, |_, i, _| at(i))
    };
    let fit = fit(&offset, &[0.0]);
    assert!(fit.covariance.expect_err("no bars").contains("no scatter"));
}

#[test]
fn a_parameter_that_moves_nothing_is_degenerate_and_named() {
    let value = |b: &[f64], _: usize| b[0] + 0.0 * b[1];
    let idle = curve(&[1.0, 1.2, 0.9, 1.1], 2, value, |_, _, j| [1.0, 0.0][j]);
    let fit = fit(&idle, &[0.0, 3.0]);
    assert_no_bars(&fit, Stop::Degenerate, "parameter 2 of 2");
    assert!(close(fit.parameters[0], 1.05, 1e-9) && fit.parameters[1] == 3.0);
}
