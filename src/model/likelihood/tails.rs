//! Computes the log density and the log probability of the noise of each family, and their slopes.
//!
//! | family | with noise on the energy or errors of the speed | with all else |
//! |---|---|---|
//! | normal | yes | yes |
//! | Student's t | yes | yes |
//! | asymmetric Laplace | no: an integral over its kink is refused | yes |
//!
//! Student's t is stretched so that as much of it lies within a spread of its mean as of the normal, 68.3 %: its spread then
//! means what a standard deviation does, and hardly moves when a run far out takes ν down. z is in these units, c(ν) z in
//! those of t.

use rand::Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

use super::asymmetric_laplace::AsymmetricLaplace;
use super::block_sums::BlockSums;
use super::normal::{ln_normal_cdf, normal_cdf, CERTAIN};
use super::student::StudentT;
use super::sums::HeavyTails;
use crate::distributions::{student_t_peak_slope, LN_ROOT_TWO_PI};
use crate::scene::LikelihoodFamily;

/// The distribution of noise in units of its spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tails {
    /// standard normal
    Normal,
    /// Student's t, of the same central 68.3 %
    Student(Student),
    /// asymmetric Laplace, with those of a little less and a little more asymmetry
    AsymmetricLaplace(AsymmetricLaplace, [AsymmetricLaplace; 2]),
}

/// Student's t with its constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Student {
    /// ν
    nu: f64,
    /// t itself
    t: StudentT,
    /// t of a little less and a little more ν
    beside: [StudentT; 2],
    /// c, the quantile of t that as much lies below as below 1 of the standard normal
    quantile: f64,
    /// slope of ln c in ν
    quantile_slope: f64,
    /// ln of the density at 0
    peak: f64,
    /// its slope in ν
    peak_slope: f64,
}

/// A log density, or the log of a probability, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Density {
    pub value: f64,
    /// in the mean
    pub mean: f64,
    /// in the square of the spread
    pub variance: f64,
    /// in the shape
    pub shape: f64,
}

/// The log density of all rebounds of a block, with its slopes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct SummedDensity {
    pub value: f64,
    /// in σ
    pub sigma: f64,
    /// in the shape
    pub shape: f64,
    /// what the slopes of the sums in r are to be multiplied by
    pub kept_factor: f64,
}

/// ln F(z) with its slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Probability {
    pub value: f64,
    /// in z
    pub z: f64,
    /// in the shape
    pub shape: f64,
}

impl Tails {
    /// The tails of a family of this shape, which normal ones do not read.
    pub fn of(family: LikelihoodFamily, shape: f64) -> Tails {
        match family {
            LikelihoodFamily::Normal => Tails::Normal,
            LikelihoodFamily::Student => Tails::Student(Student::new(shape)),
            LikelihoodFamily::AsymmetricLaplace => {
                let beside = [shape - STEP, shape + STEP].map(AsymmetricLaplace::new);
                Tails::AsymmetricLaplace(AsymmetricLaplace::new(shape), beside)
            }
        }
    }

    /// What sums over rebounds of one spread σ want to know of heavy tails; `None` where there are none such.
    pub(super) fn heavy(&self, sigma: f64) -> Option<HeavyTails> {
        match self {
            Tails::Normal | Tails::AsymmetricLaplace(..) => None,
            Tails::Student(student) => Some(HeavyTails {
                steepness: (student.quantile / sigma).powi(2),
                nu: student.nu,
            }),
        }
    }

    /// The log density of so many runs from their sums; all 0 for normal tails.
    pub(super) fn of_sums(&self, sums: BlockSums, runs: usize, sigma: f64) -> SummedDensity {
        let Tails::Student(student) = self else {
            return SummedDensity::default();
        };
        let (n, Student { nu, .. }) = (runs as f64, *student);
        SummedDensity {
            value: n * (student.peak - sigma.ln()) - 0.5 * (nu + 1.0) * sums.ln_tails,
            sigma: (sums.weighted - n) / sigma,
            shape: n * student.peak_slope - 0.5 * sums.ln_tails + sums.weighted * (0.5 / nu - student.quantile_slope),
            kept_factor: (student.quantile / sigma).powi(2),
        }
    }

