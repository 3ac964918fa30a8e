//! Sums distances and slopes over the rebounds of a block, a few settings at a time, where the spread is one for all.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::block_sums::BlockSums;
use super::nodes::Nodes;
use super::trend::{BlockLaw, FilmColumns, CHUNK};
use crate::exponential::is_fused;
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::rebound::TURN;

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
    pub law: BlockLaw,
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
    match (order, heavy) {
        (Order::First, None) => over::<false, false>(nodes, HeavyTails::NONE, ranges),
        (Order::Second, None) => over::<true, false>(nodes, HeavyTails::NONE, ranges),
        (Order::First, Some(heavy)) => over::<false, true>(nodes, heavy, ranges),
        (Order::Second, Some(heavy)) => over::<true, true>(nodes, heavy, ranges),
    }
}

fn over<const SECOND: bool, const HEAVY: bool>(
    nodes: &Nodes,
    heavy: HeavyTails,
    ranges: &[NodeRange],
) -> Vec<BlockSums> {
    // one call for all: a range of a few nodes costs no more than its roots
    Arch::new().dispatch(RangeSums::<SECOND, HEAVY> { nodes, heavy, ranges })
}

/// Some ranges of the nodes, with what a form does not hold left out where the code is made.
struct RangeSums<'a, const SECOND: bool, const HEAVY: bool> {
    nodes: &'a Nodes,
    heavy: HeavyTails,
    ranges: &'a [NodeRange],
}

impl<const SECOND: bool, const HEAVY: bool> RangeSums<'_, SECOND, HEAVY> {
    /// Adds the settings of one register.
    #[inline(always)]
    fn add<S: Simd>(&self, simd: S, law: &Constants, to: &mut Running<S>, [x, p, b, e, n, g, h, f]: [S::f64s; 8]) {
        const TURN4: f64 = TURN * TURN * TURN * TURN;
        let number = |x: f64| simd.splat_f64s(x);
        let times = |a, b| simd.mul_f64s(a, b);
        let minus = |a, b| simd.sub_f64s(a, b);
        let fused = |a, b, c| simd.mul_add_e_f64s(a, b, c);
        let (one, turn4) = (number(1.0), number(TURN4));
        let Kept { r, e_dry, fall } = law.kept::<S, SECOND>(simd, [x, p, b, g, f]);
        let square = fused(r, r, turn4);
        let root = simd.sqrt_f64s(simd.sqrt_f64s(square));
        let inverse = simd.div_f64s(one, times(square, root));
        let distance = minus(e, times(times(r, square), inverse));
        let weighted = times(n, distance);
        // r² + τ⁴ and as much of τ⁴
        let slope = fused(number(0.5), square, number(0.5 * TURN4));
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
        let (of_x, of_g) = (times(weighted_slope, x), times(weighted_slope, g));
        let [squares, kept, viscous, dry, shape, scale, viscous_trend, inertial_trend] = to.sums;
        to.sums = [
            fused(weighted, distance, squares),
            simd.add_f64s(kept, weighted_slope),
            simd.add_f64s(viscous, of_x),
            fused(times(weighted_slope, e_dry), fall, dry),
            simd.add_f64s(shape, of_g),
            fused(weighted_slope, h, scale),
            fused(of_x, f, viscous_trend),
            fused(of_g, f, inertial_trend),
        ];
    }
}

/// Factors of a product whose logarithm is taken at once, each less than 1e18 where any density is left.
pub(super) const MOST_FACTORS: usize = 16;

