//! Sums the log density over the nodes of each block where the spread is one for all: step by step over some nodes at a time,
//! in loops that are compiled for the widest registers there are.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::nodes::Nodes;
use super::normal::{ln_normal_cdf_and_slope, CERTAIN};
use super::run_density::{BlockSums, RunDensity, Side, Totals};
use super::student::Student;
use super::trend::{BlockLaw, CHUNK};
use crate::exponential::{is_fused, logarithm};
use crate::lanes::sums;
use crate::physics::dry::Order;
use crate::physics::rebound::{kept_of_mean_restitution, mean_and_slope};

/// What is asked of the runs of the nodes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Asked {
    /// the density of their restitutions, of normal noise or of Student's, with which each node is one run
    Rebounds(Option<Student>),
    /// the probability that they came out on this side of a restitution, of normal noise
    Side(Side, f64),
}

/// Sums over the nodes of all blocks.
pub(super) struct NodeSums<'a> {
    pub nodes: &'a Nodes,
    /// of which kind they are: 0 dry, 1 wet
    pub kind: usize,
    /// of each block
    pub laws: &'a [BlockLaw],
    pub order: Order,
    /// σ
    pub sigma: f64,
    pub asked: Asked,
    /// each counts so many times
    pub times: f64,
}

impl NodeSums<'_> {
    /// Adds them to the totals of their kind.
    pub fn add_to(self, totals: &mut Totals) {
        if self.nodes.len() == 0 {
            return;
        }
        // one call for all: a block of a few nodes costs no more than its roots
        Arch::new().dispatch(Dispatched { of: self, totals });
    }
}

struct Dispatched<'a, 't> {
    of: NodeSums<'a>,
    totals: &'t mut Totals,
}

impl WithSimd for Dispatched<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Dispatched { of, totals } = self;
        let fused = is_fused::<S>();
        let mut columns = Columns {
            kept: [0.0; CHUNK],
            dry_k: [0.0; CHUNK],
            shapes: [[0.0; CHUNK]; 2],
            in_kept: [0.0; CHUNK],
        };
        let mut all = RunDensity::default();
        // loops, since what is given to an iterator may not be compiled for these registers
        for ((law, nodes), sums) in of.laws.iter().zip(&of.nodes.blocks).zip(&mut totals.blocks) {
            for first in nodes.clone().step_by(CHUNK) {
                let chunk = first..nodes.end.min(first + CHUNK);
                columns.read(of.nodes, law, chunk.clone(), of.order, fused);
                match of.asked {
                    Asked::Rebounds(student) => of.add_rebounds(student, &mut columns, chunk.clone(), fused, &mut all),
                    Asked::Side(side, limit) => {
                        if of.are_certain(side, limit, &columns.kept[..chunk.len()]) {
                            continue;
                        }
                        of.add_side(side, limit, &mut columns, chunk.clone(), fused, &mut all);
                    }
                }
                columns.add_slopes(of.nodes, chunk, of.times, sums);
            }
        }
        totals.of_kind[of.kind].add(all, of.times);
    }
}

