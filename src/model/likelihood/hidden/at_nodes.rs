//! Computes the integrand at several nodes side by side.
//!
//! Symbols as in `hidden.rs`. Lanes are added in one order on every machine.

use pulp::{Arch, Simd, WithSimd};

use super::{Column, Hidden, SettingNodes, SettingRuns, Sums, MOST_NODES};
use crate::distributions::LN_ROOT_TWO_PI;
use crate::exponential::{exponential, is_fused, logarithm};
use crate::lanes;
use crate::model::likelihood::normal::{ln_normal_cdf_and_slope, CERTAIN};
use crate::model::likelihood::run_density::Seen;
use crate::model::likelihood::tails::Tails;
use crate::physics::dry::{Order, POWER};
use crate::physics::rebound::{kept_and_slope, mean_and_slope, mean_restitution, TURN};

/// Nodes are summed in multiples of this.
const LANES: usize = 8;

/// What the line is gone along in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Path {
    /// z itself
    Straight,
    /// x, with m⁻¹(x) = kept + slope z: about where a setting turns
    Turn { kept: f64, slope: f64 },
}

impl Path {
    /// z at a place, and its slope there without the sign.
    #[inline(always)]
    pub fn at(&self, x: f64) -> [f64; 2] {
        match *self {
            Path::Straight => [x, 1.0],
            Path::Turn { kept, slope } => {
                let (y, stretch) = kept_and_slope(x);
                [(y - kept) / slope, stretch / slope.abs()]
            }
        }
    }

    /// The place of a z.
    pub fn place(&self, z: f64) -> f64 {
        match *self {
            Path::Straight => z,
            Path::Turn { kept, slope } => mean_restitution(kept + slope * z),
        }
    }

    /// The longest panel that may begin at a place: m⁻¹ has its poles at τ (±1 ± i).
    pub fn longest(&self, x: f64) -> f64 {
        match self {
            Path::Straight => f64::INFINITY,
            Path::Turn { .. } => 2.5 * TURN + 2.0 * x.abs(),
        }
    }
}

/// Some nodes of a rule along a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct RuleNodes {
    pub path: Path,
    x: Column,
    weights: Column,
    /// up to [`MOST_NODES`]
    count: usize,
}

impl RuleNodes {
    /// None yet.
    pub fn along(path: Path) -> RuleNodes {
        RuleNodes {
            path,
            x: [0.0; MOST_NODES],
            weights: [0.0; MOST_NODES],
            count: 0,
        }
    }

    pub fn is_full(&self) -> bool {
        self.count == MOST_NODES
    }

    #[inline(always)]
    pub fn push(&mut self, x: f64, weight: f64) {
        (self.x[self.count], self.weights[self.count]) = (x, weight);
        self.count += 1;
    }

    /// Fills the last register up with nodes that count for nothing.
    fn fill(&mut self) {
        while !self.count.is_multiple_of(LANES) {
            self.push(self.x[0], 0.0);
        }
    }
}

impl Hidden<'_> {
    /// Whether runs have normal noise on the restitution alone.
    pub(super) fn is_plain(&self) -> bool {
        /// whose square is then a number of which [`logarithm`] gives the logarithm
        const SIGMA: std::ops::Range<f64> = 1e-30..1e30;
        let noise = self.noise;
        noise.tails == Tails::Normal && SIGMA.contains(&noise.sigma) && noise.energy == 0.0
    }

    /// Adds nodes to sums.
    pub(super) fn at_nodes(&self, nodes: &mut RuleNodes, sums: &mut Sums) {
        nodes.fill();
        Arch::new().dispatch(Nodes {
            hidden: self,
            nodes,
            sums,
        });
    }

    /// The logarithm of the integrand at these places.
    pub(super) fn ln_at(&self, places: &[f64], sums: &mut Sums) -> Vec<f64> {
        let mut found = Vec::with_capacity(places.len());
        for some in places.chunks(MOST_NODES) {
            let mut nodes = RuleNodes::along(Path::Straight);
            some.iter().for_each(|z| nodes.push(*z, 0.0));
            self.at_nodes(&mut nodes, sums);
            found.extend(&sums.nodes.ln[..some.len()]);
        }
        found
    }
}

