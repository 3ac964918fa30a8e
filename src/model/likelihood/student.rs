//! Computes the density and the tails of Student's t.

use crate::distributions::student_t_peak;

/// Student's t of some degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StudentT {
    /// ν
    nu: f64,
    /// ln of the density at 0
    pub peak: f64,
}

impl StudentT {
    pub fn new(nu: f64) -> StudentT {
        StudentT {
            nu,
            peak: student_t_peak(nu),
        }
    }

    pub fn ln_density(self, t: f64) -> f64 {
        self.peak - 0.5 * (self.nu + 1.0) * (t * t / self.nu).ln_1p()
    }

    /// The probability of more than t, for t at or above 0; no number where t or ν is none.
    ///
    /// Half of I_x(ν/2, 1/2) at x = ν/(ν + t²), or half of what I_(1−x)(1/2, ν/2) leaves of one, whichever fraction is short;
    /// the power before either holds the density.
    pub fn above(self, t: f64) -> f64 {
        let StudentT { nu, .. } = self;
        let square = t * t;
        if square.is_infinite() {
            // below the smallest number for any ν in use
            return 0.0;
        }
        let (share, rest) = (nu / (nu + square), square / (nu + square));
        let density = self.ln_density(t).exp();
        if rest * (2.5 + 0.5 * nu) < 1.5 {
            0.5 - density * t * beta_fraction(0.5, 0.5 * nu, rest)
        } else {
            density * t / nu * beta_fraction(0.5 * nu, 0.5, share)
        }
    }

    /// Log of the probability of less than t.
    pub fn ln_below(self, t: f64) -> f64 {
        if t > 0.0 {
            (-self.above(t)).ln_1p()
        } else {
            self.above(-t).ln()
        }
    }

    /// The quantile with as much above it as above 1 of the standard normal.
    pub fn quantile_of_one(self) -> f64 {
        const ABOVE_ONE: f64 = 0.158_655_253_931_457_05;
        /// from the start used here the fourth step is below rounding for any ν above 2
        const STEPS: usize = 4;
        const ENOUGH: f64 = 1e-8;
        // Abramowitz & Stegun 26.7.5 to second order, at 1
        let mut t = 1.0 + (0.5 + 0.25 / self.nu) / self.nu;
        for _ in 0..STEPS {
            let step = (self.above(t) - ABOVE_ONE) / self.ln_density(t).exp();
            t += step;
            // the next would be the square of it
            if step.abs() < ENOUGH {
                break;
            }
        }
        t
    }
}

/// The fraction by which x^a (1 − x)^b/(a B(a, b)) is I_x(a, b); short for x below (a + 1)/(a + b + 2).
///
/// Source: NIST Digital Library of Mathematical Functions, 8.17.22, summed forwards (Lentz).
fn beta_fraction(a: f64, b: f64, x: f64) -> f64 {
    /// each step adds a digit or more where the fraction is short
    const STEPS: u32 = 200;
    const ENOUGH: f64 = 1e-16;
    let reciprocal = |denominator: f64| {
        1.0 / if denominator == 0.0 {
            f64::MIN_POSITIVE
        } else {
            denominator
        }
    };
    let mut above = 1.0;
    let mut below = reciprocal(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = below;
    for step in 1..=STEPS {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        below = reciprocal(1.0 + even * below);
        above = 1.0 + even / above;
        fraction *= below * above;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        below = reciprocal(1.0 + odd * below);
        above = 1.0 + odd / above;
        let factor = below * above;
        fraction *= factor;
        if (factor - 1.0).abs() < ENOUGH {
            break;
        }
    }
    fraction
}
