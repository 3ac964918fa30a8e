//! Draws the runs of every stratum, and gives each fit what it needs of them.
//!
//! Where all n runs of a stratum have one abscissa, a law's sum of squares over the runs drawn is that of n runs at their
//! mean, but for the squares about it, which no parameter moves. Such a stratum is one row, at the mean of what was drawn;
//! the runs of other strata are a row each, and their weight is drawn.

use std::collections::BTreeMap;
use std::ops::Range;

use rand::rngs::ChaCha8Rng;

use super::draws::{drawn, mean, weigh};
use super::target::{Pool, Target};
use crate::inference::kernel::{Regression, WeightedFit};

/// The strata of some targets, and what each target is fitted to in a replicate.
pub(super) struct Cases<'a> {
    strata: Vec<Stratum>,
    fits: Vec<RowFit<'a>>,
    /// rows before anything is drawn
    rows: Rows,
}

/// A stratum that some target has.
struct Stratum {
    /// one, or one a run
    rows: Range<usize>,
    /// of the runs
    restitution: Vec<f64>,
}

/// A target with what its rows hold in all replicates.
struct RowFit<'a> {
    target: &'a Target<'a>,
    rows: Range<usize>,
    x: Vec<f64>,
    offset: Vec<f64>,
}

/// What the rows hold in one replicate.
#[derive(Clone)]
pub(super) struct Rows {
    restitution: Vec<f64>,
    weights: Vec<f64>,
}

impl<'a> Cases<'a> {
    pub(super) fn new(pool: &Pool, targets: &'a [Target<'a>]) -> Cases<'a> {
        let mut restitution = vec![0.0; pool.runs()];
        let mut is_one_row = BTreeMap::new();
        for target in targets {
            let Target { regression, errors, .. } = target;
            let first = pool.first_run(target);
            restitution[first..first + regression.x.len()].copy_from_slice(regression.restitution);
            for stratum in target.strata.clone() {
                let Range { start, end } = pool.strata[stratum];
                let is_even = |column: &[f64]| {
                    let own = column.get(start - first..end - first).unwrap_or_default();
                    own.iter().all(|value| *value == own[0])
                };
                // runs that are weighed by their errors have no common mean
                let is_one = errors.is_none() && is_even(regression.x) && is_even(regression.offset);
                *is_one_row.entry(stratum).or_insert(true) &= is_one;
            }
        }
        let (mut strata, mut first_runs, mut weights) = (vec![], vec![], vec![]);
        for (stratum, is_one) in is_one_row {
            let runs = pool.strata[stratum].clone();
            let first = first_runs.len();
            first_runs.extend(runs.clone().step_by(if is_one { runs.len() } else { 1 }));
            let rows = first..first_runs.len();
            weights.resize(rows.end, runs.len() as f64 / rows.len() as f64);
            strata.push(Stratum {
                rows,
                restitution: restitution[runs].to_vec(),
            });
        }
        let fits = targets.iter().map(|target| {
            let Target { regression, .. } = target;
            let first = pool.first_run(target);
            let row_at = |at: usize| first_runs.partition_point(|run| *run < at);
            let rows = row_at(first)..row_at(first + regression.x.len());
            let of_rows = |column: &[f64]| -> Vec<f64> {
                let own = first_runs[rows.clone()].iter();
                own.filter_map(|run| column.get(run - first)).copied().collect()
            };
            RowFit {
                target,
                x: of_rows(regression.x),
                offset: of_rows(regression.offset),
                rows,
            }
        });
        Cases {
            fits: fits.collect(),
            strata,
            rows: Rows {
                restitution: first_runs.iter().map(|run| restitution[*run]).collect(),
                weights,
            },
        }
    }

    /// Random words of 32 bits that a replicate uses.
    pub(super) fn words(&self) -> u64 {
        let each = self
            .strata
            .iter()
            .map(|stratum| drawn(stratum.restitution.len()) as u64);
        each.sum()
    }

    /// Rows to draw into.
    pub(super) fn room(&self) -> Rows {
        self.rows.clone()
    }

    /// Draws a replicate.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng, into: &mut Rows) {
        for Stratum { rows, restitution } in &self.strata {
            if rows.len() == 1 {
                into.restitution[rows.start] = mean(rng, restitution);
            } else {
                weigh(rng, &mut into.weights[rows.clone()]);
            }
        }
    }

    /// Fits a target, by its number, to what was drawn.
    pub(super) fn fit(&self, target: usize, drawn: &Rows) -> WeightedFit {
        let RowFit {
            target,
            rows,
            x,
            offset,
        } = &self.fits[target];
        target.fit(&Regression {
            law: target.regression.law,
            x,
            offset,
            restitution: &drawn.restitution[rows.clone()],
            counts: &drawn.weights[rows.clone()],
        })
    }
}
