//! Draws from a Student's t that is adapted to a posterior, and weighs the draws by what the posterior has there.
//!
//! The roots of spreads are its coordinates, and its shape that of draws that were weighed before: so it fits posteriors
//! that are bent over several standard deviations, or have a spread that may be 0, where the normal about the mode does
//! not. It is adapted as well to a posterior without some of the runs, whose likelihood is taken away a share
//! after the other.

use super::bent::Bent;
use super::importance::{propose, DrawCounts, Proposal, Proposed, Weights};
use super::laplace::laplace;
use super::nuts::Chain;
use super::prepared_posterior::PreparedPosterior;
use super::sampling::{Method, Sampled};
use crate::model::posterior::{LogDensity, PosteriorDensity};
use crate::seed::StreamName;

/// Draws a chain from which the shape is learnt.
const TO_ADAPT: usize = 250;

/// A Student's t that is adapted to a posterior.
#[derive(Debug, Clone)]
pub struct Weighing<'p> {
    posterior: &'p PosteriorDensity,
    /// the same with the roots of spreads for coordinates
    rooted: PosteriorDensity,
    about: Bent,
    chains: usize,
    stream: StreamName<'p>,
}

/// Runs that are left out.
pub struct LeftOutRuns<'l> {
    /// names the streams of what is drawn without them
    pub name: String,
    /// their log likelihood at some full vectors of parameters
    pub ln_likelihood: &'l dyn Fn(&[Vec<f64>]) -> Vec<f64>,
}

/// An integral by weighed draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integral {
    /// its logarithm
    pub ln: f64,
    /// Monte Carlo error of that
    pub mcse: f64,
    /// shape of the weights' tail
    pub khat: f64,
}

