//! Holds the settings of runs as nodes, and the blocks that wet runs form.

use std::ops::Range;

use super::errors::Errors;
use crate::physics::balance::Impact;

/// Settings with their counts, as columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Nodes {
    /// x = 4/St
    pub(super) over_stokes: Vec<f64>,
    /// p = v^(1/5) at the dry speed in use, (m/s)^(1/5)
    pub(super) dry_root: Vec<f64>,
    /// b, the share that no parameter moves; empty where the form has none
    pub(super) fixed: Vec<f64>,
    /// v db/dv; empty with b
    pub(super) fixed_slope: Vec<f64>,
    /// mean e of the runs; 0 for stuck ones
    pub(super) restitution: Vec<f64>,
    /// how many runs the node stands for; need not be whole
    pub(super) count: Vec<f64>,
}

impl Nodes {
    pub(super) fn len(&self) -> usize {
        self.count.len()
    }

    /// Adds a node; `has_fixed` whether the form has shares that no parameter moves.
    pub(super) fn push(&mut self, at: Impact, has_fixed: bool, restitution: f64, count: f64) {
        self.over_stokes.push(at.over_stokes);
        self.dry_root.push(at.dry_root);
        if has_fixed {
            self.fixed.push(at.fixed[0]);
            self.fixed_slope.push(at.fixed[1]);
        }
        self.restitution.push(restitution);
        self.count.push(count);
    }

    #[inline]
    pub(super) fn impact(&self, node: usize) -> Impact {
        let of = |column: &[f64]| column.get(node).copied().unwrap_or(0.0);
        Impact {
            over_stokes: self.over_stokes[node],
            dry_root: self.dry_root[node],
            fixed: [of(&self.fixed), of(&self.fixed_slope)],
        }
    }

    /// Whether there are shares that no parameter moves.
    pub(super) fn has_fixed(&self) -> bool {
        !self.fixed.is_empty()
    }

    /// Appends all of some other nodes, and says where they are.
    pub(super) fn append(&mut self, more: &Nodes) -> Range<usize> {
        let first = self.len();
        self.over_stokes.extend(&more.over_stokes);
        self.dry_root.extend(&more.dry_root);
        self.fixed.extend(&more.fixed);
        self.fixed_slope.extend(&more.fixed_slope);
        self.restitution.extend(&more.restitution);
        self.count.extend(&more.count);
        first..self.len()
    }
}

/// Wet runs of one series that share a film ratio.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WetBlock {
    pub(super) sphere: usize,
    pub(super) density_ratio: f64,
    /// place in a full vector of the offset of its series, where series have one
    pub(super) offset: Option<usize>,
    /// index into [`super::Likelihood::film_ratios`]
    pub(super) film: usize,
    /// range of [`super::Likelihood::rebounds`]
    pub(super) rebounds: Range<usize>,
    /// range of [`super::Likelihood::stuck`]
    pub(super) stuck: Range<usize>,
}

/// A dry run by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DryRow {
    pub(super) sphere: usize,
    /// p
    pub(super) dry_root: f64,
    /// e; `None` where it stuck
    pub(super) restitution: Option<f64>,
    pub(super) errors: Errors,
}
