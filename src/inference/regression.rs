//! Fits a law to runs by least squares, with its sensitivity to errors of the speed and to a known offset.
//!
//! The caller gives no starting values: they come from a flat law.

use nalgebra::DMatrix;

use super::effective_variance::{chi_squared, reweight, ErrorColumns, ErrorWeights, RunInSpeed, SpeedDependent};
use super::kernel;
pub use super::kernel::Regression;
use super::law::{Law, LawInSpeed, Response};
use super::least_squares::{fit_weighted, Fit, OutOfDomain, ResidualProblem};
use crate::physics::Order;
use crate::scene::WetLaw;

impl<'a> Regression<'a> {
    /// Fits the law with all runs weighing the same.
    pub fn fit(&self) -> Fit {
        let problem = self.problem(vec![]);
        let start = &self.start()[..self.law.parameters()];
        let roots: Vec<f64> = self.counts.iter().map(|count| count.sqrt()).collect();
        fit_weighted(&problem, &roots, start).of_runs(self.counts.iter().sum())
    }

    /// Fits the law, the runs weighed by their measurement errors if there are any; x must move with the speed as the
    /// law's does.
    pub fn fit_with_errors(&self, errors: Option<&ErrorColumns>) -> (Fit, Option<ErrorWeights>) {
        match errors {
            Some(errors) => reweight(errors, self.fit(), |excluded| self.problem(excluded)),
            None => (self.fit(), None),
        }
    }

    pub(super) fn problem(&self, excluded: Vec<bool>) -> RegressionProblem<'a> {
        RegressionProblem {
            regression: *self,
            excluded,
        }
    }

    /// Weighted squares of the law fitted with these variances of the runs, infinite for those left out, from a start.
    pub fn chi_squared(&self, variance: &[f64], start: &[f64]) -> f64 {
        let problem = self.problem(variance.iter().map(|variance| variance.is_infinite()).collect());
        let of_rows: Vec<f64> = (0..variance.len()).map(|run| variance[run] / self.count(run)).collect();
        chi_squared(&problem, &of_rows, start)
    }

    /// How many runs one stands for.
    pub fn count(&self, run: usize) -> f64 {
        self.counts.get(run).copied().unwrap_or(1.0)
    }

    /// Restitution that a fit of the law gives each run; 0 where the law is undefined, NaN where the fit did not converge.
    pub fn fitted(&self, fit: &Fit) -> Vec<f64> {
        let runs = 0..self.x.len();
        let parameters = if fit.converged() {
            pair(&fit.parameters)
        } else {
            [f64::NAN; 2]
        };
        runs.map(|run| self.law.restitution(parameters, self.x[run], self.offset_of(run)))
            .collect()
    }

    /// The law at a run, with its slopes and bends.
    pub fn response(&self, parameters: [f64; 2], run: usize) -> Response {
        self.law.response(self.predictor(parameters, run))
    }

    /// The same beyond the law's domain, too.
    pub fn continued(&self, parameters: [f64; 2], run: usize) -> Response {
        self.law.continued(self.predictor(parameters, run))
    }

    fn predictor(&self, parameters: [f64; 2], run: usize) -> f64 {
        self.law.predictor(parameters, self.x[run], self.offset_of(run))
    }

    /// The law at a run with its derivatives in the speed; `None` outside the law's domain.
    ///
    /// `offset_slopes` are v o′ and v² o″ of each run, empty for none.
    pub fn in_speed(&self, parameters: [f64; 2], run: usize, offset_slopes: &[[f64; 2]]) -> Option<LawInSpeed> {
        let predictor = Some(self.predictor(parameters, run)).filter(|of| self.law.is_defined(*of))?;
        let slopes = offset_slopes.get(run).copied().unwrap_or_default();
        Some(self.law.in_speed(parameters, self.x[run], predictor, slopes))
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
        let parameters = pair(&fitted.parameters);
        let bias = self.projected(fitted, variance, |run| {
            let at = self.in_speed(parameters, run, offset_slopes)?;
            Some([0, 1].map(|j| at.response.second_order_bias(at.jacobian[j], at.jacobian_slope[j])))
        });
        let share = (0.1 * fitted.se(1)? / bias?[1].abs()).sqrt();
        share.is_finite().then_some(share)
    }

    /// Slopes of both fitted parameters in a number that shifts every run's offset.
    ///
    /// `offset_slope` is d(offset)/d(that number) for each run. First order: −(JᵀWJ)⁻¹ JᵀW ∂e, with (JᵀWJ)⁻¹ taken from
    /// the covariance; `variance` is that of each residual, empty where all have the fit's own. `None` where the fit has
    /// no covariance.
    pub fn offset_sensitivity(&self, fitted: &Fit, offset_slope: &[f64], variance: &[f64]) -> Option<[f64; 2]> {
        let parameters = pair(&fitted.parameters);
        self.projected(fitted, variance, |run| {
            let jacobian = self.in_speed(parameters, run, &[])?.jacobian;
            let slope = self.response(parameters, run).slope;
            Some(jacobian.map(|own| -own * slope * offset_slope[run]))
        })
    }

    /// (JᵀWJ)⁻¹ Σ w · what each run adds, over those that are not left out; `None` where one of these adds nothing.
    fn projected(
        &self,
        fitted: &Fit,
        variance: &[f64],
        of_run: impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        let covariance = fitted.covariance.as_ref().ok()?;
        let common = fitted.residual_sd?.powi(2);
        let mut sum = [0.0; 2];
        for run in 0..self.x.len() {
            let weight = self.count(run) / variance.get(run).copied().unwrap_or(common);
            if weight != 0.0 {
                let added = of_run(run)?;
                sum = [0, 1].map(|j| sum[j] + weight * added[j]);
            }
        }
        Some([0, 1].map(|j| covariance[(j, 0)] * sum[0] + covariance[(j, 1)] * sum[1]))
    }

    /// Parameters at the minimum or near it, inside the domain of the law at every run: from a flat law.
    fn start(&self) -> [f64; 2] {
        let ones = vec![1.0; self.x.len()];
        let weights = if self.counts.is_empty() { &ones } else { self.counts };
        let mean_of = |of: &dyn Fn(usize) -> f64| {
            let products = weights.iter().enumerate().map(|(run, weight)| weight * of(run));
            products.sum::<f64>() / weights.iter().sum::<f64>()
        };
        let square = |run: usize| self.restitution[run].powi(2);
        let (law, start) = match self.law {
            Law::Dry(_) => (Law::Dry(Order::First), [0.0; 2]),
            Law::Wet(WetLaw::Linear) => (self.law, [mean_of(&|run| self.restitution[run]), 0.0]),
            Law::Wet(WetLaw::Sqrt) => {
                let least = self.offset.iter().copied().fold(0.0, f64::min);
                let left = mean_of(&|run| square(run) - self.offset_of(run));
                (self.law, [left.max(START_MARGIN * mean_of(&square) - least), 0.0])
            }
        };
        let sample = Regression { law, ..*self };
        kernel::fit(&sample.weighted(weights), start).unwrap_or(start)
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

/// One or two parameters as two numbers.
fn pair(parameters: &[f64]) -> [f64; 2] {
    [0, 1].map(|j| parameters.get(j).copied().unwrap_or(0.0))
}

/// A regression as a least-squares problem, in which the domain of some runs may not be held.
pub(super) struct RegressionProblem<'a> {
    regression: Regression<'a>,
    /// runs without weight, which may lie outside the domain; empty for none
    excluded: Vec<bool>,
}

