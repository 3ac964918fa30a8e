//! Sums distances and slopes over the rebounds of a block, a few settings at a time, where the spread is one for all.

use std::ops::Range;

use super::{e_dry, Law, Nodes};
use crate::physics::dry::Order;
use crate::physics::rebound::TURN;

/// Sums over the rebounds of a block: Σ n d², Σ n d m′, Σ n d m′ x, Σ n d m′ e_dry p, with d = e − m(r).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub squares: f64,
    pub kept: f64,
    pub viscous: f64,
    pub dry: f64,
}

/// Runs taken at once, so that the machine's vector registers fill.
const LANES: usize = 4;

/// So many numbers, one after another in memory.
type Lanes = [f64; LANES];

#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

/// The sums over a range of the nodes.
pub(super) fn rebound_sums(nodes: &Nodes, range: Range<usize>, law: &Law) -> Sums {
    match (law.order, nodes.bridge.is_empty()) {
        (Order::First, true) => sums::<false, false>(nodes, range, law),
        (Order::First, false) => sums::<false, true>(nodes, range, law),
        (Order::Second, true) => sums::<true, false>(nodes, range, law),
        (Order::Second, false) => sums::<true, true>(nodes, range, law),
    }
}

/// The sums, with what a form does not hold left out where the code is made.
fn sums<const SECOND: bool, const BRIDGE: bool>(nodes: &Nodes, range: Range<usize>, law: &Law) -> Sums {
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let Law { k, inertial, l, .. } = *law;
    let order = if SECOND { Order::Second } else { Order::First };
    let x = &nodes.viscous[range.clone()];
    let p = &nodes.dry_power[range.clone()];
    // without a bridge a column that is not read
    let b = if BRIDGE { &nodes.bridge[range.clone()] } else { x };
    let e = &nodes.restitution[range.clone()];
    let n = &nodes.count[range];
    let [mut squares, mut kept, mut viscous, mut dry] = [[0.0; LANES]; 4];
    // a step for all lanes at a time is what a compiler turns into vector instructions
    let mut add = |x: &Lanes, p: &Lanes, b: &Lanes, e: &Lanes, n: &Lanes| {
        let e_dry_of = each(|i| e_dry(order, k, p[i]).0);
        let fall = each(|i| e_dry(order, k, p[i]).1);
        let r = each(|i| {
            let r = e_dry_of[i] * e_dry_of[i] - inertial - l * x[i];
            if BRIDGE {
                r - b[i]
            } else {
                r
            }
        });
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
        dry = each(|i| dry[i] + moved[i] * e_dry_of[i] * fall[i]);
    };
    let ((x, x_rest), (p, p_rest), (b, b_rest)) = (x.as_chunks(), p.as_chunks(), b.as_chunks());
    let ((e, e_rest), (n, n_rest)) = (e.as_chunks(), n.as_chunks());
    for (((x, p), b), (e, n)) in x.iter().zip(p).zip(b).zip(e.iter().zip(n)) {
        add(x, p, b, e, n);
    }
    if let (Some(last_x), Some(last_p), Some(last_b)) = (x_rest.last(), p_rest.last(), b_rest.last()) {
        // the rest, filled up with settings that count for nothing
        let (mut x, mut p, mut b) = ([*last_x; LANES], [*last_p; LANES], [*last_b; LANES]);
        let (mut e, mut n) = ([0.0; LANES], [0.0; LANES]);
        let columns = [
            (&mut x, x_rest),
            (&mut p, p_rest),
            (&mut b, b_rest),
            (&mut e, e_rest),
            (&mut n, n_rest),
        ];
        for (to, from) in columns {
            to[..from.len()].copy_from_slice(from);
        }
        add(&x, &p, &b, &e, &n);
    }
    let [squares, kept, viscous, dry] = [squares, kept, viscous, dry].map(|lanes| lanes.iter().sum::<f64>());
    Sums {
        squares,
        kept,
        viscous,
        dry,
    }
}
