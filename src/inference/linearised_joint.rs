//! Solves a joint fit that is linear about a point, from sums over its rows.
//!
//! Symbols: J are the slopes of the rows, each over its sd, r what they leave at the point, A = JᵀJ. The least squares are
//! at the step −A⁻¹Jᵀr, a change Δe of the rows moves them by A⁻¹JᵀΔe, and a row of slopes j has the leverage jᵀA⁻¹j. In
//! directions that the rows do not identify A⁻¹ is 0.

use nalgebra::{DMatrix, DVector};

use super::information::{axes, function, scaled};
use super::sums::{along, square, Sums};

/// Directions with less of this share of the information, all parameters scaled to one, are not identified.
const UNSEEN: f64 = 1e-10;

/// The inverse of an information matrix in the directions that are identified.
pub struct Inverse {
    /// A⁻¹
    pub matrix: DMatrix<f64>,
    /// how many directions are identified
    pub rank: usize,
    /// whether each parameter is
    pub identified: Vec<bool>,
}

impl Inverse {
    /// Inverts what can be inverted.
    pub fn of(information: &DMatrix<f64>) -> Inverse {
        let over = |sum: f64| if sum > 0.0 { 1.0 / sum.sqrt() } else { 0.0 };
        let scale: Vec<f64> = information.diagonal().iter().copied().map(over).collect();
        let Some(axes) = axes(scaled(information, &scale)) else {
            return Inverse {
                matrix: DMatrix::zeros(scale.len(), scale.len()),
                rank: 0,
                identified: vec![false; scale.len()],
            };
        };
        let is_identified = |strength: f64| strength > UNSEEN;
        let kept = function(&axes, |strength| f64::from(u8::from(is_identified(strength)))).diagonal();
        let identified = |(scale, kept): (&f64, &f64)| *scale > 0.0 && *kept > 1.0 - 1e-6;
        let matrix = function(
            &axes,
            |strength| if is_identified(strength) { 1.0 / strength } else { 0.0 },
        );
        Inverse {
            rank: axes
                .eigenvalues
                .iter()
                .filter(|strength| is_identified(**strength))
                .count(),
            identified: scale.iter().zip(&kept).map(identified).collect(),
            matrix: scaled(&matrix, &scale),
        }
    }

    /// The parameter that JᵀΔe moves most, and by how many standard errors of rows with the sd 1.
    pub fn moved_most(&self, pull: &DVector<f64>) -> Option<(usize, f64)> {
        let shift = &self.matrix * pull;
        let in_se = |j: usize| shift[j].abs() / self.matrix[(j, j)].sqrt();
        let identified = (0..shift.len()).filter(|j| self.identified[*j]);
        identified.map(|j| (j, in_se(j))).max_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// A joint fit that is linear about a point.
pub struct LinearisedJoint {
    /// from the point to the least squares
    pub step: DVector<f64>,
    /// A⁻¹
    pub inverse: Inverse,
    /// Σ residual² there
    pub left: f64,
}

/// What a fit leaves of some rows.
#[derive(Clone, Copy, Default)]
pub struct RowsLeft {
    /// Σ residual²
    pub squares: f64,
    /// the rows less the parameters spent on them
    pub freedom: f64,
}

impl RowsLeft {
    /// Adds other rows.
    pub fn add(&mut self, other: RowsLeft) {
        self.squares += other.squares;
        self.freedom += other.freedom;
    }
}

impl LinearisedJoint {
    /// The fit to all rows.
    pub fn new(sums: &Sums) -> LinearisedJoint {
        let inverse = Inverse::of(&sums.information);
        let step = -(&inverse.matrix * &sums.gradient);
        LinearisedJoint {
            left: sums.squares + sums.gradient.dot(&step),
            step,
            inverse,
        }
    }

    /// What the fit, in which they have this weight, leaves of some rows; sums of further parameters are not read.
    pub fn leaves(&self, sums: &Sums, weight: f64) -> RowsLeft {
        let n = self.step.len();
        let information = sums.information.view((0, 0), (n, n));
        let squares =
            sums.squares + 2.0 * sums.gradient.rows(0, n).dot(&self.step) + (information * &self.step).dot(&self.step);
        let spent = self.inverse.matrix.component_mul(&information).sum();
        RowsLeft {
            squares: squares.max(0.0),
            freedom: sums.runs as f64 - weight * spent,
        }
    }

    /// By how much the fit moves the model of a row.
    pub fn shift(&self, slopes: &[(usize, f64)]) -> f64 {
        along(slopes, &self.step)
    }

    /// The leverage of a row.
    pub fn leverage(&self, slopes: &[(usize, f64)]) -> f64 {
        square(&self.inverse.matrix, slopes)
    }

    /// By how much each standard error is too small where the rows' scores have the information `scores`; `None` of a
    /// parameter that is not identified.
    pub fn widening(&self, scores: &DMatrix<f64>) -> Vec<Option<f64>> {
        let inverse = &self.inverse.matrix;
        let covariance = (inverse * scores * inverse).diagonal();
        let ratio = |j: usize| (covariance[j] / inverse[(j, j)]).sqrt();
        let identified = self.inverse.identified.iter().enumerate();
        identified
            .map(|(j, identified)| identified.then(|| ratio(j)).filter(|ratio| ratio.is_finite()))
            .collect()
    }
}