struct Nodes<'n, 'b> {
    hidden: &'n Hidden<'b>,
    nodes: &'n RuleNodes,
    sums: &'n mut Sums,
}

impl WithSimd for Nodes<'_, '_> {
    type Output = ();

    // each loop is over slices whose length is not known where the code is made: of one that is, the registers are not filled
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Nodes { hidden, nodes, sums } = self;
        // a copy, so that no loop has to ask whether what it reads is what it writes
        let RuleNodes {
            path,
            x,
            weights,
            count,
        } = *nodes;
        let count = count.min(MOST_NODES);
        let fused = is_fused::<S>();
        let sigma = hidden.noise.sigma;
        let is_plain = hidden.is_plain();
        let [mut ln, mut parts, mut of_sigma, mut of_energy, mut of_shape] = [[0.0; MOST_NODES]; 5];
        let (mut z, mut stretch) = ([0.0; MOST_NODES], [1.0; MOST_NODES]);
        for ((z, stretch), x) in z[..count].iter_mut().zip(&mut stretch[..count]).zip(&x[..count]) {
            [*z, *stretch] = path.at(*x);
        }
        let z = &z[..count];
        for (ln, z) in ln[..count].iter_mut().zip(z) {
            *ln = -0.5 * z * z;
        }
        for (setting, to) in hidden.settings.iter().zip(sums.at.iter_mut()) {
            setting.at_nodes(z, fused, to);
            let (mut mean, mut slope) = ([0.0; MOST_NODES], [1.0; MOST_NODES]);
            for ((mean, slope), kept) in mean[..count].iter_mut().zip(&mut slope[..count]).zip(&to.kept[..count]) {
                (*mean, *slope) = mean_and_slope(*kept);
            }
            to.of_kept[..count].fill(0.0);
            for run in setting.runs {
                let [ln, of_sigma] = [&mut ln, &mut of_sigma].map(|column| &mut column[..count]);
                let of_kept = &mut to.of_kept[..count];
                let sums = ln.iter_mut().zip(&mut *of_kept).zip(&mut *of_sigma);
                let at = mean[..count].iter().zip(&slope[..count]).zip(z);
                match run.seen {
                    Seen::Rebound(e) if is_plain => {
                        let errors = run.errors;
                        let shared = errors.shared();
                        for (((ln, of_kept), of_sigma), ((mean, slope), z)) in sums.zip(at) {
                            let ratio = errors.ratio(*z);
                            let variance = errors.variance(sigma * ratio);
                            let distance = e - shared * (1.0 - ratio) - mean * ratio;
                            let inverse = 1.0 / variance;
                            let square = distance * distance * inverse;
                            *ln -= 0.5 * (square + logarithm(variance, fused)) + LN_ROOT_TWO_PI;
                            *of_kept += distance * inverse * ratio * slope;
                            *of_sigma += (square - 1.0) * inverse * sigma * ratio * ratio;
                        }
                    }
                    Seen::On(side, limit) if is_plain => {
                        let towards = side.sign() / sigma;
                        // nothing is added by a side that is certain
                        if mean[..count].iter().all(|mean| towards * (limit - mean) > CERTAIN) {
                            continue;
                        }
                        for (((ln, of_kept), of_sigma), ((mean, slope), _)) in sums.zip(at) {
                            let z = towards * (limit - mean);
                            let [value, of_z] = ln_normal_cdf_and_slope(z, fused);
                            *ln += value;
                            *of_kept -= towards * of_z * slope;
                            *of_sigma -= of_z * z / sigma;
                        }
                    }
                    _ => {
                        for (node, z) in z.iter().enumerate() {
                            let of = hidden.density_at(run, to.kept[node], *z);
                            ln[node] += of.value;
                            of_kept[node] += of.kept;
                            of_sigma[node] += of.sigma;
                            of_energy[node] += of.energy;
                            of_shape[node] += of.shape;
                        }
                    }
                }
            }
        }
        sums.refer_to(ln[..count].iter().copied().fold(f64::NEG_INFINITY, f64::max));
        let reference = sums.reference;
        let weights = weights.iter().zip(&stretch);
        for ((part, (weight, stretch)), ln) in parts[..count].iter_mut().zip(weights).zip(&ln) {
            *part = weight * stretch * exponential(ln - reference, fused);
        }
        let of_parts = &parts[..count];
        // no number where a logarithm is none, whose exponential is one here
        let [mass, no_number, of_sigma] =
            lanes::sums([of_parts, &ln[..count], &of_sigma[..count]], |[part, ln, of_sigma]| {
                [part, ln, part * of_sigma]
            });
        sums.of[0] += mass + 0.0 * no_number;
        sums.of[1] += of_sigma;
        if !is_plain {
            let [of_energy, of_shape] = lanes::sums(
                [of_parts, &of_energy[..count], &of_shape[..count]],
                |[part, of_energy, of_shape]| [part * of_energy, part * of_shape],
            );
            sums.of[2] += of_energy;
            sums.of[3] += of_shape;
        }
        for (sum, of) in sums.settings.iter_mut().zip(sums.at.iter_mut()) {
            let of_kept = &mut of.of_kept[..count];
            for (of_kept, part) in of_kept.iter_mut().zip(of_parts) {
                *of_kept *= part;
            }
            let columns = [&of.of_kept, &of.over_stokes, &of.slope_k].map(|column| &column[..count]);
            let slopes = lanes::sums(columns, |[of_kept, x, of_k]| [of_kept, of_kept * x, of_kept * of_k]);
            for (sum, more) in sum.iter_mut().zip(slopes) {
                *sum += more;
            }
        }
        if let Some(trace) = &mut sums.trace {
            trace.extend(z.iter().zip(of_parts).map(|(z, part)| [*z, *part]));
        }
        let at = &mut sums.nodes;
        for (to, of) in [(&mut at.ln, &ln), (&mut at.stretch, &stretch), (&mut at.parts, &parts)] {
            to[..count].copy_from_slice(&of[..count]);
        }
    }
}

