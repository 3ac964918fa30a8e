//! Gathers runs that share a stratum and an abscissa into one node, of which a replicate needs the mean only.
//!
//! Where all n runs of a stratum have one x, a law's sum of squares over the runs drawn is that of n runs at their mean
//! plus the squares about it, which no parameter moves. The mean and these squares are sums over the draws, tabulated by
//! how the draws fall. The runs of other strata are a node each, and their weight is drawn.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;

use super::kernel::Sample;
use super::picks::{draws, drawn, unit, ways, weigh, Picks};
use super::{Pool, Target};

/// A stratum, as nodes.
struct Stratum {
    picks: Range<usize>,
    nodes: Range<usize>,
    /// mean restitution, of a stratum that is one node of several runs
    mean: Option<f64>,
    runs: f64,
}

/// All strata as nodes.
pub(super) struct Nodes {
    picks: Picks,
    strata: Vec<Stratum>,
    /// Σ w (e − mean) and Σ w (e − mean)² of the draws of a pick, for every way in which they fall
    tables: Vec<[f64; 2]>,
    /// where the table of each pick starts
    starts: Vec<usize>,
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
        let picks = Picks::new(&pool.strata);
        let mut nodes = Nodes {
            strata: vec![],
            tables: vec![],
            starts: vec![],
            runs: vec![],
            restitution,
            columns: vec![],
            picks,
        };
        for (number, (stratum, alike)) in pool.strata.iter().zip(alike).enumerate() {
            let first = nodes.runs.len();
            let mean = (alike && stratum.len() > 1).then(|| nodes.tabulate(number, stratum));
            nodes.runs.extend(stratum.clone().take(match mean {
                Some(_) => 1,
                None => stratum.len(),
            }));
            nodes.starts.resize(nodes.picks.strata[number].end, 0);
            nodes.strata.push(Stratum {
                picks: nodes.picks.strata[number].clone(),
                nodes: first..nodes.runs.len(),
                mean,
                runs: stratum.len() as f64,
            });
        }
        nodes.columns = targets.iter().map(|target| nodes.column(pool, target)).collect();
        nodes
    }

    /// Tabulates the draws of a stratum and gives its mean restitution.
    fn tabulate(&mut self, number: usize, stratum: &Range<usize>) -> f64 {
        let own = &self.restitution[stratum.clone()];
        let n = own.len();
        let mean = own.iter().sum::<f64>() / n as f64;
        let mut made = None;
        let picks = self.picks.strata[number].clone();
        for (pick, draws) in picks.zip(draws(n)) {
            if made != Some(draws) {
                made = Some(draws);
                self.starts.resize(pick, 0);
                let start = self.tables.len();
                self.tables.extend((0..ways(n, draws)).map(|way| {
                    drawn(way, n, draws).fold([0.0; 2], |[sum, squares], member| {
                        let e = own[member] - mean;
                        [sum + unit(n) * e, squares + unit(n) * e * e]
                    })
                }));
                self.starts.push(start);
            } else {
                self.starts.extend(self.starts.last().copied());
            }
        }
        mean
    }

    /// A target's columns over its nodes.
    fn column(&self, pool: &Pool, target: &Target) -> Column {
        let nodes = match &self.strata[target.strata.clone()] {
            [] => 0..0,
            [first, .., last] => first.nodes.start..last.nodes.end,
            [only] => only.nodes.clone(),
        };
        let first = pool.first_run(target);
        let of = |column: &[f64]| {
            let own = self.runs[nodes.clone()].iter();
            own.filter_map(|run| column.get(run - first)).copied().collect()
        };
        Column {
            x: of(target.x),
            offset: of(target.offset),
            nodes,
        }
    }

    /// Words of 32 bits that a replicate uses.
    pub(super) fn words(&self) -> u64 {
        self.picks.words()
    }

    /// Room for a replicate; what no draw moves is in place.
    pub(super) fn room(&self) -> Drawn {
        let mut weights = vec![1.0; self.runs.len()];
        for stratum in self.strata.iter().filter(|stratum| stratum.mean.is_some()) {
            weights[stratum.nodes.start] = stratum.runs;
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
        for stratum in &self.strata {
            let fell = &into.fell[stratum.picks.clone()];
            let Some(mean) = stratum.mean else {
                weigh(fell, &mut into.weights[stratum.nodes.clone()]);
                continue;
            };
            let (mut sum, mut squares) = (0.0, 0.0);
            for (way, start) in fell.iter().zip(&self.starts[stratum.picks.clone()]) {
                let [s, q] = self.tables[start + *way as usize];
                sum += s;
                squares += q;
            }
            let shift = sum / stratum.runs;
            into.restitution[stratum.nodes.start] = mean + shift;
            into.squares[stratum.nodes.start] = squares - sum * shift;
        }
    }
}
