//! Puts the dry, linear and square-root laws as least-squares problems that bring their Jacobians, and fits them.
//!
//! x is 1/St (or 1/v), e a restitution. No starting values are asked for: a straight line gives them.

use nalgebra::DMatrix;

use super::effective_variance::{chi_squared, weigh, Erring, InSpeed, OfSpeed, Weighing};
use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem};
use crate::physics::dry::{Order, SECOND_ORDER};

/// e = 1 − k v^(1/5), linear in k, or the same to second order.
#[derive(Clone, Copy)]
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

impl OfSpeed for DryLaw<'_> {
    fn in_speed(&self, b: &[f64], erring: &Erring) -> Result<InSpeed, OutOfDomain> {
        let mut all = InSpeed::zeros(self.runs(), 1);
        let second = match self.order {
            Order::First => 0.0,
            Order::Second => SECOND_ORDER,
        };
        for (run, (root, v)) in self.speed_root.iter().zip(erring.speed).enumerate() {
            // root is v^(1/5)
            let (first, bend) = (0.2 * root / v, -0.16 * root / (v * v));
            let (loss, falls) = (b[0] * root, 2.0 * second * b[0] * root - 1.0);
            all.value[run] = 1.0 - loss + second * loss * loss;
            all.slope[run] = falls * b[0] * first;
            all.bend[run] = falls * b[0] * bend + 2.0 * second * (b[0] * first).powi(2);
            all.jacobian[(run, 0)] = falls * root;
            all.jacobian_slope[(run, 0)] = (2.0 * falls + 1.0) * first;
        }
        Ok(all)
    }
}

/// Fits k of e = 1 − k v^(1/5), or of the same to second order; speeds in m/s.
pub fn fit_dry(impact_speed: &[f64], restitution: &[f64], order: Order) -> Fit {
    fit_dry_weighed(impact_speed, restitution, order, None).0
}

/// The same, with the runs weighed where they err.
pub fn fit_dry_weighed(
    impact_speed: &[f64],
    restitution: &[f64],
    order: Order,
    erring: Option<&Erring>,
) -> (Fit, Option<Weighing>) {
    let speed_root: Vec<f64> = impact_speed.iter().map(|v| v.powf(0.2)).collect();
    let squares: f64 = speed_root.iter().map(|s| s * s).sum();
    let products: f64 = speed_root.iter().zip(restitution).map(|(s, e)| s * (1.0 - e)).sum();
    let start = if squares > 0.0 { products / squares } else { 0.0 };
    let problem = DryLaw {
        order,
        speed_root: &speed_root,
        restitution,
    };
    let plain = fit(&problem, &[start]);
    weighed(plain, erring, |_| problem)
}

fn weighed<P: OfSpeed>(
    plain: Fit,
    erring: Option<&Erring>,
    leaving_out: impl Fn(Vec<bool>) -> P,
) -> (Fit, Option<Weighing>) {
    match erring {
        Some(erring) => weigh(erring, plain, leaving_out),
        None => (plain, None),
    }
}

/// Weighted squares of the dry law fitted with these variances of the runs, from a start.
pub fn dry_squares(impact_speed: &[f64], restitution: &[f64], order: Order, variance: &[f64], start: &[f64]) -> f64 {
    let speed_root: Vec<f64> = impact_speed.iter().map(|v| v.powf(0.2)).collect();
    let problem = DryLaw {
        order,
        speed_root: &speed_root,
        restitution,
    };
    chi_squared(&problem, variance, start)
}

/// e = a − b x; a is e_inf, b/a is St_c.
#[derive(Clone, Copy)]
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

impl OfSpeed for LinearLaw<'_> {
    fn in_speed(&self, b: &[f64], erring: &Erring) -> Result<InSpeed, OutOfDomain> {
        let mut all = InSpeed::zeros(self.runs(), 2);
        for (run, (x, v)) in self.x.iter().zip(erring.speed).enumerate() {
            all.value[run] = b[0] - b[1] * x;
            all.slope[run] = b[1] * x / v;
            all.bend[run] = -2.0 * b[1] * x / (v * v);
            all.jacobian[(run, 0)] = 1.0;
            all.jacobian[(run, 1)] = -x;
            all.jacobian_slope[(run, 1)] = x / v;
        }
        Ok(all)
    }
}

