//! Resamples the runs and fits every law to each replicate.
//!
//! Strata are particle × liquid × diameter × film ratio (dry: particle × diameter). A replicate has one random stream,
//! from which the strata are drawn in a fixed order, so that neither the number of threads nor the number of replicates
//! moves any of them. Indices are drawn and counted, never stored: a thread holds one weight a run.
//!
//! | file | job |
//! |---|---|
//! | `kernel.rs` | fits a law to weighted runs in one stream over them |
//! | `intervals.rs` | percentile, BCa and studentized intervals from replicates |

pub mod intervals;
pub mod kernel;

use std::ops::Range;

use rand::rngs::ChaCha8Rng;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use crate::scene::ResamplingScheme;
use crate::seed::stream;
use kernel::Weighted;

/// A law fitted to some strata.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// e = 1 − k s; x is s = v^(1/5)
    Dry,
    /// e = a − b x
    Linear,
    /// e = √(α + β x + o)
    SquareRoot,
}

impl Law {
    /// Parameters of the law.
    pub fn parameters(self) -> usize {
        match self {
            Law::Dry => 1,
            Law::Linear | Law::SquareRoot => 2,
        }
    }
}

/// A fit to be bootstrapped: its runs, in strata, and where it ended.
#[derive(Debug, Clone)]
pub struct Target<'a> {
    /// the law
    pub law: Law,
    /// abscissa of each run
    pub x: &'a [f64],
    /// known offset of each run; empty for none
    pub offset: &'a [f64],
    /// restitution of each run
    pub restitution: &'a [f64],
    /// the strata, as indices into [`Pool::strata`]; consecutive, and together all of x
    pub strata: Range<usize>,
    /// parameters of the fit to the runs themselves
    pub fitted: [f64; 2],
}

/// Sizes of all strata, in the fixed order in which a replicate draws them.
#[derive(Debug, Clone, Default)]
pub struct Pool {
    /// ranges of consecutive runs
    pub strata: Vec<Range<usize>>,
}

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

/// Replicates of one target: parameters and covariance, or NaN where a replicate has no fit.
pub type Replicated = Vec<Weighted>;

/// A replicate without a fit.
const NO_FIT: Weighted = Weighted {
    parameters: [f64::NAN; 2],
    covariance: [f64::NAN; 3],
};

/// Replicates handled by one thread at a time.
const BLOCK: usize = 32;

/// Fits a target to weighted restitutions.
fn solve(target: &Target, restitution: &[f64], weights: &[f64]) -> Weighted {
    let fit = match target.law {
        Law::Dry => kernel::dry(target.x, restitution, weights),
        Law::Linear => kernel::linear(target.x, restitution, weights),
        Law::SquareRoot => kernel::square_root(target.x, target.offset, restitution, weights, target.fitted),
    };
    fit.filter(|fit| fit.parameters.iter().all(|p| p.is_finite()))
        .unwrap_or(NO_FIT)
}

/// Restitution the fitted law gives each run; negative or NaN nowhere, since the fit lies in its domain.
fn fitted(target: &Target) -> Vec<f64> {
    let [a, b] = target.fitted;
    let at = |run: usize| {
        let x = target.x[run];
        match target.law {
            Law::Dry => 1.0 - a * x,
            Law::Linear => a - b * x,
            Law::SquareRoot => {
                let offset = target.offset.get(run).copied().unwrap_or(0.0);
                (a + b * x + offset).max(0.0).sqrt()
            }
        }
    };
    (0..target.x.len()).map(at).collect()
}

/// What the residual and parametric schemes draw from.
struct Noise {
    fitted: Vec<f64>,
    /// residuals over √(1 − leverage), centred
    residuals: Vec<f64>,
    sd: f64,
}