    /// Log density at a distance above the mean; `stretch` divides the square of the spread where the density is wanted on
    /// another scale than the distance has.
    #[inline]
    pub(super) fn ln_density(&self, distance: f64, variance: f64, stretch: f64) -> Density {
        let ln_variance = (variance / stretch).ln();
        match self {
            Tails::Normal => normal_density(distance, variance, ln_variance),
            Tails::Student(student) => {
                let square = distance * distance / variance;
                let nu = student.nu;
                let stretched = student.quantile * student.quantile;
                let square = stretched * square;
                let ln_tail = (square / nu).ln_1p();
                // falls with the square of the distance, so that what lies far out pulls less the farther it is
                let weight = (nu + 1.0) / (nu + square);
                Density {
                    value: student.peak - 0.5 * (nu + 1.0) * ln_tail - 0.5 * ln_variance,
                    mean: weight * stretched * distance / variance,
                    variance: 0.5 * (weight * square - 1.0) / variance,
                    shape: student.peak_slope - 0.5 * ln_tail + 0.5 * weight * square / nu
                        - weight * square * student.quantile_slope,
                }
            }
            Tails::AsymmetricLaplace(own, beside) => {
                let spread = variance.sqrt();
                let z = distance / spread;
                let [value, slope] = own.ln_density(z);
                Density {
                    value: value - 0.5 * ln_variance,
                    mean: -slope / spread,
                    variance: -0.5 * (1.0 + z * slope) / variance,
                    shape: difference(beside.map(|of| of.ln_density(z)[0])),
                }
            }
        }
    }

    /// Log of the probability of less than z.
    pub(super) fn ln_probability(&self, z: f64) -> Probability {
        match self {
            Tails::Normal if z > CERTAIN => Probability::CERTAIN,
            Tails::Normal => {
                let (value, slope) = ln_normal_cdf(z);
                Probability {
                    value,
                    z: slope,
                    shape: 0.0,
                }
            }
            Tails::Student(student) => {
                if student.is_certain(z) {
                    return Probability::CERTAIN;
                }
                let at = student.quantile * z;
                let [less, more] = student.beside;
                let all = [student.t, less, more];
                let densities = StudentT::density_of_each(all, at);
                let [above, less, more] = StudentT::above_of_each(all, at.abs(), densities);
                let above_nu = (more / less).ln() / (2.0 * STEP * student.nu);
                let (value, probability, of_nu) = if at > 0.0 {
                    let below = 1.0 - above;
                    ((-above).ln_1p(), below, -above_nu * above / below)
                } else {
                    (above.ln(), above, above_nu)
                };
                let slope = densities[0] * student.quantile / probability;
                Probability {
                    value,
                    z: slope,
                    shape: of_nu + slope * z * student.quantile_slope,
                }
            }
            Tails::AsymmetricLaplace(own, beside) => {
                let value = own.ln_probability(z);
                Probability {
                    value,
                    z: (own.ln_density(z)[0] - value).exp(),
                    shape: difference(beside.map(|of| of.ln_probability(z))),
                }
            }
        }
    }

    /// Probability of less than z.
    pub fn probability(&self, z: f64) -> f64 {
        match self {
            Tails::Normal => normal_cdf(z),
            Tails::Student(student) if z > 0.0 => 1.0 - student.t.above(student.quantile * z),
            Tails::Student(student) => student.t.above(-student.quantile * z),
            Tails::AsymmetricLaplace(own, _) => own.ln_probability(z).exp(),
        }
    }

    /// Log of the probability of less than z, and its slope.
    pub fn ln_probability_and_slope(&self, z: f64) -> (f64, f64) {
        match self {
            Tails::Normal => ln_normal_cdf(z),
            Tails::Student(student) => {
                let value = student.t.ln_below(student.quantile * z);
                (value, (student.ln_density(z) - value).exp())
            }
            Tails::AsymmetricLaplace(own, _) => {
                let value = own.ln_probability(z);
                (value, (own.ln_density(z)[0] - value).exp())
            }
        }
    }

