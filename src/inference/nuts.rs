//! Samples a log density by the No-U-Turn sampler; the only file that names the crate that has it.
//!
//! The space is first made round with the curvature at the mode: then neither correlation nor scale of the parameters
//! costs steps, and adaptation has little left to do.

use std::collections::HashMap;

use nuts_rs::{Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings as _};
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::laplace::Laplace;
use crate::model::likelihood::OutsideDomain;
use crate::model::posterior::LogDensity;
use crate::seed::StreamName;

/// How much is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// chains
    pub chains: usize,
    /// draws a chain spends adapting
    pub warmup: usize,
    /// draws a chain keeps
    pub draws: usize,
    /// mean acceptance probability to which the step size is adapted; nearer 1 is shorter steps
    pub target_accept: f64,
}

/// The acceptance that is least work where a posterior is nearly normal.
pub const TARGET_ACCEPT: f64 = 0.8;

/// Rounding of the log density beyond which no step keeps the energy: every trajectory would be followed to its largest
/// depth for nothing.
const MOST_ROUNDING: f64 = 1e-3;

/// Depth at which a trajectory is cut: 2¹⁰ steps.
pub const LARGEST_DEPTH: u64 = 10;

/// What one chain kept. Every column but `points` has one number a draw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chain {
    /// the points, one after the other, as many numbers each as there are dimensions
    pub points: Vec<f64>,
    /// log density at the point
    pub ln_density: Vec<f64>,
    /// mean acceptance probability of the trajectory
    pub acceptance_rate: Vec<f64>,
    /// step size in the rounded space
    pub step_size: Vec<f64>,
    /// doublings of the trajectory
    pub tree_depth: Vec<u64>,
    /// leapfrog steps of the trajectory
    pub steps: Vec<u64>,
    /// whether the energy ran away
    pub diverging: Vec<bool>,
    /// energy
    pub energy: Vec<f64>,
}

/// Why nothing could be sampled.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("chain {chain} could not be sampled: {reason}")]
pub struct SamplingFailure {
    /// from 1
    pub chain: usize,
    /// in words
    pub reason: String,
}

/// Kept draws whose trajectory diverged.
pub fn divergences(chains: &[Chain]) -> usize {
    chains
        .iter()
        .flat_map(|chain| &chain.diverging)
        .filter(|diverging| **diverging)
        .count()
}

/// Hears of every draw: whether it is kept, and whether it diverged.
pub type Watcher<'w> = &'w (dyn Fn(bool, bool) + Sync);

/// Samples every chain from a stream of its own: the same bytes for any number of threads.
///
/// Fails where the log density is lost in rounding, where a chain finds no start, or where the
/// sampler itself fails.
pub fn sample_chains<T: LogDensity + ?Sized>(
    target: &T,
    about: &Laplace,
    effort: Effort,
    streams: StreamName,
    watcher: Watcher,
) -> Result<Vec<Chain>, SamplingFailure> {
    let rounding = about.ln_density.abs() * f64::EPSILON;
    if rounding > MOST_ROUNDING {
        return Err(SamplingFailure {
            chain: 1,
            reason: format!(
                "the log density at the mode is {:.1e}, of which rounding leaves {rounding:.0e}; a prior or a spread is held \
                 far too tightly for these runs",
                about.ln_density
            ),
        });
    }
    let sampler = ChainSampler {
        target,
        about,
        effort,
        watcher,
    };
    let one = |chain: usize| {
        let index = chain as u64;
        let sampled = sampler.chain(index, streams.at(index));
        sampled.map_err(|reason| SamplingFailure {
            chain: chain + 1,
            reason,
        })
    };
    (0..effort.chains).into_par_iter().map(one).collect()
}

/// A log density with what every chain samples it by.
struct ChainSampler<'s, T: ?Sized> {
    target: &'s T,
    about: &'s Laplace,
    effort: Effort,
    watcher: Watcher<'s>,
}

