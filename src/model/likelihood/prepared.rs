//! Holds the runs of a scene as the likelihood reads them: as nodes, and one by one those of which these do not say enough.

use super::nodes::Nodes;
use super::pointwise::Pointwise;
use crate::physics::Form;
use crate::runs::Runs;
use crate::scene::{LikelihoodFamily, Scene};

/// The log likelihood of the runs of a scene as a function of a full vector of parameters.
#[derive(Debug, Clone)]
pub struct Likelihood {
    /// the runs
    pub(super) rows: Pointwise,
    /// dry ones and wet ones as nodes
    pub(super) nodes: [KindNodes; 2],
    /// whether some runs have spreads or tails that no node says
    pub needs_rows: bool,
}

/// The runs of a kind as nodes.
#[derive(Debug, Clone, Default)]
pub(super) struct KindNodes {
    pub rebounds: Nodes,
    pub stuck: Nodes,
    /// runs that the nodes of rebounds stand for
    pub runs: f64,
    /// sum of squares of these about the means of their settings
    pub leftover: f64,
}

impl Likelihood {
    /// The likelihood of the runs of a scene.
    pub fn new(scene: &Scene, runs: &Runs, form: Form) -> Likelihood {
        let rows = Pointwise::new(scene, runs, form);
        let needs_rows = scene.model.has_own_noise() || !rows.errors.is_empty();
        // the rebounds with Student's noise of one spread are nodes, too, each by itself
        let is_student = rows.family == LikelihoodFamily::Student;
        let rebounds_are_nodes = !needs_rows || is_student && !rows.is_integrated() && !rows.truncated;
        let is_node = |run: usize| !needs_rows || rebounds_are_nodes && !rows.is_stuck(run);
        let nodes = [0..rows.dry, rows.dry..rows.len()].map(|of_kind| {
            let mut of_blocks = vec![[vec![], vec![]]; rows.blocks.len()];
            for run in of_kind.filter(|run| is_node(*run)) {
                of_blocks[rows.setting(run).block][usize::from(rows.is_stuck(run))].push(run);
            }
            let mut nodes = KindNodes::default();
            for [of_rebounds, of_stuck] in of_blocks {
                nodes.leftover += nodes.rebounds.add(&rows, of_rebounds, !needs_rows);
                nodes.stuck.add(&rows, of_stuck, !needs_rows);
            }
            nodes.runs = nodes.rebounds.count.iter().sum();
            nodes
        });
        Likelihood {
            rows,
            nodes,
            needs_rows,
        }
    }

    /// Whether the likelihood of a scene's runs is one of rows, because they have spreads or tails of their own.
    pub fn needs_every_row(scene: &Scene, runs: &Runs) -> bool {
        scene.model.has_own_noise() || runs.errors_with_medians().is_some()
    }

    /// Nodes of wet runs, rebounded and stuck: different settings, or runs where these are not joined.
    pub fn nodes(&self) -> usize {
        let [_, wet] = &self.nodes;
        wet.rebounds.len() + wet.stuck.len()
    }
}

impl Nodes {
    /// Adds the runs of a block, those of one setting as one node where they are joined; gives the sum of their squares about
    /// the means of their nodes.
    fn add(&mut self, rows: &Pointwise, mut runs: Vec<usize>, are_joined: bool) -> f64 {
        // stable: runs of one setting keep their order
        runs.sort_by(|a, b| rows.setting(*a).order(rows.setting(*b)));
        let first = self.len();
        let mut leftover = 0.0;
        for of_one in runs.chunk_by(|a, b| are_joined && rows.setting(*a) == rows.setting(*b)) {
            let each = || of_one.iter().map(|run| (rows.count(*run), rows.restitution[*run]));
            let count: f64 = each().map(|(count, _)| count).sum();
            let mean = each().map(|(count, e)| count * e).sum::<f64>() / count;
            leftover += each().map(|(count, e)| count * (e - mean).powi(2)).sum::<f64>();
            self.push(*rows.setting(of_one[0]), mean, count);
        }
        self.blocks.push(first..self.len());
        leftover
    }
}
