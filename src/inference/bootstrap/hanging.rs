//! Resamples a fit of very many runs that hangs on a few: those are drawn, and the others stand together where resampling
//! tends to.
//!
//! Near the edge of the square root's domain a run's weight in the Hessian grows as r^(-3/2), and without bound; replicates
//! without it are far from those with it, and no covariance says how they spread. The others are so many that together they
//! do what their means do: gathered into bins of x, each with its mean restitution and the normal noise that the weights of
//! its runs give that.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

use super::kernel::{self, Failure, Sample, WeightedFit};
use super::sandwich::MANY_RUNS;
use super::target::{Pool, Target};
use crate::inference::law::Law;
use crate::inference::regression::Regression;

/// Runs nearest to the edge that are drawn: the i-th nearest has a leverage of about 1/(2 i) where all are, so that none of the
/// others has more than a thousandth.
const DRAWN: usize = 500;

/// Bins of the others: what the curvature inside one does is the same in all replicates, and taken off.
const BINS: usize = 256;

/// A fit that hangs on a few runs.
pub(super) struct Hanging {
    /// strata of the runs that are drawn, which stand first
    strata: Vec<Range<usize>>,
    /// those that are drawn, then the means of bins
    x: Vec<f64>,
    restitution: Vec<f64>,
    weights: Vec<f64>,
    /// of the mean restitution of each bin
    noise: Vec<f64>,
    /// squares about the bins' means
    within: f64,
    fitted: [f64; 2],
    /// what the bins take off the fit to all runs
    shift: [f64; 2],
}

impl Hanging {
    /// A square root of many runs without a known offset; `None` of any other fit.
    pub fn new(pool: &Pool, target: &Target) -> Option<Hanging> {
        let Regression {
            law,
            x,
            offset,
            restitution,
            counts: _,
        } = target.regression;
        let serves = law == Law::SQUARE_ROOT && offset.is_empty() && target.run_weights.is_none();
        if !serves || x.len() < MANY_RUNS {
            return None;
        }
        let first = pool.first_run(target);
        let kept = |run: usize| law.predictor(target.fitted, x[run], 0.0);
        let strata = pool.strata[target.strata.clone()].iter();
        let mut strata: Vec<(f64, Range<usize>)> = strata
            .map(|stratum| stratum.start - first..stratum.end - first)
            .map(|stratum| (stratum.clone().map(kept).fold(f64::INFINITY, f64::min), stratum))
            .collect();
        strata.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut hanging = Hanging {
            strata: vec![],
            x: vec![],
            restitution: vec![],
            weights: vec![],
            noise: vec![],
            within: 0.0,
            fitted: target.fitted,
            shift: [0.0; 2],
        };
        let mut others = strata.into_iter().map(|(_, stratum)| stratum);
        for stratum in others.by_ref() {
            let from = hanging.x.len();
            hanging.x.extend(&x[stratum.clone()]);
            hanging.restitution.extend(&restitution[stratum]);
            hanging.strata.push(from..hanging.x.len());
            if hanging.x.len() >= DRAWN {
                break;
            }
        }
        hanging.weights.resize(hanging.x.len(), 1.0);
        let mut others: Vec<Range<usize>> = others.collect();
        others.sort_by(|a, b| x[a.start].total_cmp(&x[b.start]));
        let residual = |run: usize| restitution[run] - law.restitution(target.fitted, x[run], 0.0);
        for bin in others.chunks(others.len().div_ceil(BINS).max(1)) {
            hanging.add_bin(bin, [x, restitution], residual);
        }
        let found = hanging.fit(&hanging.restitution, &hanging.weights).ok()?;
        hanging.shift = [0, 1].map(|j| target.fitted[j] - found.parameters[j]);
        Some(hanging)
    }

    /// Gathers the runs of some strata.
    fn add_bin(&mut self, strata: &[Range<usize>], [x, restitution]: [&[f64]; 2], residual: impl Fn(usize) -> f64) {
        let runs = || strata.iter().flat_map(Clone::clone);
        let n = runs().count() as f64;
        let mean = |of: &dyn Fn(usize) -> f64| runs().map(of).sum::<f64>() / n;
        let mean_residual = mean(&residual);
        let mut variance = 0.0;
        for stratum in strata.iter().filter(|stratum| stratum.len() > 1) {
            let m = stratum.len() as f64;
            let centre = stratum.clone().map(&residual).sum::<f64>() / m;
            let squares: f64 = stratum.clone().map(|run| (residual(run) - centre).powi(2)).sum();
            variance += m / (m - 1.0) * squares;
        }
        self.x.push(mean(&|run| x[run]));
        self.restitution.push(mean(&|run| restitution[run]));
        self.weights.push(n);
        self.noise.push(variance.sqrt() / n);
        self.within += runs().map(|run| (residual(run) - mean_residual).powi(2)).sum::<f64>();
    }

    fn fit(&self, restitution: &[f64], weights: &[f64]) -> Result<WeightedFit, Failure> {
        let sample = Sample {
            within: self.within,
            ..Sample::new(&self.x, restitution, weights)
        };
        kernel::fit(Law::SQUARE_ROOT, &sample, self.fitted)
    }

    /// So many replicates in turn.
    pub fn replicates(&self, count: usize, mut rng: ChaCha8Rng) -> Vec<Result<WeightedFit, Failure>> {
        let (mut restitution, mut weights) = (self.restitution.clone(), self.weights.clone());
        let drawn = self.x.len() - self.noise.len();
        let mut replicate = || {
            weights[..drawn].fill(0.0);
            for stratum in &self.strata {
                match stratum.len() {
                    // it cannot vary
                    1 => weights[stratum.start] = 1.0,
                    n => {
                        let weight = n as f64 / (n as f64 - 1.0);
                        for _ in 1..n {
                            weights[rng.random_range(stratum.clone())] += weight;
                        }
                    }
                }
            }
            for (bin, noise) in self.noise.iter().enumerate() {
                let z: f64 = StandardNormal.sample(&mut rng);
                restitution[drawn + bin] = self.restitution[drawn + bin] + noise * z;
            }
            let found = self.fit(&restitution, &weights)?;
            Ok(WeightedFit {
                parameters: [0, 1].map(|j| found.parameters[j] + self.shift[j]),
                ..found
            })
        };
        (0..count).map(|_| replicate()).collect()
    }
}
