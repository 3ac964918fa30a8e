//! Prepares a posterior for sampling: finds a start, and the mode with its curvature.

use super::importance::{propose, DrawCounts, ProposalTails};
use super::laplace::{laplace, Laplace};
use super::nuts::Chain;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::model::posterior::{LogDensity, PosteriorDensity};
use crate::seed::StreamName;

/// A posterior with what every method of sampling starts from.
#[derive(Debug, Clone)]
pub struct PreparedPosterior {
    /// the posterior
    pub posterior: PosteriorDensity,
    /// its mode and curvature; [`Laplace::is_at_peak`] says whether the search ended there, or where a sampler may only start
    pub about: Laplace,
    /// seconds it took
    pub seconds: f64,
}

/// The posterior has no density at any start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the posterior has no density at the least-squares estimates, nor at the medians of the priors")]
pub struct NoStart;

/// Values a search for the mode may start from, by kind; what is missing starts at its prior's median.
pub type Start = Vec<(ParameterKind, f64)>;

impl PreparedPosterior {
    /// Prepares the posterior of these parameters under a likelihood.
    pub fn new(parameters: ModelParameters, likelihood: &Likelihood, start: &Start) -> Result<Self, NoStart> {
        let starts = starts(&parameters, start);
        Self::of_starts(parameters, likelihood, &starts)
    }

    /// The same, where the mode is known to lie near the start.
    pub fn near(parameters: ModelParameters, likelihood: &Likelihood, start: &Start) -> Result<Self, NoStart> {
        let [near, _] = starts(&parameters, start);
        Self::of_starts(parameters, likelihood, &[near])
    }

    fn of_starts(parameters: ModelParameters, likelihood: &Likelihood, starts: &[Vec<f64>]) -> Result<Self, NoStart> {
        let began = std::time::Instant::now();
        let reference = parameters.full(&starts[0]);
        let posterior = PosteriorDensity::new(parameters, likelihood.clone()).with_offsets_about(&reference);
        let about = highest(&posterior, starts)?;
        let (posterior, about) = about_the_mode(posterior, about)?;
        Ok(PreparedPosterior {
            posterior,
            about,
            seconds: began.elapsed().as_secs_f64(),
        })
    }

    /// Proposals about the mode, from the stream of a step of what the stream is for.
    pub(super) fn propose(&self, tails: ProposalTails, size: DrawCounts, stream: StreamName, step: &str) -> Vec<Chain> {
        let name = format!("{} {step}", stream.name);
        let from = (&self.about, tails);
        propose(&self.posterior, from, size, StreamName::new(stream.seed, &name))
    }
}

/// Seconds that a log density that takes one run at a time takes with its slopes, where the search for the mode starts; `None`
/// of one by sums, which is quick, or where it has no value there.
pub fn seconds_of_rows(parameters: ModelParameters, rows: Likelihood, start: &Start) -> Option<f64> {
    /// evaluations of which the quickest counts, and seconds after which one is enough
    const MOST: usize = 5;
    const ENOUGH: f64 = 0.05;
    if !rows.needs_rows {
        return None;
    }
    let starts = starts(&parameters, start);
    let posterior = PosteriorDensity::new(parameters, rows);
    let began = std::time::Instant::now();
    let mut slopes = vec![0.0; posterior.dimension()];
    let mut least: Option<f64> = None;
    for _ in 0..MOST {
        let one = std::time::Instant::now();
        posterior
            .ln_density(&posterior.point_at(&starts[0]), &mut slopes)
            .ok()?;
        least = least.into_iter().chain([one.elapsed().as_secs_f64()]).reduce(f64::min);
        if began.elapsed().as_secs_f64() > ENOUGH {
            break;
        }
    }
    least
}

/// The least-squares start, and the medians of the priors for the case that it is no good.
fn starts(parameters: &ModelParameters, start: &Start) -> [Vec<f64>; 2] {
    let medians: Vec<f64> = parameters.sampled.iter().map(|p| p.prior.median()).collect();
    let given = parameters.sampled.iter().zip(&medians).map(|(parameter, median)| {
        let found = start.iter().find(|(kind, _)| *kind == parameter.kind);
        found.map_or(*median, |(_, value)| *value)
    });
    [given.collect(), medians]
}

/// The highest mode that the starts lead to.
fn highest(posterior: &PosteriorDensity, starts: &[Vec<f64>]) -> Result<Laplace, NoStart> {
    let modes = starts
        .iter()
        .filter_map(|start| laplace(posterior, &posterior.point_at(start)).ok());
    // the earlier start wins a tie
    let best = modes.reduce(|a, b| if b.ln_density > a.ln_density + 1e-6 { b } else { a });
    best.ok_or(NoStart)
}

/// The posterior with the offsets of series on coordinates that are round about its mode, and the mode in these.
fn about_the_mode(posterior: PosteriorDensity, about: Laplace) -> Result<(PosteriorDensity, Laplace), NoStart> {
    if posterior.parameters().series_offsets.is_empty() {
        return Ok((posterior, about));
    }
    let draw = posterior.draw_at(&about.mode);
    let full = posterior.parameters().full(&draw);
    let posterior = posterior.with_offsets_about(&full);
    let about = laplace(&posterior, &posterior.point_at(&draw)).map_err(|_| NoStart)?;
    Ok((posterior, about))
}
