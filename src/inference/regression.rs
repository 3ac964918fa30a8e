//! Fits a law to runs by least squares, with its sensitivity to errors of the speed and to a known offset.
//!
//! The caller gives no starting values: they come from a straight line, and for the square root from Newton's method.

use nalgebra::DMatrix;

use super::effective_variance::{
    chi_squared, reweight, ErrorColumns, ErrorWeights, SpeedDependent, SpeedDerivatives, WeightedProblem,
};
use super::kernel::{self, Sample};
use super::law::{Law, Response};
use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem};
use crate::lanes::sums;
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
    /// how many runs each stands for; empty where that is itself
    pub counts: &'a [f64],
}

impl<'a> Regression<'a> {
    /// A law without offset.
    pub fn new(law: Law, x: &'a [f64], restitution: &'a [f64]) -> Regression<'a> {
        Regression {
            law,
            x,
            offset: &[],
            restitution,
            counts: &[],
        }
    }

    /// Fits the law with all runs weighing the same.
    pub fn fit(&self) -> Fit {
        let problem = self.problem(vec![]);
        let start = &self.start()[..self.law.parameters()];
        if self.counts.is_empty() {
            return fit(&problem, start);
        }
        let roots: Vec<f64> = self.counts.iter().map(|count| count.sqrt()).collect();
        let weighted = WeightedProblem {
            problem: &problem,
            roots: &roots,
        };
        fit(&weighted, start).of_runs(self.counts.iter().sum())
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
    fn weights<'f>(
        &'f self,
        fitted: &Fit,
        variance: &'f [f64],
    ) -> Option<impl Iterator<Item = (usize, f64)> + use<'a, 'f>> {
        let (common, counts) = (fitted.residual_sd? * fitted.residual_sd?, self.counts);
        let of_run = move |run: usize| 1.0 / variance.get(run).copied().unwrap_or(common);
        let runs = (0..self.x.len()).map(move |run| (run, of_run(run) * counts.get(run).copied().unwrap_or(1.0)));
        Some(runs.filter(|(_, weight)| *weight != 0.0))
    }

    /// Parameters near the minimum, inside the domain of the law at every run: of the square root those that Newton's method
    /// finds, which takes hundreds of steps fewer than a fit along the edge of the domain does.
    fn start(&self) -> [f64; 2] {
        let ones = vec![1.0; if self.counts.is_empty() { self.x.len() } else { 0 }];
        let weights = if ones.is_empty() { self.counts } else { &ones };
        let sample = Sample {
            offset: self.offset,
            ..Sample::new(self.x, self.restitution, weights)
        };
        match self.law {
            Law::Dry(_) => kernel::dry(&sample).unwrap_or_default(),
            Law::Wet(WetLaw::Linear) => {
                let [mean, centre, slope] = line(&sample);
                [mean - slope * centre, -slope]
            }
            Law::Wet(WetLaw::Sqrt) => {
                let squares: Vec<f64> = self.restitution.iter().map(|e| e * e).collect();
                let without: Vec<f64> = (0..squares.len())
                    .map(|run| squares[run] - self.offset_of(run))
                    .collect();
                let through = line(&Sample::new(self.x, &without, weights));
                let start = self.flattened(through, START_MARGIN * weighted_mean(&squares, weights));
                kernel::square_root(&sample, start).unwrap_or(start)
            }
        }
    }

    /// A line through e², flattened about its mean until it lies nowhere below a floor.
    fn flattened(&self, [mean, centre, slope]: [f64; 3], floor: f64) -> [f64; 2] {
        let mut flatten: f64 = 1.0;
        for (run, x) in self.x.iter().enumerate() {
            let offset = self.offset_of(run);
            let (kept, flat) = (mean + slope * (x - centre) + offset, mean + offset);
            if kept < floor && flat > floor {
                flatten = flatten.min((flat - floor) / (flat - kept));
            }
        }
        let slope = slope * flatten;
        [mean - slope * centre, slope]
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

/// The mean of a sample, its mean abscissa and the slope of the line through it; 0 where the abscissae do not vary.
fn line(sample: &Sample) -> [f64; 3] {
    let [mean, centre] = [sample.restitution, sample.x].map(|column| weighted_mean(column, sample.weights));
    let slope = kernel::linear(sample).map_or(0.0, |[_, fall]| -fall);
    [mean, centre, slope]
}

fn weighted_mean(column: &[f64], weights: &[f64]) -> f64 {
    let [sum, all] = sums([column, weights], |[x, w]| [w * x, w]);
    if all > 0.0 {
        sum / all
    } else {
        0.0
    }
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
    fn predictor(&self, parameters: [f64; 2], run: usize) -> Result<f64, OutOfDomain> {
        let predictor = self.regression.predictor(parameters, run);
        if self.regression.law.is_defined(predictor) {
            Ok(predictor)
        } else if self.excluded.get(run) == Some(&true) {
            Ok(EXCLUDED)
        } else {
            Err(OutOfDomain)
        }
    }
}

impl ResidualProblem for RegressionProblem<'_> {
    fn parameters(&self) -> usize {
        self.regression.law.parameters()
    }
    fn runs(&self) -> usize {
        self.regression.restitution.len()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        let law = self.regression.law;
        for (run, residual) in residuals.iter_mut().enumerate() {
            *residual = law.response(self.predictor(pair(b), run)?).value - self.regression.restitution[run];
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let law = self.regression.law;
        for (run, x) in self.regression.x.iter().enumerate() {
            let slope = law.response(self.predictor(pair(b), run)?).slope;
            for (entry, c) in jacobian.row_mut(run).iter_mut().zip(law.design(*x)) {
                *entry = slope * c;
            }
        }
        Ok(())
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
            let predictor = self.predictor(parameters, run)?;
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
