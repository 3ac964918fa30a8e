//! Draws from a posterior as cheaply as an accuracy allows: the first method whose own check vouches for it.
//!
//! The methods in their order: the normal about the mode, the same resampled by importance weights, the No-U-Turn sampler
//! on nodes, the same on every row. The accuracy is the largest error of any parameter's mean, in posterior sds, and of any
//! sd, relative. A Monte Carlo error counts [`SURE`] times.

use super::diagnostics::pareto::khat_threshold;
use super::diagnostics::rhat::rhat;
use super::importance::{propose, weighted_shift, DrawCounts, Proposal, Weights};
use super::mixing::{draws_a_chain, summary_of, MixingLines, ParameterDraws};
use super::nuts::{Effort, Watcher};
use super::prepared_posterior::{Evaluation, PreparedPosterior, Start, LARGEST_ERROR};
use super::sampling::{sample_normal, Method, NoPosterior, NutsSampling, ReachedAccuracy, Sampled};
use super::weighing::{sample_by_importance, PROPOSED};
use crate::model::likelihood::{Likelihood, Resolution};
use crate::model::parameters::ModelParameters;
use crate::model::posterior::LogDensity;
use crate::seed::StreamName;

/// Monte Carlo errors that stand for the error that is not exceeded: one in a thousand is.
pub const SURE: f64 = 3.3;

/// Accuracies that may be requested: below, draws would fill the memory; above, they would say nothing.
pub const RANGE: (f64, f64) = (0.005, 1.0);

/// Draws from the normal by which its error is estimated.
const PILOT: usize = 2000;

/// The fewest draws a chain keeps: fewer leave nothing to assess them by.
const FEWEST_DRAWS: usize = 250;

/// The most draws a chain keeps: nearly twice what the finest accuracy takes where draws are independent and chains four.
const MOST_DRAWS: usize = 200_000;

/// How a posterior is to be sampled to an accuracy.
#[derive(Debug, Clone, Copy)]
pub struct AccuracyPlan<'p> {
    /// the largest error of any mean, in posterior sds, and of any sd, relative
    pub accuracy: f64,
    /// the chains and their adaptation; the number of draws does not count
    pub effort: Effort,
    /// the chains' streams
    pub stream: StreamName<'p>,
}

/// Samples the posterior of these parameters under the likelihood of all rows to an accuracy.
///
/// Fails as [`super::sampling::sample_posterior`] does. Where no method reaches the accuracy, the last one's draws come with
/// the error it can vouch for.
pub fn sample_to_accuracy(
    parameters: ModelParameters,
    rows: &Likelihood,
    start: &Start,
    plan: AccuracyPlan,
    watcher: Watcher,
) -> Result<Sampled, NoPosterior> {
    // an error of the log density moves no mean by more than as many sds
    let bound = LARGEST_ERROR.min(0.1 * plan.accuracy);
    let compressed = Evaluation::Compressed(Resolution::Bound(bound));
    let prepared = PreparedPosterior::new(parameters.clone(), rows, start, compressed)?;
    let mut search = MethodSearch {
        requested: plan.accuracy,
        chains: plan.effort.chains,
        stream: plan.stream,
        tried: vec![],
    };
    if let Some(sampled) = search.about_the_mode(&prepared, bound) {
        return Ok(sampled);
    }
    let sampled = search.by_trajectories(&prepared, bound, plan.effort, watcher)?;
    if sampled.checked_error.is_none_or(|error| error <= bound) {
        return Ok(search.followed(sampled, bound));
    }
    search.tried.push((
        Method::NutsCompressed,
        "the log density of the nodes is off by more than a tenth of what was asked for".to_owned(),
    ));
    let prepared = PreparedPosterior::new(parameters, rows, start, Evaluation::Rows)?;
    let sampled = search.by_trajectories(&prepared, 0.0, plan.effort, watcher)?;
    Ok(search.followed(sampled, 0.0))
}

/// The search for the cheapest method that reaches an accuracy.
struct MethodSearch<'p> {
    requested: f64,
    chains: usize,
    stream: StreamName<'p>,
    /// methods that did not reach it, with the reason
    tried: Vec<(Method, String)>,
}