/// Fits a and b of e = a − b x.
pub fn fit_linear(x: &[f64], restitution: &[f64]) -> Fit {
    fit_linear_weighed(x, restitution, None).0
}

/// The same, with the runs weighed where they err; x falls with the inverse of v.
pub fn fit_linear_weighed(x: &[f64], restitution: &[f64], erring: Option<&Erring>) -> (Fit, Option<Weighing>) {
    let (intercept, slope) = line(x, restitution.iter().copied());
    let problem = LinearLaw { x, restitution };
    let plain = fit(&problem, &[intercept, -slope]);
    weighed(plain, erring, |_| problem)
}

/// Weighted squares of the linear law fitted with these variances of the runs, from a start.
pub fn linear_squares(x: &[f64], restitution: &[f64], variance: &[f64], start: &[f64]) -> f64 {
    chi_squared(&LinearLaw { x, restitution }, variance, start)
}

/// e = √(α + β x + o), with a known offset o for each run (empty: none).
struct SquareRootLaw<'a> {
    x: &'a [f64],
    offset: &'a [f64],
    restitution: &'a [f64],
    /// runs whose domain is not held, since they are left out; empty for none
    without: Vec<bool>,
}

/// Energy kept that stands for that of a run outside its domain.
const OUTSIDE: f64 = 1e-12;

