//! Puts the sums of all parts together: the joint fit linearised, in units of each run's sd.

use nalgebra::{DMatrix, DVector};

use super::rows::{GroupedPart, Rows};
use crate::inference::information::{axes, function, scaled, Sums};
use crate::inference::joint::{JointRow, MOST_SLOPES};

/// Directions with less of this share of the information, all parameters scaled to one, are not identified.
const UNSEEN: f64 = 1e-10;

/// Sums over all runs at one point, in the order of the parameters' names.
pub(super) struct NormalEquations {
    pub(super) squares: f64,
    pub(super) gradient: DVector<f64>,
    pub(super) information: DMatrix<f64>,
}

impl NormalEquations {
    /// The sums of a part without runs: its parameters, and last an offset of all its restitutions.
    pub(super) fn blank(part: &GroupedPart) -> Sums {
        Sums::new(part.places.len() + 1)
    }

    /// Adds a run to the sums of its part.
    pub(super) fn add(sums: &mut Sums, part: &GroupedPart, row: &JointRow, sd: f64) {
        let offset = part.places.len();
        let mut slopes = [(offset, 1.0 / sd); 1 + MOST_SLOPES];
        for (j, slope) in row.slopes[..offset].iter().enumerate() {
            slopes[j] = (j, slope / sd);
        }
        sums.add(row.residual / sd, &slopes[..=offset]);
    }

    /// Puts the parts together, each with its weight.
    pub(super) fn new(rows: &Rows, sums: &[Sums], weight: impl Fn(usize) -> f64) -> NormalEquations {
        let parameters = rows.names.len();
        let mut joint = NormalEquations {
            squares: 0.0,
            gradient: DVector::zeros(parameters),
            information: DMatrix::zeros(parameters, parameters),
        };
        for (index, (part, sums)) in rows.parts.iter().zip(sums).enumerate() {
            joint.add_part(part, sums, weight(index));
        }
        joint
    }

    /// The same without what an offset of each wet part, free for itself, would take up; and the sums so.
    pub(super) fn within(rows: &Rows, sums: &[Sums], weight: impl Fn(usize) -> f64) -> (NormalEquations, Vec<Sums>) {
        let demeaned: Vec<Sums> = rows
            .parts
            .iter()
            .zip(sums)
            .map(|(part, sums)| demeaned(part, sums))
            .collect();
        (NormalEquations::new(rows, &demeaned, weight), demeaned)
    }

    fn add_part(&mut self, part: &GroupedPart, sums: &Sums, weight: f64) {
        self.squares += weight * sums.squares;
        for (i, of_row) in part.places.iter().enumerate() {
            self.gradient[*of_row] += weight * sums.gradient[i];
            for (j, of_column) in part.places.iter().enumerate() {
                self.information[(*of_row, *of_column)] += weight * sums.information[(i, j)];
            }
        }
    }

    /// The slopes of a part, summed over its runs, each with its parameter's place.
    pub(super) fn slopes(part: &GroupedPart, sums: &Sums) -> Vec<(usize, f64)> {
        let offset = part.places.len();
        let of = |(i, place): (usize, &usize)| (*place, sums.information[(i, offset)]);
        part.places.iter().enumerate().map(of).collect()
    }

    /// The fit to these sums: the step from the point they were taken at, and the sum of squares it leaves.
    pub(super) fn fit(&self) -> JointSolution {
        let inverse = inverse(&self.information);
        let step = -(&inverse.matrix * &self.gradient);
        JointSolution {
            left: self.squares + self.gradient.dot(&step),
            step,
            inverse,
        }
    }
}

/// A joint fit.
pub(super) struct JointSolution {
    /// from the point of the sums
    pub(super) step: DVector<f64>,
    pub(super) inverse: Inverse,
    /// Σ residual²
    pub(super) left: f64,
}

impl JointSolution {
    /// What the fit leaves of a part or several: Σ residual², and the runs less the parameters spent on them.
    pub(super) fn leaves<'s>(
        &self,
        parts: impl Iterator<Item = (&'s GroupedPart, &'s Sums)>,
        weight: f64,
    ) -> (f64, f64) {
        let (mut squares, mut freedom) = (0.0, 0.0);
        for (part, sums) in parts {
            let n = part.places.len();
            let step = self.step.select_rows(&part.places);
            let information = sums.information.view((0, 0), (n, n));
            squares += sums.squares + 2.0 * sums.gradient.rows(0, n).dot(&step) + (information * &step).dot(&step);
            let spent = |i: usize, j: usize| self.inverse.matrix[(part.places[i], part.places[j])];
            let all = (0..n * n).map(|place| (place % n, place / n));
            let spent: f64 = all.map(|(i, j)| spent(i, j) * information[(i, j)]).sum();
            freedom += sums.runs as f64 - weight * spent;
        }
        (squares.max(0.0), freedom)
    }

    /// The sum of what the fit leaves of one part, and the sum of its weights.
    pub(super) fn sum(&self, part: &GroupedPart, sums: &Sums) -> (f64, f64) {
        let n = part.places.len();
        let step = self.step.select_rows(&part.places);
        let slopes = sums.information.view((0, n), (n, 1));
        (sums.gradient[n] + slopes.dot(&step), sums.information[(n, n)])
    }

    /// The covariance of the fit where the runs' scores have the information `scores`, as variances over those the fit
    /// claims: by how much each standard error is too short. `None` of a parameter that is not identified.
    pub(super) fn widening(&self, scores: &DMatrix<f64>) -> Vec<Option<f64>> {
        let inverse = &self.inverse.matrix;
        let covariance = (inverse * scores * inverse).diagonal();
        let ratio = |j: usize| (covariance[j] / inverse[(j, j)]).sqrt();
        let identified = self.inverse.identified.iter().enumerate();
        identified
            .map(|(j, identified)| identified.then(|| ratio(j)).filter(|ratio| ratio.is_finite()))
            .collect()
    }
}

/// Sums with the mean of the part taken out of residuals and slopes; dry parts stay as they are.
fn demeaned(part: &GroupedPart, sums: &Sums) -> Sums {
    let offset = part.places.len();
    let weight = sums.information[(offset, offset)];
    let mut within = sums.clone();
    if part.series.is_none() || weight <= 0.0 {
        return within;
    }
    let mean = sums.gradient[offset];
    within.squares -= mean * mean / weight;
    for i in 0..offset {
        let of_row = sums.information[(i, offset)];
        within.gradient[i] -= of_row * mean / weight;
        for j in 0..offset {
            let (was, taken) = (
                sums.information[(i, j)],
                of_row * sums.information[(j, offset)] / weight,
            );
            // a slope that is the same in all runs leaves only rounding
            let rounding = 1e-12 * (sums.information[(i, i)] * sums.information[(j, j)]).sqrt();
            within.information[(i, j)] = if (was - taken).abs() > rounding {
                was - taken
            } else {
                0.0
            };
        }
    }
    within
}

/// The inverse of an information matrix in the directions that are identified.
pub(super) struct Inverse {
    pub(super) matrix: DMatrix<f64>,
    /// how many directions are identified
    pub(super) rank: usize,
    /// whether each parameter is
    pub(super) identified: Vec<bool>,
}

/// Inverts what can be inverted; the other directions are left out.
pub(super) fn inverse(information: &DMatrix<f64>) -> Inverse {
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
