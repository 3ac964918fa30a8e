//! Finds the directions in which runs say more of the parameters than was believed before, by sums over the runs.
//!
//! Symbols: z = (ln θ − ln median)/sd is the logarithm of a parameter in sds of its prior; J is the slope of each run's
//! model in z over the runs' spread. An eigenvalue s² of JᵀJ belongs to a direction of which the runs alone leave the
//! spread 1/s, runs and prior together 1/√(1 + s²). Only the sums over runs are kept, never a row a run.

use nalgebra::linalg::SymmetricEigen;
use nalgebra::{DMatrix, DVector};

/// Sums over runs that share a spread, at one point, in the parameters' own units.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// how many runs
    pub runs: usize,
    /// Σ residual²
    pub squares: f64,
    /// Σ residual · slope
    pub gradient: DVector<f64>,
    /// Σ slope · slopeᵀ
    pub information: DMatrix<f64>,
}

impl Sums {
    /// No runs yet.
    pub fn new(parameters: usize) -> Sums {
        Sums {
            runs: 0,
            squares: 0.0,
            gradient: DVector::zeros(parameters),
            information: DMatrix::zeros(parameters, parameters),
        }
    }

    /// Adds a run by its residual (model − observed) and the slopes of its model, each with its parameter's place.
    pub fn add(&mut self, residual: f64, slopes: &[(usize, f64)]) {
        self.runs += 1;
        self.squares += residual * residual;
        for &(i, slope) in slopes {
            self.gradient[i] += residual * slope;
            for &(j, other) in slopes {
                self.information[(i, j)] += slope * other;
            }
        }
    }

    /// The sums of some of the parameters.
    pub fn of(&self, kept: &[usize]) -> Sums {
        Sums {
            runs: self.runs,
            squares: self.squares,
            gradient: self.gradient.select_rows(kept),
            information: self.information.select_rows(kept).select_columns(kept),
        }
    }

    /// The spread the residuals leave; `before` counts as one residual, so that no number of runs leaves none.
    fn spread(&self, before: f64) -> f64 {
        let spent = self.information.diagonal().iter().filter(|sum| **sum > 0.0).count();
        let left = self.runs.saturating_sub(spent) + 1;
        ((self.squares + before * before) / left as f64).sqrt()
    }
}

/// What was believed of a positive parameter before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// median
    pub median: f64,
    /// sd of the logarithm
    pub ln_sd: f64,
}

/// Runs of some kinds, each kind with its own spread.
pub struct Kinds<'a> {
    /// belief of each parameter
    pub beliefs: &'a [Belief],
    /// spread of each kind that was believed before
    pub spreads: &'a [f64],
    /// sums of each kind at a point
    pub sums: &'a dyn Fn(&[f64]) -> Vec<Sums>,
}

/// What runs and prior say about a point, in z.
struct Local {
    cost: f64,
    downhill: DVector<f64>,
    information: DMatrix<f64>,
}

