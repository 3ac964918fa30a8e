//! Sums distances and slopes over the rebounds of a block where the spread is one for all: step by step over some nodes at a
//! time, in loops that are compiled for the widest registers there are.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::block_sums::BlockSums;
use super::nodes::Nodes;
use super::trend::{BlockLaw, FilmColumns, CHUNK};
use crate::exponential::{is_fused, logarithm};
use crate::lanes::sums;
use crate::physics::dry::Order;
use crate::physics::rebound::mean_and_slope;

/// Student's tails of one spread.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeavyTails {
    /// q over the square of a distance
    pub steepness: f64,
    /// ν
    pub nu: f64,
}

/// A range of the nodes with its energy balance.
#[derive(Debug, Clone)]
pub(super) struct NodeRange {
    pub nodes: Range<usize>,
    pub law: BlockLaw,
}

/// The sums over each of some ranges of the nodes.
///
/// With heavy tails each node is one run, and counts by the weight its distance leaves it.
pub(super) fn rebound_sums(
    nodes: &Nodes,
    order: Order,
    heavy: Option<HeavyTails>,
    ranges: &[NodeRange],
) -> Vec<BlockSums> {
    // one call for all: a range of a few nodes costs no more than its roots
    Arch::new().dispatch(Rebounds {
        nodes,
        order,
        heavy,
        ranges,
    })
}

struct Rebounds<'a> {
    nodes: &'a Nodes,
    order: Order,
    heavy: Option<HeavyTails>,
    ranges: &'a [NodeRange],
}

impl WithSimd for Rebounds<'_> {
    type Output = Vec<BlockSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<BlockSums> {
        let mut columns = Columns::default();
        // loops, since what is given to an iterator may not be compiled for these registers
        let mut all = Vec::with_capacity(self.ranges.len());
        for range in self.ranges {
            let mut sums = BlockSums::default();
            for chunk in range.chunks() {
                columns.read(self.nodes, range, chunk.clone(), self.order, is_fused::<S>());
                self.add(&mut columns, chunk, is_fused::<S>(), &mut sums);
            }
            all.push(sums);
        }
        all
    }
}

impl Rebounds<'_> {
    /// Adds the nodes of a chunk that was read.
    #[inline(always)]
    fn add(&self, columns: &mut Columns, chunk: Range<usize>, fused: bool, all: &mut BlockSums) {
        let (e, n) = (&self.nodes.restitution[chunk.clone()], &self.nodes.count[chunk.clone()]);
        // n d², n d m′
        let (mut squares, mut weighted) = ([0.0; CHUNK], [0.0; CHUNK]);
        let [squares, weighted] = [&mut squares, &mut weighted].map(|column| &mut column[..chunk.len()]);
        // slices of one length, so that no place has to be held against the end
        let to = squares.iter_mut().zip(weighted.iter_mut());
        for ((square, weighted), (kept, (e, n))) in to.zip(columns.kept[..chunk.len()].iter().zip(e.iter().zip(n))) {
            let (mean, slope) = mean_and_slope(*kept);
            let distance = e - mean;
            *square = n * distance * distance;
            *weighted = n * distance * slope;
        }
        let squares = &*squares;
        if let Some(HeavyTails { steepness, nu }) = self.heavy {
            let [of_weight, ln_tails] = sums([squares], |[square]| {
                let q = steepness * square;
                [(nu + 1.0) * q / (nu + q), ln_one_and(q / nu, fused)]
            });
            all.weighted += of_weight;
            all.ln_tails += ln_tails;
            for (weighted, square) in weighted.iter_mut().zip(squares) {
                *weighted *= (nu + 1.0) / (nu + steepness * square);
            }
        }
        let [of_squares] = sums([squares], |[square]| [square]);
        all.squares += of_squares;
        columns.add_slopes(self.nodes, chunk, weighted, all);
    }
}

