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
    /// ln of the density of t at 0
    pub(super) t_peak: f64,
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

/// What is lost beside 1, in rounding.
const LOST: f64 = 1e-18;

/// ln of what lies below t, where so much lies beyond |t| on its side.
fn ln_of_side(t: f64, beyond: f64) -> f64 {
    match t > 0.0 {
        true if beyond < LOST => 0.0,
        true => (-beyond).ln_1p(),
        false => beyond.ln(),
    }
}

impl Student {
    /// Of so many degrees of freedom.
    pub fn new(nu: f64) -> Student {
        /// what lies above 1 of the standard normal
        const ABOVE_ONE: f64 = 0.158_655_253_931_457_05;
        // the normal's is 1, and ν above 2 wherever there is one
        let quantile = root_between([0.9, 2.0], |t| student_t_tail(t, nu) - ABOVE_ONE).unwrap_or(f64::NAN);
        let t_peak = student_t_peak(nu);
        let mut student = Student {
            nu,
            t_peak,
            quantile,
            quantile_slope: 0.0,
            peak: t_peak + quantile.ln(),
            peak_slope: student_t_peak_slope(nu),
        };
        // as much stays above
        let [less, more] = student.above_beside(quantile);
        student.quantile_slope = (more - less) / (2.0 * STEP * nu) / student.density(quantile) / quantile;
        student.peak_slope += student.quantile_slope;
        student
    }

    /// Density of t.
    fn density(&self, t: f64) -> f64 {
        (self.t_peak - 0.5 * (self.nu + 1.0) * (t * t / self.nu).ln_1p()).exp()
    }

    /// What lies above t ≥ 0, of a little less and of a little more ν.
    fn above_beside(&self, t: f64) -> [f64; 2] {
        [-STEP, STEP].map(|step| student_t_tail(t, self.nu + step * self.nu))
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

    /// Log of the probability of less than z.
    pub(super) fn ln_below(&self, z: f64) -> f64 {
        let at = self.quantile * z;
        ln_of_side(at, student_t_tail(at.abs(), self.nu))
    }

    /// Log of the probability of less than z, with its slopes.
    pub(super) fn ln_probability(&self, z: f64) -> LnOfNoise {
        let at = self.quantile * z;
        let above = student_t_tail(at.abs(), self.nu);
        if at > 0.0 && above < LOST {
            return LnOfNoise::default();
        }
        let [less, more] = self.above_beside(at.abs());
        let above_nu = (more / less).ln() / (2.0 * STEP * self.nu);
        let (probability, of_nu) = if at > 0.0 {
            let below = 1.0 - above;
            (below, -above_nu * above / below)
        } else {
            (above, above_nu)
        };
        let slope = self.density(at) * self.quantile / probability;
        LnOfNoise {
            value: ln_of_side(at, above),
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
