//! Sums distances and slopes over the rebounds of a block, a few settings at a time, where the spread is one for all.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::{Law, Nodes};
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::rebound::TURN;

/// Sums over the rebounds of a block: Σ n d², Σ n d m′, Σ n d m′ x, Σ n d m′ e_dry p, with d = e − m(r).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub squares: f64,
    pub kept: f64,
    pub viscous: f64,
    pub dry: f64,
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

/// A range of the nodes with its law.
pub(super) type Piece = (Range<usize>, Law);

/// The sums over each of some ranges of the nodes, in the widest registers that the machine has.
pub(super) fn rebound_sums(nodes: &Nodes, order: Order, pieces: &[Piece]) -> Vec<Sums> {
    // one call for all: a range of a few nodes costs no more than its roots
    let machine = Arch::new();
    match (order, nodes.bridge.is_empty()) {
        (Order::First, true) => machine.dispatch(Over::<false, false> { nodes, pieces }),
        (Order::First, false) => machine.dispatch(Over::<false, true> { nodes, pieces }),
        (Order::Second, true) => machine.dispatch(Over::<true, false> { nodes, pieces }),
        (Order::Second, false) => machine.dispatch(Over::<true, true> { nodes, pieces }),
    }
}

/// Some ranges of the nodes, with what a form does not hold left out where the code is made.
struct Over<'a, const SECOND: bool, const BRIDGE: bool> {
    nodes: &'a Nodes,
    pieces: &'a [Piece],
}

impl<const SECOND: bool, const BRIDGE: bool> Over<'_, SECOND, BRIDGE> {
    /// Adds the settings of one register.
    #[inline(always)]
    fn add<S: Simd>(simd: S, law: &Law, to: &mut Running<S>, [x, p, b, e, n]: [S::f64s; 5]) {
        const TURN4: f64 = TURN * TURN * TURN * TURN;
        let number = |x: f64| simd.splat_f64s(x);
        let times = |a, b| simd.mul_f64s(a, b);
        let minus = |a, b| simd.sub_f64s(a, b);
        let (one, turn4) = (number(1.0), number(TURN4));
        let loss = times(number(law.k), p);
        let (e_dry, fall) = if SECOND {
            let bent = times(number(SECOND_ORDER * law.k), p);
            let half_way = minus(one, times(number(2.0), bent));
            (minus(one, times(loss, minus(one, bent))), times(p, half_way))
        } else {
            (minus(one, loss), p)
        };
        let mut r = minus(times(e_dry, e_dry), number(law.inertial));
        r = minus(r, times(number(law.l), x));
        if BRIDGE {
            r = minus(r, b);
        }
        let square = simd.add_f64s(times(r, r), turn4);
        let root = simd.sqrt_f64s(simd.sqrt_f64s(square));
        let inverse = simd.div_f64s(one, times(square, root));
        let distance = minus(e, times(times(r, square), inverse));
        let weighted = times(n, distance);
        let slope = simd.add_f64s(times(times(number(0.5), r), r), turn4);
        let moved = times(times(weighted, slope), inverse);
        let more = [
            times(weighted, distance),
            moved,
            times(moved, x),
            times(times(moved, e_dry), fall),
        ];
        for (sum, more) in to.0.iter_mut().zip(more) {
            *sum = simd.add_f64s(*sum, more);
        }
    }
}

/// The sums of each lane, in the order of [`Sums`].
struct Running<S: Simd>([S::f64s; 4]);

impl<const SECOND: bool, const BRIDGE: bool> WithSimd for Over<'_, SECOND, BRIDGE> {
    type Output = Vec<Sums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<Sums> {
        let mut all = Vec::with_capacity(self.pieces.len());
        for (range, law) in self.pieces {
            let mut running = Running::<S>([simd.splat_f64s(0.0); 4]);
            let x = &self.nodes.viscous[range.clone()];
            let p = &self.nodes.dry_power[range.clone()];
            // without a bridge a column that is not read
            let b = if BRIDGE { &self.nodes.bridge[range.clone()] } else { x };
            let e = &self.nodes.restitution[range.clone()];
            let n = &self.nodes.count[range.clone()];
            let columns = [x, p, b, e, n];
            // one by one: a map over the five would be copied about in memory
            let ((x, x_rest), (p, p_rest), (b, b_rest)) = (S::as_simd_f64s(x), S::as_simd_f64s(p), S::as_simd_f64s(b));
            let ((e, e_rest), (n, n_rest)) = (S::as_simd_f64s(e), S::as_simd_f64s(n));
            for (((x, p), b), (e, n)) in x.iter().zip(p).zip(b).zip(e.iter().zip(n)) {
                Self::add(simd, law, &mut running, [*x, *p, *b, *e, *n]);
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
                Self::add(simd, law, &mut running, last);
            }
            let [squares, kept, viscous, dry] = running.0.map(|lanes| simd.reduce_sum_f64s(lanes));
            all.push(Sums {
                squares,
                kept,
                viscous,
                dry,
            });
        }
        all
    }
}
