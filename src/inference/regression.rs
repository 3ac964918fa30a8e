//! Fits a law to runs by least squares, with its sensitivity to errors of the speed and to a known offset.
//!
//! The caller gives no starting values: they come from a straight line.

use nalgebra::DMatrix;

use super::effective_variance::{chi_squared, reweight, ErrorColumns, ErrorWeights, SpeedDependent, SpeedDerivatives};
use super::law::{Law, Response};
use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem};
use crate::scene::WetLaw;

/// A law and the runs it is fitted to, one number a run in every column.
#[derive(Debug, Clone, Copy)]
pub struct Regression<'a> {
    /// the law
    pub law: Law,
    /// abscissae
    pub x: &'a [f64],
    /// known offsets; empty for none
    pub offset: &'a [f64],
    /// restitutions
    pub restitution: &'a [f64],
}

impl<'a> Regression<'a> {
    /// A law without offset.
    pub fn new(law: Law, x: &'a [f64], restitution: &'a [f64]) -> Regression<'a> {
        Regression {
            law,
            x,
            offset: &[],
            restitution,
        }
    }

    /// Fits the law with all runs weighing the same.
    pub fn fit(&self) -> Fit {
        fit(&self.problem(vec![]), &self.start()[..self.law.parameters()])
    }

    /// Fits the law, the runs weighed by their measurement errors if there are any; x must move with the speed as the
    /// law's does.
    pub fn fit_with_errors(&self, errors: Option<&ErrorColumns>) -> (Fit, Option<ErrorWeights>) {
        match errors {
            Some(errors) => reweight(errors, self.fit(), |excluded| self.problem(excluded)),
            None => (self.fit(), None),
        }
    }

    fn problem(&self, excluded: Vec<bool>) -> RegressionProblem<'a> {
        RegressionProblem {
            regression: *self,
            excluded,
        }
    }

    /// Weighted squares of the law fitted with these variances of the runs, infinite for those left out, from a start.
    pub fn chi_squared(&self, variance: &[f64], start: &[f64]) -> f64 {
        let problem = self.problem(variance.iter().map(|variance| variance.is_infinite()).collect());
        chi_squared(&problem, variance, start)
    }

    /// Restitution that the law gives each run; 0 where it is undefined.
    pub fn fitted(&self, parameters: [f64; 2]) -> Vec<f64> {
        let runs = 0..self.x.len();
        runs.map(|run| self.law.restitution(parameters, self.x[run], self.offset_of(run)))
            .collect()
    }

    /// The law at a run, with its slopes and bends.
    pub fn response(&self, parameters: [f64; 2], run: usize) -> Response {
        self.law.response(self.predictor(parameters, run))
    }

    fn predictor(&self, parameters: [f64; 2], run: usize) -> f64 {
        self.law.predictor(parameters, self.x[run], self.offset_of(run))
    }

    fn offset_of(&self, run: usize) -> f64 {
        self.offset.get(run).copied().unwrap_or(0.0)
    }

    /// The error of v, as a share of it common to all runs, that would bias the second parameter of a fit by a tenth of
    /// its standard error; the bias grows with the square of that share.
    ///
    /// `offset_slopes` are v o′ and v² o″ of each run, empty for none; `variance` is that of each residual, empty where
    /// all have the fit's own. `None` where the fit has no covariance or such an error no bias.
    pub fn speed_error_that_matters(&self, fitted: &Fit, offset_slopes: &[[f64; 2]], variance: &[f64]) -> Option<f64> {
        let covariance = fitted.covariance.as_ref()?;
        let parameters = pair(&fitted.parameters);
        let mut pull = [0.0; 2];
        for (run, weight) in self.weights(fitted, variance)? {
            let predictor = self.predictor(parameters, run);
            if !self.law.is_defined(predictor) {
                return None;
            }
            let offset_slopes = offset_slopes.get(run).copied().unwrap_or_default();
            let at = self.law.in_speed(parameters, self.x[run], predictor, offset_slopes);
            for (j, pull) in pull.iter_mut().enumerate() {
                *pull += weight * at.response.second_order_bias(at.jacobian[j], at.jacobian_slope[j]);
            }
        }
        let bias = covariance[(1, 0)] * pull[0] + covariance[(1, 1)] * pull[1];
        let share = (0.1 * fitted.se(1)? / bias.abs()).sqrt();
        share.is_finite().then_some(share)
    }

    /// Slopes of both fitted parameters in a number that shifts every run's offset.
    ///
    /// `offset_slope` is d(offset)/d(that number) for each run. First order: −(JᵀWJ)⁻¹ JᵀW ∂e, with (JᵀWJ)⁻¹ taken from
    /// the covariance; `variance` is that of each residual, empty where all have the fit's own. `None` where the fit has
    /// no covariance.
    pub fn offset_sensitivity(&self, fitted: &Fit, offset_slope: &[f64], variance: &[f64]) -> Option<[f64; 2]> {
        let covariance = fitted.covariance.as_ref()?;
        let parameters = pair(&fitted.parameters);
        let mut projected = [0.0; 2];
        for (run, weight) in self.weights(fitted, variance)? {
            let predictor = self.predictor(parameters, run);
            if !self.law.is_defined(predictor) {
                return None;
            }
            let slope = self.law.response(predictor).slope;
            for (projected, c) in projected.iter_mut().zip(self.law.design(self.x[run])) {
                *projected += weight * slope * slope * c * offset_slope[run];
            }
        }
        Some([0, 1].map(|j| -(covariance[(j, 0)] * projected[0] + covariance[(j, 1)] * projected[1])))
    }

    /// The runs that are not left out, each with the inverse of its residual's variance.
    fn weights<'f>(&self, fitted: &Fit, variance: &'f [f64]) -> Option<impl Iterator<Item = (usize, f64)> + use<'f>> {
        let common = fitted.residual_sd? * fitted.residual_sd?;
        let of_run = move |run: usize| 1.0 / variance.get(run).copied().unwrap_or(common);
        let runs = (0..self.x.len()).map(move |run| (run, of_run(run)));
        Some(runs.filter(|(_, weight)| *weight != 0.0))
    }

    /// Parameters near the minimum, inside the domain of the law at every run.
    fn start(&self) -> [f64; 2] {
        match self.law {
            Law::Dry(_) => {
                let squares: f64 = self.x.iter().map(|x| x * x).sum();
                let products: f64 = self.x.iter().zip(self.restitution).map(|(x, e)| x * (1.0 - e)).sum();
                [if squares > 0.0 { products / squares } else { 0.0 }, 0.0]
            }
            Law::Wet(WetLaw::Linear) => {
                let (intercept, slope) = line(self.x, self.restitution.iter().copied());
                [intercept, -slope]
            }
            Law::Wet(WetLaw::Sqrt) => self.start_of_square_root(),
        }
    }

    /// The line through e², flattened about its mean until no run lies below a margin.
    fn start_of_square_root(&self) -> [f64; 2] {
        let runs = self.restitution.iter().enumerate();
        let squares = || runs.clone().map(|(run, e)| e * e - self.offset_of(run));
        let (alpha, beta) = line(self.x, squares());
        let n = self.x.len().max(1) as f64;
        let mean_square = self.restitution.iter().map(|e| e * e).sum::<f64>() / n;
        let mean_x = self.x.iter().sum::<f64>() / n;
        let level = squares().sum::<f64>() / n;
        let floor = START_MARGIN * mean_square;
        let mut flatten: f64 = 1.0;
        for (run, x) in self.x.iter().enumerate() {
            let offset = self.offset_of(run);
            let kept = self.law.predictor([alpha, beta], *x, offset);
            let flat = level + offset;
            if kept < floor && flat > floor {
                flatten = flatten.min((flat - floor) / (flat - kept));
            }
        }
        let beta = beta * flatten;
        [level - beta * mean_x, beta]
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

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

/// One or two parameters as two numbers.
fn pair(parameters: &[f64]) -> [f64; 2] {
    [0, 1].map(|j| parameters.get(j).copied().unwrap_or(0.0))
}

/// A regression as a least-squares problem, in which the domain of some runs may not be held.
struct RegressionProblem<'a> {
    regression: Regression<'a>,
    /// runs without weight, which may lie outside the domain; empty for none
    excluded: Vec<bool>,
}