impl NodeSums<'_> {
    /// Adds the density of the rebounds of a chunk that was read but for what is the same of each, and writes its slope in r.
    #[inline(always)]
    fn add_rebounds(
        &self,
        student: Option<Student>,
        columns: &mut Columns,
        chunk: Range<usize>,
        fused: bool,
        all: &mut RunDensity,
    ) {
        let (e, n) = (&self.nodes.restitution[chunk.clone()], &self.nodes.count[chunk.clone()]);
        let stretch = student.map_or(1.0, |of| of.quantile);
        let steepness = (stretch / self.sigma).powi(2);
        // q, the square of a distance in units of the noise, n times
        let mut squares = [0.0; CHUNK];
        let squares = &mut squares[..chunk.len()];
        let Columns { kept, in_kept, .. } = columns;
        let in_kept = &mut in_kept[..chunk.len()];
        // slices of one length, so that no place has to be held against the end
        let to = squares.iter_mut().zip(in_kept.iter_mut());
        for ((square, in_kept), (kept, (e, n))) in to.zip(kept[..chunk.len()].iter().zip(e.iter().zip(n))) {
            let (mean, slope) = mean_and_slope(*kept);
            let distance = e - mean;
            let weighted = steepness * n * distance;
            *square = weighted * distance;
            *in_kept = weighted * slope;
        }
        let squares = &*squares;
        let Some(Student { nu, quantile_slope, .. }) = student else {
            let [square] = sums([squares], |[square]| [square]);
            all.value -= 0.5 * square;
            all.sigma += square / self.sigma;
            return;
        };
        let [of_weight, ln_tails] = sums([squares], |[q]| [(nu + 1.0) * q / (nu + q), ln_one_and(q / nu, fused)]);
        all.value -= 0.5 * (nu + 1.0) * ln_tails;
        all.sigma += of_weight / self.sigma;
        all.shape += of_weight * (0.5 / nu - quantile_slope) - 0.5 * ln_tails;
        for (in_kept, q) in in_kept.iter_mut().zip(squares) {
            *in_kept *= (nu + 1.0) / (nu + q);
        }
    }

    /// Whether all that keep this come out on the side for certain; not where it is no number.
    #[inline(always)]
    fn are_certain(&self, side: Side, limit: f64, kept: &[f64]) -> bool {
        let certain = kept_of_mean_restitution(limit - side.sign() * CERTAIN * self.sigma);
        kept.iter().all(|r| side.sign() * (*r - certain) < 0.0)
    }

    /// Adds the probability that the runs of a chunk came out on a side, and writes its slope in r.
    #[inline(always)]
    fn add_side(
        &self,
        side: Side,
        limit: f64,
        columns: &mut Columns,
        chunk: Range<usize>,
        fused: bool,
        all: &mut RunDensity,
    ) {
        let over_sigma = side.sign() / self.sigma;
        let n = &self.nodes.count[chunk.clone()];
        let Columns { kept, in_kept, .. } = columns;
        let (mut z, mut slope, mut ln, mut of_z) = ([0.0; CHUNK], [0.0; CHUNK], [0.0; CHUNK], [0.0; CHUNK]);
        for ((z, slope), r) in z.iter_mut().zip(&mut slope).zip(&kept[..chunk.len()]) {
            let (mean, of_kept) = mean_and_slope(*r);
            (*z, *slope) = ((limit - mean) * over_sigma, of_kept);
        }
        for ((ln, of_z), z) in ln.iter_mut().zip(&mut of_z).zip(&z[..chunk.len()]) {
            [*ln, *of_z] = ln_normal_cdf_and_slope(*z, fused);
        }
        let [value, in_z] = sums([n, &ln, &of_z, &z], |[n, ln, of_z, z]| [n * ln, n * of_z * z]);
        all.value += value;
        all.sigma -= in_z / self.sigma;
        for (place, n) in n.iter().enumerate() {
            in_kept[place] = -n * of_z[place] * over_sigma * slope[place];
        }
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
struct Columns {
    /// r
    kept: [f64; CHUNK],
    /// its slope in k
    dry_k: [f64; CHUNK],
    /// g exp(C′ f), and its slope in δ̃0 where it has one
    shapes: [[f64; CHUNK]; 2],
    /// slope of the log density in r
    in_kept: [f64; CHUNK],
}

impl Columns {
    /// Computes those of a chunk of a block, but for the last.
    #[inline(always)]
    fn read(&mut self, nodes: &Nodes, law: &BlockLaw, chunk: Range<usize>, order: Order, fused: bool) {
        law.films.shapes(nodes, chunk.clone(), fused, &mut self.shapes);
        let (k, inertial) = (law.dry_k, law.block.density_ratio * law.films.prefactor);
        let (viscous, trend) = (law.films.viscous(), law.films.lubrication_trend);
        let [x, p, b, f] =
            [&nodes.over_stokes, &nodes.dry_root, &nodes.fixed, &nodes.ln_film].map(|column| &column[chunk.clone()]);
        let Columns {
            kept, dry_k, shapes, ..
        } = self;
        let [kept, dry_k, g] = [kept, dry_k, &mut shapes[0]].map(|column| &mut column[..chunk.len()]);
        let own = x.iter().zip(p).zip(b).zip(f.iter().zip(&*g));
        for ((kept, dry_k), (((x, p), b), (f, g))) in kept.iter_mut().zip(dry_k).zip(own) {
            let [e_dry, in_loss, _] = order.of_loss(k * p);
            *dry_k = 2.0 * e_dry * in_loss * p;
            *kept = e_dry * e_dry - inertial * g - (viscous + trend * f) * x - b + law.offset;
        }
    }

    /// Adds so many times the sums of slopes of a chunk from those in r.
    #[inline(always)]
    fn add_slopes(&self, nodes: &Nodes, chunk: Range<usize>, times: f64, all: &mut BlockSums) {
        let [x, f] = [&nodes.over_stokes, &nodes.ln_film].map(|column| &column[chunk.clone()]);
        let [g, h] = &self.shapes;
        let found = sums(
            [&self.in_kept[..chunk.len()], x, &self.dry_k, g, h, f],
            |[w, x, of_k, g, h, f]| {
                let (of_x, of_g) = (w * x, w * g);
                [w, of_x, w * of_k, of_g, w * h, of_x * f, of_g * f]
            },
        );
        for (sum, more) in all.iter_mut().zip(found) {
            *sum += times * more;
        }
    }
}
