//! Sums the probabilities that runs came out on one side of the limit, with their slopes, a few settings at a time.

use pulp::{Arch, Simd, WithSimd};

use super::block_sums::BlockSums;
use super::nodes::Nodes;
use super::normal::{ln_normal_cdf_and_slope, CERTAIN};
use super::run_density::Side;
use super::sums::{Constants, NodeRange};
use super::trend::CHUNK;
use crate::exponential::is_fused;
use crate::physics::dry::Order;
use crate::physics::rebound::{kept_of_mean_restitution, mean_and_slope};

/// Settings that are computed side by side.
const LANES: usize = 8;

/// What is asked of runs with normal noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct SideOfLimit {
    pub side: Side,
    pub limit: f64,
    pub sigma: f64,
}

/// Sums over the runs of a block.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SideSums {
    /// Σ n ln P
    pub value: f64,
    /// its slope in σ
    pub sigma: f64,
    /// its slopes in r, as [`BlockSums`] has them; without squares
    pub slopes: BlockSums,
}

/// The sums over each of some ranges of the nodes.
pub(super) fn side_sums(nodes: &Nodes, order: Order, of: SideOfLimit, ranges: &[NodeRange]) -> Vec<SideSums> {
    let arch = Arch::new();
    match order {
        Order::First => arch.dispatch(OverRanges::<false> { nodes, of, ranges }),
        Order::Second => arch.dispatch(OverRanges::<true> { nodes, of, ranges }),
    }
}

struct OverRanges<'a, const SECOND: bool> {
    nodes: &'a Nodes,
    of: SideOfLimit,
    ranges: &'a [NodeRange],
}

/// Nodes that are gathered: few, since they are cleared at every evaluation.
const GATHERED: usize = 2 * LANES;

/// Nodes of a block whose side is not certain, gathered until there are enough of them.
struct Uncertain {
    /// n, x, p, r, G, dG/dδ̃0 and f
    columns: [[f64; GATHERED]; 7],
    count: usize,
    /// z, m′, ln P and its slope in z
    steps: [[f64; GATHERED]; 4],
    /// in the order of [`SideSums`]
    sums: [[f64; LANES]; 9],
}

impl<const SECOND: bool> WithSimd for OverRanges<'_, SECOND> {
    type Output = Vec<SideSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<SideSums> {
        let SideOfLimit { side, limit, sigma } = self.of;
        let certain = kept_of_mean_restitution(limit - side.sign() * CERTAIN * sigma);
        let mut shapes = [[0.0; CHUNK]; 2];
        let mut kept = [0.0; CHUNK];
        let mut nodes = Uncertain {
            columns: [[0.0; GATHERED]; 7],
            count: 0,
            steps: [[0.0; GATHERED]; 4],
            sums: [[0.0; LANES]; 9],
        };
        let mut all = Vec::with_capacity(self.ranges.len());
        for NodeRange { nodes: range, law } in self.ranges {
            let constants = Constants::of(law);
            for chunk in self.nodes.chunks(range) {
                let films = self.nodes.film_columns(&chunk);
                let [g, h] = law.films.shapes(films, is_fused::<S>(), &mut shapes);
                let kept = &mut kept[..chunk.len()];
                constants.kept_of_chunk::<S, SECOND>(simd, self.nodes, (chunk.clone(), [g, films.ln]), kept);
                for (place, (node, r)) in chunk.zip(kept).enumerate() {
                    // also where it is no number
                    if side.sign() * (*r - certain) < 0.0 {
                        continue;
                    }
                    let (n, x, p) = (&self.nodes.count, &self.nodes.over_stokes, &self.nodes.dry_root);
                    nodes.push([n[node], x[node], p[node], *r, g[place], h[place], films.ln[place]]);
                    if nodes.count == GATHERED {
                        self.add(law.dry_k, &mut nodes, is_fused::<S>());
                    }
                }
            }
            self.add(law.dry_k, &mut nodes, is_fused::<S>());
            all.push(nodes.take(sigma));
        }
        all
    }
}

impl Uncertain {
    #[inline(always)]
    fn push(&mut self, node: [f64; 7]) {
        for (column, number) in self.columns.iter_mut().zip(node) {
            column[self.count] = number;
        }
        self.count += 1;
    }

    /// The sums over a block; the next one starts from nothing.
    fn take(&mut self, sigma: f64) -> SideSums {
        let sums = std::mem::replace(&mut self.sums, [[0.0; LANES]; 9]);
        let [value, of_z, kept, viscous, dry, shape, scale, viscous_trend, inertial_trend] =
            sums.map(|lanes| lanes.iter().sum::<f64>());
        SideSums {
            value,
            sigma: of_z / sigma,
            slopes: BlockSums {
                kept,
                viscous,
                dry,
                shape,
                scale,
                viscous_trend,
                inertial_trend,
                ..BlockSums::default()
            },
        }
    }
}

impl<const SECOND: bool> OverRanges<'_, SECOND> {
    /// Adds the nodes gathered. Step by step, each a loop over lanes that do not need one another.
    #[inline(always)]
    fn add(&self, dry_k: f64, nodes: &mut Uncertain, fused: bool) {
        let SideOfLimit { side, limit, sigma } = self.of;
        let order = if SECOND { Order::Second } else { Order::First };
        let over_sigma = side.sign() / sigma;
        let filled = nodes.count.next_multiple_of(LANES);
        // filled up with nodes that count for nothing
        nodes.columns[0][nodes.count..filled].fill(0.0);
        nodes.count = 0;
        let [n, x, p, r, g, h, f] = nodes.columns.each_ref().map(|column| &column[..filled]);
        let [z, slope, ln, of_z] = nodes.steps.each_mut().map(|column| &mut column[..filled]);
        for ((z, slope), r) in z.iter_mut().zip(&mut *slope).zip(r) {
            let (mean, of_kept) = mean_and_slope(*r);
            (*z, *slope) = ((limit - mean) * over_sigma, of_kept);
        }
        for ((ln, of_z), z) in ln.iter_mut().zip(&mut *of_z).zip(&*z) {
            [*ln, *of_z] = ln_normal_cdf_and_slope(*z, fused);
        }
        for first in (0..filled).step_by(LANES) {
            for lane in 0..LANES {
                let i = first + lane;
                let weighted = n[i] * of_z[i];
                let kept = -weighted * over_sigma * slope[i];
                let [e_dry, in_loss, _] = order.of_loss(dry_k * p[i]);
                let (viscous, shape) = (kept * x[i], kept * g[i]);
                let terms = [
                    n[i] * ln[i],
                    -weighted * z[i],
                    kept,
                    viscous,
                    -kept * e_dry * in_loss * p[i],
                    shape,
                    kept * h[i],
                    viscous * f[i],
                    shape * f[i],
                ];
                for (sum, term) in nodes.sums.iter_mut().zip(terms) {
                    sum[lane] += term;
                }
            }
        }
    }
}
