//! Takes a scene's runs to draws of its posterior: start, compression, mode, chains, and the check of the compression.

use rayon::prelude::*;

use super::laplace::{laplace, Laplace};
use super::nuts::{divergences, sample, Chain, Effort, SamplingFailure, Watcher};
use crate::model::likelihood::{Compression, Likelihood};
use crate::model::parameters::{Kind, Parameters};
use crate::model::posterior::{LogDensity, Posterior};

/// Largest error of the log density that a compression may make over the posterior's region.
pub const LARGEST_ERROR: f64 = 1e-3;

/// Draws at which the sum over all rows is held against the compressed one.
pub const CHECKED: usize = 200;

/// How a posterior is to be sampled.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'p> {
    /// how much
    pub effort: Effort,
    /// seed and name of the chains' streams
    pub stream: (u64, &'p str),
    /// every row in every evaluation, instead of the compressed likelihood
    pub exact_rows: bool,
}

/// Draws of a posterior.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// the parameters
    pub parameters: Parameters,
    /// what each chain kept, in the unbounded space
    pub chains: Vec<Chain>,
    /// acceptance the step size was adapted to: the plan's, or nearer 1 where trajectories diverged with it
    pub target_accept: f64,
    /// the draws of each parameter in each chain: `values[parameter][chain][draw]`
    pub values: Vec<Vec<Vec<f64>>>,
    /// mode and curvature the chains started from
    pub laplace: Laplace,
    /// what was compressed; `None` if every row was used
    pub compression: Option<Compression>,
    /// largest difference between the sum over all rows and the compressed one at some of the draws
    pub checked_error: Option<f64>,
    /// seconds of compressing, of sampling and of checking
    pub seconds: [f64; 3],
}

/// Why there is no posterior.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoPosterior {
    /// the start has no density
    #[error("the posterior has no density at the least-squares estimates, nor at the medians of the priors")]
    NoStart,
    /// the sampler failed
    #[error(transparent)]
    Sampling(#[from] SamplingFailure),
}

/// Values a search for the mode may start from, by kind; what is missing starts at its prior's median.
pub type Start = Vec<(Kind, f64)>;

impl Sampled {
    /// Draws in all.
    pub fn draws(&self) -> usize {
        self.chains.iter().map(|chain| chain.ln_density.len()).sum()
    }

    /// Every draw as a full vector of parameters, chain after chain.
    pub fn full_draws(&self) -> Vec<Vec<f64>> {
        let kept = self.chains.iter().map(|chain| chain.ln_density.len());
        let places = kept
            .enumerate()
            .flat_map(|(chain, draws)| (0..draws).map(move |draw| (chain, draw)));
        places
            .map(|(chain, draw)| {
                let values: Vec<f64> = self.values.iter().map(|of| of[chain][draw]).collect();
                self.parameters.full(&values)
            })
            .collect()
    }
}

/// Samples the posterior of these parameters under the likelihood of all rows.
///
/// Fails where no start has a density or a chain cannot be sampled; divergent draws are kept and counted.
pub fn sample_posterior(
    parameters: Parameters,
    rows: &Likelihood,
    start: &Start,
    plan: Plan,
    watcher: Watcher,
) -> Result<Sampled, NoPosterior> {
    let began = std::time::Instant::now();
    let starts = starts(&parameters, start);
    let (posterior, about, compression) = if plan.exact_rows {
        let posterior = Posterior::new(parameters.clone(), rows.clone());
        let about = highest(&posterior, &starts)?;
        (posterior, about, None)
    } else {
        let (posterior, about, compression) = compressed(&parameters, rows, &starts)?;
        (posterior, about, Some(compression))
    };
    let compressed = began.elapsed().as_secs_f64();
    let (chains, target_accept) = without_divergences(&posterior, &about, plan, watcher)?;
    let sampled = began.elapsed().as_secs_f64();
    let dimension = posterior.dimension();
    let mut values = vec![vec![vec![]; chains.len()]; dimension];
    for (chain, kept) in chains.iter().enumerate() {
        for point in kept.points.chunks_exact(dimension.max(1)) {
            for (of, value) in values.iter_mut().zip(posterior.draw_at(point)) {
                of[chain].push(value);
            }
        }
    }
    let checked_error = compression.map(|_| largest_difference(&posterior, rows, &chains));
    Ok(Sampled {
        parameters,
        chains,
        target_accept,
        values,
        laplace: about,
        compression,
        checked_error,
        seconds: [
            compressed,
            sampled - compressed,
            began.elapsed().as_secs_f64() - sampled,
        ],
    })
}

