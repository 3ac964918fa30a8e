//! Sums the probabilities that runs came out on one side of the limit, with their slopes, some nodes at a time.

use pulp::{Arch, Simd, WithSimd};

use super::block_sums::BlockSums;
use super::nodes::Nodes;
use super::normal::{ln_normal_cdf_and_slope, CERTAIN};
use super::run_density::Side;
use super::sums::{Columns, NodeRange};
use super::trend::CHUNK;
use crate::exponential::is_fused;
use crate::lanes::sums;
use crate::physics::dry::Order;
use crate::physics::rebound::{kept_of_mean_restitution, mean_and_slope};

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
    Arch::new().dispatch(Sides {
        nodes,
        order,
        of,
        ranges,
    })
}

struct Sides<'a> {
    nodes: &'a Nodes,
    order: Order,
    of: SideOfLimit,
    ranges: &'a [NodeRange],
}

impl WithSimd for Sides<'_> {
    type Output = Vec<SideSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<SideSums> {
        let SideOfLimit { side, limit, sigma } = self.of;
        let over_sigma = side.sign() / sigma;
        let certain = kept_of_mean_restitution(limit - side.sign() * CERTAIN * sigma);
        let mut columns = Columns::default();
        let mut all = Vec::with_capacity(self.ranges.len());
        for range in self.ranges {
            let mut sides = SideSums::default();
            for chunk in range.chunks() {
                columns.read(self.nodes, range, chunk.clone(), self.order, is_fused::<S>());
                // also where it is no number
                let is_certain = |r: &f64| side.sign() * (*r - certain) < 0.0;
                if columns.kept[..chunk.len()].iter().all(is_certain) {
                    continue;
                }
                let n = &self.nodes.count[chunk.clone()];
                let (mut z, mut slope, mut ln, mut of_z) = ([0.0; CHUNK], [0.0; CHUNK], [0.0; CHUNK], [0.0; CHUNK]);
                for ((z, slope), r) in z.iter_mut().zip(&mut slope).zip(&columns.kept[..chunk.len()]) {
                    let (mean, of_kept) = mean_and_slope(*r);
                    (*z, *slope) = ((limit - mean) * over_sigma, of_kept);
                }
                for ((ln, of_z), z) in ln.iter_mut().zip(&mut of_z).zip(&z[..chunk.len()]) {
                    [*ln, *of_z] = ln_normal_cdf_and_slope(*z, is_fused::<S>());
                }
                let [value, in_z] = sums([n, &ln, &of_z, &z], |[n, ln, of_z, z]| [n * ln, n * of_z * z]);
                sides.value += value;
                sides.sigma -= in_z / sigma;
                let mut in_kept = [0.0; CHUNK];
                for (place, n) in n.iter().enumerate() {
                    in_kept[place] = -n * of_z[place] * over_sigma * slope[place];
                }
                columns.add_slopes(self.nodes, chunk.clone(), &in_kept[..chunk.len()], &mut sides.slopes);
            }
            all.push(sides);
        }
        all
    }
}
