//! Takes many rebounds with normal noise on the energy kept at once: one register holds a node of as many of them.
//!
//! What a rebound by itself waits for, others fill: a third of the time of [`Hidden::integrate`](super::Hidden::integrate), which
//! takes those that sixteen nodes do not do for, and which the numbers here are held to.

use pulp::{Arch, Simd, WithSimd};

use super::gauss::{is_small, HERMITE};
use crate::distributions::LN_ROOT_TWO_PI;
use crate::exponential::{exponential, is_fused, logarithm};
use crate::model::likelihood::run_density::RunDensity;
use crate::model::likelihood::run_noise::RunNoise;
use crate::physics::rebound::kept_and_slope;

/// Rebounds of one call.
pub(in crate::model::likelihood) const MOST_REBOUNDS: usize = 64;

/// A number of each rebound.
type Column = [f64; MOST_REBOUNDS];

/// Rebounds that were measured without errors.
pub(in crate::model::likelihood) struct Rebounds {
    count: usize,
    /// e
    restitution: Column,
    /// r
    kept: Column,
}

impl Rebounds {
    pub const NONE: Rebounds = Rebounds {
        count: 0,
        restitution: [0.0; MOST_REBOUNDS],
        kept: [0.0; MOST_REBOUNDS],
    };

    pub fn push(&mut self, restitution: f64, kept: f64) {
        (self.restitution[self.count], self.kept[self.count]) = (restitution, kept);
        self.count += 1;
    }

    /// The log density of each under normal noise, with its slopes in r and in the spreads; `None` where its integrand is not all
    /// but normal.
    pub fn densities(&self, noise: RunNoise) -> [Option<RunDensity>; MOST_REBOUNDS] {
        Arch::new().dispatch(ByLanes { of: self, noise })
    }
}

struct ByLanes<'r> {
    of: &'r Rebounds,
    noise: RunNoise,
}

impl WithSimd for ByLanes<'_> {
    type Output = [Option<RunDensity>; MOST_REBOUNDS];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        /// of Gauss–Newton's from the restitution
        const STEPS: usize = 3;
        /// widths beyond which a bell has nothing
        const FAR: f64 = 6.7;
        /// of which [`logarithm`] gives the logarithm
        const MASS: std::ops::Range<f64> = 1e-300..1e300;
        let fused = is_fused::<S>();
        let RunNoise { sigma, energy, .. } = self.noise;
        let (own, of_energy) = (1.0 / sigma, 1.0 / energy);
        let count = self.of.count.next_multiple_of(8).min(MOST_REBOUNDS);
        let (restitution, kept) = (&self.of.restitution[..count], &self.of.kept[..count]);
        let [mut x, mut width, mut reference, mut mass, mut of_r, mut of_energies, mut of_own, mut odd, mut even] =
            [[0.0; MOST_REBOUNDS]; 9];
        let bells = x.iter_mut().zip(&mut width).zip(&mut reference);
        for (((x, width), reference), (e, r)) in bells.zip(restitution.iter().zip(kept)) {
            let (mut place, mut variance) = (*e, 1.0);
            for _ in 0..STEPS {
                // far from the turn m⁻¹(x) is x |x|, and near it there is no bell
                let a = (place * place.abs() - r) * of_energy;
                let slope = 2.0 * place.abs() * of_energy;
                variance = 1.0 / (own * own + slope * slope);
                place += ((e - place) * own * own - a * slope) * variance;
            }
            let (a, b) = ((place * place.abs() - r) * of_energy, (e - place) * own);
            (*x, *width, *reference) = (place, variance.sqrt(), -0.5 * (a * a + b * b));
        }
        for [node, weight, last] in HERMITE {
            for rebound in 0..count {
                let (e, r) = (restitution[rebound], kept[rebound]);
                let mut parts = [0.0; 2];
                for (part, apart) in parts.iter_mut().zip([-node, node]) {
                    let place = x[rebound] + width[rebound] * apart;
                    let (y, stretch) = kept_and_slope(place);
                    let (a, b) = ((y - r) * of_energy, (e - place) * own);
                    let ln = -0.5 * (a * a + b * b) - reference[rebound];
                    *part = weight * stretch * exponential(ln, fused);
                    of_r[rebound] += *part * a;
                    of_energies[rebound] += *part * a * a;
                    of_own[rebound] += *part * b * b;
                }
                let [below, above] = parts;
                mass[rebound] += below + above;
                odd[rebound] += last * (above - below);
                even[rebound] += last * node * (above + below);
            }
        }
        let ln_scale = (own * of_energy).ln() - 2.0 * LN_ROOT_TWO_PI;
        let mut found = [None; MOST_REBOUNDS];
        for (rebound, found) in found.iter_mut().enumerate().take(self.of.count) {
            let mass = mass[rebound];
            let is_bell = x[rebound] > FAR * width[rebound] && is_small([odd[rebound], even[rebound]], mass);
            if !is_bell || !MASS.contains(&mass) {
                continue;
            }
            let [of_r, of_energies, of_own] = [of_r, of_energies, of_own].map(|sums| sums[rebound] / mass);
            *found = Some(RunDensity {
                value: reference[rebound] + logarithm(mass * width[rebound], fused) + ln_scale,
                kept: of_r * of_energy,
                sigma: (of_own - 1.0) * own,
                energy: (of_energies - 1.0) * of_energy,
                ..RunDensity::default()
            });
        }
        found
    }
}