impl Noise {
    fn new(target: &Target) -> Noise {
        let fitted = fitted(target);
        let n = target.x.len() as f64;
        let p = target.law.parameters() as f64;
        let slope = |run: usize| match target.law {
            Law::Dry => [-target.x[run], 0.0],
            Law::Linear => [1.0, -target.x[run]],
            Law::SquareRoot => [0.5 / fitted[run], 0.5 * target.x[run] / fitted[run]],
        };
        let (mut j0, mut j1, mut j2) = (0.0, 0.0, 0.0);
        for run in 0..target.x.len() {
            let [a, b] = slope(run);
            j0 += a * a;
            j1 += a * b;
            j2 += b * b;
        }
        let determinant = j0 * j2 - j1 * j1;
        let leverage = |run: usize| {
            let [a, b] = slope(run);
            match target.law {
                Law::Dry => a * a / j0,
                _ => (a * a * j2 - 2.0 * a * b * j1 + b * b * j0) / determinant,
            }
        };
        let raw: Vec<f64> = target.restitution.iter().zip(&fitted).map(|(e, f)| e - f).collect();
        let sd = (raw.iter().map(|r| r * r).sum::<f64>() / (n - p)).sqrt();
        let mut residuals: Vec<f64> = raw
            .iter()
            .enumerate()
            .map(|(run, r)| r / (1.0 - leverage(run)).max(f64::EPSILON).sqrt())
            .collect();
        let mean = residuals.iter().sum::<f64>() / n;
        residuals.iter_mut().for_each(|r| *r -= mean);
        Noise { fitted, residuals, sd }
    }
}

/// One thread's working space.
struct Scratch {
    weights: Vec<f64>,
    restitution: Vec<f64>,
}

/// Draws an index below `n` from 32 random bits; the bias of the multiplication is below n/2³².
fn index(rng: &mut ChaCha8Rng, n: usize) -> usize {
    ((u64::from(rng.next_u32()) * n as u64) >> 32) as usize
}

/// Counts of a resample with replacement inside each stratum.
fn draw_cases(rng: &mut ChaCha8Rng, pool: &Pool, weights: &mut [f64]) {
    weights.fill(0.0);
    for stratum in &pool.strata {
        let runs = &mut weights[stratum.clone()];
        let n = runs.len();
        // beyond 32 bits of runs no stratum could be held in memory
        for _ in 0..n {
            runs[index(rng, n)] += 1.0;
        }
    }
}

/// Every replicate of every target, in order; targets × replicates.
pub fn replicate(pool: &Pool, targets: &[Target], plan: Plan) -> Vec<Replicated> {
    let runs = pool.strata.last().map_or(0, |stratum| stratum.end);
    let most = targets.iter().map(|target| target.x.len()).max().unwrap_or(0);
    let noises: Vec<Option<Noise>> = targets
        .iter()
        .map(|target| match plan.scheme {
            ResamplingScheme::Residuals | ResamplingScheme::Parametric => Some(Noise::new(target)),
            ResamplingScheme::Cases | ResamplingScheme::Series => None,
        })
        .collect();
    let scratch = || Scratch {
        weights: vec![0.0; runs.max(most)],
        restitution: vec![0.0; most],
    };
    let mut rows = vec![NO_FIT; targets.len() * plan.replicates];
    if targets.is_empty() {
        return vec![];
    }
    rows.par_chunks_mut(BLOCK * targets.len())
        .enumerate()
        .for_each_init(scratch, |scratch, (block, rows)| {
            for (index, row) in rows.chunks_mut(targets.len()).enumerate() {
                let number = (block * BLOCK + index) as u64;
                one(pool, targets, &noises, plan, number, scratch, row);
            }
        });
    (0..targets.len())
        .map(|target| rows.iter().skip(target).step_by(targets.len()).copied().collect())
        .collect()
}

