//! Gathers runs that share a stratum and an abscissa into one node, of which a replicate needs the mean only.
//!
//! Where all n runs of a stratum have one x, a law's sum of squares over the runs drawn is that of n runs at their mean
//! plus the squares about it, which no parameter moves. The mean and these squares are sums over the draws, tabulated by
//! how the draws fall. The runs of other strata are a node each, and their weight is drawn.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;

use super::kernel::{Lines, Sample};
use super::picks::{drawn, draws, unit, ways, weigh, Picks};
use super::{Law, Pool, Target};

/// A stratum whose runs are a node each.
struct Apart {
    picks: Range<usize>,
    nodes: Range<usize>,
}

/// A stratum that is one node.
struct Alike {
    picks: Range<usize>,
    node: usize,
    runs: f64,
    /// 1/runs: dividing takes as long as the sums
    share: f64,
    /// their mean restitution
    mean: f64,
}

/// All strata as nodes.
pub(super) struct Nodes {
    picks: Picks,
    alike: Vec<Alike>,
    apart: Vec<Apart>,
    /// Σ w (e − mean) and Σ w (e − mean)² of the draws of a pick, for every way in which they fall
    tables: Vec<[f64; 2]>,
    /// nodes of each stratum
    strata: Vec<Range<usize>>,
    /// the first run of each node
    runs: Vec<usize>,
    /// restitution of each run
    restitution: Vec<f64>,
    /// by target
    pub(super) columns: Vec<Column>,
}

/// Abscissa and offset of a target's nodes.
pub(super) struct Column {
    nodes: Range<usize>,
    x: Vec<f64>,
    offset: Vec<f64>,
    /// of a linear law, where no draw moves a weight
    pub(super) lines: Option<Lines>,
}

/// A replicate, by node.
pub(super) struct Drawn {
    fell: Vec<u32>,
    restitution: Vec<f64>,
    weights: Vec<f64>,
    /// squares about the node's mean
    squares: Vec<f64>,
}

impl Drawn {
    /// What a target is fitted to.
    pub(super) fn of<'a>(&'a self, column: &'a Column) -> Sample<'a> {
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

impl Nodes {
    pub(super) fn new(pool: &Pool, targets: &[Target]) -> Nodes {
        let runs = pool.strata.last().map_or(0, |stratum| stratum.end);
        let mut restitution = vec![0.0; runs];
        // a stratum that no target has is a node, too
        let mut alike = vec![true; pool.strata.len()];
        for target in targets {
            let first = pool.first_run(target);
            restitution[first..first + target.x.len()].copy_from_slice(target.restitution);
            let strata = pool.strata[target.strata.clone()].iter();
            for (stratum, alike) in strata.zip(&mut alike[target.strata.clone()]) {
                let same = |column: &[f64]| {
                    let own = column.get(stratum.start - first..stratum.end - first);
                    own.is_none_or(|own| own.iter().all(|x| *x == own[0]))
                };
                *alike &= same(target.x) && same(target.offset);
            }
        }
        let mut nodes = Nodes {
            picks: Picks::new(&pool.strata),
            alike: vec![],
            apart: vec![],
            tables: vec![],
            strata: vec![],
            runs: vec![],
            restitution,
            columns: vec![],
        };
        for (number, (stratum, alike)) in pool.strata.iter().zip(alike).enumerate() {
            let first = nodes.runs.len();
            let picks = nodes.picks.strata[number].clone();
            if alike && stratum.len() > 1 {
                nodes.runs.push(stratum.start);
                nodes.tabulate(picks, stratum);
            } else {
                nodes.runs.extend(stratum.clone());
                nodes.apart.push(Apart {
                    picks,
                    nodes: first..nodes.runs.len(),
                });
            }
            nodes.strata.push(first..nodes.runs.len());
        }
        nodes.columns = targets.iter().map(|target| nodes.column(pool, target)).collect();
        nodes
    }

    /// Adds a stratum that is the last node, with the sums over its draws.
    fn tabulate(&mut self, picks: Range<usize>, stratum: &Range<usize>) {
        let own = &self.restitution[stratum.clone()];
        let n = own.len();
        let mean = own.iter().sum::<f64>() / n as f64;
        let (mut made, mut start) = (0, 0);
        for (pick, draws) in picks.clone().zip(draws(n)) {
            if made != draws {
                made = draws;
                start = u32::try_from(self.tables.len()).unwrap_or(u32::MAX);
                self.tables.extend((0..ways(n, draws)).map(|way| {
                    drawn(way, n, draws).fold([0.0; 2], |[sum, squares], member| {
                        let e = own[member] - mean;
                        [sum + unit(n) * e, squares + unit(n) * e * e]
                    })
                }));
            }
            self.picks.number_from(pick, start);
        }
        self.alike.push(Alike {
            picks,
            node: self.runs.len() - 1,
            runs: n as f64,
            share: 1.0 / n as f64,
            mean,
        });
    }

    /// A target's columns over its nodes.
    fn column(&self, pool: &Pool, target: &Target) -> Column {
        let nodes = match &self.strata[target.strata.clone()] {
            [] => 0..0,
            [first, .., last] => first.start..last.end,
            [only] => only.clone(),
        };
        let first = pool.first_run(target);
        let of = |column: &[f64]| -> Vec<f64> {
            let own = self.runs[nodes.clone()].iter();
            own.filter_map(|run| column.get(run - first)).copied().collect()
        };
        let x = of(target.x);
        // a stratum of one run is one that no draw moves, either
        let moved = |apart: &Apart| apart.nodes.len() > 1 && nodes.contains(&apart.nodes.start);
        let lines = if target.law == Law::Linear && !self.apart.iter().any(moved) {
            Lines::new(&x, &self.room().weights[nodes.clone()]).ok()
        } else {
            None
        };
        Column {
            x,
            offset: of(target.offset),
            nodes,
            lines,
        }
    }

    /// Words of 32 bits that a replicate uses.
    pub(super) fn words(&self) -> u64 {
        self.picks.words()
    }

    /// Room for a replicate; what no draw moves is in place.
    pub(super) fn room(&self) -> Drawn {
        let mut weights = vec![1.0; self.runs.len()];
        for stratum in &self.alike {
            weights[stratum.node] = stratum.runs;
        }
        Drawn {
            fell: vec![0; self.picks.len()],
            restitution: self.runs.iter().map(|run| self.restitution[*run]).collect(),
            weights,
            squares: vec![0.0; self.runs.len()],
        }
    }

    /// Draws a replicate of all strata.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng, into: &mut Drawn) {
        self.picks.draw(rng, &mut into.fell);
        for stratum in &self.apart {
            weigh(
                &into.fell[stratum.picks.clone()],
                &mut into.weights[stratum.nodes.clone()],
            );
        }
        for stratum in &self.alike {
            let (mut sum, mut squares) = (0.0, 0.0);
            for way in &into.fell[stratum.picks.clone()] {
                let [s, q] = self.tables[*way as usize];
                sum += s;
                squares += q;
            }
            let shift = sum * stratum.share;
            into.restitution[stratum.node] = stratum.mean + shift;
            into.squares[stratum.node] = squares - sum * shift;
        }
    }
}