impl<'p> Weighing<'p> {
    /// Adapts a Student's t to a prepared posterior, to be drawn from in so many chains; `None` where the densities allow no
    /// weights.
    pub fn new(prepared: &'p PreparedPosterior, chains: usize, stream: StreamName<'p>) -> Option<Weighing<'p>> {
        /// times that the shape is learnt, each from a better proposal: the last where fewer of its draws are left in effect
        /// than this share
        const ROUNDS: usize = 3;
        const ENOUGH: f64 = 0.5;
        let posterior = &prepared.posterior;
        let rooted = posterior.clone().with_roots_of_spreads();
        let mode = rooted.point_at(&posterior.draw_at(&prepared.about.mode));
        let mut weighing = Weighing {
            about: Bent::of_normal(&laplace(&rooted, &mode).ok()?),
            posterior,
            rooted,
            chains,
            stream,
        };
        for round in 0..ROUNDS {
            let proposed = weighing.propose(TO_ADAPT, &format!("adapting {round}"));
            let weights = Weights::of(&proposed)?;
            let effective = weights.effective() / weights.weights.len() as f64;
            weighing.adapt(&proposed, &weights)?;
            if round + 2 == ROUNDS && effective >= ENOUGH {
                break;
            }
        }
        Some(weighing)
    }

    /// So many weighed draws a chain; `None` where the densities allow no weights.
    pub fn draw(&self, draws: usize) -> Option<WeighedDraws> {
        let began = std::time::Instant::now();
        let mut weighed = WeighedDraws::new(self.propose(draws, "adapted"), began)?;
        for one in &mut weighed.proposed {
            one.move_to(self.posterior, &self.rooted);
        }
        Some(weighed)
    }

    /// The integral of the posterior over its parameters, by draws that were made of it here.
    pub fn integral(&self, of: &WeighedDraws) -> Integral {
        self.integral_of(&of.ln_ratios(), &of.weights)
    }

    /// The same of the posterior without some runs, by so many draws a chain of a Student's t that is adapted to that; `None`
    /// where none is found.
    pub fn integral_without(&self, runs: &LeftOutRuns, draws: usize) -> Option<Integral> {
        let adapted = self.adapted_without(runs)?;
        let proposed = adapted.propose(draws, &format!("without {}", runs.name));
        let ln_ratios = adapted.ln_ratios(runs, &proposed).without(1.0);
        let weights = Weights::of_ln_ratios(&ln_ratios)?;
        Some(adapted.integral_of(&ln_ratios, &weights))
    }

    /// So many weighed draws a chain of the posterior without some runs; `None` where no proposal serves.
    pub fn draw_without(&self, runs: &LeftOutRuns, draws: usize) -> Option<WeighedDraws> {
        let began = std::time::Instant::now();
        let adapted = self.adapted_without(runs)?;
        let mut proposed = adapted.propose(draws, &format!("without {}", runs.name));
        let mut without = adapted.ln_ratios(runs, &proposed).without(1.0).into_iter();
        for one in &mut proposed {
            one.ln_ratio
                .iter_mut()
                .zip(&mut without)
                .for_each(|(ln, own)| *ln = own);
        }
        let mut weighed = WeighedDraws::new(proposed, began)?;
        for one in &mut weighed.proposed {
            one.move_to(self.posterior, &self.rooted);
        }
        Some(weighed)
    }

    /// Takes the likelihood of some runs away, each time as large a share as draws of the proposal bear.
    fn adapted_without(&self, runs: &LeftOutRuns) -> Option<Weighing<'p>> {
        /// of the draws that must be left in effect by a share, and when it is all that the runs say
        const LEAST: f64 = 0.1;
        const ENOUGH: f64 = 0.4;
        /// a step that leaves no more than so many times those of the one before has adapted all it can
        const BETTER: f64 = 1.1;
        const MOST_STEPS: usize = 20;
        /// a share is found to a thousandth
        const BISECTIONS: usize = 10;
        let mut adapted = self.clone();
        let mut taken = 0.0;
        let mut before = None;
        for step in 0..MOST_STEPS {
            let proposed = adapted.propose(TO_ADAPT, &format!("adapting without {} {step}", runs.name));
            let ln_ratios = adapted.ln_ratios(runs, &proposed);
            let weights = |share: f64| Weights::of_ln_ratios(&ln_ratios.without(share));
            let count = ln_ratios.with.len() as f64;
            let mut found = weights(1.0)?;
            if found.effective() < LEAST * count {
                let mut ends = [taken, 1.0];
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (ends[0] + ends[1]);
                    let borne = weights(middle)?.effective() >= LEAST * count;
                    ends[usize::from(!borne)] = middle;
                }
                taken = ends[0];
                found = weights(taken)?;
            } else {
                taken = 1.0;
            }
            adapted.adapt(&proposed, &found)?;
            if taken == 1.0 {
                let effective = found.effective();
                if effective >= ENOUGH * count || before.is_some_and(|before| effective < BETTER * before) {
                    return Some(adapted);
                }
                before = Some(effective);
            }
        }
        None
    }

    fn ln_ratios(&self, runs: &LeftOutRuns, proposed: &[Proposed]) -> LnRatios {
        let points = proposed
            .iter()
            .flat_map(|one| one.points.chunks_exact(self.rooted.dimension().max(1)));
        let full = points.map(|point| self.posterior.parameters().full(&self.rooted.draw_at(point)));
        LnRatios {
            ln_likelihood: (runs.ln_likelihood)(&full.collect::<Vec<_>>()),
            with: proposed.iter().flat_map(|one| &one.ln_ratio).copied().collect(),
        }
    }

    fn integral_of(&self, ln_ratios: &[f64], weights: &Weights) -> Integral {
        let count = ln_ratios.len() as f64;
        // weights in the middle are not smoothed: their logarithm is that of the ratio less that of the sum of all
        let mut order: Vec<usize> = (0..ln_ratios.len()).collect();
        let (_, middle, _) =
            order.select_nth_unstable_by(ln_ratios.len() / 2, |a, b| ln_ratios[*a].total_cmp(&ln_ratios[*b]));
        let ln_sum = ln_ratios[*middle] - weights.weights[*middle].ln();
        Integral {
            ln: ln_sum - count.ln() + self.about.ln_volume(),
            mcse: (1.0 / weights.effective() - 1.0 / count).max(0.0).sqrt(),
            khat: weights.khat,
        }
    }

    fn propose(&self, draws: usize, step: &str) -> Vec<Proposed> {
        let name = format!("{} {step}", self.stream.name);
        let size = DrawCounts {
            chains: self.chains,
            draws,
        };
        let stream = StreamName::new(self.stream.seed, &name);
        propose(&self.rooted, &Proposal::Student(&self.about), size, stream)
    }

    /// Takes the shape from weighed draws; `None` where these span no volume.
    fn adapt(&mut self, proposed: &[Proposed], weights: &Weights) -> Option<()> {
        let points: Vec<f64> = proposed.iter().flat_map(|one| &one.points).copied().collect();
        self.about = Bent::of_draws(&points, &weights.weights, self.rooted.dimension())?;
        Some(())
    }
}

/// Draws from the normal for one that is kept after weighing.
pub const PROPOSED: usize = 4;