fn one(
    pool: &Pool,
    targets: &[Target],
    noises: &[Option<Noise>],
    plan: Plan,
    number: u64,
    scratch: &mut Scratch,
    row: &mut [Weighted],
) {
    let mut rng = stream(plan.seed, "bootstrap", number);
    if plan.scheme == ResamplingScheme::Cases {
        draw_cases(&mut rng, pool, &mut scratch.weights);
    }
    for ((target, noise), out) in targets.iter().zip(noises).zip(row) {
        let n = target.x.len();
        *out = match (plan.scheme, noise) {
            (ResamplingScheme::Cases, _) => {
                let first = pool.strata.get(target.strata.start).map_or(0, |stratum| stratum.start);
                solve(target, target.restitution, &scratch.weights[first..first + n])
            }
            (ResamplingScheme::Series, _) => {
                draw_series(&mut rng, pool, target, &mut scratch.weights[..n]);
                solve(target, target.restitution, &scratch.weights[..n])
            }
            (_, Some(noise)) => {
                scratch.weights[..n].fill(1.0);
                let first = pool.strata.get(target.strata.start).map_or(0, |stratum| stratum.start);
                for stratum in &pool.strata[target.strata.clone()] {
                    for run in stratum.start - first..stratum.end - first {
                        let shift = if plan.scheme == ResamplingScheme::Parametric {
                            let z: f64 = StandardNormal.sample(&mut rng);
                            noise.sd * z
                        } else {
                            noise.residuals[rng.random_range(0..n)]
                        };
                        scratch.restitution[run] = noise.fitted[run] + shift;
                        // it would have stuck, and stuck runs are left out
                        if scratch.restitution[run] <= 0.0 {
                            scratch.weights[run] = 0.0;
                            scratch.restitution[run] = 0.0;
                        }
                    }
                }
                solve(target, &scratch.restitution[..n], &scratch.weights[..n])
            }
            (_, None) => NO_FIT,
        };
    }
}

/// Whole strata drawn with replacement: every run weighs as often as its series was drawn.
fn draw_series(rng: &mut ChaCha8Rng, pool: &Pool, target: &Target, weights: &mut [f64]) {
    weights.fill(0.0);
    let strata = &pool.strata[target.strata.clone()];
    let Some(first) = strata.first().map(|stratum| stratum.start) else {
        return;
    };
    for _ in 0..strata.len() {
        let drawn = &strata[index(rng, strata.len())];
        for weight in &mut weights[drawn.start - first..drawn.end - first] {
            *weight += 1.0;
        }
    }
}

/// Runs up to which leave-one-out fits are made one by one; above, they are taken to first order, off by 1/runs.
const EXACT_JACKKNIFE: usize = 500;

/// Parameters without each run in turn, by stratum.
pub fn leave_one_out(pool: &Pool, target: &Target) -> Vec<Vec<[f64; 2]>> {
    let first = pool.strata.get(target.strata.start).map_or(0, |stratum| stratum.start);
    let shifts = (target.x.len() > EXACT_JACKKNIFE).then(|| first_order(target));
    let mut weights = vec![1.0; target.x.len()];
    let mut without = |run: usize| match &shifts {
        Some(shifts) => [target.fitted[0] - shifts[run][0], target.fitted[1] - shifts[run][1]],
        None => {
            weights[run] = 0.0;
            let left = solve(target, target.restitution, &weights);
            weights[run] = 1.0;
            left.parameters
        }
    };
    pool.strata[target.strata.clone()]
        .iter()
        .map(|stratum| (stratum.start - first..stratum.end - first).map(&mut without).collect())
        .collect()
}

/// dθ/dw_i of both parameters for each run: −H⁻¹ times the run's own gradient.
fn first_order(target: &Target) -> Vec<[f64; 2]> {
    let fitted = fitted(target);
    let pull = |run: usize| -> ([f64; 2], [f64; 3]) {
        let (x, e, f) = (target.x[run], target.restitution[run], fitted[run]);
        match target.law {
            Law::Dry => ([-(f - e) * x, 0.0], [x * x, 0.0, 1.0]),
            Law::Linear => ([f - e, -(f - e) * x], [1.0, -x, x * x]),
            Law::SquareRoot => {
                let slope = 0.5 * (1.0 - e / f);
                let bend = 0.25 * e / (f * f * f);
                ([slope, slope * x], [bend, bend * x, bend * x * x])
            }
        }
    };
    let (mut h0, mut h1, mut h2) = (0.0, 0.0, 0.0);
    for run in 0..target.x.len() {
        let (_, [a, b, c]) = pull(run);
        h0 += a;
        h1 += b;
        h2 += c;
    }
    let determinant = h0 * h2 - h1 * h1;
    (0..target.x.len())
        .map(|run| {
            let ([g0, g1], _) = pull(run);
            [(h1 * g1 - h2 * g0) / determinant, (h1 * g0 - h0 * g1) / determinant]
        })
        .collect()
}
