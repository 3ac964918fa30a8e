//! Holds the settings of runs: one by one, the blocks that they form, and as columns.

use std::cmp::Ordering;
use std::ops::Range;

use crate::physics::balance::Impact;

/// Runs of one k, density ratio and offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    pub sphere: usize,
    /// whether there was a liquid
    pub wet: bool,
    /// ρ̃; 0 of dry runs
    pub density_ratio: f64,
    /// place in a full vector of the offset of its series, where series have one
    pub offset: Option<usize>,
}

/// The film of a setting; that of a dry one is nought.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Film {
    /// δ̃
    pub ratio: f64,
    /// f, its logarithm over the middle one of the runs
    pub ln: f64,
    /// g(δ̃); `None` where a parameter moves it
    pub shape: Option<f64>,
}

/// What the restitution of a run depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunSetting {
    /// its place among the blocks
    pub block: usize,
    pub film: Film,
    pub impact: Impact,
}

impl RunSetting {
    /// By film, then by speed and diameter.
    pub fn order(&self, other: &RunSetting) -> Ordering {
        let key = |own: &RunSetting| {
            let at = own.impact;
            [own.film.ratio, at.over_stokes, at.dry_root, at.fixed[0]]
        };
        let mut orders = key(self).into_iter().zip(key(other)).map(|(a, b)| a.total_cmp(&b));
        orders.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    }
}

/// Settings with their counts, as columns.
#[derive(Debug, Clone, Default)]
pub(super) struct Nodes {
    /// the nodes of each block, sorted by their film ratios
    pub blocks: Vec<Range<usize>>,
    /// x = 4/St
    pub over_stokes: Vec<f64>,
    /// p = v^(1/5) at the dry speed in use, (m/s)^(1/5)
    pub dry_root: Vec<f64>,
    /// b, the share that no parameter moves
    pub fixed: Vec<f64>,
    /// δ̃
    pub film_ratio: Vec<f64>,
    /// f
    pub ln_film: Vec<f64>,
    /// g(δ̃); 0 of dry runs, and where a parameter moves it
    pub shape: Vec<f64>,
    /// mean e of the runs
    pub restitution: Vec<f64>,
    /// how many runs the node stands for; need not be whole
    pub count: Vec<f64>,
}

impl Nodes {
    pub fn len(&self) -> usize {
        self.count.len()
    }

    /// Adds a node.
    pub fn push(&mut self, RunSetting { film, impact, .. }: RunSetting, restitution: f64, count: f64) {
        self.over_stokes.push(impact.over_stokes);
        self.dry_root.push(impact.dry_root);
        self.fixed.push(impact.fixed[0]);
        self.film_ratio.push(film.ratio);
        self.ln_film.push(film.ln);
        self.shape.push(film.shape.unwrap_or_default());
        self.restitution.push(restitution);
        self.count.push(count);
    }
}