impl<T: LogDensity + ?Sized> ChainSampler<'_, T> {
    /// Samples one chain, by its number from 0.
    fn chain(&self, chain: u64, mut rng: ChaCha8Rng) -> Result<Chain, String> {
        let ChainSampler {
            target,
            about,
            effort,
            watcher,
        } = *self;
        let start = self.start(&mut rng).ok_or("no start near the mode has a density")?;
        let mut settings = DiagNutsSettings {
            num_tune: effort.warmup as u64,
            num_draws: effort.draws as u64,
            num_chains: effort.chains,
            maxdepth: LARGEST_DEPTH,
            ..DiagNutsSettings::default()
        };
        settings.adapt_options.step_size_settings.target_accept = effort.target_accept;
        let math = CpuMath::new(Rounded::new(target, about));
        let reason = |error: &dyn std::fmt::Display| error.to_string();
        let mut sampler = settings.new_chain(chain, math, &mut rng).map_err(|e| reason(&e))?;
        sampler.set_position(&start).map_err(|e| reason(&e))?;
        for _ in 0..effort.warmup {
            let (_, progress) = sampler.draw().map_err(|e| reason(&e))?;
            watcher(false, progress.diverging);
        }
        let mut kept = Chain::default();
        let mut point = vec![0.0; target.dimension()];
        for _ in 0..effort.draws {
            let (z, _, stats, progress) = sampler.expanded_draw().map_err(|e| reason(&e))?;
            watcher(true, progress.diverging);
            about.point(&z, &mut point);
            kept.points.extend_from_slice(&point);
            kept.ln_density.push(stats.point.logp);
            kept.acceptance_rate.push(stats.adapt.step_size.mean_tree_accept);
            kept.step_size.push(progress.step_size);
            kept.tree_depth.push(stats.depth);
            kept.steps.push(progress.num_steps);
            kept.diverging.push(progress.diverging);
            kept.energy.push(stats.point.energy);
        }
        Ok(kept)
    }

    /// A start about the mode, wider than the posterior where that has a density.
    fn start(&self, rng: &mut ChaCha8Rng) -> Option<Vec<f64>> {
        const WIDER: f64 = 1.5;
        const TRIES: i32 = 50;
        let mut point = vec![0.0; self.target.dimension()];
        let mut slopes = point.clone();
        (0..TRIES).find_map(|attempt| {
            let spread = WIDER * 0.8f64.powi(attempt);
            let z: Vec<f64> = (0..point.len())
                .map(|_| {
                    let z: f64 = StandardNormal.sample(rng);
                    spread * z
                })
                .collect();
            self.about.point(&z, &mut point);
            self.target.ln_density(&point, &mut slopes).is_ok().then_some(z)
        })
    }
}

/// The target as a function of z, where point = mode + S z.
struct Rounded<'t, T: ?Sized> {
    target: &'t T,
    about: &'t Laplace,
    point: Vec<f64>,
    slopes: Vec<f64>,
}

impl<'t, T: LogDensity + ?Sized> Rounded<'t, T> {
    fn new(target: &'t T, about: &'t Laplace) -> Self {
        let dimension = target.dimension();
        Rounded {
            target,
            about,
            point: vec![0.0; dimension],
            slopes: vec![0.0; dimension],
        }
    }
}

impl<T: ?Sized> HasDims for Rounded<'_, T> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.point.len() as u64)])
    }
}

/// No density at a point: the trajectory ends there as divergent, the chain goes on.
#[derive(Debug, thiserror::Error)]
#[error("outside the domain")]
struct Outside;

impl LogpError for Outside {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl<T: LogDensity + ?Sized> CpuLogpFunc for Rounded<'_, T> {
    type LogpError = Outside;
    type FlowParameters = ();
    type ExpandedVector = ();

    fn dim(&self) -> usize {
        self.point.len()
    }

    fn logp(&mut self, z: &[f64], gradient: &mut [f64]) -> Result<f64, Outside> {
        self.about.point(z, &mut self.point);
        let value = self.target.ln_density(&self.point, &mut self.slopes);
        let value = value.map_err(|OutsideDomain| Outside)?;
        self.about.slopes(&self.slopes, gradient);
        Ok(value)
    }

    fn expand_vector<R: rand::Rng + ?Sized>(&mut self, _: &mut R, _: &[f64]) -> Result<(), CpuMathError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
