//! Tests of the sampler on normal targets with given moments.

use nalgebra::DMatrix;

use super::*;
use crate::inference::laplace::laplace;
use crate::inference::mixing::{draws_a_chain, draws_to_add, MixingLines};
use crate::seed::StreamName;

/// A log density of so many dimensions, by a function that writes its slopes.
pub struct Target<F>(pub usize, pub F);

impl<F: Fn(&[f64], &mut [f64]) -> Result<f64, OutsideDomain> + Sync> LogDensity for Target<F> {
    fn dimension(&self) -> usize {
        self.0
    }
    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        (self.1)(point, slopes)
    }
}

/// A normal of one dimension that stands for a log density.
pub fn normal_about(mode: f64, sd: f64) -> Laplace {
    Laplace {
        mode: vec![mode],
        ln_density: 0.0,
        scale: DMatrix::identity(1, 1) * sd,
        converged: true,
        peaked: true,
    }
}

/// A normal about zero in d dimensions: sds from 1 to 10⁶, neighbours correlated.
struct Normal {
    precision: DMatrix<f64>,
    covariance: DMatrix<f64>,
}

impl Normal {
    fn new(dimension: usize, correlation: f64) -> Normal {
        let sd = |i: usize| 10f64.powf(6.0 * i as f64 / (dimension - 1) as f64);
        let covariance = DMatrix::from_fn(dimension, dimension, |i, j| {
            correlation.powi(i32::try_from(i.abs_diff(j)).expect("small")) * sd(i) * sd(j)
        });
        // the correlation matrix of an autoregression is inverted in closed form, scale apart
        let correlations = DMatrix::from_fn(dimension, dimension, |i, j| covariance[(i, j)] / (sd(i) * sd(j)));
        let inverse = correlations.try_inverse().expect("a correlation matrix");
        let precision = DMatrix::from_fn(dimension, dimension, |i, j| inverse[(i, j)] / (sd(i) * sd(j)));
        Normal { precision, covariance }
    }
}

impl LogDensity for Normal {
    fn dimension(&self) -> usize {
        self.precision.nrows()
    }
    fn ln_density(&self, point: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        let mut value = 0.0;
        for (i, slope) in slopes.iter_mut().enumerate() {
            *slope = -self.precision.row(i).iter().zip(point).map(|(p, x)| p * x).sum::<f64>();
            value += 0.5 * *slope * point[i];
        }
        Ok(value)
    }
}

const EFFORT: Effort = Effort {
    chains: 4,
    warmup: 500,
    draws: 2000,
    target_accept: TARGET_ACCEPT,
};

/// Largest distance of a mean, and of a variance, from the truth, in standard errors for as many independent draws.
fn distances(target: &Normal, chains: &[Chain]) -> (f64, f64) {
    let dimension = target.dimension();
    let n = chains.iter().map(|chain| chain.ln_density.len()).sum::<usize>() as f64;
    let mut worst = (0.0f64, 0.0f64);
    for i in 0..dimension {
        let values = || {
            chains
                .iter()
                .flat_map(move |chain| chain.points.iter().skip(i).step_by(dimension))
        };
        let variance = target.covariance[(i, i)];
        let mean = values().sum::<f64>() / n;
        let found = values().map(|x| x * x).sum::<f64>() / n;
        worst.0 = worst.0.max(mean.abs() / (variance / n).sqrt());
        worst.1 = worst.1.max((found / variance - 1.0).abs() / (2.0 / n).sqrt());
    }
    worst
}

fn at_once(
    target: &Normal,
    about: &Laplace,
    effort: Effort,
    streams: StreamName,
) -> Result<Vec<Chain>, SamplingFailure> {
    sample_chains(target, about, SamplingPlan::new(effort, streams), &mut |_| 0)
}

/// Squares mix more slowly than the points themselves, so the errors of a variance are allowed twice the independent
/// ones; a sampler with the wrong metric, or an accept step forgotten, is off by tens.
#[test]
fn means_and_variances_of_a_correlated_normal_are_its_own() {
    let target = Normal::new(5, 0.99);
    let about = laplace(&target, &[0.3; 5]).expect("a density everywhere");
    let name = "means_and_variances_of_a_correlated_normal_are_its_own";
    let chains = at_once(&target, &about, EFFORT, StreamName::new(1, name)).expect("sampled");
    let (mean, variance) = distances(&target, &chains);
    assert!(mean < 4.5 && variance < 9.0, "{mean} {variance}");
    assert!(chains
        .iter()
        .all(|chain| chain.diverging.iter().all(|diverging| !diverging)));
    // the planted fault: draws of another target do not pass
    let other = Normal::new(5, 0.9);
    let chains = at_once(&other, &about, EFFORT, StreamName::new(1, name)).expect("sampled");
    let halved = Normal {
        covariance: &target.covariance * 0.8,
        precision: target.precision.clone(),
    };
    assert!(
        distances(&halved, &chains).1 > 12.0,
        "{:?}",
        distances(&halved, &chains)
    );
}

