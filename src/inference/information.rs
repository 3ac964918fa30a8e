//! Finds the directions in which runs say more of the parameters than their priors, by sums over the runs.
//!
//! Symbols: z = (ln θ − ln median)/sd is the logarithm of a parameter in sds of its prior; J is the slope of each run's
//! model in z over the runs' spread. An eigenvalue s² of JᵀJ belongs to a direction of which the runs alone leave the
//! spread 1/s, runs and prior together 1/√(1 + s²). Only the sums over runs are kept, never a row a run.

use nalgebra::linalg::SymmetricEigen;
use nalgebra::{DMatrix, DVector, Dyn};

use super::descent::descend;
use super::sums::Sums;

/// Every entry times the factors of its row and its column.
pub fn scaled(matrix: &DMatrix<f64>, factors: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        factors[i] * factors[j] * matrix[(i, j)]
    })
}

/// Eigenvalues and directions of a symmetric matrix; `None` where they are not found.
pub fn axes(matrix: DMatrix<f64>) -> Option<SymmetricEigen<f64, Dyn>> {
    const TURNS: usize = 10_000;
    // there are no axes of nothing
    if matrix.is_empty() {
        let (eigenvalues, eigenvectors) = (DVector::zeros(0), matrix);
        return Some(SymmetricEigen {
            eigenvectors,
            eigenvalues,
        });
    }
    SymmetricEigen::try_new(matrix, f64::EPSILON, TURNS)
}

/// Σ of(λ) · axis · axisᵀ: a function of a symmetric matrix by its axes.
pub fn function(axes: &SymmetricEigen<f64, Dyn>, of: impl Fn(f64) -> f64) -> DMatrix<f64> {
    let mut weighted = axes.eigenvectors.clone();
    for (mut axis, strength) in weighted.column_iter_mut().zip(&axes.eigenvalues) {
        axis *= of(*strength);
    }
    weighted * axes.eigenvectors.transpose()
}

/// The prior of a positive parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormalPrior {
    /// median
    pub median: f64,
    /// sd of the logarithm
    pub ln_sd: f64,
}

impl LogNormalPrior {
    /// Whether a value with its standard error lies more than three sds of the two together from the median.
    pub fn is_contradicted_by(self, value: f64, se: f64) -> bool {
        (value / self.median).ln().abs() > 3.0 * self.ln_sd.hypot(se / value)
    }
}

/// Runs of some kinds, each kind with its own spread.
pub struct RunsWithPriors<'a> {
    /// prior of each parameter
    pub beliefs: &'a [LogNormalPrior],
    /// prior spread of each kind
    pub spreads: &'a [f64],
    /// sums of each kind at a point
    pub sums: &'a dyn Fn(&[f64]) -> Vec<Sums>,
}

impl RunsWithPriors<'_> {
    fn spreads(&self, values: &[f64]) -> Vec<f64> {
        let sums = (self.sums)(values);
        sums.iter().zip(self.spreads).map(|(sums, s)| sums.spread(*s)).collect()
    }

    fn in_z(&self, values: &[f64]) -> Vec<f64> {
        let each = values.iter().zip(self.beliefs);
        each.map(|(x, of)| (x / of.median).ln() / of.ln_sd).collect()
    }

    fn values(&self, z: &[f64]) -> Vec<f64> {
        let each = z.iter().zip(self.beliefs);
        each.map(|(z, of)| of.median * (z * of.ln_sd).exp()).collect()
    }

    /// The sums of all runs over their spreads, in z; `None` where one is not finite.
    fn local(&self, values: &[f64], spreads: &[f64]) -> Option<Sums> {
        let width: Vec<f64> = values.iter().zip(self.beliefs).map(|(x, of)| x * of.ln_sd).collect();
        let mut all = Sums::new(values.len());
        for (sums, spread) in (self.sums)(values).iter().zip(spreads) {
            all.add_weighted(sums, 1.0 / (spread * spread));
        }
        all.gradient
            .iter_mut()
            .zip(&width)
            .for_each(|(slope, width)| *slope *= width);
        all.information = scaled(&all.information, &width);
        let mut entries = all.gradient.iter().chain(&all.information);
        (all.squares.is_finite() && entries.all(|x| x.is_finite())).then_some(all)
    }

    /// Searches the least squares of runs and prior together, which exist whatever the runs determine.
    ///
    /// `None` where a sum is not finite at the start.
    pub fn fit_with_priors(&self, start: &[f64]) -> Option<Vec<f64>> {
        /// spreads follow the residuals and vice versa
        const ROUNDS: usize = 4;
        /// a fall of the squares that moves no direction by a noticeable part of its spread
        const SMALL: f64 = 1e-6;
        let mut z = self.in_z(start);
        for round in 0..ROUNDS {
            // residuals before the first fit are no noise, and their spread would leave all to the priors
            let spreads = if round == 0 {
                self.spreads.to_vec()
            } else {
                self.spreads(&self.values(&z))
            };
            let end = descend(&z, SMALL, |z| {
                let mut sums = self.local(&self.values(z), &spreads)?;
                for (place, z) in z.iter().enumerate() {
                    sums.add(*z, &[(place, 1.0)]);
                }
                Some(sums)
            })?;
            z = end.point;
            // with spreads that were residuals already
            if round > 0 && end.fell < SMALL {
                break;
            }
        }
        Some(self.values(&z))
    }

    /// What the runs say about a point; `None` where it is not finite.
    pub fn information(&self, values: &[f64]) -> Option<DirectionalInformation> {
        let axes = axes(self.local(values, &self.spreads(values))?.information)?;
        Some(DirectionalInformation { axes })
    }
}