/// Draws from the normal about the mode, resampled by what the posterior has there; `None` where the densities allow no
/// weights. `khat` says whether they are reliable.
pub fn sample_by_importance(prepared: &PreparedPosterior, size: DrawCounts, stream: StreamName) -> Option<Sampled> {
    let size = DrawCounts {
        draws: PROPOSED * size.draws,
        ..size
    };
    let began = std::time::Instant::now();
    let name = format!("{} proposed", stream.name);
    let from = Proposal::Normal(&prepared.about);
    let proposed = propose(&prepared.posterior, &from, size, StreamName::new(stream.seed, &name));
    Some(WeighedDraws::new(proposed, began)?.resample(prepared, PROPOSED, stream))
}

/// Logarithms of the posterior's density over the proposal's at some draws, with and without some runs.
struct LnRatios {
    with: Vec<f64>,
    /// of these runs
    ln_likelihood: Vec<f64>,
}

impl LnRatios {
    /// With a share of what the runs say taken away.
    fn without(&self, share: f64) -> Vec<f64> {
        let each = self.with.iter().zip(&self.ln_likelihood);
        // a point without a density has none without the runs, either
        let without = |(with, ln): (&f64, &f64)| if with.is_finite() { with - share * ln } else { *with };
        each.map(without).collect()
    }
}

/// Draws of a proposal with the weights that make them draws of the posterior.
#[derive(Debug, Clone)]
pub struct WeighedDraws {
    proposed: Vec<Proposed>,
    weights: Weights,
    began: std::time::Instant,
}

impl Proposed {
    /// The same points in the coordinates of another posterior of the same parameters.
    fn move_to(&mut self, other: &PosteriorDensity, own: &PosteriorDensity) {
        let points = self.points.chunks_exact_mut(own.dimension().max(1));
        for (point, ln_density) in points.zip(&mut self.ln_density) {
            let moved = other.point_at(&own.draw_at(point));
            *ln_density += other.ln_jacobian(&moved) - own.ln_jacobian(point);
            point.copy_from_slice(&moved);
        }
    }
}

impl WeighedDraws {
    /// `None` where the densities allow no weights.
    pub(super) fn new(proposed: Vec<Proposed>, began: std::time::Instant) -> Option<WeighedDraws> {
        Some(WeighedDraws {
            weights: Weights::of(&proposed)?,
            proposed,
            began,
        })
    }

    /// Shape of the weights' tail.
    pub fn khat(&self) -> f64 {
        self.weights.khat
    }

    /// Logarithms of the posterior's density over the proposal's, up to a constant, chain after chain.
    pub fn ln_ratios(&self) -> Vec<f64> {
        self.proposed.iter().flat_map(|one| &one.ln_ratio).copied().collect()
    }

    /// Every draw as a full vector of parameters, chain after chain.
    pub fn full_draws(&self, posterior: &PosteriorDensity) -> Vec<Vec<f64>> {
        let points = self
            .proposed
            .iter()
            .flat_map(|one| one.points.chunks_exact(posterior.dimension().max(1)));
        points
            .map(|point| posterior.parameters().full(&posterior.draw_at(point)))
            .collect()
    }

    /// One draw kept of so many, so that each stands for as much weight.
    pub fn resample(&self, prepared: &PreparedPosterior, of: usize, stream: StreamName) -> Sampled {
        let dimension = prepared.posterior.dimension();
        let name = format!("{} resampled", stream.name);
        let mut rng = StreamName::new(stream.seed, &name).at(0);
        let proposed = self.proposed.iter().flat_map(|one| &one.ln_density);
        let ln_density: Vec<f64> = proposed.copied().collect();
        let chains = self.proposed.len().max(1);
        let draws = (ln_density.len() / chains / of.max(1)).max(1);
        let kept = self.weights.resample(chains * draws, &mut rng);
        let points: Vec<&[f64]> = self
            .proposed
            .iter()
            .flat_map(|one| one.points.chunks_exact(dimension.max(1)))
            .collect();
        let chain = |kept: &[usize]| Chain {
            points: kept.iter().flat_map(|place| points[*place]).copied().collect(),
            ln_density: kept.iter().map(|place| ln_density[*place]).collect(),
            ..Chain::default()
        };
        let chains: Vec<Chain> = kept.chunks(draws).map(chain).collect();
        Sampled {
            khat: Some(self.weights.khat),
            // the noise of choosing the draws adds to that of those there were to choose from
            mcse_factor: (1.0 + kept.len() as f64 / self.weights.effective()).sqrt(),
            ..Sampled::of_chains(prepared, Method::LaplacePsis, chains, self.began)
        }
    }
}