    /// Mean of what lies below z.
    pub fn mean_below(&self, z: f64) -> f64 {
        let (_, slope) = self.ln_probability_and_slope(z);
        match self {
            Tails::Normal => -slope,
            // ∫ t f(t) dt up to t is −f(t) (ν + t²)/(ν − 1)
            Tails::Student(Student { nu, quantile, .. }) => {
                let stretched = quantile * quantile;
                -slope * (nu / stretched + z * z) / (nu - 1.0)
            }
            Tails::AsymmetricLaplace(own, _) => own.mean_below(z),
        }
    }

    /// Log density at z, of a spread of 1.
    #[inline]
    pub fn ln_unit_density(&self, z: f64) -> f64 {
        match self {
            Tails::Normal => -0.5 * z * z - LN_ROOT_TWO_PI,
            Tails::Student(student) => student.ln_density(z),
            Tails::AsymmetricLaplace(own, _) => own.ln_density(z)[0],
        }
    }

    /// A draw of z.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        match self {
            Tails::Normal => StandardNormal.sample(rng),
            Tails::Student(student) => {
                // ν lies above 2 wherever there is one
                let wide = ChiSquared::new(student.nu).map_or(f64::NAN, |squares| student.scale(squares.sample(rng)));
                let z: f64 = StandardNormal.sample(rng);
                wide * z
            }
            Tails::AsymmetricLaplace(own, _) => own.draw(rng),
        }
    }
}

impl Probability {
    /// Of what lies below z for certain.
    const CERTAIN: Probability = Probability {
        value: 0.0,
        z: 0.0,
        shape: 0.0,
    };
}

/// The slope in the asymmetry from values at a little less and a little more of it.
fn difference([less, more]: [f64; 2]) -> f64 {
    (more - less) / (2.0 * STEP)
}

/// Log density of the normal at a distance above its mean.
#[inline(always)]
pub(super) fn normal_density(distance: f64, variance: f64, ln_variance: f64) -> Density {
    let inverse = 1.0 / variance;
    let square = distance * distance * inverse;
    Density {
        value: -0.5 * (square + ln_variance) - LN_ROOT_TWO_PI,
        mean: distance * inverse,
        variance: 0.5 * (square - 1.0) * inverse,
        shape: 0.0,
    }
}

impl Student {
    /// Of so many degrees of freedom.
    fn new(nu: f64) -> Student {
        let step = STEP * nu;
        let t = StudentT::new(nu);
        let beside = [nu - step, nu + step].map(StudentT::new);
        let quantile = t.quantile_of_one();
        // as much stays above
        let [less, more] = beside.map(|t| t.above(quantile));
        let quantile_slope = (more - less) / (2.0 * step) / t.ln_density(quantile).exp() / quantile;
        Student {
            nu,
            t,
            beside,
            quantile,
            quantile_slope,
            peak: t.peak + quantile.ln(),
            peak_slope: student_t_peak_slope(nu) + quantile_slope,
        }
    }

    /// √(ν/χ²)/c, what a standard normal is to be multiplied by where χ² comes out as `squares`.
    fn scale(&self, squares: f64) -> f64 {
        (self.nu / squares).sqrt() / self.quantile
    }

    /// Whether what lies above z is lost in rounding beside 1: z Q(z) is less than the mean f(z) (ν + z²)/(ν − 1) of what
    /// lies there.
    fn is_certain(&self, z: f64) -> bool {
        /// nearer, not even the normal has so little
        const FAR: f64 = 9.0;
        const LOST: f64 = 1e-18;
        let at = self.quantile * z;
        z > FAR && self.ln_density(z).exp() * (self.nu + at * at) < LOST * (self.nu - 1.0) * at
    }

    fn ln_density(&self, z: f64) -> f64 {
        self.t.ln_density(self.quantile * z) + self.quantile.ln()
    }
}

/// Step of a difference in a shape, in ν as a share of it: what the third order leaves is below 1e-6 of a slope, and what rounding
/// takes far below.
const STEP: f64 = 1e-4;

#[cfg(test)]
mod tests;
