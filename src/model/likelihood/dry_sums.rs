//! Holds the sums that the dry rebounds of a sphere need, and gives their squares about a law.

use crate::physics::dry::{Order, SECOND_ORDER};

/// The dry runs of a sphere: their rebounds need four numbers, with y = 1 − e = k p + σ z.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct DryRuns {
    pub(super) rebounds: f64,
    /// Σ p y / Σ p²
    pub(super) slope: f64,
    /// Σ p²
    pub(super) weight: f64,
    /// Σ (y − slope p)²
    pub(super) leftover: f64,
    /// Σ p³, Σ p⁴ and Σ p² (y − slope p), which the second order wants
    pub(super) bent: [f64; 3],
    /// stuck runs, by p with their count
    pub(super) stuck: Vec<[f64; 2]>,
    /// rebounds, by p with their count, where stuck runs were not logged
    pub(super) logged: Vec<[f64; 2]>,
}

impl DryRuns {
    /// Σ (e − e_dry)² over the rebounds, and its slope in k.
    pub(super) fn squares(&self, order: Order, k: f64) -> (f64, f64) {
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
}
