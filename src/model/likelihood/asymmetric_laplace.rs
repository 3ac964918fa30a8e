//! Computes the density and the probability of asymmetric Laplace noise: two exponentials of different slope.
//!
//! So scatter the restitutions of spheres on rough plates (Montaine, Heckel, Kruelle, Schwager and Pöschel 2011, Physical Review
//! E 84, 041306). The kink between both is rounded by a little normal noise, so that the density has slopes of every order
//! (the normal-Laplace distribution of Reed and Jorgensen 2004): z = m + b x − a y + τ n with x and y exponential of mean 1 and
//! n standard normal. Mean 0 and variance 1 ask for m = a − b and a² + b² + τ² = 1; η = ln(b/a) is the asymmetry.
//!
//! With s = z − m, T₁ = exp(τ²/(2b²) − s/b) Φ(s/τ − τ/b) and T₂ = exp(τ²/(2a²) + s/a) Φ(−s/τ − τ/a) the density is
//! (T₁ + T₂)/(a + b) and the probability Φ(s/τ) + (a T₂ − b T₁)/(a + b); T₁′ = −T₁/b + φ(s/τ)/τ, T₂′ = T₂/a − φ(s/τ)/τ. Of
//! a and b T₁ has the slope (s − τ²/b) T₁/b² + τ φ(s/τ)/b² in b, T₂ the mirrored one in a; a′ = −a b²/(a² + b²) and
//! b′ = b a²/(a² + b²) in η.

use rand::Rng;
use rand_distr::{Distribution, Exp1, StandardNormal};

use super::normal::{ln_normal_cdf, ln_scaled_tail};
use super::run_density::LnOfNoise;
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

    /// Slopes of a and b in η.
    fn slopes(&self) -> [f64; 2] {
        let AsymmetricLaplace { below, above } = self;
        let both = below * below + above * above;
        [-below * above * above / both, above * below * below / both]
    }

    /// ln T₁ and ln T₂.
    fn ln_parts(&self, s: f64) -> [f64; 2] {
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

    /// Slopes of ln T₁ and ln T₂ in η, but for those of Φ in them.
    fn slopes_of_parts(&self, s: f64) -> [f64; 2] {
        let [of_below, of_above] = self.slopes();
        let part = |mean: f64, of_mean: f64, s: f64, of_s: f64| {
            (of_mean * (s - ROUNDING * ROUNDING / mean) / mean - of_s) / mean
        };
        let of_s = of_above - of_below;
        [
            part(self.above, of_above, s, of_s),
            part(self.below, of_below, -s, -of_s),
        ]
    }

    /// ln f(z), with its slopes.
    pub(super) fn ln_density(&self, z: f64) -> LnOfNoise {
        let (a, b, s) = (self.below, self.above, z - self.kink());
        let parts = self.ln_parts(s);
        let top = parts[0].max(parts[1]);
        let [falls, rises] = parts.map(|part| (part - top).exp());
        let sum = falls + rises;
        let ([of_falls, of_rises], [of_a, of_b]) = (self.slopes_of_parts(s), self.slopes());
        let of_rounding = ROUNDING * scaled_normal(s, top) * (of_a / (a * a) + of_b / (b * b));
        LnOfNoise {
            value: top + (sum / (a + b)).ln(),
            z: (rises / a - falls / b) / sum,
            shape: (falls * of_falls + rises * of_rises + of_rounding) / sum - (of_a + of_b) / (a + b),
        }
    }

    /// ln F(z), with its slopes.
    pub(super) fn ln_probability(&self, z: f64) -> LnOfNoise {
        if z > 0.0 {
            // F(z) is 1 less F(−z) with the sides, and so η, the other way round
            let above = self.mirrored().ln_lower_tail(-z);
            let value = (-above.value.exp()).ln_1p();
            let odds = (above.value - value).exp();
            LnOfNoise {
                value,
                z: above.z * odds,
                shape: above.shape * odds,
            }
        } else {
            self.ln_lower_tail(z)
        }
    }

    /// The same with the sides exchanged, and so η the other way round.
    pub(super) fn ln_probability_mirrored(&self, z: f64) -> LnOfNoise {
        let of = self.mirrored().ln_probability(z);
        LnOfNoise { shape: -of.shape, ..of }
    }

    /// ln F(z), with its slopes, to rounding where F is small.
    fn ln_lower_tail(&self, z: f64) -> LnOfNoise {
        let (a, b, s) = (self.below, self.above, z - self.kink());
        let [falls, rises] = self.ln_parts(s);
        let normal = ln_normal_cdf(s / ROUNDING).0;
        let top = normal.max(rises).max(falls);
        let [normal, falls, rises] = [normal, falls, rises].map(|part| (part - top).exp());
        let ([of_falls, of_rises], [of_a, of_b]) = (self.slopes_of_parts(s), self.slopes());
        let both = a + b;
        let sides = (a * rises - b * falls) / both;
        let of_sides =
            of_a * rises + a * rises * of_rises - of_b * falls - b * falls * of_falls - sides * (of_a + of_b);
        let probability = normal + sides;
        LnOfNoise {
            value: top + probability.ln(),
            z: (falls + rises) / both / probability,
            shape: (of_sides - ROUNDING * scaled_normal(s, top)) / both / probability,
        }
    }

    /// A draw of z.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let [above, below]: [f64; 2] = [Exp1.sample(rng), Exp1.sample(rng)];
        let normal: f64 = StandardNormal.sample(rng);
        self.kink() + self.above * above - self.below * below + ROUNDING * normal
    }
}

/// φ(s/τ) over the exponential of this.
fn scaled_normal(s: f64, top: f64) -> f64 {
    (-0.5 * (s / ROUNDING).powi(2) - LN_ROOT_TWO_PI - top).exp()
}
