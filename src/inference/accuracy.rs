//! Draws from a posterior as cheaply as an accuracy allows: the first way whose own check vouches for it.
//!
//! The ways in their order: the normal about the mode, the same resampled by importance weights, the No-U-Turn sampler on
//! nodes, the same on every row. The accuracy is the largest error of any parameter's mean, in posterior sds, and of any
//! sd, relative. A Monte Carlo error counts [`SURE`] times.

use super::diagnostics::pareto::khat_threshold;
use super::diagnostics::rhat::rhat;
use super::diagnostics::summary::summarise;
use super::importance::{normal_draws, shift, Weights};
use super::nuts::{Effort, Watcher};
use super::posed::{Evaluation, Posed, Start, LARGEST_ERROR};
use super::sampling::{by_normal, by_weights, follow, Accuracy, Method, NoPosterior, Plan, Sampled, PROPOSED};
use crate::model::likelihood::{Likelihood, Resolution};
use crate::model::parameters::Parameters;
use crate::model::posterior::LogDensity;

/// Monte Carlo errors that stand for the error that is not exceeded: one in a thousand is.
pub const SURE: f64 = 3.3;

/// Accuracies that may be asked for: below, draws would fill the memory; above, nothing is known.
pub const RANGE: (f64, f64) = (0.005, 1.0);

/// Draws from the normal that tell how far it is off.
const PILOT: usize = 2000;

/// The fewest draws a chain keeps: fewer leave nothing to judge them by.
const FEWEST_DRAWS: usize = 250;

/// The most draws a chain keeps: nearly twice what the finest accuracy takes where draws are independent and chains four.
const MOST_DRAWS: usize = 200_000;

/// Draws as the accuracy `asked` wants, with the chains and the adapting of `plan`; its draws and evaluation do not count.
///
/// Fails as [`super::sampling::sample_posterior`] does. Where no way reaches the accuracy, the last one's draws come with
/// the error it can vouch for.
pub fn sample_to(
    asked: f64,
    parameters: Parameters,
    rows: &Likelihood,
    start: &Start,
    plan: Plan,
    watcher: Watcher,
) -> Result<Sampled, NoPosterior> {
    // an error of the log density moves no mean by more than as many sds
    let bound = LARGEST_ERROR.min(0.1 * asked);
    let compressed = Evaluation::Compressed(Resolution::Bound(bound));
    let posed = Posed::new(parameters.clone(), rows, start, compressed)?;
    let mut climb = Climb {
        asked,
        chains: plan.effort.chains,
        stream: plan.stream,
        tried: vec![],
    };
    if let Some(sampled) = climb.about_the_mode(&posed, bound) {
        return Ok(sampled);
    }
    let sampled = climb.by_trajectories(&posed, bound, plan.effort, watcher)?;
    if sampled.checked_error.is_none_or(|error| error <= bound) {
        return Ok(climb.followed(sampled, bound));
    }
    climb.tried.push((
        Method::NutsCompressed,
        "the log density of the nodes is off by more than a tenth of what was asked for".to_owned(),
    ));
    let posed = Posed::new(parameters, rows, start, Evaluation::Rows)?;
    let sampled = climb.by_trajectories(&posed, 0.0, plan.effort, watcher)?;
    Ok(climb.followed(sampled, 0.0))
}

struct Climb<'p> {
    asked: f64,
    chains: usize,
    stream: (u64, &'p str),
    tried: Vec<(Method, String)>,
}