/// Linear predictor that stands for that of an excluded run outside its domain.
const EXCLUDED: f64 = 1e-12;

impl RegressionProblem<'_> {
    /// The linear predictor of a run.
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
        let Regression { law, restitution, .. } = self.regression;
        for (run, (residual, e)) in residuals.iter_mut().zip(restitution).enumerate() {
            *residual = law.response(self.predictor(pair(b), run)?).value - e;
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let Regression { law, x, .. } = self.regression;
        for (run, x) in x.iter().enumerate() {
            let slope = law.response(self.predictor(pair(b), run)?).slope;
            for (j, c) in law.design(*x).into_iter().take(law.parameters()).enumerate() {
                jacobian[(run, j)] = slope * c;
            }
        }
        Ok(())
    }
}

impl SpeedDependent for RegressionProblem<'_> {
    fn each_in_speed(&self, b: &[f64], errors: &ErrorColumns, hand_on: RunInSpeed) -> Result<(), OutOfDomain> {
        let law = self.regression.law;
        for (run, x) in self.regression.x.iter().enumerate() {
            let predictor = self.predictor(pair(b), run)?;
            let offset_slopes = errors.offset_slopes.get(run).copied().unwrap_or_default();
            let at = law.in_speed(pair(b), *x, predictor, offset_slopes);
            let slopes = [0, 1].map(|j| (j, [at.jacobian[j], at.jacobian_slope[j]]));
            hand_on(at.response, &slopes[..law.parameters()]);
        }
        Ok(())
    }
}
