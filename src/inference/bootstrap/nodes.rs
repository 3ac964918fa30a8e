//! Gathers runs that share a stratum and an abscissa into one node, of which a replicate needs the mean only.
//!
//! Where all n runs of a stratum have one x, a law's sum of squares over the runs drawn is that of n runs at their mean
//! plus the squares about it, which no parameter moves. The mean and these squares are sums over the draws, tabulated by
//! what is drawn. The runs of other strata are a node each, and their weight is drawn.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;

use super::batches::{unit_weight, write_weights, Batches, Drawn, TOGETHER};
use super::kernel::Sample;
use super::lines::{BatchTable, LineFits};
use super::multisets::{Multisets, FEW};
use super::target::{Pool, Target};
use crate::inference::law::Law;

/// A stratum with its batches of draws and its nodes.
struct Stratum {
    batches: Range<usize>,
    nodes: Range<usize>,
    /// `None` where its runs are a node each
    alike: Option<Alike>,
}

/// A stratum that is one node.
struct Alike {
    /// its part of the tables
    table: Range<usize>,
    runs: f64,
    /// 1/runs: dividing takes as long as the sums
    share: f64,
    /// their mean restitution
    mean: f64,
}

/// All strata as nodes.
pub(super) struct StrataNodes {
    batches: Batches,
    /// those of targets that are not fitted from the tables alone
    strata: Vec<Stratum>,
    /// Σ w (e − mean) and Σ w (e − mean)² of the draws of a batch, by the multiset or the member drawn
    tables: Vec<[f64; 2]>,
    /// the first run of each node
    runs: Vec<usize>,
    /// restitution of each run
    restitution: Vec<f64>,
    /// by target
    pub(super) columns: Vec<NodeColumn>,
}

/// Abscissa and offset of a target's nodes.
pub(super) struct NodeColumn {
    nodes: Range<usize>,
    x: Vec<f64>,
    offset: Vec<f64>,
    /// of a linear law, where no draw moves a weight
    pub(super) lines: Option<LineFits>,
}

/// What some replicates draw, and the nodes of one of them.
pub(super) struct DrawnNodes {
    drawn: Drawn<TOGETHER>,
    restitution: Vec<f64>,
    weights: Vec<f64>,
    /// squares about the node's mean
    squares: Vec<f64>,
}

impl DrawnNodes {
    /// What the batches of the replicates drew.
    pub(super) fn of_batch(&self) -> &[[u32; TOGETHER]] {
        &self.drawn.of_batch
    }

    /// What a target is fitted to.
    pub(super) fn sample<'a>(&'a self, column: &'a NodeColumn) -> Sample<'a> {
        let nodes = column.nodes.clone();
        Sample {
            x: &column.x,
            offset: &column.offset,
            restitution: &self.restitution[nodes.clone()],
            weights: &self.weights[nodes.clone()],
            within: self.squares[nodes].iter().sum(),
        }
    }
}

impl StrataNodes {
    pub(super) fn new(pool: &Pool, targets: &[Target]) -> StrataNodes {
        let runs = pool.strata.last().map_or(0, |stratum| stratum.end);
        let mut restitution = vec![0.0; runs];
        // a stratum that no target has is a node, too
        let mut alike = vec![true; pool.strata.len()];
        for target in targets {
            let first = pool.first_run(target);
            restitution[first..first + target.regression.x.len()].copy_from_slice(target.regression.restitution);
            let strata = pool.strata[target.strata.clone()].iter();
            for (stratum, alike) in strata.zip(&mut alike[target.strata.clone()]) {
                let same = |column: &[f64]| {
                    let own = column.get(stratum.start - first..stratum.end - first);
                    own.is_none_or(|own| own.iter().all(|x| *x == own[0]))
                };
                *alike &= same(target.regression.x) && same(target.regression.offset);
            }
        }
        let mut nodes = StrataNodes {
            batches: Batches::new(&pool.strata),
            strata: vec![],
            tables: vec![],
            runs: vec![],
            restitution,
            columns: vec![],
        };
        for (number, (stratum, alike)) in pool.strata.iter().zip(alike).enumerate() {
            let first = nodes.runs.len();
            let batches = nodes.batches.strata[number].clone();
            let alike = (alike && stratum.len() > 1).then(|| nodes.tabulate(stratum));
            if alike.is_some() {
                nodes.runs.push(stratum.start);
            } else {
                nodes.runs.extend(stratum.clone());
            }
            nodes.strata.push(Stratum {
                batches,
                nodes: first..nodes.runs.len(),
                alike,
            });
        }
        nodes.columns = targets.iter().map(|target| nodes.column(pool, target)).collect();
        let mut drawn = vec![false; nodes.strata.len()];
        for (target, column) in targets.iter().zip(&nodes.columns) {
            if column.lines.is_none() {
                drawn[target.strata.clone()].fill(true);
            }
        }
        let mut drawn = drawn.into_iter();
        nodes.strata.retain(|_| drawn.next() == Some(true));
        nodes
    }