/// Linear predictor that stands for that of an excluded run outside its domain.
const EXCLUDED: f64 = 1e-12;

impl RegressionProblem<'_> {
    /// The linear predictor of a run at its abscissa.
    fn predictor(&self, law: Law, parameters: [f64; 2], run: usize, x: f64) -> Result<f64, OutOfDomain> {
        let predictor = law.predictor(parameters, x, self.regression.offset_of(run));
        if law.is_defined(predictor) {
            Ok(predictor)
        } else if self.excluded.get(run) == Some(&true) {
            Ok(EXCLUDED)
        } else {
            Err(OutOfDomain)
        }
    }

    #[inline(always)]
    fn write_residuals(&self, law: Law, b: [f64; 2], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        let runs = self.regression.x.iter().zip(self.regression.restitution).enumerate();
        for (residual, (run, (x, e))) in residuals.iter_mut().zip(runs) {
            *residual = law.response(self.predictor(law, b, run, *x)?).value - e;
        }
        Ok(())
    }

    #[inline(always)]
    fn write_jacobian(&self, law: Law, b: [f64; 2], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let (first, second) = jacobian.as_mut_slice().split_at_mut(self.runs());
        let slope = |run: usize, x: f64| Ok(law.response(self.predictor(law, b, run, x)?).slope);
        let runs = self.regression.x.iter().enumerate();
        if law.parameters() == 1 {
            for (first, (run, x)) in first.iter_mut().zip(runs) {
                *first = slope(run, *x)? * law.design(*x)[0];
            }
        } else {
            for ((first, second), (run, x)) in first.iter_mut().zip(second).zip(runs) {
                let slope = slope(run, *x)?;
                [*first, *second] = law.design(*x).map(|c| slope * c);
            }
        }
        Ok(())
    }
}