impl Kinds<'_> {
    fn spreads(&self, values: &[f64]) -> Vec<f64> {
        let sums = (self.sums)(values);
        sums.iter().zip(self.spreads).map(|(sums, s)| sums.spread(*s)).collect()
    }

    /// `None` where a sum is not finite.
    fn local(&self, values: &[f64], spreads: &[f64]) -> Option<Local> {
        let p = values.len();
        let each = || values.iter().zip(self.beliefs);
        let z = DVector::from_iterator(p, each().map(|(x, of)| (x / of.median).ln() / of.ln_sd));
        let width = DVector::from_iterator(p, each().map(|(x, of)| x * of.ln_sd));
        let mut local = Local {
            cost: z.norm_squared(),
            downhill: -z,
            information: DMatrix::zeros(p, p),
        };
        for (sums, spread) in (self.sums)(values).iter().zip(spreads) {
            let weight = 1.0 / (spread * spread);
            local.cost += weight * sums.squares;
            local.downhill -= sums.gradient.component_mul(&width) * weight;
            local.information += DMatrix::from_fn(p, p, |i, j| sums.information[(i, j)] * width[i] * width[j] * weight);
        }
        let finite = local.cost.is_finite() && local.information.iter().all(|x| x.is_finite());
        (finite && local.downhill.iter().all(|x| x.is_finite())).then_some(local)
    }

    /// Walks to the least squares of runs and prior together, which exist whatever the runs determine.
    ///
    /// `None` where a sum is not finite at the start.
    pub fn settle(&self, start: &[f64]) -> Option<Vec<f64>> {
        /// spreads follow the residuals and the other way round
        const ROUNDS: usize = 4;
        const STEPS: usize = 30;
        /// a fall of the cost that moves no direction by a noticeable part of its spread
        const SMALL: f64 = 1e-6;
        let mut values = start.to_vec();
        for round in 0..ROUNDS {
            // residuals before the first walk are no noise, and their spread would leave all to the priors
            let spreads = if round == 0 {
                self.spreads.to_vec()
            } else {
                self.spreads(&values)
            };
            let mut here = self.local(&values, &spreads)?;
            let mut damping = 1e-3;
            let began = here.cost;
            for _ in 0..STEPS {
                let mut curvature = here.information.clone();
                for j in 0..values.len() {
                    curvature[(j, j)] = (curvature[(j, j)] + 1.0) * (1.0 + damping);
                }
                let Some(step) = curvature.cholesky().map(|root| root.solve(&here.downhill)) else {
                    break;
                };
                let moved = values.iter().zip(self.beliefs).zip(step.iter());
                let trial: Vec<f64> = moved.map(|((x, of), dz)| x * (of.ln_sd * dz).exp()).collect();
                let there = self.local(&trial, &spreads).filter(|there| there.cost < here.cost);
                match there {
                    Some(there) => {
                        let fall = here.cost - there.cost;
                        (values, here) = (trial, there);
                        damping *= 0.1;
                        if fall < SMALL {
                            break;
                        }
                    }
                    None if damping > 1e8 => break,
                    None => damping *= 10.0,
                }
            }
            // with spreads that were residuals already
            if round > 0 && began - here.cost < SMALL {
                break;
            }
        }
        Some(values)
    }

    /// What the runs say about a point; `None` where it is not finite.
    pub fn known(&self, values: &[f64]) -> Option<Known> {
        Known::of(self.local(values, &self.spreads(values))?.information)
    }
}

/// The directions of the parameters with what runs say of each.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// s of each direction
    pub strengths: Vec<f64>,
    /// the directions in z, a column each
    pub axes: DMatrix<f64>,
}

/// Parameters of which a direction is told only by the prior.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// places of the parameters
    pub members: Vec<usize>,
    /// how many directions among them are unseen
    pub directions: usize,
}

/// Strength at which runs say as much of a direction as its prior: 1/√2 of the prior's spread is left.
pub const AS_MUCH: f64 = 1.0;

/// A parameter is named where an unseen direction leaves it this share of its prior variance (a tenth of its sd), and
/// at least half of the variance it has left.
const SHARE: f64 = 0.01;

impl Known {
    fn of(information: DMatrix<f64>) -> Option<Known> {
        const TURNS: usize = 10_000;
        let found = SymmetricEigen::try_new(information, f64::EPSILON, TURNS)?;
        Some(Known {
            // rounding may leave a zero a little below it
            strengths: found.eigenvalues.iter().map(|s2| s2.max(0.0).sqrt()).collect(),
            axes: found.eigenvectors,
        })
    }

    /// Covariance of z under runs and prior, or the part of it in the directions that are wanted.
    fn covariance(&self, wanted: impl Fn(f64) -> bool) -> DMatrix<f64> {
        let p = self.strengths.len();
        let mut sum = DMatrix::zeros(p, p);
        for (axis, s) in self.axes.column_iter().zip(&self.strengths) {
            if wanted(*s) {
                sum += axis * axis.transpose() / (1.0 + s * s);
            }
        }
        sum
    }

    /// Share of its prior sd that each parameter keeps.
    pub fn left(&self) -> Vec<f64> {
        self.covariance(|_| true).diagonal().iter().map(|x| x.sqrt()).collect()
    }

