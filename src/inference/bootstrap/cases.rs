//! Draws the runs of every stratum, and gives each fit what it needs of them.
//!
//! Where all n runs of a stratum have one abscissa, a law's sum of squares over the runs drawn is that of n runs at their
//! mean, but for the squares about it, which no parameter moves. Such a stratum is one node, at the mean of what was drawn;
//! the runs of other strata are a node each, and their weight is drawn.

use std::ops::Range;

use rand::rngs::ChaCha8Rng;

use super::draws::{DrawnMean, Draws};
use super::target::{Pool, Target};
use crate::inference::kernel::{Sample, WeightedFit};

/// A stratum and its nodes.
enum Stratum {
    /// of one abscissa
    OneNode {
        node: usize,
        restitution: DrawnMean,
    },
    NodeARun {
        nodes: Range<usize>,
        draws: Draws,
    },
}

/// The strata of some targets, and what is fitted in a replicate of each.
pub(super) struct Cases<'a> {
    targets: &'a [Target<'a>],
    /// those that some target has
    strata: Vec<Stratum>,
    /// by target
    columns: Vec<NodeColumns>,
    /// nodes before anything is drawn
    nodes: Nodes,
}

/// What the nodes of a target hold in all replicates.
struct NodeColumns {
    nodes: Range<usize>,
    x: Vec<f64>,
    offset: Vec<f64>,
}

/// What the nodes hold in one replicate.
#[derive(Clone, Default)]
pub(super) struct Nodes {
    restitution: Vec<f64>,
    weights: Vec<f64>,
}

impl<'a> Cases<'a> {
    pub(super) fn new(pool: &Pool, targets: &'a [Target<'a>]) -> Cases<'a> {
        let runs = pool.strata.last().map_or(0, |stratum| stratum.end);
        let mut restitution = vec![0.0; runs];
        let (mut is_drawn, mut is_one_node) = (vec![false; pool.strata.len()], vec![true; pool.strata.len()]);
        for target in targets {
            let first = pool.first_run(target);
            restitution[first..first + target.regression.x.len()].copy_from_slice(target.regression.restitution);
            for stratum in target.strata.clone() {
                let own = pool.strata[stratum].start - first..pool.strata[stratum].end - first;
                let is_even = |column: &[f64]| {
                    let own = column.get(own.clone());
                    own.is_none_or(|own| own.iter().all(|x| *x == own[0]))
                };
                is_drawn[stratum] = true;
                // runs that are weighed by their errors have no common mean
                is_one_node[stratum] &=
                    target.errors.is_none() && is_even(target.regression.x) && is_even(target.regression.offset);
            }
        }
        let mut nodes = Nodes::default();
        // the first run of each node, and the first node of each stratum
        let (mut run_of_node, mut first_nodes) = (vec![], vec![]);
        for (runs, is_one_node) in pool.strata.iter().zip(&is_one_node) {
            first_nodes.push(run_of_node.len());
            let (count, weight) = match *is_one_node {
                true => (1, runs.len() as f64),
                false => (runs.len(), 1.0),
            };
            run_of_node.extend(runs.clone().take(count));
            nodes.weights.resize(run_of_node.len(), weight);
        }
        first_nodes.push(run_of_node.len());
        nodes.restitution = run_of_node.iter().map(|run| restitution[*run]).collect();
        let columns = targets.iter().map(|target| {
            let nodes = first_nodes[target.strata.start]..first_nodes[target.strata.end];
            let first = pool.first_run(target);
            let of_nodes = |column: &[f64]| -> Vec<f64> {
                let own = run_of_node[nodes.clone()].iter();
                own.filter_map(|run| column.get(run - first)).copied().collect()
            };
            NodeColumns {
                x: of_nodes(target.regression.x),
                offset: of_nodes(target.regression.offset),
                nodes: nodes.clone(),
            }
        });
        let columns = columns.collect();
        let drawn = (0..pool.strata.len()).filter(|stratum| is_drawn[*stratum]);
        let strata = drawn.map(|stratum| match is_one_node[stratum] {
            true => Stratum::OneNode {
                node: first_nodes[stratum],
                restitution: DrawnMean::new(&restitution[pool.strata[stratum].clone()]),
            },
            false => Stratum::NodeARun {
                nodes: first_nodes[stratum]..first_nodes[stratum + 1],
                draws: Draws::new(pool.strata[stratum].len()),
            },
        });
        Cases {
            targets,
            strata: strata.collect(),
            columns,
            nodes,
        }
    }

    /// Random words of 32 bits that a replicate uses.
    pub(super) fn words(&self) -> u64 {
        let of_stratum = |stratum: &Stratum| match stratum {
            Stratum::OneNode { restitution, .. } => restitution.words(),
            Stratum::NodeARun { draws, .. } => draws.words(),
        };
        self.strata.iter().map(of_stratum).sum()
    }

    /// Nodes to draw into.
    pub(super) fn room(&self) -> Nodes {
        self.nodes.clone()
    }

    /// Draws a replicate.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng, into: &mut Nodes) {
        for stratum in &self.strata {
            match stratum {
                Stratum::OneNode { node, restitution } => into.restitution[*node] = restitution.draw(rng),
                Stratum::NodeARun { nodes, draws } => draws.weigh(rng, &mut into.weights[nodes.clone()]),
            }
        }
    }

    /// Fits a target, by its number, to what was drawn.
    pub(super) fn fit(&self, target: usize, drawn: &Nodes) -> WeightedFit {
        let NodeColumns { nodes, x, offset } = &self.columns[target];
        self.targets[target].fit(&Sample {
            x,
            offset,
            restitution: &drawn.restitution[nodes.clone()],
            weights: &drawn.weights[nodes.clone()],
        })
    }
}
