//! Computes the log density and the log probability of the noise of each family, and their slopes.
//!
//! What a family cannot stand beside, [`LikelihoodFamily::refused_beside`] says.
//!
//! Student's t is stretched so that as much of it lies within a spread of its mean as of the normal, 68.3 %: its spread then
//! means what a standard deviation does, and hardly moves when a run far out takes ν down. z is in these units, c(ν) z in
//! those of t.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::asymmetric_laplace::AsymmetricLaplace;
use super::normal::{ln_normal_cdf, normal_cdf};
use super::run_density::{LnOfNoise, Side};
use super::student::Student;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::scene::LikelihoodFamily;

/// The distribution of noise in units of its spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tails {
    /// standard normal
    Normal,
    /// Student's t, of the same central 68.3 %
    Student(Student),
    /// asymmetric Laplace
    AsymmetricLaplace(AsymmetricLaplace),
}

impl Tails {
    /// The tails of a family of this shape, which normal ones do not read.
    pub fn of(family: LikelihoodFamily, shape: f64) -> Tails {
        match family {
            LikelihoodFamily::Normal => Tails::Normal,
            LikelihoodFamily::Student => Tails::Student(Student::new(shape)),
            LikelihoodFamily::AsymmetricLaplace => Tails::AsymmetricLaplace(AsymmetricLaplace::new(shape)),
        }
    }

    /// Log density at z, of a spread of 1, with its slopes.
    #[inline]
    pub(super) fn ln_density(&self, z: f64) -> LnOfNoise {
        match self {
            Tails::Normal => LnOfNoise {
                value: -0.5 * z * z - LN_ROOT_TWO_PI,
                z: -z,
                shape: 0.0,
            },
            Tails::Student(student) => student.ln_density(z),
            Tails::AsymmetricLaplace(laplace) => laplace.ln_density(z),
        }
    }

    /// Log of the probability of less than z, with its slopes.
    pub(super) fn ln_probability(&self, z: f64) -> LnOfNoise {
        match self {
            Tails::Normal => {
                let (value, slope) = ln_normal_cdf(z);
                LnOfNoise {
                    value,
                    z: slope,
                    shape: 0.0,
                }
            }
            Tails::Student(student) => student.ln_probability(z),
            Tails::AsymmetricLaplace(laplace) => laplace.ln_probability(z),
        }
    }

    /// Log of the probability that noise on this side is less than z away: of −z′ for noise z′ above.
    pub(super) fn ln_probability_of(&self, side: Side, z: f64) -> LnOfNoise {
        match (self, side) {
            (Tails::AsymmetricLaplace(laplace), Side::Above) => laplace.ln_probability_mirrored(z),
            _ => self.ln_probability(z),
        }
    }

    /// The same without slopes.
    pub(super) fn ln_below(&self, z: f64) -> f64 {
        match self {
            Tails::Normal => ln_normal_cdf(z).0,
            Tails::Student(student) => student.ln_below(z),
            Tails::AsymmetricLaplace(laplace) => laplace.ln_probability(z).value,
        }
    }

    /// Probability of less than z.
    pub fn probability(&self, z: f64) -> f64 {
        match self {
            Tails::Normal => normal_cdf(z),
            Tails::Student(_) | Tails::AsymmetricLaplace(_) => self.ln_below(z).exp(),
        }
    }

    /// A draw of z.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        match self {
            Tails::Normal => StandardNormal.sample(rng),
            Tails::Student(student) => student.draw(rng),
            Tails::AsymmetricLaplace(laplace) => laplace.draw(rng),
        }
    }
}

#[cfg(test)]
mod tests;
