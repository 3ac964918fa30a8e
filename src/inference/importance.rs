//! Draws from the normal or Student's t about a posterior's mode, and weighs the draws by what the posterior has there.

use rand::{Rng, RngExt};
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rayon::prelude::*;

use super::diagnostics::pareto::tail_length;
use super::diagnostics::psis::psis;
use super::laplace::Laplace;
use super::nuts::Chain;
use crate::model::posterior::LogDensity;
use crate::seed::StreamName;

/// How many independent draws are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawCounts {
    /// chains
    pub chains: usize,
    /// draws a chain
    pub draws: usize,
}

/// The tails of a proposal about a mode with its curvature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProposalTails {
    /// those of the normal
    Normal,
    /// those of Student's t: heavier than a posterior's that is skewed or bent, so that no weight runs away
    Student,
}

/// Degrees of freedom of Student's t.
const NU: f64 = 5.0;

impl ProposalTails {
    /// Stretches a standard normal z, and gives the log density that it then has, up to a constant.
    fn stretch(self, z: &mut [f64], rng: &mut impl Rng) -> f64 {
        let square: f64 = z.iter().map(|z| z * z).sum();
        if self == ProposalTails::Normal {
            return -0.5 * square;
        }
        let over = NU / ChiSquared::new(NU).expect("positive").sample(rng);
        z.iter_mut().for_each(|z| *z *= over.sqrt());
        -0.5 * (NU + z.len() as f64) * (square * over / NU).ln_1p()
    }
}

/// Draws about a mode, chain after chain: the same bytes for any number of threads.
///
/// A point without a density has the log density −∞.
pub fn propose<T: LogDensity + ?Sized>(
    target: &T,
    (about, tails): (&Laplace, ProposalTails),
    size: DrawCounts,
    streams: StreamName,
) -> Vec<Chain> {
    let one = |chain: usize| {
        let mut rng = streams.at(chain as u64);
        let mut proposed = Chain::default();
        let dimension = target.dimension();
        let (mut point, mut slopes) = (vec![0.0; dimension], vec![0.0; dimension]);
        let mut z = vec![0.0; dimension];
        for _ in 0..size.draws {
            z.fill_with(|| StandardNormal.sample(&mut rng));
            let of_proposal = tails.stretch(&mut z, &mut rng);
            about.point(&z, &mut point);
            let ln_density = target.ln_density(&point, &mut slopes).unwrap_or(f64::NEG_INFINITY);
            proposed.points.extend_from_slice(&point);
            proposed.ln_density.push(ln_density);
            proposed.ln_ratio.push(ln_density - of_proposal);
        }
        proposed
    };
    (0..size.chains).into_par_iter().map(one).collect()
}

/// Smoothed weights of all draws.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// the weights, which sum to 1, chain after chain
    pub weights: Vec<f64>,
    /// shape of their tail; −∞ where they are all the same
    pub khat: f64,
}

impl Weights {
    /// The Pareto-smoothed weights of draws; `None` where the densities allow none.
    pub fn of(proposed: &[Chain]) -> Option<Weights> {
        let ln_ratios: Vec<f64> = proposed.iter().flat_map(|one| &one.ln_ratio).copied().collect();
        // the draws are independent
        let smoothed = psis(&ln_ratios, tail_length(ln_ratios.len(), 1.0))?;
        Some(Weights {
            weights: smoothed.weights,
            khat: smoothed.khat.unwrap_or(f64::NEG_INFINITY),
        })
    }

    /// How many independent draws of the posterior they are worth: 1/Σw².
    pub fn effective(&self) -> f64 {
        1.0 / self.weights.iter().map(|w| w * w).sum::<f64>()
    }

    /// Which draws to keep so that each stands for as much weight: systematic resampling, in the order of the draws.
    pub fn resample(&self, kept: usize, rng: &mut impl Rng) -> Vec<usize> {
        let step = 1.0 / kept as f64;
        let offset: f64 = rng.random::<f64>() * step;
        let mut places = Vec::with_capacity(kept);
        let (mut place, mut reached) = (0, self.weights.first().copied().unwrap_or(0.0));
        for i in 0..kept {
            let wanted = offset + i as f64 * step;
            // the last weight's sum may miss 1 by rounding
            while reached <= wanted && place + 1 < self.weights.len() {
                place += 1;
                reached += self.weights[place];
            }
            places.push(place);
        }
        places
    }
}