impl Climb<'_> {
    /// The normal about the mode, or its weighted draws, if either can be vouched for.
    fn about_the_mode(&mut self, posed: &Posed, bound: f64) -> Option<Sampled> {
        let (off, efficiency) = match look(posed, self.stream) {
            Ok(looked) => looked,
            Err(why) => {
                let both = [Method::Laplace, Method::LaplacePsis];
                self.tried.extend(both.map(|method| (method, why.clone())));
                return None;
            }
        };
        let off = off + bound;
        // half of the accuracy for the normal's own error, half for the number of its draws
        if off <= 0.5 * self.asked {
            let each = self.each((SURE / (self.asked - off)).powi(2));
            let sampled = by_normal(posed, (self.chains, each), self.stream);
            let vouched = monte_carlo_error(&sampled) + off;
            if self.holds(&sampled, vouched, bound) {
                return Some(self.done(sampled, vouched));
            }
            let why = format!("its draws leave an error of {vouched:.2}, with its own of {off:.2}");
            self.tried.push((Method::Laplace, why));
        } else {
            let why = format!("the normal is off by up to {off:.2}, more than half of what was asked for");
            self.tried.push((Method::Laplace, why));
        }
        let mut wanted = (SURE / (self.asked - bound)).powi(2) * (1.0 + 1.0 / (PROPOSED as f64 * efficiency));
        /// each corrects what the one before it found missing
        const TRIES: usize = 4;
        let mut why = "the densities allow no weights".to_owned();
        for _ in 0..TRIES {
            let each = self.each(wanted);
            let Some(sampled) = by_weights(posed, (self.chains, each), self.stream) else {
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
            why = format!("{} draws leave an error of {vouched:.2}", self.chains * each);
            wanted = 1.1 * (self.chains * each) as f64 * (vouched / self.asked).powi(2);
        }
        self.tried.push((Method::LaplacePsis, why));
        None
    }

    /// Whether the accuracy is reached, the nodes with it.
    fn holds(&self, sampled: &Sampled, vouched: f64, bound: f64) -> bool {
        vouched <= self.asked && sampled.checked_error.is_none_or(|error| error <= bound)
    }

    /// Draws a chain for so many in all.
    fn each(&self, all: f64) -> usize {
        ((all / self.chains as f64).ceil() as usize).clamp(FEWEST_DRAWS, MOST_DRAWS)
    }

    /// Trajectories, anew with more draws until the accuracy is reached or is out of reach.
    fn by_trajectories(
        &self,
        posed: &Posed,
        bound: f64,
        effort: Effort,
        watcher: Watcher,
    ) -> Result<Sampled, NoPosterior> {
        let left = self.asked - bound;
        let mut draws = self.each((SURE / left).powi(2));
        loop {
            let sampled = follow(posed, Effort { draws, ..effort }, self.stream, watcher)?;
            let error = monte_carlo_error(&sampled);
            // draws that say nothing of their error are doubled
            let more = if error.is_finite() {
                1.1 * (error / left).powi(2)
            } else {
                2.0
            };
            let next = draws as f64 * more.max(1.1);
            // chains that do not agree, or so slow that not even the most draws would do, are not followed further
            if error <= left || next > MOST_DRAWS as f64 || !chains_agree(&sampled) {
                return Ok(sampled);
            }
            draws = next.ceil() as usize;
        }
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
            accuracy: Some(Accuracy {
                asked: self.asked,
                vouched,
                tried: std::mem::take(&mut self.tried),
            }),
            ..sampled
        }
    }
}

/// Largest error of the normal about the mode as the accuracy counts it, and how many draws of the posterior one of its
/// own is worth, from a few draws; the reason where they do not tell.
pub fn look(posed: &Posed, (seed, name): (u64, &str)) -> Result<(f64, f64), String> {
    if !(posed.about.converged && posed.about.peaked) {
        return Err("the posterior has no peak to lay a normal about".to_owned());
    }
    let name = format!("{name} pilot");
    let pilot = normal_draws(&posed.posterior, &posed.about, (1, PILOT), (seed, &name));
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
    let off = largest_shift(posed, &pilot[0].points, &weights.weights);
    Ok((off, weights.effective() / PILOT as f64))
}

/// The largest error that leaving the weights out makes, of any mean in sds and of any sd.
fn largest_shift(posed: &Posed, points: &[f64], weights: &[f64]) -> f64 {
    let dimension = posed.posterior.dimension();
    let draws: Vec<Vec<f64>> = points
        .chunks_exact(dimension)
        .map(|point| posed.posterior.draw_at(point))
        .collect();
    let of = |place: usize| {
        let values: Vec<f64> = draws.iter().map(|draw| draw[place]).collect();
        let found = shift(&values, weights);
        let mean = found.mean.abs() + SURE * found.mean_mcse;
        mean.max(found.sd.abs() + SURE * found.sd_mcse)
    };
    (0..dimension).map(of).fold(0.0, f64::max)
}

/// Whether no parameter has an R-hat so far from 1 that more draws would not bring its chains together.
fn chains_agree(sampled: &Sampled) -> bool {
    const LOST: f64 = 1.1;
    let agree = |values: &Vec<Vec<f64>>| {
        let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        rhat(&chains).is_ok_and(|rhat| rhat < LOST)
    };
    sampled.values.iter().all(agree)
}

/// [`SURE`] Monte Carlo errors of the mean in sds, or of the sd, of the parameter that has most; infinite where the draws
/// do not tell.
pub fn monte_carlo_error(sampled: &Sampled) -> f64 {
    let of = |values: &Vec<Vec<f64>>| {
        let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
        let found = summarise(&chains);
        match (found.sd, found.mcse_mean, found.mcse_sd) {
            (Some(sd), Some(mean), Some(of_sd)) if sd > 0.0 => mean.max(of_sd) / sd,
            _ => f64::INFINITY,
        }
    };
    let largest = sampled.values.iter().map(of).fold(0.0, f64::max);
    SURE * largest * sampled.mcse_factor
}