impl ResidualProblem for RegressionProblem<'_> {
    fn parameters(&self) -> usize {
        self.regression.law.parameters()
    }
    fn runs(&self) -> usize {
        self.regression.restitution.len()
    }
    // the square root, fitted most often, has loops compiled for it alone: they take a tenth less time
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        match self.regression.law {
            Law::SQUARE_ROOT => self.write_residuals(Law::SQUARE_ROOT, pair(b), residuals),
            law => self.write_residuals(law, pair(b), residuals),
        }
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        match self.regression.law {
            Law::SQUARE_ROOT => self.write_jacobian(Law::SQUARE_ROOT, pair(b), jacobian),
            law => self.write_jacobian(law, pair(b), jacobian),
        }
    }
}

impl SpeedDependent for RegressionProblem<'_> {
    fn speed_derivatives(&self, b: &[f64], errors: &ErrorColumns) -> Result<SpeedDerivatives, OutOfDomain> {
        let (law, parameters) = (self.regression.law, pair(b));
        let (runs, number) = (self.runs(), self.parameters());
        let mut all = SpeedDerivatives {
            response: Vec::with_capacity(runs),
            jacobian: DMatrix::zeros(runs, number),
            jacobian_slope: DMatrix::zeros(runs, number),
        };
        for (run, x) in self.regression.x.iter().enumerate() {
            let predictor = self.predictor(law, parameters, run, *x)?;
            let offset_slopes = errors.offset_slopes.get(run).copied().unwrap_or_default();
            let at = law.in_speed(parameters, *x, predictor, offset_slopes);
            all.response.push(at.response);
            for j in 0..number {
                all.jacobian[(run, j)] = at.jacobian[j];
                all.jacobian_slope[(run, j)] = at.jacobian_slope[j];
            }
        }
        Ok(all)
    }
}