impl MethodSearch<'_> {
    /// The normal about the mode, or its weighted draws, if either can be vouched for.
    fn about_the_mode(&mut self, prepared: &PreparedPosterior, bound: f64) -> Option<Sampled> {
        let NormalError { largest, efficiency } = match normal_error(prepared, self.stream) {
            Ok(found) => found,
            Err(why) => {
                let both = [Method::Laplace, Method::LaplacePsis];
                self.tried.extend(both.map(|method| (method, why.clone())));
                return None;
            }
        };
        let off = largest + bound;
        // half of the accuracy for the normal's own error, half for the number of its draws
        if off <= 0.5 * self.requested {
            let each = self.each((SURE / (self.requested - off)).powi(2));
            let sampled = sample_normal(prepared, self.size(each), self.stream);
            let vouched = monte_carlo_error(&sampled) + off;
            if self.holds(&sampled, vouched, bound) {
                return Some(self.done(sampled, vouched));
            }
            let why = format!("its draws are too few, or leave an error of {vouched:.2}, with its own of {off:.2}");
            self.tried.push((Method::Laplace, why));
        } else {
            let why = format!("the normal is off by up to {off:.2}, more than half of what was asked for");
            self.tried.push((Method::Laplace, why));
        }
        let mut wanted = (SURE / (self.requested - bound)).powi(2) * (1.0 + 1.0 / (PROPOSED as f64 * efficiency));
        /// each corrects what the one before it found missing
        const TRIES: usize = 4;
        let mut why = "the densities allow no weights".to_owned();
        for _ in 0..TRIES {
            let each = self.each(wanted);
            let Some(sampled) = sample_by_importance(prepared, self.size(each), self.stream) else {
                break;
            };
            let (khat, line) = (
                sampled.khat.unwrap_or(f64::INFINITY),
                khat_threshold(self.chains * each),
            );
            if khat > line {
                why = format!("importance weights have the shape {khat:.2}, above {line:.2}");
                break;
            }
            let vouched = monte_carlo_error(&sampled) + bound;
            if self.holds(&sampled, vouched, bound) {
                return Some(self.done(sampled, vouched));
            }
            why = format!(
                "{} draws are too few, or leave an error of {vouched:.2}",
                self.chains * each
            );
            // draws whose error will do may yet be too few for what is asked of the tails
            wanted = 1.1 * (self.chains * each) as f64 * (vouched / self.requested).powi(2).max(1.2);
        }
        self.tried.push((Method::LaplacePsis, why));
        None
    }

    /// Whether the accuracy is reached, the nodes with it.
    fn holds(&self, sampled: &Sampled, vouched: f64, bound: f64) -> bool {
        let lines = asked_of_draws(sampled.method, self.chains, Some(self.requested));
        vouched <= self.requested
            && sampled.checked_error.is_none_or(|error| error <= bound)
            && lines.hold(&sampled.values, sampled.mcse_factor)
    }

    fn size(&self, each: usize) -> DrawCounts {
        DrawCounts {
            chains: self.chains,
            draws: each,
        }
    }

    /// Draws a chain for so many in all.
    fn each(&self, all: f64) -> usize {
        ((all / self.chains as f64).ceil() as usize).clamp(FEWEST_DRAWS, MOST_DRAWS)
    }

    /// Trajectories, drawn on until the accuracy is reached or is out of reach.
    fn by_trajectories(
        &self,
        prepared: &PreparedPosterior,
        bound: f64,
        effort: Effort,
        watcher: Watcher,
    ) -> Result<Sampled, NoPosterior> {
        let left = self.requested - bound;
        let lines = asked_of_draws(Method::NutsCompressed, self.chains, Some(self.requested));
        let first = self.each((SURE / left).powi(2));
        let mut more = |values: &ParameterDraws| {
            let error = error_of_draws(values);
            let made = draws_a_chain(values);
            // draws that say nothing of their error are doubled
            let times = if error.is_finite() {
                1.1 * (error / left).powi(2)
            } else {
                2.0
            };
            let next = made as f64 * times.max(1.1);
            let enough = error <= left && lines.hold(values, 1.0);
            // chains that do not agree, or so slow that not even the most draws would do, are not followed further
            if enough || next > MOST_DRAWS as f64 || !chains_agree(values) {
                return 0;
            }
            next.ceil() as usize - made
        };
        let sampling = NutsSampling {
            prepared,
            effort: Effort { draws: first, ..effort },
            stream: self.stream,
            watcher,
        };
        Ok(sampling.sample_while(&mut more)?)
    }

    /// What trajectories gave, with the error they vouch for.
    fn followed(mut self, sampled: Sampled, bound: f64) -> Sampled {
        let vouched = match sampled.checked_error {
            Some(error) if error > bound => f64::INFINITY,
            _ => monte_carlo_error(&sampled) + bound,
        };
        self.done(sampled, vouched)
    }

    fn done(&mut self, sampled: Sampled, vouched: f64) -> Sampled {
        Sampled {
            accuracy: Some(ReachedAccuracy {
                requested: self.requested,
                vouched,
                tried: std::mem::take(&mut self.tried),
            }),
            ..sampled
        }
    }
}

