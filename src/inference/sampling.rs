//! Draws from a posterior by one of several methods.

use serde::{Deserialize, Serialize};

use super::importance::{DrawCounts, ProposalTails, Weights};
use super::mixing::ParameterDraws;
use super::nuts::{divergences, sample_chains, Chain, SamplingFailure, SamplingPlan, LARGEST_DEPTH};
use super::prepared_posterior::PreparedPosterior;
use crate::model::parameters::ModelParameters;
use crate::model::posterior::{LogDensity, PosteriorDensity};
use crate::seed::StreamName;

/// How draws were made, the cheapest method first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// from the normal about the mode
    Laplace,
    /// from Student's t of the same shape, resampled by Pareto-smoothed importance weights
    LaplacePsis,
    /// by the No-U-Turn sampler
    // as findings of earlier versions say
    #[serde(alias = "nuts_compressed", alias = "nuts_exact")]
    Nuts,
}

impl Method {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Method::Laplace => "laplace",
            Method::LaplacePsis => "laplace_psis",
            Method::Nuts => "nuts",
        }
    }
}

/// Draws that are made at most, over those asked for, where the chains have not mixed before.
pub const MOST_TIMES: usize = 8;

/// Steps of all trajectories beyond which chains are not drawn on; beyond half of them none is sampled anew.
const MOST_STEPS: u64 = 2_000_000;

/// A requested accuracy, and how it was reached.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ReachedAccuracy {
    /// the request
    #[serde(rename = "asked")]
    pub requested: f64,
    /// the error the method's own check vouches for; `None`: nothing
    pub vouched: Option<f64>,
    /// the methods tried before, cheapest first
    pub tried: Vec<RejectedMethod>,
}

/// A method that did not do.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct RejectedMethod {
    /// which
    pub method: Method,
    /// why it did not do
    pub why: String,
}

/// Draws of a posterior.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// the parameters
    pub parameters: ModelParameters,
    /// how they were drawn
    pub method: Method,
    /// what each chain kept, in the unbounded space; only points and densities where no trajectory was followed
    pub chains: Vec<Chain>,
    /// acceptance the step size was adapted to: the plan's, or nearer 1 where trajectories diverged with it
    pub target_accept: f64,
    /// the draws of each parameter in each chain: `values[parameter][chain][draw]`
    pub values: Vec<Vec<Vec<f64>>>,
    /// those of the offsets of r of each series; empty where series have none
    pub series_offsets: Vec<Vec<Vec<f64>>>,
    /// Pareto shape of the importance weights of the normal about the mode, where these were used
    pub khat: Option<f64>,
    /// Monte Carlo errors are so many times those of the draws alone; more than 1 where they were resampled
    pub mcse_factor: f64,
    /// the requested accuracy, and how it was reached
    pub accuracy: Option<ReachedAccuracy>,
    /// seconds of finding the mode and of sampling
    pub seconds: [f64; 2],
}

impl Sampled {
    /// Draws in all.
    pub fn draws(&self) -> usize {
        self.chains.iter().map(|chain| chain.ln_density.len()).sum()
    }

    /// Every draw as a full vector of parameters, chain after chain.
    pub fn full_draws(&self) -> Vec<Vec<f64>> {
        let columns = self.values.iter().chain(&self.series_offsets).map(|of| of.concat());
        let columns: Vec<Vec<f64>> = columns.collect();
        let draw = |place: usize| columns.iter().map(|column| column[place]).collect::<Vec<f64>>();
        (0..self.draws())
            .map(|place| self.parameters.full(&draw(place)))
            .collect()
    }

    /// What chains of points say of the parameters.
    fn of_chains(
        prepared: &PreparedPosterior,
        method: Method,
        chains: Vec<Chain>,
        began: std::time::Instant,
    ) -> Sampled {
        let posterior = &prepared.posterior;
        let mut values = parameter_draws(posterior, &chains);
        let series_offsets = values.split_off(posterior.parameters().sampled.len());
        Sampled {
            parameters: posterior.parameters().clone(),
            method,
            chains,
            target_accept: 0.0,
            values,
            series_offsets,
            khat: None,
            mcse_factor: 1.0,
            accuracy: None,
            seconds: [prepared.seconds, began.elapsed().as_secs_f64()],
        }
    }
}

/// The parameters, and the offsets after them, at the points of chains.
fn parameter_draws(posterior: &PosteriorDensity, chains: &[Chain]) -> Vec<Vec<Vec<f64>>> {
    let dimension = posterior.dimension();
    let mut values = vec![vec![vec![]; chains.len()]; dimension];
    for (chain, kept) in chains.iter().enumerate() {
        for point in kept.points.chunks_exact(dimension.max(1)) {
            for (of, value) in values.iter_mut().zip(posterior.draw_at(point)) {
                of[chain].push(value);
            }
        }
    }
    values
}

