//! Computes the log likelihood of dry runs with normal noise of one spread, from a few sums over those of each sphere.

use super::errors::Errors;
use super::run_density::{RunDensity, Seen, Side};
use super::run_law::RunImpact;
use super::run_noise::RunNoise;
use crate::distributions::LN_ROOT_TWO_PI;
use crate::physics::balance::{Balance, Impact};
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::runs::Runs;
use crate::scene::{Scene, Sticking};

/// The dry runs of a sphere: their rebounds need a few numbers, with y = 1 − e = k p + σ z.
#[derive(Debug, Clone, Default)]
pub(super) struct DryRuns {
    rebounds: f64,
    /// Σ p y / Σ p²
    slope: f64,
    /// Σ p²
    weight: f64,
    /// Σ (y − slope p)²
    leftover: f64,
    /// Σ p³, Σ p⁴ and Σ p² (y − slope p), which the second order wants
    bent: [f64; 3],
    /// sides of the limit that runs came out on, each with p and how often it counts: those that stuck and, where such runs
    /// were not logged, those that rebounded, by whose probability a density is divided
    sides: Vec<(Side, f64, f64)>,
}

impl DryRuns {
    /// Those of a sphere, by its index.
    pub fn of(scene: &Scene, runs: &Runs, sphere: usize) -> DryRuns {
        let mut sums = DryRuns::default();
        let groups = || runs.dry.iter().filter(|group| group.sphere == sphere);
        let numbers = |run: usize| {
            let (count, y) = (runs.count(run), 1.0 - runs.restitution[run]);
            (runs.impacts.speed_root[run], y, count)
        };
        let rebounds = || groups().flat_map(|group| group.rebounds.clone()).map(numbers);
        let mut cross = 0.0;
        for (p, y, count) in rebounds() {
            sums.rebounds += count;
            sums.weight += count * p * p;
            cross += count * p * y;
        }
        if sums.rebounds > 0.0 {
            sums.slope = cross / sums.weight;
        }
        // about the fit, where nothing cancels
        for (p, y, count) in rebounds() {
            let left = y - sums.slope * p;
            sums.leftover += count * left * left;
            let square = p * p;
            for (sum, term) in sums.bent.iter_mut().zip([square * p, square * square, square * left]) {
                *sum += count * term;
            }
        }
        let stuck = groups().flat_map(|group| group.stuck.clone()).map(numbers);
        sums.sides.extend(stuck.map(|(p, _, count)| (Side::Below, p, count)));
        if scene.model.sticking == Sticking::Truncated {
            sums.sides
                .extend(rebounds().map(|(p, _, count)| (Side::Above, p, -count)));
        }
        sums
    }

    /// Σ (e − e_dry)² over the rebounds, and its slope in k.
    fn squares(&self, order: Order, k: f64) -> (f64, f64) {
        let distance = k - self.slope;
        let first = (
            self.leftover + self.weight * distance * distance,
            2.0 * self.weight * distance,
        );
        match order {
            Order::First => first,
            // with y − k p + a k² p² = u − distance p + a k² p², where Σ p u = 0
            Order::Second => {
                let [cubes, fourth, bend] = self.bent;
                let a = SECOND_ORDER;
                let square = k * k;
                (
                    first.0 + a * square * (a * square * fourth + 2.0 * (bend - distance * cubes)),
                    first.1 + 4.0 * a * k * (a * square * fourth + bend - distance * cubes) - 2.0 * a * square * cubes,
                )
            }
        }
    }

    /// Their log likelihood under this k, with its slopes in the noise and in k.
    pub fn density(&self, noise: &RunNoise, order: Order, k: f64, limit: f64) -> RunDensity {
        // without runs σ may be anything
        if self.rebounds == 0.0 && self.sides.is_empty() {
            return RunDensity::default();
        }
        let sigma = noise.spreads.sigma;
        let precision = 1.0 / (sigma * sigma);
        let (squares, slope) = self.squares(order, k);
        let mut all = RunDensity {
            value: -self.rebounds * (sigma.ln() + LN_ROOT_TWO_PI) - 0.5 * squares * precision,
            sigma: (squares * precision - self.rebounds) / sigma,
            dry_k: -0.5 * slope * precision,
            ..RunDensity::default()
        };
        let balance = Balance::dry(order, k);
        for (side, dry_root, count) in &self.sides {
            let run = RunImpact {
                balance: &balance,
                impact: Impact {
                    dry_root: *dry_root,
                    ..Impact::default()
                },
                errors: Errors::NONE,
            };
            all.add(run.density(noise, Seen::On(*side, limit)), *count);
        }
        all
    }
}