/// ln(1 + x) of x ≥ 0, as exact for small x as for large.
#[inline(always)]
fn ln_one_and(x: f64, fused: bool) -> f64 {
    let more = 1.0 + x;
    // with what the sum lost of x
    logarithm(more, fused) + (x - (more - 1.0)) / more
}

/// What the sums read of a chunk of nodes beside the nodes' own columns.
pub(super) struct Columns {
    /// r
    pub kept: [f64; CHUNK],
    /// e_dry times its fall with k
    pub dry: [f64; CHUNK],
    /// g exp(C′ f), and its slope in δ̃0 where it has one
    shapes: [[f64; CHUNK]; 2],
}

impl Default for Columns {
    fn default() -> Columns {
        Columns {
            kept: [0.0; CHUNK],
            dry: [0.0; CHUNK],
            shapes: [[0.0; CHUNK]; 2],
        }
    }
}

impl Columns {
    /// Computes those of a chunk of a range.
    #[inline(always)]
    pub fn read(&mut self, nodes: &Nodes, range: &NodeRange, chunk: Range<usize>, order: Order, fused: bool) {
        let law = &range.law;
        law.films.shapes(nodes.film_columns(&chunk), fused, &mut self.shapes);
        let (k, inertial) = (law.dry_k, law.density_ratio * law.films.prefactor);
        let (viscous, trend) = (law.films.viscous(), law.films.lubrication_trend);
        let [x, p, f] = [&nodes.over_stokes, &nodes.dry_root, &nodes.ln_film].map(|column| &column[chunk.clone()]);
        let Columns { kept, dry, shapes } = self;
        let [kept, dry, g] = [kept, dry, &mut shapes[0]].map(|column| &mut column[..chunk.len()]);
        let own = x.iter().zip(p).zip(f.iter().zip(&*g));
        for ((kept, dry), ((x, p), (f, g))) in kept.iter_mut().zip(dry).zip(own) {
            let [e_dry, in_loss, _] = order.of_loss(k * p);
            *dry = -e_dry * in_loss * p;
            *kept = e_dry * e_dry - inertial * g - (viscous + trend * f) * x + law.offset;
        }
        for (kept, fixed) in self.kept.iter_mut().zip(nodes.fixed.get(chunk).unwrap_or(&[])) {
            *kept -= fixed;
        }
    }

    /// Adds the sums of slopes of a chunk from those in r.
    #[inline(always)]
    pub fn add_slopes(&self, nodes: &Nodes, chunk: Range<usize>, in_kept: &[f64], all: &mut BlockSums) {
        let own = [&nodes.over_stokes, &nodes.ln_film].map(|column| &column[chunk.clone()]);
        let [x, f] = own;
        let [g, h] = &self.shapes;
        let [kept, viscous, dry, shape, scale, viscous_trend, inertial_trend] =
            sums([in_kept, x, &self.dry, g, h, f], |[w, x, dry, g, h, f]| {
                let (of_x, of_g) = (w * x, w * g);
                [w, of_x, w * dry, of_g, w * h, of_x * f, of_g * f]
            });
        let more = BlockSums {
            kept,
            viscous,
            dry,
            shape,
            scale,
            viscous_trend,
            inertial_trend,
            ..BlockSums::default()
        };
        all.add_slopes(more, 1.0);
    }
}

impl NodeRange {
    /// The nodes, some at a time.
    pub fn chunks(&self) -> impl Iterator<Item = Range<usize>> {
        let end = self.nodes.end;
        let firsts = self.nodes.clone().step_by(CHUNK);
        firsts.map(move |first| first..end.min(first + CHUNK))
    }
}

impl Nodes {
    fn film_columns(&self, chunk: &Range<usize>) -> FilmColumns<'_> {
        FilmColumns {
            ratio: &self.film_ratio[chunk.clone()],
            ln: &self.ln_film[chunk.clone()],
            shape: self.shape.get(chunk.clone()).unwrap_or(&[]),
        }
    }
}