/// Where the normal about the mode is not that of the target a chain goes on in a space that its own first draws make round.
#[test]
fn a_chain_of_long_trajectories_goes_on_in_a_rounder_space() {
    let target = Normal::new(5, 0.9999);
    let other = laplace(&Normal::new(5, 0.0), &[0.3; 5]).expect("a density everywhere");
    let name = "a_chain_of_long_trajectories_goes_on_in_a_rounder_space";
    let steps = |warmup: usize| {
        let effort = Effort { warmup, ..EFFORT };
        let chains = at_once(&target, &other, effort, StreamName::new(1, name)).expect("sampled");
        let (mean, variance) = distances(&target, &chains);
        assert!(mean < 4.5 && variance < 9.0, "{mean} {variance}");
        let all: Vec<u64> = chains.iter().flat_map(|chain| chain.steps.clone()).collect();
        all.iter().sum::<u64>() as f64 / all.len() as f64
    };
    // which is too short to go on after its first draws
    let (round, long) = (steps(EFFORT.warmup), steps(FIRST));
    assert!(round < LONG && long > 2.0 * round, "{round} {long}");
}

/// A density of one half of the line: steps across its edge end as divergences, not as failures.
#[test]
fn the_edge_of_a_domain_is_counted_and_survived() {
    let half = Target(1, |point: &[f64], slopes: &mut [f64]| {
        slopes[0] = -point[0];
        (point[0] > 0.0)
            .then_some(-0.5 * point[0] * point[0])
            .ok_or(OutsideDomain)
    });
    let about = normal_about(0.7, 1.0);
    let heard = std::sync::atomic::AtomicUsize::new(0);
    let count = |_: bool, diverging: bool| {
        heard.fetch_add(usize::from(diverging), std::sync::atomic::Ordering::Relaxed);
    };
    let plan = SamplingPlan {
        watcher: &count,
        ..SamplingPlan::new(EFFORT, StreamName::new(1, "the_edge_of_a_domain"))
    };
    let chains = sample_chains(&half, &about, plan, &mut |_| 0).expect("sampled");
    let diverged: usize = chains.iter().flat_map(|chain| &chain.diverging).filter(|d| **d).count();
    assert!(diverged > 0 && heard.into_inner() >= diverged);
    assert!(chains.iter().all(|chain| chain.points.iter().all(|x| *x > 0.0)));
}

#[test]
fn chains_that_are_drawn_on_keep_what_they_would_have_kept_at_once() {
    let target = Normal::new(3, 0.5);
    let about = laplace(&target, &[0.3; 3]).expect("a density everywhere");
    let of = |draws: usize| Effort {
        chains: 3,
        warmup: 50,
        draws,
        target_accept: TARGET_ACCEPT,
    };
    let streams = StreamName::new(7, "drawn on");
    let drawn_on = |threads: usize| {
        let plan = SamplingPlan::new(of(20), streams);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let mut blocks = [5, 15, 0].into_iter();
        pool.expect("a pool")
            .install(|| sample_chains(&target, &about, plan, &mut |_| blocks.next().unwrap_or(0)))
            .expect("sampled")
    };
    let at_once = at_once(&target, &about, of(40), streams).expect("sampled");
    assert_eq!(drawn_on(1), at_once);
    assert_eq!(drawn_on(2), at_once);
    assert_eq!(drawn_on(3), at_once);
    assert_ne!(at_once[0], at_once[1]);
}

/// Two peaks in one dimension, so many sds apart: beyond some ten no chain finds its way from one to the other.
#[test]
fn chains_in_two_peaks_never_mix_and_one_peak_does() {
    const MOST: usize = 1600;
    let drawn = |apart: f64| {
        let target = Target(1, |point: &[f64], slopes: &mut [f64]| {
            let (near, far) = (point[0], point[0] - apart);
            let weight = 1.0 / (1.0 + (0.5 * (far * far - near * near)).exp());
            slopes[0] = -(1.0 - weight) * near - weight * far;
            let nearest = near.abs().min(far.abs());
            let others = 0.5 * (near * near - far * far).abs();
            Ok(-0.5 * nearest * nearest + (-others).exp().ln_1p())
        });
        // as wide as both peaks
        let about = normal_about(0.5 * apart, 1.0 + 0.5 * apart);
        let effort = Effort { draws: 200, ..EFFORT };
        let plan = SamplingPlan::new(effort, StreamName::new(1, "chains_in_two_peaks_never_mix"));
        let values = |chains: &[Chain]| vec![chains.iter().map(|chain| chain.points.clone()).collect::<Vec<_>>()];
        let lines = MixingLines::of_chains(EFFORT.chains);
        let chains = sample_chains(&target, &about, plan, &mut |chains| {
            draws_to_add(lines, &values(chains), MOST)
        });
        let values = values(&chains.expect("sampled"));
        (draws_a_chain(&values), lines.hold(&values, 1.0))
    };
    assert_eq!(drawn(14.0), (MOST, false));
    let (draws, mixed) = drawn(0.0);
    assert!(mixed && draws < MOST, "{draws}");
    // a first block that was too short is made good
    let (draws, mixed) = drawn(4.0);
    assert!(mixed && draws > 200, "{draws}");
}
