//! Computes the integrand over the true speed at several nodes side by side.
//!
//! Symbols as in `hidden_speed.rs`. Lanes are added in one order on every machine.

use pulp::{Arch, Simd, WithSimd};

use super::rules::Height;
use super::{HiddenSpeed, MeasuredRun, SettingRuns, SettingSlopes, Sums, FALL};
use crate::exponential::{exponential, is_fused, logarithm};
use crate::model::likelihood::normal::{ln_normal_cdf_and_slope, CERTAIN};
use crate::model::likelihood::run_density::{RunDensity, Seen};
use crate::model::likelihood::tails::{normal_density, Tails};
use crate::physics::dry::{Order, POWER};
use crate::physics::rebound::mean_and_slope;
use crate::runs::MOST_SETTINGS;

/// Nodes are computed in multiples of this.
const LANES: usize = 8;

/// Nodes of one call.
const MOST_NODES: usize = 16;

/// Variances whose logarithm is taken at once, that of their product: one takes as long as all else that a rebound adds.
const MOST_FACTORS: usize = 4;

/// A number at each of these nodes.
type Column = [f64; MOST_NODES];

/// Some nodes of a rule.
#[derive(Clone, Copy)]
pub(super) struct RuleNodes {
    places: Column,
    weights: Column,
    /// up to [`MOST_NODES`]
    count: usize,
}

impl RuleNodes {
    pub const NONE: RuleNodes = RuleNodes {
        places: [0.0; MOST_NODES],
        weights: [0.0; MOST_NODES],
        count: 0,
    };

    #[inline(always)]
    pub fn push(&mut self, z: f64, weight: f64) {
        (self.places[self.count], self.weights[self.count]) = (z, weight);
        self.count += 1;
    }

    /// Fills the last register up with nodes that count for nothing.
    fn fill(&mut self) {
        while !self.count.is_multiple_of(LANES) {
            self.push(self.places[0], 0.0);
        }
    }
}

/// What the integrand is at some nodes.
pub(super) struct AtNodes {
    /// its logarithm
    ln: Column,
    /// what a node adds to the mass
    pub parts: Column,
    /// slope of the logarithm in what is kept, that of all settings together
    of_kept: Column,
}

/// Nodes of a rule, gathered until there are enough of them.
pub(super) struct NodeBatch<'n, 'b, 's> {
    hidden: &'n HiddenSpeed<'b>,
    sums: Sums<'s>,
    nodes: RuleNodes,
    /// nodes of one call
    enough: usize,
}

impl<'n, 'b, 's> NodeBatch<'n, 'b, 's> {
    /// About a value that the logarithm has near its largest, or less.
    pub fn new(
        hidden: &'n HiddenSpeed<'b>,
        reference: f64,
        of_settings: &'s mut [SettingSlopes],
    ) -> NodeBatch<'n, 'b, 's> {
        NodeBatch {
            hidden,
            sums: Sums::new(reference, of_settings),
            nodes: RuleNodes::NONE,
            enough: MOST_NODES,
        }
    }

    /// The logarithm at this node where it is computed; infinite where it waits for others.
    pub fn add(&mut self, z: f64, weight: f64) -> f64 {
        self.nodes.push(z, weight);
        if self.nodes.count < self.enough {
            return f64::INFINITY;
        }
        let at = self.hidden.add_nodes(&self.nodes, &mut self.sums);
        self.nodes.count = 0;
        at.ln[self.enough - 1]
    }

    /// The sums over all nodes.
    pub fn finish(mut self) -> Sums<'s> {
        if self.nodes.count > 0 {
            self.nodes.fill();
            self.hidden.add_nodes(&self.nodes, &mut self.sums);
        }
        self.sums
    }
}

