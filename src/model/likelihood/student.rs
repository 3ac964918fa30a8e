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

    pub fn density(self, t: f64) -> f64 {
        self.ln_density(t).exp()
    }

    /// The densities of some whose ν differ by no more than a thousandth, with one logarithm.
    pub fn density_of_each<const N: usize>(all: [StudentT; N], t: f64) -> [f64; N] {
        let square = t * t;
        let Some(first) = all.first().map(|of| square / of.nu) else {
            return [0.0; N];
        };
        let ln_tail = first.ln_1p();
        all.map(|of| {
            // of a thousandth, ln(1 + u) to rounding
            let u = (square / of.nu - first) / (1.0 + first);
            let ln_tail = ln_tail + u * (1.0 - u * (0.5 - u * (1.0 / 3.0 - 0.25 * u)));
            (of.peak - 0.5 * (of.nu + 1.0) * ln_tail).exp()
        })
    }

    /// The probability of more than t, for t at or above 0; no number where t or ν is none.
    pub fn above(self, t: f64) -> f64 {
        let [above] = StudentT::above_of_each([self], t, [self.density(t)]);
        above
    }

    /// The probability of more than t of some whose ν are nearly one, all at once, with the density of each there.
    ///
    /// Half of I_x(ν/2, 1/2) at x = ν/(ν + t²), or half of what I_(1−x)(1/2, ν/2) leaves of one, whichever fraction is short;
    /// the power before either holds the density.
    pub fn above_of_each<const N: usize>(all: [StudentT; N], t: f64, density: [f64; N]) -> [f64; N] {
        let square = t * t;
        if square.is_infinite() {
            // below the smallest number for any ν in use
            return [0.0; N];
        }
        let mut found = density.map(|density| density * t);
        let near = |of: &StudentT| square / (of.nu + square) * (2.5 + 0.5 * of.nu) < 1.5;
        if all.first().is_some_and(near) {
            let fractions = beta_fractions(all.map(|of| [0.5, 0.5 * of.nu, square / (of.nu + square)]));
            for (found, fraction) in found.iter_mut().zip(fractions) {
                *found = 0.5 - *found * fraction;
            }
        } else {
            let fractions = beta_fractions(all.map(|of| [0.5 * of.nu, 0.5, of.nu / (of.nu + square)]));
            for ((found, fraction), of) in found.iter_mut().zip(fractions).zip(all) {
                *found *= fraction / of.nu;
            }
        }
        found
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
            let step = (self.above(t) - ABOVE_ONE) / self.density(t);
            t += step;
            // the next would be the square of it
            if step.abs() < ENOUGH {
                break;
            }
        }
        t
    }
}

/// The fractions by which x^a (1 − x)^b/(a B(a, b)) are I_x(a, b), of some (a, b, x) that are nearly one; short for x below
/// (a + 1)/(a + b + 2).
///
/// Source: NIST Digital Library of Mathematical Functions, 8.17.22, summed forwards (Lentz).
fn beta_fractions<const N: usize>(all: [[f64; 3]; N]) -> [f64; N] {
    /// each step adds a digit or more where the fraction is short
    const STEPS: u32 = 200;
    /// a few roundings: the next step would move it by less than one
    const ENOUGH: f64 = 1e-15;
    let reciprocal = |denominator: f64| {
        1.0 / if denominator == 0.0 {
            f64::MIN_POSITIVE
        } else {
            denominator
        }
    };
    let mut above = [1.0; N];
    let mut below = all.map(|[a, b, x]| reciprocal(1.0 - (a + b) * x / (a + 1.0)));
    let mut fractions = below;
    for step in 1..=STEPS {
        let m = f64::from(step);
        let mut farthest = 0.0;
        // a step of each: one by itself waits for its divisions
        for (place, [a, b, x]) in all.into_iter().enumerate() {
            let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
            let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
            let (below, above) = (&mut below[place], &mut above[place]);
            *below = reciprocal(1.0 + even * *below);
            *above = 1.0 + even / *above;
            let mut factor = *below * *above;
            *below = reciprocal(1.0 + odd * *below);
            *above = 1.0 + odd / *above;
            factor *= *below * *above;
            fractions[place] *= factor;
            farthest = (factor - 1.0).abs().max(farthest);
        }
        if farthest < ENOUGH {
            break;
        }
    }
    fractions
}
