//! Resamples the runs and fits every law to each replicate.
//!
//! Strata are particle × liquid × diameter × film ratio (dry: particle × diameter), and inside these the impact speed.
//! From n runs of a stratum n − 1 are drawn, each with the weight n/(n − 1), which keeps the variance of small strata
//! unbiased. A replicate has a random stream of its own, or where runs are drawn inside strata its own stretch of one, so
//! that neither the number of threads nor the number of replicates moves any of them.
//!
//! | file | job |
//! |---|---|
//! | `target.rs` | describes the fits and how their runs are divided |
//! | `errors.rs` | fits a law to weighted runs with measurement errors |
//! | `strata.rs` | divides the runs of a series by impact speed |
//! | `draws.rs` | draws n − 1 of n members |
//! | `cases.rs` | draws the runs of every stratum, and gives each fit what it needs of them |
//! | `jackknife.rs` | leaves out one run at a time: acceleration and degrees of freedom |
//! | `sandwich.rs` | the covariance of replicates without any, of many runs |
//! | `intervals.rs` | percentile and BCa intervals from replicates |

mod cases;
mod draws;
mod errors;
pub mod intervals;
pub mod jackknife;
pub mod sandwich;
pub mod strata;
mod target;

pub use errors::RunErrors;
pub use target::{Pool, Target};

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::inference::kernel::{Failure, WeightedFit};
use crate::scene::ResamplingScheme;
use crate::seed::Streams;
use cases::{Cases, Rows};
use draws::{drawn, weigh};

/// How replicates are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// replicates
    pub replicates: usize,
    /// what is resampled
    pub scheme: ResamplingScheme,
    /// seed of the streams
    pub seed: u64,
}

/// The name of the stream of which a replicate of [`ResamplingScheme::Cases`] has its own stretch.
const CASES: &str = "bootstrap cases";

/// Every replicate of every target, in order. `done` is called with the number of replicates just finished.
///
/// A target with a single series has no replicates where series are resampled.
pub fn replicate(pool: &Pool, targets: &[Target], plan: Plan, done: &(dyn Fn(usize) + Sync)) -> Vec<Vec<WeightedFit>> {
    let cases = Cases::new(pool, targets);
    let (of_cases, words) = (Streams::new(plan.seed, CASES), cases.words());
    let of_series = Streams::new(plan.seed, "bootstrap");
    let one = |rows: &mut Rows, replicate: usize| -> Vec<WeightedFit> {
        let fits = match plan.scheme {
            ResamplingScheme::Cases => {
                cases.draw(&mut of_cases.stretch(replicate as u64, words), rows);
                (0..targets.len()).map(|target| cases.fit(target, rows)).collect()
            }
            ResamplingScheme::Series => {
                let mut rng = of_series.at(replicate as u64);
                let fit = |target: &Target| match &pool.series[target.series.clone()] {
                    [] | [_] => Err(Failure::OneSeries),
                    series => target.fit_weighted(&series_weights(series, &mut rng)),
                };
                targets.iter().map(fit).collect()
            }
        };
        done(1);
        fits
    };
    let replicates = (0..plan.replicates).into_par_iter();
    let made: Vec<Vec<WeightedFit>> = replicates.map_init(|| cases.room(), one).collect();
    let of_target = |target: usize| made.iter().map(|fits| fits[target]).collect();
    (0..targets.len()).map(of_target).collect()
}

/// Weights of the runs of some series where whole series are drawn: every run weighs as its series does.
fn series_weights(series: &[Range<usize>], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut of_series = vec![0.0; series.len()];
    weigh(rng, &mut of_series);
    let runs = series.iter().zip(of_series);
    runs.flat_map(|(series, weight)| std::iter::repeat_n(weight, series.len()))
        .collect()
}

/// Weights of all runs of a pool in one replicate of [`ResamplingScheme::Cases`] of fits that have all strata, for fits other
/// than those made here.
pub fn weights(pool: &Pool, seed: u64, number: u64) -> Vec<f64> {
    let mut weights = vec![0.0; pool.runs()];
    let words = pool.strata.iter().map(|stratum| drawn(stratum.len()) as u64).sum();
    let mut rng = Streams::new(seed, CASES).stretch(number, words);
    for stratum in &pool.strata {
        weigh(&mut rng, &mut weights[stratum.clone()]);
    }
    weights
}