/// The sums of each lane.
struct Running<S: Simd> {
    /// in the order of [`BlockSums`]
    sums: [S::f64s; 8],
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
            sums: [zero; 8],
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

impl<const SECOND: bool, const HEAVY: bool> WithSimd for RangeSums<'_, SECOND, HEAVY> {
    type Output = Vec<BlockSums>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<BlockSums> {
        let mut all = Vec::with_capacity(self.ranges.len());
        let mut shapes = [[0.0; CHUNK]; 2];
        for NodeRange { nodes: range, law } in self.ranges {
            let mut running = Running::new(simd);
            let constants = Constants::of(law);
            for chunk in self.nodes.chunks(range) {
                let films = self.nodes.film_columns(&chunk);
                let [g, h] = law.films.shapes(films, is_fused::<S>(), &mut shapes);
                self.add_chunk(simd, &constants, &mut running, chunk, [g, h, films.ln]);
            }
            if HEAVY {
                running.take_logarithms(simd);
            }
            let sums = running.sums.map(|lanes| simd.reduce_sum_f64s(lanes));
            let [squares, kept, viscous, dry, shape, scale, viscous_trend, inertial_trend] = sums;
            all.push(BlockSums {
                squares,
                kept,
                viscous,
                dry,
                shape,
                scale,
                viscous_trend,
                inertial_trend,
                weighted: simd.reduce_sum_f64s(running.weighted),
                ln_tails: running.ln_tails,
            });
        }
        all
    }
}

impl<const SECOND: bool, const HEAVY: bool> RangeSums<'_, SECOND, HEAVY> {
    /// Adds some nodes; `films` are g, h and f of each.
    #[inline(always)]
    fn add_chunk<S: Simd>(
        &self,
        simd: S,
        law: &Constants,
        running: &mut Running<S>,
        chunk: Range<usize>,
        [g, h, f]: [&[f64]; 3],
    ) {
        let x = &self.nodes.over_stokes[chunk.clone()];
        let p = &self.nodes.dry_root[chunk.clone()];
        let b = self.nodes.fixed_column(&chunk);
        let e = &self.nodes.restitution[chunk.clone()];
        let n = &self.nodes.count[chunk];
        let columns = [x, p, b, e, n, g, h, f];
        // one by one: a map over all would be copied about in memory
        let ((x, x_rest), (p, p_rest), (b, b_rest)) = (S::as_simd_f64s(x), S::as_simd_f64s(p), S::as_simd_f64s(b));
        let ((e, e_rest), (n, n_rest)) = (S::as_simd_f64s(e), S::as_simd_f64s(n));
        let ((g, g_rest), (h, h_rest), (f, f_rest)) = (S::as_simd_f64s(g), S::as_simd_f64s(h), S::as_simd_f64s(f));
        let of_run = x.iter().zip(p).zip(b).zip(e.iter().zip(n));
        let of_film = g.iter().zip(h).zip(f);
        for ((((x, p), b), (e, n)), ((g, h), f)) in of_run.zip(of_film) {
            self.add(simd, law, running, [*x, *p, *b, *e, *n, *g, *h, *f]);
        }
        let rest = x_rest.len();
        if rest == 0 {
            return;
        }
        let last = if x.is_empty() {
            // filled up with settings that count for nothing
            [
                filled::<S>(x_rest),
                filled::<S>(p_rest),
                filled::<S>(b_rest),
                filled::<S>(e_rest),
                filled::<S>(n_rest),
                filled::<S>(g_rest),
                filled::<S>(h_rest),
                filled::<S>(f_rest),
            ]
        } else {
            // the last full register, in which those that were added count for nothing
            let from = columns[0].len() - S::F64_LANES;
            let last = |column: &[f64]| S::as_simd_f64s(&column[from..]).0[0];
            let [x, p, b, e, n, g, h, f] = columns;
            let new = S::as_simd_f64s(&LAST[WIDEST + rest - S::F64_LANES..]).0[0];
            let n = simd.mul_f64s(last(n), new);
            [last(x), last(p), last(b), last(e), n, last(g), last(h), last(f)]
        };
        self.add(simd, law, running, last);
    }
}

/// What of the energy balance of a block is the same for all its nodes.
pub(super) struct Constants {
    /// k
    dry_k: f64,
    /// ρ̃ C
    inertial: f64,
    viscous: f64,
    /// L′
    viscous_trend: f64,
    offset: f64,
}

/// r of the settings of one register, with e_dry and its fall with k.
struct Kept<S: Simd> {
    r: S::f64s,
    e_dry: S::f64s,
    fall: S::f64s,
}

