//! Draws from a posterior as cheaply as an accuracy allows: the first way whose own check vouches for it.
//!
//! The ways in their order: the normal about the mode, the same resampled by importance weights, the No-U-Turn sampler on
//! nodes, the same on every row. The accuracy is the largest error of any parameter's mean, in posterior sds, and of any
//! sd, relative. A Monte Carlo error counts [`SURE`] times.

use super::diagnostics::pareto::khat_threshold;
use super::diagnostics::summary::summarise;
use super::importance::{normal_draws, shift, Weights};
use super::nuts::{Chain, Effort, Watcher};
use super::posed::{Evaluation, Posed, Start, LARGEST_ERROR};
use super::sampling::{follow, Method, NoPosterior, Plan, Sampled};
use crate::model::likelihood::{Likelihood, Resolution};
use crate::model::parameters::Parameters;
use crate::model::posterior::LogDensity;
use crate::seed::stream;

/// Monte Carlo errors that stand for the error that is not exceeded: one in a thousand is.
pub const SURE: f64 = 3.3;

/// Accuracies that may be asked for: below, draws would fill the memory; above, nothing is known.
pub const RANGE: (f64, f64) = (0.005, 1.0);

/// Draws from the normal that tell how far it is off.
const PILOT: usize = 2000;

/// Draws from the normal for one that is kept after weighing.
const PROPOSED: usize = 4;

/// The fewest draws a chain keeps: fewer leave nothing to judge them by.
const FEWEST_DRAWS: usize = 250;

/// The most draws a chain keeps.
const MOST_DRAWS: usize = 1_000_000;

/// An accuracy that was asked for, and how it was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// what was asked for
    pub asked: f64,
    /// the error the method's own check vouches for; infinite if none did
    pub vouched: f64,
    /// the ways tried before, cheapest first, each with why it did not do
    pub tried: Vec<(Method, String)>,
}

impl Accuracy {
    /// Whether it was reached.
    pub fn reached(&self) -> bool {
        self.vouched <= self.asked
    }
}

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
    if let Some(sampled) = climb.from_the_normal(&posed, bound) {
        return Ok(sampled);
    }
    let sampled = climb.by_trajectories(&posed, bound, plan.effort, watcher)?;
    if sampled.checked_error.is_none_or(|error| error <= bound) {
        return Ok(climb.done(sampled, bound));
    }
    climb.tried.push((
        Method::NutsCompressed,
        "the log density of the nodes is off by more than a tenth of what was asked for".to_owned(),
    ));
    let posed = Posed::new(parameters, rows, start, Evaluation::Rows)?;
    let sampled = climb.by_trajectories(&posed, 0.0, plan.effort, watcher)?;
    Ok(climb.done(sampled, 0.0))
}

struct Climb<'p> {
    asked: f64,
    chains: usize,
    stream: (u64, &'p str),
    tried: Vec<(Method, String)>,
}