impl SettingRuns<'_> {
    /// Writes what is kept at each node.
    #[inline(always)]
    fn at_nodes(&self, places: &[f64], fused: bool, to: &mut SettingNodes) {
        let mut roots = [1.0; MOST_NODES];
        let roots = &mut roots[..places.len()];
        if self.balance.own_speed {
            for (root, z) in roots.iter_mut().zip(places) {
                *root = exponential(POWER * logarithm(self.ratio(*z), fused), fused);
            }
        }
        // each a loop of its own without a choice in it
        match self.balance.order {
            Order::First => self.kept_at(Order::First, places, roots, to),
            Order::Second => self.kept_at(Order::Second, places, roots, to),
        }
    }

    /// What an impact keeps, where the dry speed's fifth root is so many times as large.
    #[inline(always)]
    fn kept_at(&self, order: Order, places: &[f64], roots: &[f64], to: &mut SettingNodes) {
        let balance = self.balance.of_order(order);
        let (first, errors) = (self.impact, self.runs[0].errors);
        let count = places.len();
        let [kept, slope_k, over_stokes] =
            [&mut to.kept, &mut to.slope_k, &mut to.over_stokes].map(|column| &mut column[..count]);
        let to = kept.iter_mut().zip(slope_k).zip(over_stokes);
        for (((kept, slope_k), over_stokes), (z, root)) in to.zip(places.iter().zip(roots)) {
            let impact = first.at_speed_ratio(errors.ratio(*z), *root);
            (*kept, *slope_k) = balance.kept(&impact);
            *over_stokes = impact.over_stokes;
        }
    }
}
