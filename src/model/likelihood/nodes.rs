//! Holds the settings of runs as nodes, and the blocks that wet runs form.

use std::ops::Range;

use super::errors::Errors;
use super::law::Abscissa;

/// Settings with their counts, as columns.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Nodes {
    /// x = 4/St
    pub(super) viscous: Vec<f64>,
    /// p = v^(1/5) at the dry speed in use, (m/s)^(1/5)
    pub(super) dry_power: Vec<f64>,
    /// b = κ/v²; empty where the form holds no bridge
    pub(super) bridge: Vec<f64>,
    /// mean e of the runs; 0 for stuck ones
    pub(super) restitution: Vec<f64>,
    /// how many runs the node stands for; need not be whole
    pub(super) count: Vec<f64>,
}

impl Nodes {
    pub(super) fn len(&self) -> usize {
        self.count.len()
    }

    pub(super) fn push(&mut self, at: Abscissa, restitution: f64, count: f64) {
        self.viscous.push(at.viscous);
        self.dry_power.push(at.dry_power);
        self.bridge.extend(at.bridge);
        self.restitution.push(restitution);
        self.count.push(count);
    }

    #[inline]
    pub(super) fn abscissa(&self, node: usize) -> Abscissa {
        Abscissa {
            viscous: self.viscous[node],
            dry_power: self.dry_power[node],
            bridge: self.bridge.get(node).copied(),
        }
    }
}

/// Wet runs that share particle, liquid and film ratio.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub(super) particle: usize,
    pub(super) density_ratio: f64,
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
    pub(super) particle: usize,
    /// p
    pub(super) dry_power: f64,
    /// e; `None` where it stuck
    pub(super) restitution: Option<f64>,
    pub(super) errors: Errors,
}