    /// Adds the sums over the draws of a stratum that is one node.
    fn tabulate(&mut self, stratum: &Range<usize>) -> Alike {
        let own = &self.restitution[stratum.clone()];
        let n = own.len();
        let mean = own.iter().sum::<f64>() / n as f64;
        let of = |(count, e): (f64, &f64)| {
            let (weight, e) = (count * unit_weight(n), e - mean);
            [weight * e, weight * e * e]
        };
        let start = self.tables.len();
        if n <= FEW {
            let multisets = Multisets::all().counts(n).iter();
            self.tables
                .extend(multisets.map(|counts| counts.each().zip(own).map(of).fold([0.0; 2], add)));
        } else {
            self.tables.extend(own.iter().map(|e| of((1.0, e))));
        }
        Alike {
            table: start..self.tables.len(),
            runs: n as f64,
            share: 1.0 / n as f64,
            mean,
        }
    }

    /// A target's columns over its nodes.
    fn column(&self, pool: &Pool, target: &Target) -> NodeColumn {
        let nodes = match &self.strata[target.strata.clone()] {
            [] => 0..0,
            [first, .., last] => first.nodes.start..last.nodes.end,
            [only] => only.nodes.clone(),
        };
        let first = pool.first_run(target);
        let of = |column: &[f64]| -> Vec<f64> {
            let own = self.runs[nodes.clone()].iter();
            own.filter_map(|run| column.get(run - first)).copied().collect()
        };
        let x = of(target.regression.x);
        let lines = (target.regression.law == Law::LINEAR)
            .then(|| self.lines(target.strata.clone(), &x))
            .flatten();
        NodeColumn {
            x,
            offset: of(target.regression.offset),
            nodes,
            lines,
        }
    }

    /// Lines through some strata, where no draw moves a weight.
    fn lines(&self, strata: Range<usize>, x: &[f64]) -> Option<LineFits> {
        let strata = &self.strata[strata];
        let (first, last) = (strata.first()?, strata.last()?);
        let (mut of_batch, mut restitution, mut weights) = (vec![], vec![], vec![]);
        for (node, Stratum { batches, nodes, alike }) in strata.iter().enumerate() {
            if let Some(alike) = alike {
                restitution.push(alike.mean);
                weights.push(alike.runs);
                let table = &alike.table;
                of_batch.extend(batches.clone().map(|batch| BatchTable {
                    table: table.clone(),
                    node,
                    multisets: self.batches.multisets(batch),
                }));
            } else if nodes.len() == 1 {
                // always itself
                restitution.push(self.restitution[self.runs[nodes.start]]);
                weights.push(1.0);
            } else {
                return None;
            }
        }
        let sample = Sample::new(x, &restitution, &weights);
        LineFits::new(&sample, first.batches.start..last.batches.end, &of_batch, &self.tables).ok()
    }

    /// Words of 32 bits that a replicate uses.
    pub(super) fn words(&self) -> u64 {
        self.batches.words()
    }

    /// Room for a replicate; what no draw moves is in place.
    pub(super) fn room(&self) -> DrawnNodes {
        let mut weights = vec![1.0; self.runs.len()];
        for stratum in &self.strata {
            if let Some(alike) = &stratum.alike {
                weights[stratum.nodes.start] = alike.runs;
            }
        }
        DrawnNodes {
            drawn: self.batches.room(),
            restitution: self.runs.iter().map(|run| self.restitution[*run]).collect(),
            weights,
            squares: vec![0.0; self.runs.len()],
        }
    }

    /// Whether all targets are fitted from the tables alone.
    pub(super) fn by_lines(&self) -> bool {
        self.strata.is_empty()
    }

    /// Draws some replicates of all strata.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng, into: &mut DrawnNodes) {
        self.batches.draw(rng, &mut into.drawn);
    }

    /// The nodes of one of the replicates drawn.
    pub(super) fn gather(&self, replicate: usize, into: &mut DrawnNodes) {
        for Stratum { batches, nodes, alike } in &self.strata {
            let drawn = self.batches.drawn(batches.clone(), &into.drawn, replicate);
            let Some(alike) = alike else {
                write_weights(drawn, &mut into.weights[nodes.clone()]);
                continue;
            };
            let table = &self.tables[alike.table.clone()];
            let own = drawn.map(|drawn| table[drawn as usize]);
            let [sum, squares] = own.fold([0.0; 2], add);
            let shift = sum * alike.share;
            into.restitution[nodes.start] = alike.mean + shift;
            into.squares[nodes.start] = squares - sum * shift;
        }
    }
}

/// Adds the sums of one batch.
fn add([sum, squares]: [f64; 2], [s, q]: [f64; 2]) -> [f64; 2] {
    [sum + s, squares + q]
}
