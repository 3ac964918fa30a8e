//! Fits a law to weighted runs with measurement errors, as every replicate does: by effective variance, anew.
//!
//! What `effective_variance.rs` says of a fit to runs holds of one to weighted runs, of which each counts as often as it
//! weighs. Runs that the fit to all left out, near where nothing rebounds, stay left out.

use crate::inference::effective_variance::{ErrorColumns, ErrorWeights, WeighedRuns, MOST_ROUNDS};
use crate::inference::kernel::{self, Failure, Regression, WeightedFit};
use crate::inference::regression::RegressionProblem;

/// Measurement errors of the runs of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct RunErrors {
    /// one number a run in every column
    pub columns: ErrorColumns,
    /// runs that the fit left out
    pub left_out: Vec<bool>,
    /// weight of each run in the fit, 1 on average but for runs that were left out and have 0
    pub weights: Vec<f64>,
    /// bias by errors of the speed that was taken off the parameters
    pub bias: [f64; 2],
}

/// Relative change of the parameters after which the weights have settled: the next one is far smaller, and far below a
/// standard error.
const SETTLED: f64 = 1e-5;

impl RunErrors {
    /// Those of a fit's runs in another order.
    pub fn new(of_fit: &ErrorWeights, order: &[usize]) -> RunErrors {
        let variance: Vec<f64> = order.iter().map(|run| of_fit.variance[*run]).collect();
        let left_out: Vec<bool> = variance.iter().map(|variance| variance.is_infinite()).collect();
        let counted = left_out.iter().filter(|left_out| !**left_out).count();
        let mean = variance.iter().map(|variance| 1.0 / variance).sum::<f64>() / counted as f64;
        RunErrors {
            columns: of_fit.errors.of_runs(order),
            left_out,
            weights: variance.iter().map(|variance| 1.0 / (variance * mean)).collect(),
            bias: [0, 1].map(|j| of_fit.bias.get(j).copied().unwrap_or(0.0)),
        }
    }

    /// Weighs and fits in turn until neither changes, from the fit to all runs.
    ///
    /// Fails as [`kernel::fit`] does, and where the weights do not settle.
    pub(super) fn fit(&self, sample: &Regression, fitted: [f64; 2]) -> WeightedFit {
        let law = sample.law;
        let both = || self.left_out.iter().zip(sample.counts);
        let excluded: Vec<bool> = both().map(|(left_out, w)| *left_out || *w == 0.0).collect();
        let counted: f64 = both().filter(|(left_out, _)| !**left_out).map(|(_, w)| w).sum();
        let runs = WeighedRuns {
            problem: &sample.problem(excluded.clone()),
            errors: &self.columns,
            excluded: &excluded,
            counts: sample.counts,
            freedom: counted - law.parameters() as f64,
        };
        let mut parameters = [0, 1].map(|j| fitted[j] + self.bias[j]);
        for _ in 0..MOST_ROUNDS {
            let variances = runs.variances_at(&parameters).ok().flatten();
            let variances = variances.ok_or(Failure::Degenerate)?.total;
            let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / variance).collect();
            let next = kernel::fit(&sample.weighted(&weights), parameters)?;
            let change = |j: usize| (next[j] - parameters[j]).abs() / next[j].abs();
            let settled = (0..law.parameters()).all(|j| change(j) <= SETTLED);
            parameters = next;
            if settled {
                return Ok(runs.without_bias(&variances, parameters));
            }
        }
        Err(Failure::NotConverged)
    }
}

impl WeighedRuns<'_, RegressionProblem<'_>> {
    /// Takes the bias by errors of the speed off a fit, unless that leads out of the domain.
    fn without_bias(&self, variances: &[f64], parameters: [f64; 2]) -> [f64; 2] {
        let corrected = || {
            let (pull, information) = self.pull(&parameters, variances).ok()?;
            let bias = information.cholesky()?.solve(&pull);
            let corrected = [0, 1].map(|j| parameters[j] - bias.get(j).unwrap_or(&0.0));
            self.residuals_at(&corrected).ok().map(|_| corrected)
        };
        corrected().unwrap_or(parameters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::law::Law;
    use crate::seed::stream;
    use rand::RngExt;

    /// Runs about a square-root law whose speeds and restitutions err, each with an error of its own.
    fn runs() -> (Vec<f64>, Vec<f64>, ErrorColumns) {
        let mut rng = stream(1, "runs whose weights are drawn", 0);
        let mut uniform = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
        let (mut x, mut e, mut columns) = (vec![], vec![], ErrorColumns::default());
        for run in 0..40 {
            x.push(0.3 + 0.02 * f64::from(run));
            e.push((0.7 - 0.4 * x[run as usize]).sqrt() + uniform(-0.03, 0.03));
            columns.relative_speed_sd.push(uniform(0.005, 0.03));
            columns.restitution_sd.push(uniform(0.002, 0.01));
        }
        (x, e, columns)
    }

    fn repeated(values: &[f64], counts: &[usize]) -> Vec<f64> {
        let each = values.iter().zip(counts);
        each.flat_map(|(value, count)| std::iter::repeat_n(*value, *count))
            .collect()
    }

    #[test]
    fn a_weighted_fit_is_that_of_repeated_runs() {
        let (x, e, columns) = runs();
        for law in [Law::SQUARE_ROOT, Law::LINEAR] {
            let fit_of = |counts: &[usize]| {
                let errors = ErrorColumns {
                    relative_speed_sd: repeated(&columns.relative_speed_sd, counts),
                    restitution_sd: repeated(&columns.restitution_sd, counts),
                    ..ErrorColumns::default()
                };
                let (x, e) = (repeated(&x, counts), repeated(&e, counts));
                let (fit, weights) = Regression::new(law, &x, &e).fit_with_errors(Some(&errors));
                ([fit.parameters[0], fit.parameters[1]], weights.expect("errors"))
            };
            let all = vec![1; x.len()];
            let (fitted, own) = fit_of(&all);
            let in_order: Vec<usize> = (0..x.len()).collect();
            let errors = RunErrors::new(&own, &in_order);
            assert!(own.bias.iter().all(|bias| bias.abs() > 1e-5), "{:?}", own.bias);
            let drawn: Vec<usize> = (0..x.len()).map(|run| run * 7 % 4).collect();
            for counts in [&all, &drawn] {
                let weights: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
                let sample = Regression::new(law, &x, &e).weighted(&weights);
                let found = errors.fit(&sample, fitted).expect("settled");
                let (expected, _) = fit_of(counts);
                for j in 0..2 {
                    assert!(
                        (found[j] / expected[j] - 1.0).abs() < 1e-6,
                        "{law:?} {found:?} {expected:?}"
                    );
                }
            }
            // the planted fault: weights of all runs, whatever was drawn
            let frozen: Vec<f64> = drawn
                .iter()
                .zip(&own.variance)
                .map(|(count, variance)| *count as f64 / variance)
                .collect();
            let frozen = Regression::new(law, &x, &e).weighted(&frozen);
            let frozen = kernel::fit(&frozen, fitted).expect("determined");
            let (expected, _) = fit_of(&drawn);
            assert!((0..2).any(|j| ((frozen[j] - own.bias[j]) / expected[j] - 1.0).abs() > 1e-4));
        }
    }
}