impl HiddenSpeed<'_> {
    /// Whether nodes may be computed side by side: of normal noise on the restitution alone.
    pub(super) fn goes_side_by_side(&self) -> bool {
        /// the product of [`MOST_FACTORS`] variances is then a number of which [`logarithm`] gives the logarithm
        const SIGMA: std::ops::Range<f64> = 1e-30..1e30;
        let is_measured = |run: &MeasuredRun| matches!(run.seen, Seen::Measured(..));
        self.tails == Tails::Normal
            && !self.both()
            && SIGMA.contains(&self.spreads.sigma)
            && !self.runs().any(is_measured)
    }

    /// The integral of an integrand that [`HiddenSpeed::goes_side_by_side`].
    pub(super) fn integrate_side_by_side(&self, of_settings: &mut [SettingSlopes]) -> RunDensity {
        if self.is_certain_within_reach() {
            of_settings.fill(SettingSlopes::default());
            return RunDensity::default();
        }
        if let Some(found) = self.over_bell_or_turn(of_settings) {
            return found;
        }
        let reach = self.reach(FALL);
        let mut nodes = NodeBatch::new(self, reach.ln, of_settings);
        if reach.turns.is_empty() {
            // steps end where one says that there is nothing left
            nodes.enough = LANES;
        }
        self.over_nodes(&reach, &mut |z, weight| nodes.add(z, weight));
        nodes.finish().density()
    }

    /// How large the integrand is at each of these places.
    pub(super) fn heights(&self, places: &[f64]) -> Vec<Height> {
        let mut unused = [SettingSlopes::default(); MOST_SETTINGS];
        let mut unused = Sums::new(f64::INFINITY, &mut unused[..self.settings.len()]);
        let mut heights = Vec::with_capacity(places.len());
        for some in places.chunks(MOST_NODES) {
            let mut nodes = RuleNodes::NONE;
            some.iter().for_each(|z| nodes.push(*z, 0.0));
            nodes.fill();
            let AtNodes { ln, of_kept, .. } = self.at_nodes(&nodes, &mut unused);
            heights.extend((0..some.len()).map(|node| Height {
                ln: ln[node],
                of_kept: of_kept[node],
            }));
        }
        heights
    }

    /// Adds nodes, a multiple of [`LANES`], to sums.
    pub(super) fn add_nodes(&self, nodes: &RuleNodes, sums: &mut Sums) -> AtNodes {
        #[cfg(test)]
        crate::model::likelihood::tests::nodes::count(nodes.count * self.runs().count());
        self.at_nodes(nodes, sums)
    }

    fn at_nodes(&self, nodes: &RuleNodes, sums: &mut Sums) -> AtNodes {
        let arch = Arch::new();
        // most runs are alone, and room for one is made sooner
        if self.settings.len() == 1 {
            arch.dispatch(Nodes::<1> {
                hidden: self,
                nodes,
                sums,
            })
        } else {
            arch.dispatch(Nodes::<MOST_SETTINGS> {
                hidden: self,
                nodes,
                sums,
            })
        }
    }
}

/// Nodes of at most so many settings.
struct Nodes<'n, 'b, 'm, 's, const SETTINGS: usize> {
    hidden: &'n HiddenSpeed<'b>,
    nodes: &'n RuleNodes,
    sums: &'m mut Sums<'s>,
}

impl<const SETTINGS: usize> WithSimd for Nodes<'_, '_, '_, '_, SETTINGS> {
    type Output = AtNodes;