/// The directions of the parameters with what runs say of each.
#[derive(Debug, Clone)]
pub struct DirectionalInformation {
    /// s² of each direction in z
    axes: SymmetricEigen<f64, Dyn>,
}

/// Parameters of which a direction is determined only by the prior.
#[derive(Debug, Clone, PartialEq)]
pub struct UnseenGroup {
    /// places of the parameters
    pub members: Vec<usize>,
    /// how many directions among them are unseen
    pub directions: usize,
}

/// s² at which runs say as much of a direction as its prior: 1/√2 of the prior's spread is left.
const AS_MUCH: f64 = 1.0;

/// A parameter is named where an unseen direction leaves it this share of its prior variance (a tenth of its sd), and
/// at least half of the variance it has left.
const SHARE: f64 = 0.01;

impl DirectionalInformation {
    /// Covariance of z under runs and prior, or the part of it in the directions of wanted s².
    fn covariance(&self, wanted: impl Fn(f64) -> bool) -> DMatrix<f64> {
        // rounding may leave an s² of zero a little below it
        function(
            &self.axes,
            |s2| if wanted(s2) { 1.0 / (1.0 + s2.max(0.0)) } else { 0.0 },
        )
    }

    /// Share of its prior sd that each parameter keeps.
    pub fn left(&self) -> Vec<f64> {
        self.covariance(|_| true).diagonal().iter().map(|x| x.sqrt()).collect()
    }

    /// The parameters with a share in the unseen directions; those that move together are one group.
    pub fn unseen(&self) -> Vec<UnseenGroup> {
        /// correlation from which two parameters move together
        const TOGETHER: f64 = 0.1;
        let hidden = |s2: f64| s2 < AS_MUCH;
        if !self.axes.eigenvalues.iter().any(|s2| hidden(*s2)) {
            return vec![];
        }
        let (all, part) = (self.covariance(|_| true), self.covariance(hidden));
        let own: Vec<f64> = part.diagonal().iter().copied().collect();
        let has_share = |j: &usize| own[*j] >= SHARE && own[*j] >= 0.5 * all[(*j, *j)];
        let mut open: Vec<usize> = (0..own.len()).filter(has_share).collect();
        if open.is_empty() {
            open.extend((0..own.len()).max_by(|i, j| own[*i].total_cmp(&own[*j])));
        }
        let mut found: Vec<Vec<usize>> = vec![];
        while let Some(first) = open.first().copied() {
            open.remove(0);
            let mut members = vec![first];
            let mut at = 0;
            while let Some(&i) = members.get(at) {
                let moves = |j: &usize| part[(i, *j)].abs() >= TOGETHER * (own[i] * own[*j]).sqrt();
                let (with, without): (Vec<usize>, Vec<usize>) = open.iter().partition(|j| moves(j));
                members.extend(with);
                open = without;
                at += 1;
            }
            members.sort_unstable();
            found.push(members);
        }
        found.sort_unstable();
        let group = |members: Vec<usize>| {
            // the squares of what the hidden directions have of the members
            let weight: f64 = (self.axes.eigenvectors.column_iter())
                .zip(&self.axes.eigenvalues)
                .filter(|(_, s2)| hidden(**s2))
                .map(|(axis, _)| members.iter().map(|place| axis[*place] * axis[*place]).sum::<f64>())
                .sum();
            UnseenGroup {
                members,
                directions: (weight.round() as usize).max(1),
            }
        };
        found.into_iter().map(group).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn information(rows: &[[f64; 3]]) -> DirectionalInformation {
        let mut sums = Sums::new(3);
        for row in rows {
            sums.add(0.0, &[(0, row[0]), (1, row[1]), (2, row[2])]);
        }
        DirectionalInformation {
            axes: axes(sums.information).expect("finite"),
        }
    }

    #[test]
    fn parameters_that_only_move_together_are_one_group_with_their_sum_known() {
        // a + b is seen to 1/√(2·50), c to 1/30
        let information = information(&[[5.0, 5.0, 0.0], [5.0, 5.0, 0.0], [0.0, 0.0, 30.0]]);
        let groups = information.unseen();
        assert_eq!(groups.len(), 1);
        assert_eq!((groups[0].members.as_slice(), groups[0].directions), (&[0, 1][..], 1));
        let left = information.left();
        // half of the variance stays unseen, the other half shrinks to 1/101
        assert!((left[0] - (0.5 + 0.5 / 101.0f64).sqrt()).abs() < 1e-12);
        assert!((left[2] - 1.0 / 901f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_direction_is_unseen_below_the_line_only() {
        assert_eq!(
            information(&[[1.01, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]).unseen(),
            vec![]
        );
        let groups = information(&[[0.99, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]).unseen();
        assert_eq!(groups[0].members, vec![0]);
    }
}