/// Samples a prepared posterior by the No-U-Turn sampler, and draws every chain on by so many draws as `more` says after seeing
/// those made, none to end; no further where two million steps are made, or most trajectories were cut at their largest depth.
///
/// Samples anew with shorter steps as long as trajectories diverge, as they may where few runs leave σ wide open. Fails where
/// no start has a density or a chain cannot be sampled; divergent draws that are left are kept and counted.
pub fn sample_by_nuts(
    prepared: &PreparedPosterior,
    plan: SamplingPlan,
    more: &mut dyn FnMut(&ParameterDraws) -> usize,
) -> Result<Sampled, SamplingFailure> {
    const SHORTER: [f64; 3] = [0.95, 0.995, 0.9995];
    let began = std::time::Instant::now();
    let posterior = &prepared.posterior;
    let mut effort = plan.effort;
    let mut shorter = SHORTER
        .into_iter()
        .filter(|shorter| *shorter > plan.effort.target_accept);
    loop {
        let next = shorter.next();
        // shorter steps make trajectories several times as long
        let anew = |chains: &[Chain]| {
            let is_long = mostly_cut(chains) || 2 * steps(chains) > MOST_STEPS;
            next.is_some() && divergences(chains) > 0 && !is_long
        };
        let chains = sample_chains(
            posterior,
            &prepared.about,
            SamplingPlan { effort, ..plan },
            &mut |chains| {
                // long trajectories cost most of all: more of them would take minutes, and those that are cut would not mix either
                if anew(chains) || mostly_cut(chains) || steps(chains) > MOST_STEPS {
                    0
                } else {
                    more(&parameter_draws(posterior, chains))
                }
            },
        )?;
        match next {
            Some(next) if anew(&chains) => effort.target_accept = next,
            _ => {
                return Ok(Sampled {
                    target_accept: effort.target_accept,
                    ..Sampled::of_chains(prepared, Method::Nuts, chains, began)
                })
            }
        }
    }
}

/// Draws from the normal about the mode of a prepared posterior, whatever the posterior has there.
pub fn sample_normal(prepared: &PreparedPosterior, size: DrawCounts, stream: StreamName) -> Sampled {
    let began = std::time::Instant::now();
    let chains = prepared.propose(ProposalTails::Normal, size, stream, "normal");
    Sampled::of_chains(prepared, Method::Laplace, chains, began)
}

/// Two points about the mode of a prepared posterior for each dimension, one ± of the normal there to either side: what a few
/// evaluations tell of it.
pub fn sample_about_the_mode(prepared: &PreparedPosterior) -> Sampled {
    let (about, dimension) = (&prepared.about, prepared.posterior.dimension());
    let mut chain = Chain::default();
    let (mut z, mut point) = (vec![0.0; dimension], vec![0.0; dimension]);
    for (place, sign) in (0..dimension).flat_map(|place| [(place, 1.0), (place, -1.0)]) {
        z.fill(0.0);
        z[place] = sign;
        about.point(&z, &mut point);
        chain.points.extend_from_slice(&point);
        chain.ln_density.push(about.ln_density - 0.5);
    }
    Sampled::of_chains(prepared, Method::Laplace, vec![chain], std::time::Instant::now())
}

/// Draws from Student's t for one that is kept after weighing.
pub const PROPOSED: usize = 2;

/// Draws from Student's t about the mode, resampled by what the posterior has there; `None` where the densities allow no
/// weights. `khat` says whether they are reliable.
pub fn sample_by_importance(prepared: &PreparedPosterior, size: DrawCounts, stream: StreamName) -> Option<Sampled> {
    let began = std::time::Instant::now();
    let dimension = prepared.posterior.dimension().max(1);
    let more = DrawCounts {
        draws: PROPOSED * size.draws,
        ..size
    };
    let proposed = prepared.propose(ProposalTails::Student, more, stream, "proposed");
    let weights = Weights::of(&proposed)?;
    let name = format!("{} resampled", stream.name);
    let mut rng = StreamName::new(stream.seed, &name).at(0);
    let kept = weights.resample(size.chains * size.draws, &mut rng);
    let points: Vec<&[f64]> = proposed
        .iter()
        .flat_map(|one| one.points.chunks_exact(dimension))
        .collect();
    let ln_density: Vec<f64> = proposed.iter().flat_map(|one| &one.ln_density).copied().collect();
    let chain = |kept: &[usize]| Chain {
        points: kept.iter().flat_map(|place| points[*place]).copied().collect(),
        ln_density: kept.iter().map(|place| ln_density[*place]).collect(),
        ..Chain::default()
    };
    let chains = kept.chunks(size.draws.max(1)).map(chain).collect();
    Some(Sampled {
        khat: Some(weights.khat),
        // the noise of choosing the draws adds to that of those there were to choose from
        mcse_factor: (1.0 + kept.len() as f64 / weights.effective()).sqrt(),
        ..Sampled::of_chains(prepared, Method::LaplacePsis, chains, began)
    })
}

/// Whether most trajectories ended at the largest depth: shorter steps would end nearer still, at the same cost.
fn mostly_cut(chains: &[Chain]) -> bool {
    let depths = || chains.iter().flat_map(|chain| &chain.tree_depth);
    2 * depths().filter(|depth| **depth >= LARGEST_DEPTH).count() > depths().count()
}

/// Steps of all trajectories that were kept.
fn steps(chains: &[Chain]) -> u64 {
    chains.iter().flat_map(|chain| &chain.steps).sum()
}
