//! Sums the weighted squares of a joint fit over its runs, anywhere about its minimum.

use super::joint::{JointFit, JointRow};
use super::profile::Squares;
use super::sums::{add_square, Sums};
use crate::physics::rebound::{bend_mean_restitution, slope_mean_restitution};

/// The weighted squares of a joint fit.
pub struct JointSquares<'p, 'r> {
    /// the fit
    pub problem: &'p JointFit<'r>,
    /// the root of the weight of each residual beside the fit's own; empty for none
    pub roots: &'p [f64],
    /// what was taken off the minimum's parameters; empty for nothing
    pub bias: &'p [f64],
}

impl JointSquares<'_, '_> {
    /// Hands on every residual with its slopes, each with its parameter's place; of a wet run the row, too. `None` outside
    /// the domain.
    fn each(&self, b: &[f64], mut hand_on: impl FnMut(f64, &[(usize, f64)], Option<&JointRow>)) -> Option<()> {
        let mut b = b.to_vec();
        b.iter_mut().zip(self.bias).for_each(|(b, bias)| *b += bias);
        if !self.problem.joint.holds(&b) {
            return None;
        }
        let root_of = |residual: usize| self.roots.get(residual).copied().unwrap_or(1.0);
        let mut rebounds = 0;
        self.problem.each_rebound(&b, |residual, part, root, row| {
            let root = root * root_of(residual);
            let wet = part.series.is_some().then_some(&row);
            hand_on(root * row.residual, &part.slopes(&row, root), wet);
            rebounds = residual + 1;
        });
        for (known, residual) in self.problem.known.iter().zip(rebounds..) {
            let root = known.root * root_of(residual);
            hand_on((b[known.place] - known.value) * root, &[(known.place, root)], None);
        }
        Some(())
    }
}

impl Squares for JointSquares<'_, '_> {
    fn at(&self, b: &[f64]) -> Option<f64> {
        let mut squares = 0.0;
        self.each(b, |residual, _, _| squares += residual * residual)?;
        squares.is_finite().then_some(squares)
    }

    /// To the information is added what the bend of m(r) has of the squares' curvature where it adds to it: without it,
    /// steps leap to and fro over a run near r = 0 that rebounded by luck.
    fn sums_at(&self, b: &[f64]) -> Option<Sums> {
        let mut sums = Sums::new(self.problem.joint.parameters());
        self.each(b, |residual, slopes, wet| {
            sums.add(residual, slopes);
            let bent = wet.map_or(0.0, |row| {
                row.residual * bend_mean_restitution(row.kept) / slope_mean_restitution(row.kept).powi(2)
            });
            if bent > 0.0 {
                add_square(&mut sums.information, bent, slopes);
            }
        })?;
        sums.squares.is_finite().then_some(sums)
    }
}