/// Samples anew with shorter steps as long as trajectories diverge, as they may where few runs leave σ wide open.
fn without_divergences(
    posterior: &Posterior,
    about: &Laplace,
    plan: Plan,
    watcher: Watcher,
) -> Result<(Vec<Chain>, f64), SamplingFailure> {
    const SHORTER: [f64; 2] = [0.95, 0.995];
    let with = |target_accept: f64| {
        let effort = Effort {
            target_accept,
            ..plan.effort
        };
        sample(posterior, about, effort, plan.stream, watcher)
    };
    let mut target_accept = plan.effort.target_accept;
    let mut chains = with(target_accept)?;
    for shorter in SHORTER
        .into_iter()
        .filter(|shorter| *shorter > plan.effort.target_accept)
    {
        if divergences(&chains) == 0 {
            break;
        }
        target_accept = shorter;
        chains = with(target_accept)?;
    }
    Ok((chains, target_accept))
}

/// The least-squares start, and the medians of the priors for the case that it is no good.
fn starts(parameters: &Parameters, start: &Start) -> [Vec<f64>; 2] {
    let medians: Vec<f64> = parameters.sampled.iter().map(|p| p.prior.median()).collect();
    let given = parameters.sampled.iter().zip(&medians).map(|(parameter, median)| {
        let found = start.iter().find(|(kind, _)| *kind == parameter.kind);
        found.map_or(*median, |(_, value)| *value)
    });
    [given.collect(), medians]
}

/// The highest mode that the starts lead to.
fn highest(posterior: &Posterior, starts: &[Vec<f64>]) -> Result<Laplace, NoPosterior> {
    let modes = starts
        .iter()
        .filter_map(|start| laplace(posterior, &posterior.point_at(start)).ok());
    // the earlier start wins a tie
    let best = modes.reduce(|a, b| if b.ln_density > a.ln_density + 1e-6 { b } else { a });
    best.ok_or(NoPosterior::NoStart)
}

/// The compressed posterior with its mode: first roughly, to learn where the posterior lies, then to the bound there.
///
/// With very many runs the rough one may lie many standard deviations off; then the bound was kept in the wrong place,
/// and the rows are compressed again about the new mode until it stays.
fn compressed(
    parameters: &Parameters,
    rows: &Likelihood,
    starts: &[Vec<f64>],
) -> Result<(Posterior, Laplace, Compression), NoPosterior> {
    /// each time the mode is nearer by orders of magnitude
    const TRIES: usize = 8;
    let reference = parameters.full(&starts[0]);
    let (rough, _) = rows.compressed(&reference, &[], LARGEST_ERROR);
    let mut posterior = Posterior::new(parameters.clone(), rough);
    let mut about = highest(&posterior, starts)?;
    let mut tries = 0;
    loop {
        tries += 1;
        let full = |point: &[f64]| parameters.full(&posterior.draw_at(point));
        let tests = region(&about).iter().map(|point| full(point)).collect::<Vec<_>>();
        let (likelihood, compression) = rows.compressed(&full(&about.mode), &tests, LARGEST_ERROR);
        posterior = Posterior::new(parameters.clone(), likelihood);
        let next = laplace(&posterior, &about.mode).map_err(|_| NoPosterior::NoStart)?;
        let stays = next.distance(&about.mode).is_some_and(|moved| moved < 1.0);
        about = next;
        if stays || tries == TRIES {
            return Ok((posterior, about, compression));
        }
    }
}

/// Points two and six standard deviations from the mode, along each axis of the rounded space.
fn region(about: &Laplace) -> Vec<Vec<f64>> {
    const FAR: [f64; 4] = [-6.0, -2.0, 2.0, 6.0];
    let dimension = about.mode.len();
    let mut points = vec![];
    for axis in 0..dimension {
        for far in FAR {
            let mut z = vec![0.0; dimension];
            z[axis] = far;
            let mut point = z.clone();
            about.point(&z, &mut point);
            points.push(point);
        }
    }
    points
}

/// Largest difference of the log density between all rows and the nodes, at draws spread over the chains.
fn largest_difference(posterior: &Posterior, rows: &Likelihood, chains: &[Chain]) -> f64 {
    let dimension = posterior.dimension();
    let points: Vec<&[f64]> = chains
        .iter()
        .flat_map(|chain| chain.points.chunks_exact(dimension.max(1)))
        .collect();
    let step = points.len().div_ceil(CHECKED).max(1);
    let checked: Vec<&[f64]> = points.into_iter().step_by(step).collect();
    let difference = |point: &&[f64]| {
        let full = posterior.parameters().full(&posterior.draw_at(point));
        let mut slopes = vec![0.0; full.len()];
        let exact = rows.ln_density(&full, &mut slopes);
        let short = posterior.likelihood().ln_density(&full, &mut slopes);
        match (exact, short) {
            (Ok(exact), Ok(short)) => (exact - short).abs(),
            _ => f64::INFINITY,
        }
    };
    checked.par_iter().map(difference).reduce(|| 0.0, f64::max)
}
