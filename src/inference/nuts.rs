//! Samples a log density by the No-U-Turn sampler; the only file that names the crate that has it.
//!
//! The space is first made round with the curvature at the mode: then neither correlation nor scale of the parameters
//! costs steps, and adaptation has little left to do. Where trajectories are long even so, as the offsets of series make them
//! whose spread is not that of the mode, a chain goes on in a space in which its own first draws are round.

use std::collections::HashMap;
use std::sync::mpsc::channel;

use nalgebra::{DMatrix, DVector};
use nuts_rs::{Chain as _, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings as _};
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

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

/// What one chain kept. A column has one number a draw, `points` several; where no trajectory was followed, those of
/// trajectories are empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Chain {
    /// the points, one after the other, as many numbers each as there are dimensions
    pub points: Vec<f64>,
    /// log density at the point
    pub ln_density: Vec<f64>,
    /// the same less that of the proposal it was drawn from, up to a constant; empty where there was none
    pub ln_ratio: Vec<f64>,
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

impl Chain {
    /// Adds the draws that came after.
    fn append(&mut self, later: Chain) {
        self.points.extend(later.points);
        self.ln_density.extend(later.ln_density);
        self.acceptance_rate.extend(later.acceptance_rate);
        self.step_size.extend(later.step_size);
        self.tree_depth.extend(later.tree_depth);
        self.steps.extend(later.steps);
        self.diverging.extend(later.diverging);
        self.energy.extend(later.energy);
    }
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

/// How something is sampled.
#[derive(Clone, Copy)]
pub struct SamplingPlan<'p> {
    /// how much, at first
    pub effort: Effort,
    /// the chains' streams
    pub streams: StreamName<'p>,
    /// hears of every draw
    pub watcher: Watcher<'p>,
}

impl<'p> SamplingPlan<'p> {
    /// With nobody to hear of the draws.
    pub fn new(effort: Effort, streams: StreamName<'p>) -> SamplingPlan<'p> {
        SamplingPlan {
            effort,
            streams,
            watcher: &|_, _| (),
        }
    }
}

/// Samples every chain from a stream of its own, and draws on: `more` sees what was kept so far and says how many draws each
/// chain is to add, none to end. The same bytes for any number of threads; a chain that is drawn on keeps the draws it would
/// have kept at once.
///
/// Fails where the log density is lost in rounding, where a chain finds no start, where the system gives no thread, or where
/// the sampler itself fails.
pub fn sample_chains<T: LogDensity + ?Sized>(
    target: &T,
    about: &Laplace,
    plan: SamplingPlan,
    more: &mut dyn FnMut(&[Chain]) -> usize,
) -> Result<Vec<Chain>, SamplingFailure> {
    check_rounding(about)?;
    let all = plan.effort.chains;
    std::thread::scope(|scope| {
        // a chain of the sampler's crate cannot change its thread: each stays where it began, and waits there
        let threads = rayon::current_num_threads().min(all).max(1);
        let start = |first: usize| {
            let (ask, asked) = channel::<usize>();
            let (give, blocks) = channel();
            let draw = move || {
                let start = |chain| (chain, OngoingChain::start(target, about, plan, chain as u64));
                let mut chains: Vec<_> = (first..all).step_by(threads).map(start).collect();
                for draws in asked {
                    for (chain, ongoing) in &mut chains {
                        let block = ongoing.as_mut().map_err(|why| why.clone());
                        // nobody listens any more where a chain of another thread failed
                        let _ = give.send((*chain, block.and_then(|ongoing| ongoing.draw(draws))));
                    }
                }
            };
            let thread = std::thread::Builder::new().spawn_scoped(scope, draw);
            thread.map(|_| (ask, blocks)).map_err(|error| SamplingFailure {
                chain: first + 1,
                reason: error.to_string(),
            })
        };
        let workers = (0..threads).map(start).collect::<Result<Vec<_>, _>>()?;
        let mut kept = vec![Chain::default(); all];
        let mut draws = plan.effort.draws;
        while draws > 0 {
            for (ask, _) in &workers {
                // a thread that is gone has panicked, which the end of the scope passes on
                let _ = ask.send(draws);
            }
            let blocks = (0..all).filter_map(|chain| workers[chain % threads].1.recv().ok());
            for (chain, block) in blocks.collect::<Vec<(usize, Result<Chain, String>)>>() {
                kept[chain].append(block.map_err(|reason| SamplingFailure {
                    chain: chain + 1,
                    reason,
                })?);
            }
            draws = more(&kept);
        }
        Ok(kept)
    })
}

/// Fails where rounding would move the log density.
fn check_rounding(about: &Laplace) -> Result<(), SamplingFailure> {
    let rounding = about.ln_density.abs() * f64::EPSILON;
    if rounding <= MOST_ROUNDING {
        return Ok(());
    }
    Err(SamplingFailure {
        chain: 1,
        reason: format!(
            "the log density at the mode is {:.1e}, of which rounding leaves {rounding:.0e}; a prior or a spread is held \
             far too tightly for these runs",
            about.ln_density
        ),
    })
}

/// A chain that has adapted and can be drawn on.
struct OngoingChain<'s, T: LogDensity + ?Sized> {
    about: Laplace,
    watcher: Watcher<'s>,
    chain: <DiagNutsSettings as nuts_rs::Settings>::Chain<CpuMath<Rounded<'s, T>>>,
}

