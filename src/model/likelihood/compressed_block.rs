//! Holds what became of the nodes of a block.

use super::nodes::Nodes;

/// What became of one block.
#[derive(Default)]
pub(super) struct CompressedBlock {
    pub nodes: Nodes,
    pub leftover: f64,
    pub rows_exact: usize,
    /// error at each test
    pub errors: Vec<f64>,
}

impl CompressedBlock {
    pub fn new(tests: usize) -> CompressedBlock {
        CompressedBlock {
            errors: vec![0.0; tests],
            ..CompressedBlock::default()
        }
    }

    /// Adds nodes that stand for others, with the sum of squares they leave and their error at each test.
    pub fn add(&mut self, nodes: &Nodes, leftover: f64, errors: &[f64]) {
        self.nodes.append(nodes);
        self.leftover += leftover;
        for (sum, error) in self.errors.iter_mut().zip(errors) {
            *sum += error;
        }
    }

    /// Adds settings as they are.
    pub fn keep(&mut self, settings: &Nodes) {
        self.nodes.append(settings);
        self.rows_exact += settings.count.iter().map(|count| count.round() as usize).sum::<usize>();
    }
}