    /// The parameters with a share in the unseen directions; those that move together are one group.
    pub fn unseen(&self) -> Vec<Group> {
        /// correlation from which two parameters move together
        const TOGETHER: f64 = 0.1;
        let hidden = |s: f64| s < AS_MUCH;
        if !self.strengths.iter().any(|s| hidden(*s)) {
            return vec![];
        }
        let (all, part) = (self.covariance(|_| true), self.covariance(hidden));
        let p = self.strengths.len();
        let has_share = |j: &usize| part[(*j, *j)] >= SHARE && part[(*j, *j)] >= 0.5 * all[(*j, *j)];
        let mut open: Vec<usize> = (0..p).filter(has_share).collect();
        if open.is_empty() {
            open.extend((0..p).max_by(|i, j| part[(*i, *i)].total_cmp(&part[(*j, *j)])));
        }
        let mut groups = vec![];
        while let Some(first) = open.first().copied() {
            open.remove(0);
            let mut members = vec![first];
            let mut at = 0;
            while let Some(&i) = members.get(at) {
                let moves = |j: &usize| part[(i, *j)].abs() >= TOGETHER * (part[(i, i)] * part[(*j, *j)]).sqrt();
                let (with, without): (Vec<usize>, Vec<usize>) = open.iter().partition(|j| moves(j));
                members.extend(with);
                open = without;
                at += 1;
            }
            members.sort_unstable();
            let axes = self.axes.column_iter().zip(&self.strengths);
            let weights = axes.filter(|(_, s)| hidden(**s));
            let weight: f64 = weights
                .map(|(axis, _)| members.iter().map(|j| axis[*j] * axis[*j]).sum::<f64>())
                .sum();
            groups.push(Group {
                members,
                directions: (weight.round() as usize).max(1),
            });
        }
        groups
    }

    /// Standard error of a quantity by its slopes in z, under runs and prior.
    pub fn se(&self, slopes: &[f64]) -> f64 {
        let slopes = DVector::from_column_slice(slopes);
        (self.covariance(|_| true) * &slopes).dot(&slopes).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(rows: &[[f64; 3]]) -> Known {
        let mut sums = Sums::new(3);
        for row in rows {
            sums.add(0.0, &[(0, row[0]), (1, row[1]), (2, row[2])]);
        }
        Known::of(sums.information).expect("finite")
    }

    #[test]
    fn parameters_that_only_move_together_are_one_group_with_their_sum_known() {
        // a + b is seen to 1/√(2·50), c to 1/30
        let known = known(&[[5.0, 5.0, 0.0], [5.0, 5.0, 0.0], [0.0, 0.0, 30.0]]);
        let groups = known.unseen();
        assert_eq!(groups.len(), 1);
        assert_eq!((groups[0].members.as_slice(), groups[0].directions), (&[0, 1][..], 1));
        assert!((known.se(&[0.5, 0.5, 0.0]) - (0.5 / 101.0f64).sqrt()).abs() < 1e-12);
        let left = known.left();
        // half of the variance stays unseen, the other half shrinks to 1/101
        assert!((left[0] - (0.5 + 0.5 / 101.0f64).sqrt()).abs() < 1e-12);
        assert!((left[2] - 1.0 / 901f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_direction_is_unseen_below_the_line_only() {
        assert_eq!(
            known(&[[1.01, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]).unseen(),
            vec![]
        );
        let groups = known(&[[0.99, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]).unseen();
        assert_eq!(groups[0].members, vec![0]);
    }

    /// A curve a·b·x of which only the product is told: the walk ends where it is right, as the priors share it out.
    #[test]
    fn the_walk_settles_where_only_a_product_is_told() {
        let sums = |values: &[f64]| {
            let mut sums = Sums::new(2);
            for x in [0.5, 1.0, 1.5, 2.0] {
                let off = values[0] * values[1] * x - 6.0 * x;
                sums.add(off, &[(0, values[1] * x), (1, values[0] * x)]);
            }
            vec![sums]
        };
        let belief = Belief {
            median: 1.0,
            ln_sd: 0.5,
        };
        let kinds = Kinds {
            beliefs: &[belief; 2],
            spreads: &[0.01],
            sums: &sums,
        };
        let end = kinds.settle(&[1.0, 1.0]).expect("finite");
        assert!((end[0] * end[1] / 6.0 - 1.0).abs() < 1e-3, "{end:?}");
        assert!((end[0] / end[1] - 1.0).abs() < 1e-6, "{end:?}");
        assert_eq!(kinds.known(&end).expect("finite").unseen()[0].members, vec![0, 1]);
        assert_eq!(kinds.settle(&[f64::INFINITY, 1.0]), None);
    }
}
