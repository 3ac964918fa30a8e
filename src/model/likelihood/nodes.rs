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
    /// δ̃
    pub(super) film_ratio: Vec<f64>,
    /// f, its logarithm over the middle one of the runs
    pub(super) ln_film: Vec<f64>,
    /// g(δ̃); empty where a parameter moves it
    pub(super) shape: Vec<f64>,
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
    pub(super) fn push(&mut self, at: Impact, film: NodeFilm, has_fixed: bool, restitution: f64, count: f64) {
        self.over_stokes.push(at.over_stokes);
        self.dry_root.push(at.dry_root);
        if has_fixed {
            self.fixed.push(at.fixed[0]);
            self.fixed_slope.push(at.fixed[1]);
        }
        self.film_ratio.push(film.ratio);
        self.ln_film.push(film.ln);
        self.shape.extend(film.shape);
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

    pub(super) fn film(&self, node: usize) -> NodeFilm {
        NodeFilm {
            ratio: self.film_ratio[node],
            ln: self.ln_film[node],
            shape: self.shape.get(node).copied(),
        }
    }
}

/// The film of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodeFilm {
    /// δ̃
    pub(super) ratio: f64,
    /// f
    pub(super) ln: f64,
    /// g(δ̃); `None` where a parameter moves it
    pub(super) shape: Option<f64>,
}

/// Wet runs of one k, density ratio and offset, sorted by their film ratios.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WetBlock {
    pub(super) sphere: usize,
    pub(super) density_ratio: f64,
    /// place in a full vector of the offset of its series, where series have one
    pub(super) offset: Option<usize>,
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

impl DryRow {
    pub(super) fn impact(&self) -> Impact {
        Impact {
            dry_root: self.dry_root,
            over_stokes: 0.0,
            fixed: [0.0; 2],
        }
    }
}