impl Climb<'_> {
    /// The normal about the mode, or its weighted draws, if either can be vouched for.
    fn from_the_normal(&mut self, posed: &Posed, bound: f64) -> Option<Sampled> {
        let began = std::time::Instant::now();
        let dimension = posed.posterior.dimension();
        if !(posed.about.converged && posed.about.peaked) {
            let why = "the posterior has no peak to lay a normal about";
            self.tried
                .extend([Method::Laplace, Method::LaplacePsis].map(|method| (method, why.to_owned())));
            return None;
        }
        let (seed, name) = self.stream;
        let draws = |chains_draws, what: &str| {
            let name = format!("{name} {what}");
            normal_draws(&posed.posterior, &posed.about, chains_draws, (seed, &name))
        };
        let pilot = draws((1, PILOT), "pilot");
        let Some(weights) = Weights::of(&pilot) else {
            let why = "the posterior has no density near the normal's draws";
            self.tried
                .extend([Method::Laplace, Method::LaplacePsis].map(|method| (method, why.to_owned())));
            return None;
        };
        let line = khat_threshold(PILOT);
        if weights.khat > line {
            let why = format!(
                "importance weights have the shape {:.2}, above {line:.2}: the normal does not reach the posterior's tails",
                weights.khat
            );
            self.tried
                .extend([Method::Laplace, Method::LaplacePsis].map(|method| (method, why.clone())));
            return None;
        }
        let off = largest_shift(posed, &pilot[0].points, &weights.weights) + bound;
        // half of the accuracy for the normal's own error, half for the number of its draws
        if off <= 0.5 * self.asked {
            let left = self.asked - off;
            let each = self.each((SURE / left).powi(2));
            let chains: Vec<Chain> = draws((self.chains, each), "normal")
                .iter()
                .map(|p| p.as_chain())
                .collect();
            let sampled = Sampled {
                khat: Some(weights.khat),
                ..Sampled::of_chains(posed, Method::Laplace, chains, began)
            };
            let vouched = monte_carlo_error(&sampled) + off;
            if self.holds(&sampled, vouched, bound) {
                return Some(self.done_with(sampled, vouched));
            }
            self.tried.push((
                Method::Laplace,
                format!("its draws leave an error of {vouched:.2}, with its own of {off:.2}"),
            ));
        } else {
            self.tried.push((
                Method::Laplace,
                format!("the normal is off by up to {off:.2}, more than half of what was asked for"),
            ));
        }
        let efficiency = weights.effective() / PILOT as f64;
        let left = self.asked - bound;
        let mut wanted = (SURE / left).powi(2) * (1.0 + 1.0 / (PROPOSED as f64 * efficiency));
        /// each corrects what the one before it found missing
        const TRIES: usize = 4;
        let mut why = String::new();
        for attempt in 0..TRIES {
            let each = self.each(wanted);
            let proposed = draws((self.chains, PROPOSED * each), "proposed");
            let weights = Weights::of(&proposed)?;
            let line = khat_threshold(weights.weights.len());
            if weights.khat > line {
                why = format!("importance weights have the shape {:.2}, above {line:.2}", weights.khat);
                break;
            }
            let kept = weights.resample(self.chains * each, &mut stream(seed, name, attempt as u64));
            let all: Vec<&[f64]> = proposed
                .iter()
                .flat_map(|one| one.points.chunks_exact(dimension))
                .collect();
            let ln_density: Vec<f64> = proposed.iter().flat_map(|one| &one.ln_density).copied().collect();
            let chain = |kept: &[usize]| Chain {
                points: kept.iter().flat_map(|place| all[*place]).copied().collect(),
                ln_density: kept.iter().map(|place| ln_density[*place]).collect(),
                ..Chain::default()
            };
            let chains: Vec<Chain> = kept.chunks(each).map(chain).collect();
            let sampled = Sampled {
                khat: Some(weights.khat),
                // the noise of choosing the draws adds to that of those there were to choose from
                mcse_factor: (1.0 + (self.chains * each) as f64 / weights.effective()).sqrt(),
                ..Sampled::of_chains(posed, Method::LaplacePsis, chains, began)
            };
            let vouched = monte_carlo_error(&sampled) + bound;
            if self.holds(&sampled, vouched, bound) {
                return Some(self.done_with(sampled, vouched));
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

    /// Trajectories, anew with more draws until the accuracy is reached.
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
            if error <= left || draws == MOST_DRAWS {
                return Ok(sampled);
            }
            // draws that say nothing of their error are doubled
            let more = if error.is_finite() {
                1.1 * (error / left).powi(2)
            } else {
                2.0
            };
            draws = ((draws as f64 * more.clamp(1.1, 100.0)).ceil() as usize).min(MOST_DRAWS);
        }
    }

    fn done(self, sampled: Sampled, bound: f64) -> Sampled {
        let vouched = match sampled.checked_error {
            Some(error) if error > bound => f64::INFINITY,
            _ => monte_carlo_error(&sampled) + bound,
        };
        let mut climb = self;
        climb.done_with(sampled, vouched)
    }

    fn done_with(&mut self, sampled: Sampled, vouched: f64) -> Sampled {
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
