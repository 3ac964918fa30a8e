//! Draws from a posterior as cheaply as an accuracy allows: the first method whose own check vouches for it.
//!
//! The methods in their order: the normal about the mode, the same resampled by importance weights, the No-U-Turn sampler.
//! The accuracy is the largest error of any parameter's mean, in posterior sds, and of any sd, relative. A Monte Carlo error
//! counts [`SURE`] times.

use super::diagnostics::pareto::khat_threshold;
use super::importance::{weighted_shift, DrawCounts, ProposalTails, Weights};
use super::mixing::{draws_a_chain, summary_of, MixingLines, ParameterDraws};
use super::nuts::{SamplingFailure, SamplingPlan};
use super::prepared_posterior::PreparedPosterior;
use super::sampling::{
    sample_by_importance, sample_by_nuts, sample_normal, Method, ReachedAccuracy, RejectedMethod, Sampled, PROPOSED,
};
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

/// Samples a prepared posterior until no mean is off by more than `accuracy` posterior sds, and no sd by such a share; the plan's
/// number of draws does not count.
///
/// Fails where the sampler does. Where no method reaches the accuracy, the last one's draws come with the error they can
/// vouch for.
pub fn sample_to_accuracy(
    prepared: &PreparedPosterior,
    accuracy: f64,
    plan: SamplingPlan,
) -> Result<Sampled, SamplingFailure> {
    let search = MethodSearch {
        prepared,
        accuracy,
        plan,
    };
    let mut tried = vec![];
    let (sampled, vouched) = match search.about_the_mode(&mut tried) {
        Some(found) => found,
        None => search.nuts()?,
    };
    Ok(Sampled {
        accuracy: Some(ReachedAccuracy {
            requested: accuracy,
            vouched: Some(vouched).filter(|error| error.is_finite()),
            tried,
        }),
        ..sampled
    })
}

/// Draws, and the error that they vouch for.
type Vouched = (Sampled, f64);

/// The search for the cheapest method that reaches an accuracy.
struct MethodSearch<'p> {
    prepared: &'p PreparedPosterior,
    accuracy: f64,
    plan: SamplingPlan<'p>,
}

impl MethodSearch<'_> {
    /// The normal about the mode, or its weighted draws, if either can be vouched for; else why not.
    fn about_the_mode(&self, tried: &mut Vec<RejectedMethod>) -> Option<Vouched> {
        let error = normal_error(self.prepared, self.plan.streams);
        let mut attempt = |method, draw: &dyn Fn(NormalError) -> Result<Vouched, String>| {
            let found = error.clone().and_then(draw);
            found.map_err(|why| tried.push(RejectedMethod { method, why })).ok()
        };
        attempt(Method::Laplace, &|error| self.laplace(error))
            .or_else(|| attempt(Method::LaplacePsis, &|error| self.laplace_psis(error)))
    }

    /// The normal about the mode, or why it cannot be vouched for.
    fn laplace(&self, error: NormalError) -> Result<Vouched, String> {
        let off = error.largest;
        // half of the accuracy for the normal's own error, half for the number of its draws
        if off > 0.5 * self.accuracy {
            return Err(format!(
                "the normal is off by up to {off:.2}, more than half of what was asked for"
            ));
        }
        let each = self.each((SURE / (self.accuracy - off)).powi(2));
        self.checked(sample_normal(self.prepared, self.size(each), self.plan.streams), off)
            .map_err(|vouched| {
                format!("its draws are too few, or leave an error of {vouched:.2}, with its own of {off:.2}")
            })
    }

    /// The same by importance weights.
    fn laplace_psis(&self, error: NormalError) -> Result<Vouched, String> {
        /// each corrects what the one before it found missing
        const TRIES: usize = 4;
        let requested = self.accuracy;
        let resampled = 1.0 + 1.0 / (PROPOSED as f64 * error.efficiency);
        let mut wanted = (SURE / requested).powi(2) * resampled;
        let mut why = String::new();
        for _ in 0..TRIES {
            let each = self.each(wanted);
            let draws = self.plan.effort.chains * each;
            let sampled = sample_by_importance(self.prepared, self.size(each), self.plan.streams)
                .ok_or("the densities allow no weights")?;
            let (khat, line) = (sampled.khat.unwrap_or(f64::INFINITY), khat_threshold(draws));
            if khat > line {
                return Err(format!("importance weights have the shape {khat:.2}, above {line:.2}"));
            }
            match self.checked(sampled, 0.0) {
                Ok(found) => return Ok(found),
                Err(vouched) => {
                    why = format!("{draws} draws are too few, or leave an error of {vouched:.2}");
                    // draws whose error will do may yet be too few for what is asked of the tails
                    wanted = 1.1 * draws as f64 * (vouched / requested).powi(2).max(1.2);
                }
            }
        }
        Err(why)
    }

    /// Trajectories, drawn on until the accuracy is reached or is out of reach.
    fn nuts(&self) -> Result<Vouched, SamplingFailure> {
        let lines = asked_of_draws(Method::Nuts, self.plan.effort.chains, Some(self.accuracy));
        let mut more = |values: &ParameterDraws| {
            let error = error_of_draws(values);
            let made = draws_a_chain(values);
            // draws that say nothing of their error are doubled
            let times = match error.is_finite() {
                true => 1.1 * (error / self.accuracy).powi(2),
                false => 2.0,
            };
            let next = made as f64 * times.max(1.1);
            let enough = error <= self.accuracy && lines.hold(values, 1.0);
            // chains that do not agree, or so slow that not even the most draws would do, are not followed further
            if enough || next > MOST_DRAWS as f64 || !chains_agree(values) {
                return 0;
            }
            next.ceil() as usize - made
        };
        let mut plan = self.plan;
        plan.effort.draws = self.each((SURE / self.accuracy).powi(2));
        let sampled = sample_by_nuts(self.prepared, plan, &mut more)?;
        let vouched = monte_carlo_error(&sampled);
        Ok((sampled, vouched))
    }

    /// Draws with the error they vouch for beside one of the method's own, where the accuracy is reached; else that error.
    fn checked(&self, sampled: Sampled, own: f64) -> Result<Vouched, f64> {
        let requested = self.accuracy;
        let vouched = monte_carlo_error(&sampled) + own;
        let lines = asked_of_draws(sampled.method, self.plan.effort.chains, Some(requested));
        let enough = lines.hold(&sampled.values, sampled.mcse_factor);
        match vouched <= requested && enough {
            true => Ok((sampled, vouched)),
            false => Err(vouched),
        }
    }

    fn size(&self, each: usize) -> DrawCounts {
        DrawCounts {
            chains: self.plan.effort.chains,
            draws: each,
        }
    }

    /// Draws a chain for so many in all.
    fn each(&self, all: f64) -> usize {
        ((all / self.plan.effort.chains as f64).ceil() as usize).clamp(FEWEST_DRAWS, MOST_DRAWS)
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
    if !prepared.about.is_at_peak() {
        return Err("the posterior has no peak to lay a normal about".to_owned());
    }
    let size = DrawCounts {
        chains: 1,
        draws: PILOT,
    };
    let pilot = prepared.propose(ProposalTails::Normal, size, stream, "pilot");
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
    let mut each = values.iter().map(|values| summary_of(values).rhat);
    each.all(|rhat| rhat.is_some_and(|rhat| rhat <= LOST))
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
        rhat: (method == Method::Nuts).then_some(LOST),
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
