//! Computes the log likelihood of all runs at once and its slopes, from rows or from the few nodes that stand for them.
//!
//! The generative statement: a wet run's e* = m(r) + σ_wet z, a dry run's e* = e_dry(v) + σ_dry z; the run stuck if e* is
//! at or below the limit. A node is a setting with a count and a mean restitution: a row is a node of count 1, and a
//! compressed series has few nodes and a leftover sum of squares, so that rows and nodes share one evaluation.
//!
//! Symbols: r = e_dry² − C ρ̃ g(δ̃) − L x with x = 4/St, e_dry = 1 − k p with p = v^(1/5) at the dry speed in use.

mod compress;
mod gauss;
pub mod normal;
pub mod pointwise;
mod rows;

pub use compress::{Compression, Resolution};

use std::ops::Range;

use self::normal::ln_normal_cdf;
use super::parameters::{Kind, COMMON_SLOTS};
use super::priors::LN_ROOT_TWO_PI;
use crate::physics::inertia::Inertia;
use crate::physics::rebound::{kept_of_mean_restitution, TURN};

/// Settings with their counts, as columns.
#[derive(Debug, Clone, Default, PartialEq)]
struct Nodes {
    /// x = 4/St
    viscous: Vec<f64>,
    /// p = v^(1/5) at the dry speed in use, (m/s)^(1/5)
    dry_power: Vec<f64>,
    /// mean e of the runs; 0 for stuck ones
    restitution: Vec<f64>,
    /// how many runs the node stands for; need not be whole
    count: Vec<f64>,
}

impl Nodes {
    fn len(&self) -> usize {
        self.count.len()
    }

    fn push(&mut self, viscous: f64, dry_power: f64, restitution: f64, count: f64) {
        self.viscous.push(viscous);
        self.dry_power.push(dry_power);
        self.restitution.push(restitution);
        self.count.push(count);
    }
}

/// Wet runs that share particle, liquid and film ratio.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    particle: usize,
    density_ratio: f64,
    /// index into [`Likelihood::film_ratios`]
    film: usize,
    /// range of [`Likelihood::rebounds`]
    rebounds: Range<usize>,
    /// range of [`Likelihood::stuck`]
    stuck: Range<usize>,
}

/// The dry runs of a particle: their rebounds need four numbers, with y = 1 − e = k p + σ z.
#[derive(Debug, Clone, Default, PartialEq)]
struct DryRuns {
    rebounds: f64,
    /// Σ p y / Σ p²
    slope: f64,
    /// Σ p²
    weight: f64,
    /// Σ (y − slope p)²
    leftover: f64,
    /// stuck runs, by p
    stuck: Vec<f64>,
}

/// The log likelihood of the runs of a scene as a function of a full vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Likelihood {
    inertia: Inertia,
    /// at or below this e* the run stuck
    limit: f64,
    blocks: Vec<Block>,
    /// the different film ratios: the shape of the inertial loss is computed once for each
    film_ratios: Vec<f64>,
    rebounds: Nodes,
    stuck: Nodes,
    /// wet runs that rebounded
    wet_rebounds: f64,
    /// what the nodes leave of the wet rebounds' sum of squares
    leftover: f64,
    dry: Vec<DryRuns>,
}

/// The parameters give no density here: not an error, a place to turn back from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutsideDomain;

/// Sums over the rebounds of a block: Σ n d², Σ n d m′, Σ n d m′ x, Σ n d m′ e_dry p, with d = e − m(r).
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    squares: f64,
    kept: f64,
    viscous: f64,
    dry: f64,
}

/// Runs taken at once, so that the machine's vector registers fill.
const LANES: usize = 4;

/// A stuck run this many σ below the limit stuck for certain: ln Φ(9) is −1e-19.
const CERTAIN: f64 = 9.0;

impl Likelihood {
    /// Nodes of wet runs, rebounded and stuck: the cost of one evaluation.
    pub fn nodes(&self) -> usize {
        self.rebounds.len() + self.stuck.len()
    }

    /// Log likelihood at a full vector of parameters; `slopes`, as long, is overwritten.
    ///
    /// Fails where it is not finite; a full vector with e_dry ≤ 0 or σ ≤ 0 is the caller's to avoid by its bounds.
    pub fn ln_density(&self, full: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        slopes.fill(0.0);
        let value = self.wet(full, slopes) + self.dry(full, slopes);
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        if finite {
            Ok(value)
        } else {
            Err(OutsideDomain)
        }
    }