    // each loop is over slices whose length is not known where the code is made: of one that is, the registers are not filled
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> AtNodes {
        let Nodes { hidden, nodes, sums } = self;
        // a copy, so that no loop has to ask whether what it reads is what it writes
        let RuleNodes { places, weights, count } = *nodes;
        let count = count.min(MOST_NODES);
        let fused = is_fused::<S>();
        let mut settings = [SettingNodes::NONE; SETTINGS];
        let [mut all_ln, mut parts, mut of_sigma, mut all_kept] = [[0.0; MOST_NODES]; 4];
        let (mut variances, mut factors) = ([1.0; MOST_NODES], 0);
        let [places, weights] = [&places[..count], &weights[..count]];
        let [ln, variances, of_sigma] = [&mut all_ln, &mut variances, &mut of_sigma].map(|column| &mut column[..count]);
        for (ln, z) in ln.iter_mut().zip(places) {
            *ln = -0.5 * z * z;
        }
        for (setting, to) in hidden.settings.iter().zip(&mut settings) {
            setting.at_nodes(places, hidden.wet, fused, to);
            let (mut mean, mut slope) = (to.kept, [1.0; MOST_NODES]);
            if hidden.wet {
                for ((mean, slope), kept) in mean[..count].iter_mut().zip(&mut slope[..count]).zip(&to.kept[..count]) {
                    (*mean, *slope) = mean_and_slope(*kept);
                }
            }
            let sigma = hidden.spreads.sigma;
            let of_kept = &mut to.of_kept[..count];
            for MeasuredRun { seen, errors } in setting.runs {
                let sums = ln.iter_mut().zip(&mut *of_kept).zip(&mut *of_sigma);
                let at = mean[..count].iter().zip(&slope[..count]).zip(places);
                match *seen {
                    Seen::Rebound(e) => {
                        let (errors, shared) = (*errors, errors.shared());
                        for ((((ln, of_kept), of_sigma), variances), ((mean, slope), z)) in
                            sums.zip(&mut *variances).zip(at)
                        {
                            let ratio = errors.ratio(*z);
                            let variance = hidden.variance(&errors, ratio);
                            let distance = e - shared * (1.0 - ratio) - mean * ratio;
                            let density = normal_density(distance, variance, 0.0);
                            *ln += density.value;
                            *variances *= variance;
                            *of_kept += density.mean * ratio * slope;
                            *of_sigma += 2.0 * density.variance * sigma * ratio * ratio;
                        }
                        factors += 1;
                        if factors == MOST_FACTORS {
                            divide_by_root(ln, variances, fused);
                            factors = 0;
                        }
                    }
                    // none of the latter come here
                    Seen::On(side, limit) | Seen::Measured(side, limit) => {
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
                }
            }
        }
        if factors > 0 {
            divide_by_root(ln, variances, fused);
        }
        sums.refer_to(largest(ln));
        let reference = sums.reference;
        for ((part, weight), ln) in parts[..count].iter_mut().zip(weights).zip(&*ln) {
            *part = weight * exponential(ln - reference, fused);
        }
        let of_parts = &parts[..count];
        // no number where a logarithm is none, whose exponential is one here
        let terms = |part: f64, ln: f64, of_sigma: f64| [part, ln, part * of_sigma];
        let [mass, no_number, of_sigma] = totals([of_parts, ln, of_sigma], terms);
        sums.of[0] += mass + 0.0 * no_number;
        sums.of[1] += of_sigma;
        for (sum, of) in sums.settings.iter_mut().zip(&mut settings) {
            let all_kept = all_kept[..count].iter_mut();
            for ((of_kept, all_kept), part) in of.of_kept[..count].iter_mut().zip(all_kept).zip(of_parts) {
                *all_kept += *of_kept;
                *of_kept *= part;
            }
            let columns = [&of.of_kept, &of.over_stokes, &of.slope_k].map(|column| &column[..count]);
            let [kept, viscous, dry_k] = totals(columns, |of_kept, x, of_k| [of_kept, of_kept * x, of_kept * of_k]);
            sum.kept += kept;
            sum.viscous += viscous;
            sum.dry_k += dry_k;
        }
        AtNodes {
            ln: all_ln,
            parts,
            of_kept: all_kept,
        }
    }
}

/// What a setting has at each node.
#[derive(Clone, Copy)]
struct SettingNodes {
    /// r, or e_dry of dry runs
    kept: Column,
    /// 4/St
    over_stokes: Column,
    /// slope of what is kept in k
    slope_k: Column,
    /// slope of the logarithm in what is kept
    of_kept: Column,
}

impl SettingNodes {
    const NONE: SettingNodes = SettingNodes {
        kept: [0.0; MOST_NODES],
        over_stokes: [0.0; MOST_NODES],
        slope_k: [0.0; MOST_NODES],
        of_kept: [0.0; MOST_NODES],
    };
}

impl SettingRuns<'_> {
    /// Writes what the setting keeps at each node.
    #[inline(always)]
    fn at_nodes(&self, places: &[f64], wet: bool, fused: bool, to: &mut SettingNodes) {
        let mut roots = [1.0; MOST_NODES];
        let roots = &mut roots[..places.len()];
        if self.balance.own_speed {
            for (root, z) in roots.iter_mut().zip(places) {
                *root = exponential(POWER * logarithm(self.ratio(*z), fused), fused);
            }
        }
        // each a loop of its own without a choice in it
        match (wet, self.balance.order) {
            (true, Order::First) => self.kept_at::<true>(Order::First, places, roots, to),
            (true, Order::Second) => self.kept_at::<true>(Order::Second, places, roots, to),
            (false, Order::First) => self.kept_at::<false>(Order::First, places, roots, to),
            (false, Order::Second) => self.kept_at::<false>(Order::Second, places, roots, to),
        }
    }