impl<'s, T: LogDensity + ?Sized> OngoingChain<'s, T> {
    /// Starts one chain, by its number from 0, and has it adapt.
    fn start(target: &'s T, about: &'s Laplace, plan: SamplingPlan<'s>, chain: u64) -> Result<Self, String> {
        let SamplingPlan {
            effort,
            streams,
            watcher,
        } = plan;
        let mut rng = streams.at(chain);
        let mut start = start_near(target, about, &mut rng).ok_or("no start near the mode has a density")?;
        let mut about = about.clone();
        let mut settings = DiagNutsSettings {
            num_draws: effort.draws as u64,
            num_chains: effort.chains,
            maxdepth: LARGEST_DEPTH,
            ..DiagNutsSettings::default()
        };
        settings.adapt_options.step_size_settings.target_accept = effort.target_accept;
        let reason = |error: &dyn std::fmt::Display| error.to_string();
        let mut left = effort.warmup;
        loop {
            settings.num_tune = left as u64;
            let zeros = vec![0.0; target.dimension()];
            let math = CpuMath::new(Rounded {
                target,
                about: about.clone(),
                point: zeros.clone(),
                slopes: zeros,
            });
            let mut chain = settings.new_chain(chain, math, &mut rng).map_err(|e| reason(&e))?;
            chain.set_position(&start).map_err(|e| reason(&e))?;
            let mut first = FirstDraws::default();
            while left > 0 && !(first.are_enough() && first.are_long() && left > FIRST) {
                let (z, progress) = chain.draw().map_err(|e| reason(&e))?;
                watcher(false, progress.diverging);
                first.see(&z, progress.num_steps);
                left -= 1;
            }
            match first.rounder(&about).filter(|_| left > 0) {
                Some(rounder) => (about, start) = rounder,
                None => return Ok(OngoingChain { about, watcher, chain }),
            }
        }
    }

