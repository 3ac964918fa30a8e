//! Puts the dry, linear and square-root laws as least-squares problems that bring their Jacobians, and fits them.
//!
//! x is 1/St (or 1/v), e a restitution. No starting values are asked for: a straight line gives them.

use nalgebra::DMatrix;

use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem};
use crate::physics::dry::{Order, SECOND_ORDER};

/// e = 1 − k v^(1/5), linear in k, or the same to second order.
struct DryLaw<'a> {
    order: Order,
    speed_root: &'a [f64],
    restitution: &'a [f64],
}

impl ResidualProblem for DryLaw<'_> {
    fn parameters(&self) -> usize {
        1
    }
    fn runs(&self) -> usize {
        self.restitution.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        for ((residual, root), e) in residuals.iter_mut().zip(self.speed_root).zip(self.restitution) {
            *residual = 1.0 - b[0] * root - e;
            if self.order == Order::Second {
                let loss = b[0] * root;
                *residual += SECOND_ORDER * loss * loss;
            }
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        for (slope, root) in jacobian.iter_mut().zip(self.speed_root) {
            *slope = match self.order {
                Order::First => -root,
                Order::Second => -root * (1.0 - 2.0 * SECOND_ORDER * b[0] * root),
            };
        }
        Ok(())
    }
}

/// Fits k of e = 1 − k v^(1/5), or of the same to second order; speeds in m/s.
pub fn fit_dry(impact_speed: &[f64], restitution: &[f64], order: Order) -> Fit {
    let speed_root: Vec<f64> = impact_speed.iter().map(|v| v.powf(0.2)).collect();
    let squares: f64 = speed_root.iter().map(|s| s * s).sum();
    let products: f64 = speed_root.iter().zip(restitution).map(|(s, e)| s * (1.0 - e)).sum();
    let start = if squares > 0.0 { products / squares } else { 0.0 };
    let problem = DryLaw {
        order,
        speed_root: &speed_root,
        restitution,
    };
    fit(&problem, &[start])
}

/// e = a − b x; a is e_inf, b/a is St_c.
struct LinearLaw<'a> {
    x: &'a [f64],
    restitution: &'a [f64],
}

impl ResidualProblem for LinearLaw<'_> {
    fn parameters(&self) -> usize {
        2
    }
    fn runs(&self) -> usize {
        self.restitution.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        for ((residual, x), e) in residuals.iter_mut().zip(self.x).zip(self.restitution) {
            *residual = b[0] - b[1] * x - e;
        }
        Ok(())
    }
    fn jacobian(&self, _: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let (ones, slopes) = jacobian.as_mut_slice().split_at_mut(self.x.len());
        ones.fill(1.0);
        for (slope, x) in slopes.iter_mut().zip(self.x) {
            *slope = -x;
        }
        Ok(())
    }
}

/// Fits a and b of e = a − b x.
pub fn fit_linear(x: &[f64], restitution: &[f64]) -> Fit {
    let (intercept, slope) = line(x, restitution.iter().copied());
    fit(&LinearLaw { x, restitution }, &[intercept, -slope])
}

/// e = √(α + β x + o), with a known offset o for each run (empty: none).
struct SquareRootLaw<'a> {
    x: &'a [f64],
    offset: &'a [f64],
    restitution: &'a [f64],
}

impl SquareRootLaw<'_> {
    fn kept(&self, b: &[f64], run: usize) -> Result<f64, OutOfDomain> {
        let offset = self.offset.get(run).copied().unwrap_or(0.0);
        let kept = b[0] + b[1] * self.x[run] + offset;
        // written so that a NaN is outside, too
        if kept > 0.0 {
            Ok(kept)
        } else {
            Err(OutOfDomain)
        }
    }
}

impl ResidualProblem for SquareRootLaw<'_> {
    fn parameters(&self) -> usize {
        2
    }
    fn runs(&self) -> usize {
        self.restitution.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        for (run, (residual, e)) in residuals.iter_mut().zip(self.restitution).enumerate() {
            *residual = self.kept(b, run)?.sqrt() - e;
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let (alpha, beta) = jacobian.as_mut_slice().split_at_mut(self.x.len());
        for (run, (in_alpha, in_beta)) in alpha.iter_mut().zip(beta).enumerate() {
            *in_alpha = 0.5 / self.kept(b, run)?.sqrt();
            *in_beta = *in_alpha * self.x[run];
        }
        Ok(())
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

/// Fits α and β of e = √(α + β x + o) to runs that rebounded; `offset` is empty or one number a run.
pub fn fit_square_root(x: &[f64], offset: &[f64], restitution: &[f64]) -> Fit {
    let offset_of = |run: usize| offset.get(run).copied().unwrap_or(0.0);
    let squares = || restitution.iter().enumerate().map(|(run, e)| e * e - offset_of(run));
    let (mut alpha, mut beta) = line(x, squares());
    // the line through e² may dip below zero at the slowest runs: flatten it about its mean until it does not
    let n = x.len().max(1) as f64;
    let mean_square = restitution.iter().map(|e| e * e).sum::<f64>() / n;
    let mean_x = x.iter().sum::<f64>() / n;
    let level = squares().sum::<f64>() / n;
    let floor = START_MARGIN * mean_square;
    let mut flatten: f64 = 1.0;
    for (run, x) in x.iter().enumerate() {
        let kept = alpha + beta * x + offset_of(run);
        let flat = level + offset_of(run);
        if kept < floor && flat > floor {
            flatten = flatten.min((flat - floor) / (flat - kept));
        }
    }
    beta *= flatten;
    alpha = level - beta * mean_x;
    fit(&SquareRootLaw { x, offset, restitution }, &[alpha, beta])
}

/// How the fitted α and β move when a number that shifts every run's offset moves.
///
/// `offset_slope` is d(offset)/d(that number) for each run. First order: −(JᵀJ)⁻¹ Jᵀ ∂f, with (JᵀJ)⁻¹ taken from the
/// covariance. `None` where the fit has no covariance.
pub fn square_root_shift(fitted: &Fit, x: &[f64], offset: &[f64], offset_slope: &[f64]) -> Option<[f64; 2]> {
    let covariance = fitted.covariance.as_ref()?;
    let variance = fitted.residual_sd? * fitted.residual_sd?;
    let problem = SquareRootLaw {
        x,
        offset,
        restitution: &[],
    };
    let mut projected = [0.0; 2];
    for (run, (x, slope)) in x.iter().zip(offset_slope).enumerate() {
        let half = 0.5 / problem.kept(&fitted.parameters, run).ok()?.sqrt();
        projected[0] += half * half * slope;
        projected[1] += half * half * x * slope;
    }
    let row = |j: usize| -(covariance[(j, 0)] * projected[0] + covariance[(j, 1)] * projected[1]) / variance;
    Some([row(0), row(1)])
}

/// Intercept and slope of the least-squares line; slope 0 where x does not vary.
fn line(x: &[f64], y: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = x.len().max(1) as f64;
    let mean_x = x.iter().sum::<f64>() / n;
    let mean_y = y.clone().sum::<f64>() / n;
    let (mut products, mut squares) = (0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        products += (x - mean_x) * (y - mean_y);
        squares += (x - mean_x) * (x - mean_x);
    }
    let slope = if squares > 0.0 { products / squares } else { 0.0 };
    (mean_y - slope * mean_x, slope)
}