impl SquareRootLaw<'_> {
    fn kept(&self, b: &[f64], run: usize) -> Result<f64, OutOfDomain> {
        let offset = self.offset.get(run).copied().unwrap_or(0.0);
        let kept = b[0] + b[1] * self.x[run] + offset;
        // written so that a NaN is outside, too
        if kept > 0.0 {
            Ok(kept)
        } else if self.without.get(run) == Some(&true) {
            Ok(OUTSIDE)
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

/// A square-root law at one run, with its derivatives in ln v.
struct AtRun {
    /// m
    value: f64,
    /// v m′
    slope: f64,
    /// v² m″
    bend: f64,
    /// J
    jacobian: [f64; 2],
    /// v J′
    jacobian_slope: [f64; 2],
}

impl SquareRootLaw<'_> {
    /// The law at a run whose offset has the derivatives v o′ and v² o″; x falls with 1/v.
    fn at_run(&self, b: &[f64], run: usize, [offset_slope, offset_bend]: [f64; 2]) -> Result<AtRun, OutOfDomain> {
        let value = self.kept(b, run)?.sqrt();
        let (x, half) = (self.x[run], 0.5 / value);
        let slope = half * (offset_slope - b[1] * x);
        Ok(AtRun {
            value,
            slope,
            bend: half * (offset_bend + 2.0 * b[1] * x) - slope * slope / value,
            jacobian: [half, half * x],
            jacobian_slope: [-half * slope / value, -half * x * (slope / value + 1.0)],
        })
    }
}

impl OfSpeed for SquareRootLaw<'_> {
    fn in_speed(&self, b: &[f64], erring: &Erring) -> Result<InSpeed, OutOfDomain> {
        let mut all = InSpeed::zeros(self.x.len(), 2);
        for (run, v) in erring.speed.iter().enumerate() {
            let [first, second] = erring.offset_slopes.get(run).copied().unwrap_or_default();
            let at = self.at_run(b, run, [first * v, second * v * v])?;
            all.value[run] = at.value;
            all.slope[run] = at.slope / v;
            all.bend[run] = at.bend / (v * v);
            for j in 0..2 {
                all.jacobian[(run, j)] = at.jacobian[j];
                all.jacobian_slope[(run, j)] = at.jacobian_slope[j] / v;
            }
        }
        Ok(all)
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

/// Fits α and β of e = √(α + β x + o) to runs that rebounded; `offset` is empty or one number a run.
pub fn fit_square_root(x: &[f64], offset: &[f64], restitution: &[f64]) -> Fit {
    fit_square_root_weighed(x, offset, restitution, None).0
}

/// The same, with the runs weighed where they err; x falls with the inverse of v.
pub fn fit_square_root_weighed(
    x: &[f64],
    offset: &[f64],
    restitution: &[f64],
    erring: Option<&Erring>,
) -> (Fit, Option<Weighing>) {
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
    let law = |without: Vec<bool>| SquareRootLaw {
        x,
        offset,
        restitution,
        without,
    };
    let plain = fit(&law(vec![]), &[alpha, beta]);
    weighed(plain, erring, law)
}

/// The error of v, as a share of it common to all runs, that would bias β of a fitted square-root law by a tenth of its
/// standard error; the bias grows with the square of that share.
///
/// `offset_slopes` are v o′ and v² o″ of each run, `variance` is that of its residual, empty where all have the fit's own.
/// `None` where the fit has no covariance or such an error no bias.
pub fn speed_error_that_matters(
    fitted: &Fit,
    [x, offset]: [&[f64]; 2],
    offset_slopes: &[[f64; 2]],
    variance: &[f64],
) -> Option<f64> {
    let problem = SquareRootLaw {
        x,
        offset,
        restitution: &[],
        without: vec![],
    };
    let covariance = fitted.covariance.as_ref()?;
    let of_all = fitted.residual_sd? * fitted.residual_sd?;
    let mut pull = [0.0; 2];
    for run in 0..x.len() {
        let offset = offset_slopes.get(run).copied().unwrap_or_default();
        let weight = 1.0 / variance.get(run).copied().unwrap_or(of_all);
        if weight == 0.0 {
            continue;
        }
        let at = problem.at_run(&fitted.parameters, run, offset).ok()?;
        for (j, pull) in pull.iter_mut().enumerate() {
            let mean = at.jacobian[j] * (at.value - 0.5 * at.bend);
            *pull += weight * (mean - at.jacobian_slope[j] * (at.value + at.slope));
        }
    }
    let bias = covariance[(1, 0)] * pull[0] + covariance[(1, 1)] * pull[1];
    let share = (0.1 * fitted.se(1)? / bias.abs()).sqrt();
    share.is_finite().then_some(share)
}

/// Weighted squares of the square-root law fitted with these variances of the runs, from a start.
pub fn square_root_squares(x: &[f64], offset: &[f64], restitution: &[f64], variance: &[f64], start: &[f64]) -> f64 {
    let law = SquareRootLaw {
        x,
        offset,
        restitution,
        without: variance.iter().map(|variance| variance.is_infinite()).collect(),
    };
    chi_squared(&law, variance, start)
}

/// How the fitted α and β move when a number that shifts every run's offset moves.
///
/// `offset_slope` is d(offset)/d(that number) for each run. First order: −(JᵀJ)⁻¹ Jᵀ ∂f, with (JᵀJ)⁻¹ taken from the
/// covariance; `weighed` has the variance of each run's residual where they differ. `None` where the fit has no covariance.
pub fn square_root_shift(
    fitted: &Fit,
    x: &[f64],
    offset: &[f64],
    offset_slope: &[f64],
    weighed: Option<&[f64]>,
) -> Option<[f64; 2]> {
    let covariance = fitted.covariance.as_ref()?;
    let variance = fitted.residual_sd? * fitted.residual_sd?;
    let problem = SquareRootLaw {
        x,
        offset,
        restitution: &[],
        without: vec![],
    };
    let mut projected = [0.0; 2];
    for (run, (x, slope)) in x.iter().zip(offset_slope).enumerate() {
        let weight = weighed.map_or(1.0, |each| variance / each[run]);
        if weight == 0.0 {
            continue;
        }
        let half = 0.5 / problem.kept(&fitted.parameters, run).ok()?.sqrt();
        projected[0] += weight * half * half * slope;
        projected[1] += weight * half * half * x * slope;
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

#[cfg(test)]
mod tests;