impl Constants {
    /// From x, p, b, G and f.
    #[inline(always)]
    fn kept<S: Simd, const SECOND: bool>(&self, simd: S, [x, p, b, g, f]: [S::f64s; 5]) -> Kept<S> {
        let number = |x: f64| simd.splat_f64s(x);
        let times = |a, b| simd.mul_f64s(a, b);
        let minus = |a, b| simd.sub_f64s(a, b);
        let fused = |a, b, c| simd.mul_add_e_f64s(a, b, c);
        let one = number(1.0);
        let loss = times(number(self.dry_k), p);
        let (e_dry, fall) = if SECOND {
            let bent = times(number(SECOND_ORDER * self.dry_k), p);
            let half_way = minus(one, times(number(2.0), bent));
            (minus(one, times(loss, minus(one, bent))), times(p, half_way))
        } else {
            (minus(one, loss), p)
        };
        let dry = fused(e_dry, e_dry, minus(number(self.offset), b));
        let viscous = fused(number(-self.viscous_trend), f, number(-self.viscous));
        let r = fused(viscous, x, fused(number(-self.inertial), g, dry));
        Kept { r, e_dry, fall }
    }

    pub fn of(law: &BlockLaw) -> Constants {
        Constants {
            dry_k: law.dry_k,
            inertial: law.density_ratio * law.films.prefactor,
            viscous: law.films.viscous(),
            viscous_trend: law.films.lubrication_trend,
            offset: law.offset,
        }
    }
}

impl Constants {
    /// r of some nodes, with the G and f of their films.
    #[inline(always)]
    pub fn kept_of_chunk<S: Simd, const SECOND: bool>(
        &self,
        simd: S,
        nodes: &Nodes,
        (chunk, [g, f]): (Range<usize>, [&[f64]; 2]),
        kept: &mut [f64],
    ) {
        let x = &nodes.over_stokes[chunk.clone()];
        let b = nodes.fixed_column(&chunk);
        let ((x, x_rest), (p, p_rest)) = (S::as_simd_f64s(x), S::as_simd_f64s(&nodes.dry_root[chunk]));
        let ((b, b_rest), (g, g_rest), (f, f_rest)) = (S::as_simd_f64s(b), S::as_simd_f64s(g), S::as_simd_f64s(f));
        let (kept, kept_rest) = S::as_mut_simd_f64s(kept);
        let columns = x.iter().zip(p).zip(b).zip(g.iter().zip(f));
        for (kept, (((x, p), b), (g, f))) in kept.iter_mut().zip(columns) {
            *kept = self.kept::<S, SECOND>(simd, [*x, *p, *b, *g, *f]).r;
        }
        if !kept_rest.is_empty() {
            let lanes = [
                filled::<S>(x_rest),
                filled::<S>(p_rest),
                filled::<S>(b_rest),
                filled::<S>(g_rest),
                filled::<S>(f_rest),
            ];
            let mut r = [0.0; WIDEST];
            if let Some(to) = S::as_mut_simd_f64s(&mut r).0.first_mut() {
                *to = self.kept::<S, SECOND>(simd, lanes).r;
            }
            kept_rest.copy_from_slice(&r[..kept_rest.len()]);
        }
    }
}

/// A register that begins with these numbers, less than it holds, and ends with zeros.
#[inline(always)]
fn filled<S: Simd>(rest: &[f64]) -> S::f64s {
    let mut lanes = [0.0; WIDEST];
    lanes[..rest.len()].copy_from_slice(rest);
    S::as_simd_f64s(&lanes).0[0]
}

impl Nodes {
    /// A range of nodes, as many at a time as their shapes are computed for.
    #[inline(always)]
    pub(super) fn chunks(&self, range: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let end = range.end;
        range
            .clone()
            .step_by(CHUNK)
            .map(move |first| first..end.min(first + CHUNK))
    }

    /// b of some nodes.
    #[inline(always)]
    fn fixed_column(&self, chunk: &Range<usize>) -> &[f64] {
        const NONE: [f64; CHUNK] = [0.0; CHUNK];
        self.fixed.get(chunk.clone()).unwrap_or(&NONE[..chunk.len()])
    }

    #[inline(always)]
    pub(super) fn film_columns(&self, chunk: &Range<usize>) -> FilmColumns<'_> {
        FilmColumns {
            ratio: &self.film_ratio[chunk.clone()],
            ln: &self.ln_film[chunk.clone()],
            shape: self.shape.get(chunk.clone()).unwrap_or(&[]),
        }
    }
}
