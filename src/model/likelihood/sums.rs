//! BlockSums distances and slopes over the rebounds of a block, a few settings at a time, where the spread is one for all.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::nodes::Nodes;
use crate::physics::balance::Balance;
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::rebound::TURN;

/// BlockSums over the rebounds of a block: Σ n d², Σ n d m′, Σ n d m′ x, Σ n d m′ e_dry p, with d = e − m(r).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BlockSums {
    pub squares: f64,
    pub kept: f64,
    pub viscous: f64,
    pub dry: f64,
    /// Σ w q, where tails are heavy: with q = (d/σ)² in units of Student's t, w = (ν + 1)/(ν + q) and the sums above weighted
    /// by w, but for the squares
    pub weighted: f64,
    /// Σ ln(1 + q/ν)
    pub ln_tails: f64,
}

/// Student's tails of one spread.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeavyTails {
    /// q over the square of a distance
    pub steepness: f64,
    /// ν
    pub nu: f64,
}

impl HeavyTails {
    /// Of normal noise, which reads neither.
    const NONE: HeavyTails = HeavyTails {
        steepness: 0.0,
        nu: f64::INFINITY,
    };
}

/// Numbers of the widest register there is.
const WIDEST: usize = 8;

/// As many zeros as the widest register holds, then as many ones.
const LAST: [f64; 2 * WIDEST] = {
    let mut last = [0.0; 2 * WIDEST];
    let mut lane = WIDEST;
    while lane < 2 * WIDEST {
        last[lane] = 1.0;
        lane += 1;
    }
    last
};

/// A range of the nodes with its energy balance.
#[derive(Debug, Clone)]
pub(super) struct NodeRange {
    pub nodes: Range<usize>,
    pub balance: Balance,
}

/// The sums over each of some ranges of the nodes, in the widest registers that the machine has.
///
/// With heavy tails each node is one run, and counts by the weight its distance leaves it.
pub(super) fn rebound_sums(
    nodes: &Nodes,
    order: Order,
    heavy: Option<HeavyTails>,
    ranges: &[NodeRange],
) -> Vec<BlockSums> {
    let (second, fixed) = (order == Order::Second, nodes.has_fixed());
    match (second, fixed, heavy) {
        (false, false, None) => over::<false, false, false>(nodes, HeavyTails::NONE, ranges),
        (false, true, None) => over::<false, true, false>(nodes, HeavyTails::NONE, ranges),
        (true, false, None) => over::<true, false, false>(nodes, HeavyTails::NONE, ranges),
        (true, true, None) => over::<true, true, false>(nodes, HeavyTails::NONE, ranges),
        (false, false, Some(heavy)) => over::<false, false, true>(nodes, heavy, ranges),
        (false, true, Some(heavy)) => over::<false, true, true>(nodes, heavy, ranges),
        (true, false, Some(heavy)) => over::<true, false, true>(nodes, heavy, ranges),
        (true, true, Some(heavy)) => over::<true, true, true>(nodes, heavy, ranges),
    }
}

fn over<const SECOND: bool, const FIXED: bool, const HEAVY: bool>(
    nodes: &Nodes,
    heavy: HeavyTails,
    ranges: &[NodeRange],
) -> Vec<BlockSums> {
    // one call for all: a range of a few nodes costs no more than its roots
    Arch::new().dispatch(RangeSums::<SECOND, FIXED, HEAVY> { nodes, heavy, ranges })
}

/// Some ranges of the nodes, with what a form does not hold left out where the code is made.
struct RangeSums<'a, const SECOND: bool, const FIXED: bool, const HEAVY: bool> {
    nodes: &'a Nodes,
    heavy: HeavyTails,
    ranges: &'a [NodeRange],
}

impl<const SECOND: bool, const FIXED: bool, const HEAVY: bool> RangeSums<'_, SECOND, FIXED, HEAVY> {
    /// Adds the settings of one register.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, balance: &Balance, to: &mut Running<S>, [x, p, b, e, n]: [S::f64s; 5]) {
        const TURN4: f64 = TURN * TURN * TURN * TURN;
        let number = |x: f64| simd.splat_f64s(x);
        let times = |a, b| simd.mul_f64s(a, b);
        let minus = |a, b| simd.sub_f64s(a, b);
        let (one, turn4) = (number(1.0), number(TURN4));
        let loss = times(number(balance.dry_k), p);
        let (e_dry, fall) = if SECOND {
            let bent = times(number(SECOND_ORDER * balance.dry_k), p);
            let half_way = minus(one, times(number(2.0), bent));
            (minus(one, times(loss, minus(one, bent))), times(p, half_way))
        } else {
            (minus(one, loss), p)
        };
        let mut r = minus(times(e_dry, e_dry), number(balance.lost.constant));
        r = minus(r, times(number(balance.lost.over_stokes), x));
        if FIXED {
            r = minus(r, b);
        }
        let square = simd.add_f64s(times(r, r), turn4);
        let root = simd.sqrt_f64s(simd.sqrt_f64s(square));
        let inverse = simd.div_f64s(one, times(square, root));
        let distance = minus(e, times(times(r, square), inverse));
        let weighted = times(n, distance);
        let slope = simd.add_f64s(times(times(number(0.5), r), r), turn4);
        let mut weighted_slope = times(times(weighted, slope), inverse);
        if HEAVY {
            // a node that counts for nothing has no distance, either
            let square = times(times(weighted, distance), number(self.heavy.steepness));
            let nu = number(self.heavy.nu);
            let weight = simd.div_f64s(number(self.heavy.nu + 1.0), simd.add_f64s(nu, square));
            weighted_slope = times(weighted_slope, weight);
            to.weighted = simd.add_f64s(to.weighted, times(weight, square));
            // without its 1, which with many degrees of freedom would leave nothing of the rest
            let more = times(square, number(1.0 / self.heavy.nu));
            to.tails = simd.add_f64s(to.tails, times(more, simd.add_f64s(one, to.tails)));
            to.factors += 1;
            if to.factors == MOST_FACTORS {
                to.take_logarithms(simd);
            }
        }
        let more = [
            times(weighted, distance),
            weighted_slope,
            times(weighted_slope, x),
            times(times(weighted_slope, e_dry), fall),
        ];
        for (sum, more) in to.sums.iter_mut().zip(more) {
            *sum = simd.add_f64s(*sum, more);
        }
    }
}

