//! Computes the density and the tails of Student's t, stretched so that its spread is that of the normal (`tails.rs`).

use rand::Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

use super::run_density::LnOfNoise;
use crate::distributions::{student_t_peak, student_t_peak_slope, student_t_tail};
use crate::roots::root_between;

/// Student's t of the central 68.3 % of the normal, with its constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Student {
    /// ν
    pub(super) nu: f64,
    /// t itself
    pub(super) t: StudentT,
    /// t of a little less and a little more ν
    pub(super) beside: [StudentT; 2],
    /// c, the quantile of t that as much lies below as below 1 of the standard normal
    pub(super) quantile: f64,
    /// slope of ln c in ν
    pub(super) quantile_slope: f64,
    /// ln of the density at 0
    pub(super) peak: f64,
    /// its slope in ν
    pub(super) peak_slope: f64,
}

/// Step of a difference in ν, as a share of it: what the third order leaves is below 1e-6 of a slope, and what rounding takes
/// far below.
const STEP: f64 = 1e-4;

impl Student {
    /// Of so many degrees of freedom.
    pub fn new(nu: f64) -> Student {
        let step = STEP * nu;
        let t = StudentT::new(nu);
        let beside = [nu - step, nu + step].map(StudentT::new);
        let quantile = t.quantile_of_one();
        // as much stays above
        let [less, more] = beside.map(|t| t.above(quantile));
        let quantile_slope = (more - less) / (2.0 * step) / t.density(quantile) / quantile;
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

    /// Log density at z, of a spread of 1, with its slopes.
    pub(super) fn ln_density(&self, z: f64) -> LnOfNoise {
        let (nu, stretched) = (self.nu, self.quantile * self.quantile);
        let square = stretched * z * z;
        let ln_tail = (square / nu).ln_1p();
        // falls with the square of the distance, so that what lies far out pulls less the farther it is
        let weight = (nu + 1.0) / (nu + square);
        LnOfNoise {
            value: self.peak - 0.5 * (nu + 1.0) * ln_tail,
            z: -weight * stretched * z,
            shape: self.peak_slope - 0.5 * ln_tail + weight * square * (0.5 / nu - self.quantile_slope),
        }
    }

    /// Log of the probability of less than z, with its slopes.
    pub(super) fn ln_probability(&self, z: f64) -> LnOfNoise {
        /// beside 1, in rounding
        const LOST: f64 = 1e-18;
        let at = self.quantile * z;
        let [less, more] = self.beside;
        let [above, less, more] = [self.t, less, more].map(|of| of.above(at.abs()));
        if at > 0.0 && above < LOST {
            return LnOfNoise::default();
        }
        let above_nu = (more / less).ln() / (2.0 * STEP * self.nu);
        let (value, probability, of_nu) = if at > 0.0 {
            let below = 1.0 - above;
            ((-above).ln_1p(), below, -above_nu * above / below)
        } else {
            (above.ln(), above, above_nu)
        };
        let slope = self.t.density(at) * self.quantile / probability;
        LnOfNoise {
            value,
            z: slope,
            shape: of_nu + slope * z * self.quantile_slope,
        }
    }

    /// A draw of z.
    pub(super) fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        // ν lies above 2 wherever there is one
        let squares = ChiSquared::new(self.nu).map_or(f64::NAN, |squares| squares.sample(rng));
        let z: f64 = StandardNormal.sample(rng);
        (self.nu / squares).sqrt() / self.quantile * z
    }
}

/// Student's t of some degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StudentT {
    /// ν
    nu: f64,
    /// ln of the density at 0
    peak: f64,
}

impl StudentT {
    fn new(nu: f64) -> StudentT {
        StudentT {
            nu,
            peak: student_t_peak(nu),
        }
    }

    fn density(self, t: f64) -> f64 {
        (self.peak - 0.5 * (self.nu + 1.0) * (t * t / self.nu).ln_1p()).exp()
    }

    /// What lies above t ≥ 0.
    fn above(self, t: f64) -> f64 {
        student_t_tail(t, self.nu)
    }

    /// The quantile with as much above it as above 1 of the standard normal.
    fn quantile_of_one(self) -> f64 {
        const ABOVE_ONE: f64 = 0.158_655_253_931_457_05;
        // the normal's is 1, and ν above 2 wherever there is one
        root_between([0.9, 2.0], |t| self.above(t) - ABOVE_ONE).unwrap_or(f64::NAN)
    }
}