    /// What a wet or dry impact keeps, where the dry speed's fifth root is so many times as large.
    #[inline(always)]
    fn kept_at<const WET: bool>(&self, order: Order, places: &[f64], roots: &[f64], to: &mut SettingNodes) {
        let balance = self.balance.of_order(order);
        let (first, errors) = (self.impact, *self.first());
        let count = places.len();
        let [kept, slope_k, over_stokes] =
            [&mut to.kept, &mut to.slope_k, &mut to.over_stokes].map(|column| &mut column[..count]);
        let to = kept.iter_mut().zip(slope_k).zip(over_stokes);
        for (((kept, slope_k), over_stokes), (z, root)) in to.zip(places.iter().zip(roots)) {
            let impact = first.at_speed_ratio(errors.ratio(*z), *root);
            (*kept, *slope_k) = if WET {
                balance.kept(&impact)
            } else {
                let [e_dry, slope, _] = balance.e_dry(impact.dry_root);
                (e_dry, slope)
            };
            *over_stokes = impact.over_stokes;
        }
    }
}

/// Takes half the logarithm of each product of variances off, and leaves ones.
#[inline(always)]
fn divide_by_root(ln: &mut [f64], variances: &mut [f64], fused: bool) {
    for (ln, variances) in ln.iter_mut().zip(variances) {
        *ln -= 0.5 * logarithm(*variances, fused);
        *variances = 1.0;
    }
}

#[inline(always)]
fn largest(numbers: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut lanes = [f64::NEG_INFINITY; LANES];
    for chunk in numbers.as_chunks::<LANES>().0 {
        for (lane, number) in lanes.iter_mut().zip(chunk) {
            *lane = larger(*lane, *number);
        }
    }
    lanes.into_iter().fold(f64::NEG_INFINITY, larger)
}

/// The sums of three terms of as many numbers as the shortest column has, a multiple of [`LANES`]; halves first.
#[inline(always)]
fn totals([a, b, c]: [&[f64]; 3], terms: impl Fn(f64, f64, f64) -> [f64; 3]) -> [f64; 3] {
    let mut lanes = [[0.0; LANES]; 3];
    let [a, b, c] = [a, b, c].map(|column| column.as_chunks::<LANES>().0);
    for ((a, b), c) in a.iter().zip(b).zip(c) {
        for lane in 0..LANES {
            let found = terms(a[lane], b[lane], c[lane]);
            for (sums, term) in lanes.iter_mut().zip(found) {
                sums[lane] += term;
            }
        }
    }
    lanes.map(of_lanes)
}

#[inline(always)]
fn of_lanes([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