/// How far the normal about the mode is from the posterior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalError {
    /// its largest error, as the accuracy counts it
    pub largest: f64,
    /// how many independent draws of the posterior one of its own is worth
    pub efficiency: f64,
}

/// Estimates the error of the normal about the mode from a few draws; fails with the reason where they do not give it.
pub fn normal_error(prepared: &PreparedPosterior, stream: StreamName) -> Result<NormalError, String> {
    if !(prepared.about.converged && prepared.about.peaked) {
        return Err("the posterior has no peak to lay a normal about".to_owned());
    }
    let name = format!("{} pilot", stream.name);
    let size = DrawCounts {
        chains: 1,
        draws: PILOT,
    };
    let stream = StreamName::new(stream.seed, &name);
    let pilot = propose(&prepared.posterior, &Proposal::Normal(&prepared.about), size, stream);
    let Some(weights) = Weights::of(&pilot) else {
        return Err("the posterior has no density near the normal's draws".to_owned());
    };
    let line = khat_threshold(PILOT);
    if weights.khat > line {
        return Err(format!(
            "importance weights have the shape {:.2}, above {line:.2}: the normal does not reach the posterior's tails",
            weights.khat
        ));
    }
    Ok(NormalError {
        largest: largest_shift(prepared, &pilot[0].points, &weights.weights),
        efficiency: weights.effective() / PILOT as f64,
    })
}

/// The largest error that leaving the weights out makes, of any mean in sds and of any sd.
fn largest_shift(prepared: &PreparedPosterior, points: &[f64], weights: &[f64]) -> f64 {
    let dimension = prepared.posterior.dimension();
    let draws: Vec<Vec<f64>> = points
        .chunks_exact(dimension)
        .map(|point| prepared.posterior.draw_at(point))
        .collect();
    let of = |place: usize| {
        let values: Vec<f64> = draws.iter().map(|draw| draw[place]).collect();
        let found = weighted_shift(&values, weights);
        let mean = found.mean.abs() + SURE * found.mean_mcse;
        mean.max(found.sd.abs() + SURE * found.sd_mcse)
    };
    (0..dimension).map(of).fold(0.0, f64::max)
}

/// R-hat of chains that more draws would not bring together.
const LOST: f64 = 1.1;

/// Whether no parameter has an R-hat so far from 1 that more draws would not bring its chains together.
fn chains_agree(values: &ParameterDraws) -> bool {
    let agree = |values: &Vec<Vec<f64>>| {
        let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        rhat(&chains).is_ok_and(|rhat| rhat <= LOST)
    };
    values.iter().all(agree)
}

/// What is asked of draws that a method made, for an accuracy or without one.
///
/// An accuracy asks for the effective draws that leave its Monte Carlo error, and for no more than sampling without one
/// does; of chains only that they have come together, since their disagreement counts in the error that is vouched for.
/// Independent draws have no chains that could disagree.
pub fn asked_of_draws(method: Method, chains: usize, accuracy: Option<f64>) -> MixingLines {
    let usual = MixingLines::of_chains(chains);
    let Some(accuracy) = accuracy else {
        return usual;
    };
    MixingLines {
        rhat: method.is_nuts().then_some(LOST),
        effective: usual.effective.min((SURE / accuracy).powi(2)),
    }
}

/// [`SURE`] Monte Carlo errors of the mean in sds, or of the sd, of the parameter that has most; infinite where the draws
/// do not give it.
pub fn monte_carlo_error(sampled: &Sampled) -> f64 {
    error_of_draws(&sampled.values) * sampled.mcse_factor
}

/// The same, of draws that stand for themselves.
fn error_of_draws(values: &ParameterDraws) -> f64 {
    let of = |values: &Vec<Vec<f64>>| {
        let found = summary_of(values);
        match (found.sd, found.mcse_mean, found.mcse_sd) {
            (Some(sd), Some(mean), Some(of_sd)) if sd > 0.0 => mean.max(of_sd) / sd,
            _ => f64::INFINITY,
        }
    };
    SURE * values.iter().map(of).fold(0.0, f64::max)
}