    fn wet(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        if self.blocks.is_empty() {
            return 0.0;
        }
        let at = |kind: Kind| full[kind.slot()];
        let (l, c) = (at(Kind::LubricationLog), at(Kind::InertialPrefactor));
        let (scale, sigma) = (at(Kind::FilmScale), at(Kind::SigmaWet));
        let precision = 1.0 / (sigma * sigma);
        let mut squares = self.leftover;
        let mut stuck_value = 0.0;
        let certain = kept_of_mean_restitution(self.limit - CERTAIN * sigma);
        let shapes: Vec<(f64, f64)> = self
            .film_ratios
            .iter()
            .map(|ratio| self.inertia.shape_and_slope_film_scale(*ratio, scale))
            .collect();
        for block in &self.blocks {
            let k = full[COMMON_SLOTS + block.particle];
            let (shape, shape_slope) = shapes[block.film];
            let inertial = c * block.density_ratio * shape;
            let mut sums = Sums::default();
            if !block.rebounds.is_empty() {
                sums = rebound_sums(&self.rebounds, block.rebounds.clone(), k, inertial, l);
                squares += sums.squares;
                sums.kept *= precision;
                sums.viscous *= precision;
                sums.dry *= precision;
            }
            for node in block.stuck.clone() {
                let (x, p) = (self.stuck.viscous[node], self.stuck.dry_power[node]);
                let e_dry = 1.0 - k * p;
                let r = e_dry * e_dry - inertial - l * x;
                if r < certain {
                    continue;
                }
                let (mean, slope) = mean_and_slope(r);
                let z = (self.limit - mean) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                let count = self.stuck.count[node];
                stuck_value += count * ln_cdf;
                slopes[Kind::SigmaWet.slot()] -= count * mills * z / sigma;
                let kept = -count * mills / sigma * slope;
                sums.kept += kept;
                sums.viscous += kept * x;
                sums.dry += kept * e_dry * p;
            }
            slopes[Kind::LubricationLog.slot()] -= sums.viscous;
            slopes[Kind::InertialPrefactor.slot()] -= sums.kept * block.density_ratio * shape;
            slopes[Kind::FilmScale.slot()] -= sums.kept * c * block.density_ratio * shape_slope;
            slopes[COMMON_SLOTS + block.particle] -= 2.0 * sums.dry;
        }
        slopes[Kind::SigmaWet.slot()] += (squares * precision - self.wet_rebounds) / sigma;
        stuck_value - self.wet_rebounds * (sigma.ln() + LN_ROOT_TWO_PI) - 0.5 * squares * precision
    }

    fn dry(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        let sigma = full[Kind::SigmaDry.slot()];
        let precision = 1.0 / (sigma * sigma);
        let mut value = 0.0;
        for (particle, runs) in self.dry.iter().enumerate() {
            if runs.rebounds == 0.0 && runs.stuck.is_empty() {
                continue;
            }
            let k = full[COMMON_SLOTS + particle];
            let distance = k - runs.slope;
            let squares = runs.leftover + runs.weight * distance * distance;
            value -= runs.rebounds * (sigma.ln() + LN_ROOT_TWO_PI) + 0.5 * squares * precision;
            slopes[COMMON_SLOTS + particle] -= runs.weight * distance * precision;
            slopes[Kind::SigmaDry.slot()] += (squares * precision - runs.rebounds) / sigma;
            for p in &runs.stuck {
                let z = (self.limit - 1.0 + k * p) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                value += ln_cdf;
                slopes[COMMON_SLOTS + particle] += mills * p / sigma;
                slopes[Kind::SigmaDry.slot()] -= mills * z / sigma;
            }
        }
        value
    }
}

/// m(r) and m′(r) with two roots and one division.
#[inline(always)]
fn mean_and_slope(kept: f64) -> (f64, f64) {
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let square = kept * kept + TURN4;
    let inverse = 1.0 / (square * square.sqrt().sqrt());
    (kept * square * inverse, (0.5 * kept * kept + TURN4) * inverse)
}

/// So many numbers, one after another in memory.
type Lanes = [f64; LANES];

#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

fn rebound_sums(nodes: &Nodes, range: Range<usize>, k: f64, inertial: f64, l: f64) -> Sums {
    let x = &nodes.viscous[range.clone()];
    let p = &nodes.dry_power[range.clone()];
    let e = &nodes.restitution[range.clone()];
    let n = &nodes.count[range];
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let [mut squares, mut kept, mut viscous, mut dry] = [[0.0; LANES]; 4];
    // a step for all lanes at a time is what a compiler turns into vector instructions
    let mut add = |x: &Lanes, p: &Lanes, e: &Lanes, n: &Lanes| {
        let e_dry = each(|i| 1.0 - k * p[i]);
        let r = each(|i| e_dry[i] * e_dry[i] - inertial - l * x[i]);
        let square = each(|i| r[i] * r[i] + TURN4);
        let root = each(|i| square[i].sqrt());
        let root = each(|i| root[i].sqrt());
        let inverse = each(|i| 1.0 / (square[i] * root[i]));
        let distance = each(|i| e[i] - r[i] * square[i] * inverse[i]);
        let weighted = each(|i| n[i] * distance[i]);
        let moved = each(|i| weighted[i] * (0.5 * r[i] * r[i] + TURN4) * inverse[i]);
        squares = each(|i| squares[i] + weighted[i] * distance[i]);
        kept = each(|i| kept[i] + moved[i]);
        viscous = each(|i| viscous[i] + moved[i] * x[i]);
        dry = each(|i| dry[i] + moved[i] * e_dry[i] * p[i]);
    };
    let ((x, x_rest), (p, p_rest)) = (x.as_chunks(), p.as_chunks());
    let ((e, e_rest), (n, n_rest)) = (e.as_chunks(), n.as_chunks());
    for ((x, p), (e, n)) in x.iter().zip(p).zip(e.iter().zip(n)) {
        add(x, p, e, n);
    }
    if let Some((last_x, last_p)) = x_rest.last().zip(p_rest.last()) {
        // the rest, filled up with settings that count for nothing
        let (mut x, mut p, mut e, mut n) = ([*last_x; LANES], [*last_p; LANES], [0.0; LANES], [0.0; LANES]);
        for (to, from) in [(&mut x, x_rest), (&mut p, p_rest), (&mut e, e_rest), (&mut n, n_rest)] {
            to[..from.len()].copy_from_slice(from);
        }
        add(&x, &p, &e, &n);
    }
    let [squares, kept, viscous, dry] = [squares, kept, viscous, dry].map(|lanes| lanes.iter().sum::<f64>());
    Sums {
        squares,
        kept,
        viscous,
        dry,
    }
}

#[cfg(test)]
mod tests;