    /// Draws so many times more, and keeps the draws.
    fn draw(&mut self, draws: usize) -> Result<Chain, String> {
        let mut kept = Chain::default();
        let mut point = vec![0.0; self.about.mode.len()];
        for _ in 0..draws {
            let (z, _, stats, progress) = self.chain.expanded_draw().map_err(|e| e.to_string())?;
            (self.watcher)(true, progress.diverging);
            self.about.point(&z, &mut point);
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
}

/// Draws after which a chain whose trajectories are long goes on in a rounder space, and those of them that are not looked at.
const FIRST: usize = 150;
const BEFORE: usize = 50;

/// Steps of a trajectory from which on it is long.
const LONG: f64 = 15.0;

/// What the first draws of a chain tell of the space.
#[derive(Default)]
struct FirstDraws {
    seen: usize,
    steps: u64,
    draws: Vec<DVector<f64>>,
}

impl FirstDraws {
    fn see(&mut self, z: &[f64], steps: u64) {
        self.seen += 1;
        if (BEFORE..FIRST).contains(&self.seen) {
            self.steps += steps;
            self.draws.push(DVector::from_column_slice(z));
        }
    }

    fn are_enough(&self) -> bool {
        self.seen >= FIRST
    }

    fn are_long(&self) -> bool {
        self.steps as f64 > LONG * self.draws.len() as f64
    }

    /// The space in which these draws are round, with the last of them in it: their covariance, drawn to that of the space they
    /// were made in by as many draws as there are dimensions. `None` where they are no such draws.
    fn rounder(&self, about: &Laplace) -> Option<(Laplace, Vec<f64>)> {
        let last = self.draws.last().filter(|_| self.are_enough() && self.are_long())?;
        let (draws, dimension) = (self.draws.len() as f64, last.len());
        let mean = self.draws.iter().sum::<DVector<f64>>() / draws;
        let mut squares = DMatrix::identity(dimension, dimension) * dimension as f64;
        for draw in &self.draws {
            let apart = draw - &mean;
            squares.ger(1.0, &apart, &apart, 1.0);
        }
        let root = (squares / (draws + dimension as f64)).cholesky()?.l();
        let start = root.solve_lower_triangular(&(last - &mean))?;
        let middle = DVector::from_column_slice(&about.mode) + &about.scale * mean;
        let rounder = Laplace {
            mode: middle.as_slice().to_vec(),
            scale: &about.scale * root,
            ..about.clone()
        };
        Some((rounder, start.as_slice().to_vec()))
    }
}

/// A start about the mode, wider than the posterior where that has a density.
fn start_near<T: LogDensity + ?Sized>(target: &T, about: &Laplace, rng: &mut ChaCha8Rng) -> Option<Vec<f64>> {
    const WIDER: f64 = 1.5;
    const TRIES: i32 = 50;
    let mut point = vec![0.0; target.dimension()];
    let mut slopes = point.clone();
    (0..TRIES).find_map(|attempt| {
        let spread = WIDER * 0.8f64.powi(attempt);
        let mut normal = || spread * Distribution::<f64>::sample(&StandardNormal, rng);
        let z: Vec<f64> = (0..point.len()).map(|_| normal()).collect();
        about.point(&z, &mut point);
        target.ln_density(&point, &mut slopes).is_ok().then_some(z)
    })
}

/// The target as a function of z, where point = mode + S z.
struct Rounded<'t, T: ?Sized> {
    target: &'t T,
    about: Laplace,
    point: Vec<f64>,
    slopes: Vec<f64>,
}

impl<T: ?Sized> HasDims for Rounded<'_, T> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.point.len() as u64)])
    }
}

/// No density at a point: the trajectory ends there as divergent, the chain goes on.
impl LogpError for OutsideDomain {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl<T: LogDensity + ?Sized> CpuLogpFunc for Rounded<'_, T> {
    type LogpError = OutsideDomain;
    type FlowParameters = ();
    type ExpandedVector = ();

    fn dim(&self) -> usize {
        self.point.len()
    }

    fn logp(&mut self, z: &[f64], gradient: &mut [f64]) -> Result<f64, OutsideDomain> {
        self.about.point(z, &mut self.point);
        let value = self.target.ln_density(&self.point, &mut self.slopes)?;
        self.about.slopes(&self.slopes, gradient);
        Ok(value)
    }

    fn expand_vector<R: rand::Rng + ?Sized>(&mut self, _: &mut R, _: &[f64]) -> Result<(), CpuMathError> {
        Ok(())
    }
}

#[cfg(test)]
pub(super) mod tests;