/// Factors of a product whose logarithm is taken at once, each less than 1e18 where any density is left.
const MOST_FACTORS: usize = 16;

/// The sums of each lane.
struct Running<S: Simd> {
    /// in the order of [`BlockSums`]
    sums: [S::f64s; 4],
    weighted: S::f64s,
    /// product of the tails since the last logarithms, less 1
    tails: S::f64s,
    factors: usize,
    ln_tails: f64,
}

impl<S: Simd> Running<S> {
    #[inline(always)]
    fn new(simd: S) -> Running<S> {
        let zero = simd.splat_f64s(0.0);
        Running {
            sums: [zero; 4],
            weighted: zero,
            tails: simd.splat_f64s(0.0),
            factors: 0,
            ln_tails: 0.0,
        }
    }

    #[inline(always)]
    fn take_logarithms(&mut self, simd: S) {
        let mut lanes = [0.0; WIDEST];
        if let Some(first) = S::as_mut_simd_f64s(&mut lanes).0.first_mut() {
            *first = self.tails;
        }
        self.ln_tails += lanes.iter().map(|tail| tail.ln_1p()).sum::<f64>();
        self.tails = simd.splat_f64s(0.0);
        self.factors = 0;
    }
}

impl<const SECOND: bool, const FIXED: bool, const HEAVY: bool> WithSimd for RangeSums<'_, SECOND, FIXED, HEAVY> {
    type Output = Vec<BlockSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<BlockSums> {
        let mut all = Vec::with_capacity(self.ranges.len());
        for NodeRange { nodes: range, balance } in self.ranges {
            let mut running = Running::new(simd);
            let x = &self.nodes.over_stokes[range.clone()];
            let p = &self.nodes.dry_root[range.clone()];
            // without fixed shares a column that is not read
            let b = if FIXED { &self.nodes.fixed[range.clone()] } else { x };
            let e = &self.nodes.restitution[range.clone()];
            let n = &self.nodes.count[range.clone()];
            let columns = [x, p, b, e, n];
            // one by one: a map over the five would be copied about in memory
            let ((x, x_rest), (p, p_rest), (b, b_rest)) = (S::as_simd_f64s(x), S::as_simd_f64s(p), S::as_simd_f64s(b));
            let ((e, e_rest), (n, n_rest)) = (S::as_simd_f64s(e), S::as_simd_f64s(n));
            for (((x, p), b), (e, n)) in x.iter().zip(p).zip(b).zip(e.iter().zip(n)) {
                self.add(simd, balance, &mut running, [*x, *p, *b, *e, *n]);
            }
            let rest = x_rest.len();
            if rest > 0 {
                let last = if x.is_empty() {
                    // filled up with settings that count for nothing
                    let filled = |rest: &[f64]| {
                        let mut lanes = [0.0; WIDEST];
                        lanes[..rest.len()].copy_from_slice(rest);
                        S::as_simd_f64s(&lanes).0[0]
                    };
                    [x_rest, p_rest, b_rest, e_rest, n_rest].map(filled)
                } else {
                    // the last full register, in which those that were added count for nothing
                    let last = |column: &[f64]| S::as_simd_f64s(&column[column.len() - S::F64_LANES..]).0[0];
                    let [x, p, b, e, n] = columns;
                    let new = S::as_simd_f64s(&LAST[WIDEST + rest - S::F64_LANES..]).0[0];
                    [last(x), last(p), last(b), last(e), simd.mul_f64s(last(n), new)]
                };
                self.add(simd, balance, &mut running, last);
            }
            if HEAVY {
                running.take_logarithms(simd);
            }
            let [squares, kept, viscous, dry] = running.sums.map(|lanes| simd.reduce_sum_f64s(lanes));
            all.push(BlockSums {
                squares,
                kept,
                viscous,
                dry,
                weighted: simd.reduce_sum_f64s(running.weighted),
                ln_tails: running.ln_tails,
            });
        }
        all
    }
}
