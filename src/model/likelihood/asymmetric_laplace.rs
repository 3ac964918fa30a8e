//! Computes the density and the probability of asymmetric Laplace noise: two exponentials of different slope.
//!
//! So scatter the restitutions of spheres on rough plates (Montaine, Heckel, Kruelle, Schwager and Pöschel 2011, Physical Review
//! E 84, 041306). The kink between both is rounded by a little normal noise, so that the density has slopes of every order
//! (the normal-Laplace distribution of Reed and Jorgensen 2004): z = m + b x − a y + τ n with x and y exponential of mean 1 and
//! n standard normal. Mean 0 and variance 1 ask for m = a − b and a² + b² + τ² = 1; η = ln(b/a) is the asymmetry.
//!
//! With s = z − m, T₁ = exp(τ²/(2b²) − s/b) Φ(s/τ − τ/b) and T₂ = exp(τ²/(2a²) + s/a) Φ(−s/τ − τ/a) the density is
//! (T₁ + T₂)/(a + b), and T₁′ = −T₁/b + φ(s/τ)/τ, T₂′ = T₂/a − φ(s/τ)/τ give the rest.

use rand::Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};

use super::normal::{ln_normal_cdf, ln_scaled_tail};
use crate::distributions::LN_ROOT_TWO_PI;

/// τ, the standard deviation of the normal part.
const ROUNDING: f64 = 0.15;

/// The distribution of an asymmetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsymmetricLaplace {
    /// a, the mean of the exponential below the kink
    below: f64,
    /// b, that of the one above it
    above: f64,
}

/// Φ(s/τ), T₁ and T₂, divided by the exponential of the largest of their logarithms.
struct Parts {
    top: f64,
    normal: f64,
    falls: f64,
    rises: f64,
}

impl AsymmetricLaplace {
    /// Of η.
    pub fn new(asymmetry: f64) -> AsymmetricLaplace {
        let both = (1.0 - ROUNDING * ROUNDING).sqrt();
        AsymmetricLaplace {
            below: both / (1.0 + (2.0 * asymmetry).exp()).sqrt(),
            above: both / (1.0 + (-2.0 * asymmetry).exp()).sqrt(),
        }
    }

    /// z of the kink.
    fn kink(&self) -> f64 {
        self.below - self.above
    }

    /// The same with the sides exchanged.
    fn mirrored(&self) -> AsymmetricLaplace {
        AsymmetricLaplace {
            below: self.above,
            above: self.below,
        }
    }

    /// ln T₁ and ln T₂ at z.
    fn ln_parts(&self, z: f64) -> [f64; 2] {
        let s = z - self.kink();
        let part = |mean: f64, s: f64| {
            let (steep, apart) = (ROUNDING / mean, s / ROUNDING);
            // of a steep side both parts of the first are large, and all but equal
            if steep > apart {
                ln_scaled_tail(steep - apart) - 0.5 * apart * apart
            } else {
                0.5 * steep * steep - s / mean + ln_normal_cdf(apart - steep).0
            }
        };
        [part(self.above, s), part(self.below, -s)]
    }

    /// ln f(z) and its slope.
    pub fn ln_density(&self, z: f64) -> [f64; 2] {
        let parts = self.ln_parts(z);
        let top = parts[0].max(parts[1]);
        let [falls, rises] = parts.map(|part| (part - top).exp());
        let sum = falls + rises;
        [
            top + (sum / (self.below + self.above)).ln(),
            (rises / self.below - falls / self.above) / sum,
        ]
    }

    /// ln F(z).
    pub fn ln_probability(&self, z: f64) -> f64 {
        if z > 0.0 {
            (-self.mirrored().ln_lower_tail(-z).exp()).ln_1p()
        } else {
            self.ln_lower_tail(z)
        }
    }

    /// ln F(z), to rounding where F is small.
    fn ln_lower_tail(&self, z: f64) -> f64 {
        let parts = self.parts_of_probability(z);
        parts.top + self.probability(&parts).ln()
    }

    /// Mean of what lies below z: z less ∫ F up to z over F(z).
    pub fn mean_below(&self, z: f64) -> f64 {
        let (a, b) = (self.below, self.above);
        let parts = self.parts_of_probability(z);
        let apart = (z - self.kink()) / ROUNDING;
        let density = (-0.5 * apart * apart - LN_ROOT_TWO_PI - parts.top).exp();
        let integral = z * parts.normal + ROUNDING * density + (b * b * parts.falls + a * a * parts.rises) / (a + b);
        z - integral / self.probability(&parts)
    }

    /// F of these parts.
    fn probability(&self, parts: &Parts) -> f64 {
        parts.normal + (self.below * parts.rises - self.above * parts.falls) / (self.below + self.above)
    }

    fn parts_of_probability(&self, z: f64) -> Parts {
        let [falls, rises] = self.ln_parts(z);
        let normal = ln_normal_cdf((z - self.kink()) / ROUNDING).0;
        let top = normal.max(rises).max(falls);
        Parts {
            top,
            normal: (normal - top).exp(),
            falls: (falls - top).exp(),
            rises: (rises - top).exp(),
        }
    }

    /// A draw of z.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let [above, below]: [f64; 2] = [Exp1.sample(rng), Exp1.sample(rng)];
        let normal: f64 = StandardNormal.sample(rng);
        self.kink() + self.above * above - self.below * below + ROUNDING * normal
    }
}