/// What weights change about a quantity, against the draws as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// distance of the means, in sds
    pub mean: f64,
    /// Monte Carlo error of that
    pub mean_mcse: f64,
    /// sd with weights over sd without, less 1
    pub sd: f64,
    /// Monte Carlo error of that
    pub sd_mcse: f64,
}

/// How the weights move the mean and the sd of a quantity with these values.
///
/// The difference itself is averaged, whose noise is small where weights are nearly equal: it takes far fewer draws than
/// either mean.
pub fn weighted_shift(values: &[f64], weights: &[f64]) -> Shift {
    let share = 1.0 / values.len() as f64;
    let centre = values.iter().sum::<f64>() * share;
    let variance = values.iter().map(|x| (x - centre) * (x - centre)).sum::<f64>() * share;
    let sd = variance.sqrt();
    let (mut mean, mut mean_square) = (0.0, 0.0);
    let (mut spread, mut spread_square) = (0.0, 0.0);
    for (x, w) in values.iter().zip(weights) {
        let (z, more) = ((x - centre) / sd, w - share);
        mean += more * z;
        mean_square += (more * z).powi(2);
        let square = z * z - 1.0;
        spread += more * square;
        spread_square += (more * square).powi(2);
    }
    let ratio = (1.0 + spread - mean * mean).max(0.0).sqrt();
    Shift {
        mean,
        mean_mcse: mean_square.sqrt(),
        sd: ratio - 1.0,
        // of the variance, halved for its root
        sd_mcse: 0.5 * spread_square.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inference::nuts::tests::{normal_about, Target};
    use crate::seed::stream;

    /// Draws of a normal from the standard one that is supposed.
    fn proposed(mean: f64, sd: f64, tails: ProposalTails, name: &str) -> Vec<Chain> {
        let target = Target(1, |point: &[f64], slopes: &mut [f64]| {
            let z = (point[0] - mean) / sd;
            slopes[0] = -z / sd;
            Ok(-0.5 * z * z)
        });
        let size = DrawCounts { chains: 4, draws: 2000 };
        propose(
            &target,
            (&normal_about(0.0, 1.0), tails),
            size,
            StreamName::new(1, name),
        )
    }

    #[test]
    fn the_shift_of_a_normal_is_its_distance() {
        let draws = proposed(0.1, 0.9, ProposalTails::Normal, "importance");
        let weights = Weights::of(&draws).expect("densities");
        let values: Vec<f64> = draws.iter().flat_map(|one| one.points.clone()).collect();
        let found = weighted_shift(&values, &weights.weights);
        assert!(
            (found.mean - 0.1).abs() < 4.0 * found.mean_mcse && found.mean_mcse < 0.006,
            "{found:?}"
        );
        assert!(
            (found.sd + 0.1).abs() < 4.0 * found.sd_mcse && found.sd_mcse < 0.006,
            "{found:?}"
        );
        assert!(weights.khat < 0.3 && weights.effective() > 7000.0);
    }

    #[test]
    fn a_tail_the_normal_does_not_have_shows_and_students_t_has_it() {
        let khat = |draws: &[Chain]| Weights::of(draws).expect("densities").khat;
        let of_t = khat(&proposed(0.2, 1.8, ProposalTails::Student, "tails"));
        assert!(of_t < 0.5, "{of_t}");
        let of_normal = khat(&proposed(0.0, 3.0, ProposalTails::Normal, "importance"));
        assert!(of_normal > 0.7, "{of_normal}");
    }

    #[test]
    fn resampled_draws_stand_for_the_weights() {
        let weights = Weights {
            weights: vec![0.1, 0.0, 0.65, 0.25],
            khat: 0.0,
        };
        let kept = weights.resample(1000, &mut stream(1, "resample", 1));
        let count = |place: usize| kept.iter().filter(|kept| **kept == place).count();
        assert_eq!(count(1), 0);
        for (place, expected) in [(0, 100), (2, 650), (3, 250)] {
            assert!(count(place).abs_diff(expected) <= 1, "{place} {}", count(place));
        }
    }
}
