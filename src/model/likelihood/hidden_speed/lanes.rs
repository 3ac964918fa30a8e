//! Computes the integrand over the true speed at several nodes side by side.
//!
//! Symbols as in `hidden_speed.rs`. Lanes are added in one order on every machine.

use pulp::{Arch, Simd, WithSimd};

use super::{HiddenSpeed, MeasuredRun, SettingRuns, SettingSlopes, Sums, FALL};
use crate::exponential::{exponential, is_fused, logarithm};
use crate::model::likelihood::normal::ln_normal_cdf_and_slope;
use crate::model::likelihood::run_density::{RunDensity, Seen};
use crate::model::likelihood::tails::{normal_density, Tails};
use crate::physics::dry::{Order, POWER};
use crate::physics::rebound::mean_and_slope;
use crate::runs::MOST_SETTINGS;

/// Nodes are computed in multiples of this.
const LANES: usize = 8;

/// Nodes of one call.
pub(super) const MOST_NODES: usize = 16;

/// Variances whose logarithm is taken at once, that of their product: one takes as long as all else that a rebound adds.
const MOST_FACTORS: usize = 4;

/// A number at each of these nodes.
type Column = [f64; MOST_NODES];

/// Nodes of a rule with their weights, gathered until there are enough of them.
struct NodeBatch<'n, 'b, 's> {
    hidden: &'n HiddenSpeed<'b>,
    sums: Sums<'s>,
    places: [f64; LANES],
    weights: [f64; LANES],
    count: usize,
}

impl<'n, 'b, 's> NodeBatch<'n, 'b, 's> {
    fn new(hidden: &'n HiddenSpeed<'b>, sums: Sums<'s>) -> NodeBatch<'n, 'b, 's> {
        NodeBatch {
            hidden,
            sums,
            places: [0.0; LANES],
            weights: [0.0; LANES],
            count: 0,
        }
    }

    /// The logarithm at this node where it is computed; infinite where it waits for others.
    fn add(&mut self, z: f64, weight: f64) -> f64 {
        (self.places[self.count], self.weights[self.count]) = (z, weight);
        self.count += 1;
        if self.count < LANES {
            return f64::INFINITY;
        }
        self.count = 0;
        let [.., last] = self.flush();
        last
    }

    /// The sums over all nodes.
    fn finish(mut self) -> Sums<'s> {
        if self.count > 0 {
            let filled = self.places[0];
            self.places[self.count..].fill(filled);
            self.weights[self.count..].fill(0.0);
            self.flush();
        }
        self.sums
    }

    fn flush(&mut self) -> [f64; LANES] {
        let mut ln = [0.0; LANES];
        self.hidden
            .add_nodes(&self.places, &self.weights, &mut self.sums, &mut ln);
        ln
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
        if let Some(found) = self.over_bell(of_settings) {
            return found;
        }
        let reach = self.reach(FALL);
        let mut nodes = NodeBatch::new(self, Sums::new(reach.ln, of_settings));
        self.over_nodes(&reach, &mut |z, weight| nodes.add(z, weight));
        nodes.finish().density()
    }

    /// Adds nodes with their weights to sums, and writes the logarithm of the integrand at each; a multiple of [`LANES`] up
    /// to [`MOST_NODES`].
    pub(super) fn add_nodes(&self, places: &[f64], weights: &[f64], sums: &mut Sums, ln: &mut [f64]) {
        #[cfg(test)]
        crate::model::likelihood::tests::nodes::count(places.len() * self.runs().count());
        let arch = Arch::new();
        // most runs are alone, and room for one is made sooner
        if self.settings.len() == 1 {
            arch.dispatch(Nodes::<1> {
                hidden: self,
                places,
                weights,
                sums,
                ln,
            });
        } else {
            arch.dispatch(Nodes::<MOST_SETTINGS> {
                hidden: self,
                places,
                weights,
                sums,
                ln,
            });
        }
    }
}

/// Nodes of at most so many settings.
struct Nodes<'n, 'b, 'm, 's, const SETTINGS: usize> {
    hidden: &'n HiddenSpeed<'b>,
    places: &'n [f64],
    weights: &'n [f64],
    sums: &'m mut Sums<'s>,
    ln: &'m mut [f64],
}

impl<const SETTINGS: usize> WithSimd for Nodes<'_, '_, '_, '_, SETTINGS> {
    type Output = ();

    // each loop is over slices whose length is not known where the code is made: of one that is, the registers are not filled
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Nodes {
            hidden,
            places,
            weights,
            sums,
            ln,
        } = self;
        let count = places.len().min(MOST_NODES);
        let fused = is_fused::<S>();
        let mut settings = [SettingNodes::NONE; SETTINGS];
        let mut of_sigma = [0.0; MOST_NODES];
        let (mut variances, mut factors) = ([1.0; MOST_NODES], 0);
        for (ln, z) in ln.iter_mut().zip(places) {
            *ln = -0.5 * z * z;
        }
        for (setting, to) in hidden.settings.iter().zip(&mut settings) {
            setting.at_nodes(places, hidden.wet, fused, to);
            let (mut mean, mut slope) = (to.kept, [1.0; MOST_NODES]);
            if hidden.wet {
                for ((mean, slope), kept) in mean[..count].iter_mut().zip(&mut slope).zip(&to.kept) {
                    (*mean, *slope) = mean_and_slope(*kept);
                }
            }
            let sigma = hidden.spreads.sigma;
            for MeasuredRun { seen, errors } in setting.runs {
                let sums = ln.iter_mut().zip(&mut to.of_kept).zip(&mut of_sigma);
                let at = mean.iter().zip(&slope).zip(places);
                match *seen {
                    Seen::Rebound(e) => {
                        let shared = errors.shared();
                        for ((((ln, of_kept), of_sigma), variances), ((mean, slope), z)) in
                            sums.zip(&mut variances).zip(at)
                        {
                            let ratio = errors.ratio(*z);
                            let variance = hidden.variance(errors, ratio);
                            let distance = e - shared * (1.0 - ratio) - mean * ratio;
                            let density = normal_density(distance, variance, 0.0);
                            *ln += density.value;
                            *variances *= variance;
                            *of_kept += density.mean * ratio * slope;
                            *of_sigma += 2.0 * density.variance * sigma * ratio * ratio;
                        }
                        factors += 1;
                        if factors == MOST_FACTORS {
                            divide_by_root(ln, &mut variances, fused);
                            factors = 0;
                        }
                    }
                    // none of the latter come here
                    Seen::On(side, limit) | Seen::Measured(side, limit) => {
                        let towards = side.sign() / sigma;
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
            divide_by_root(ln, &mut variances, fused);
        }
        sums.refer_to(largest(ln));
        let mut parts = [0.0; MOST_NODES];
        let parts = &mut parts[..count];
        for ((part, weight), ln) in parts.iter_mut().zip(weights).zip(&*ln) {
            *part = weight * exponential(ln - sums.reference, fused);
        }
        // no number where a logarithm is none, whose exponential is one here
        sums.of[0] += total(parts) + 0.0 * total(ln);
        sums.of[1] += total_of_products(parts, &of_sigma);
        for (sum, of) in sums.settings.iter_mut().zip(&mut settings) {
            let of_kept = &mut of.of_kept[..count];
            for (of_kept, part) in of_kept.iter_mut().zip(&*parts) {
                *of_kept *= part;
            }
            sum.kept += total(of_kept);
            sum.viscous += total_of_products(of_kept, &of.over_stokes);
            sum.dry_k += total_of_products(of_kept, &of.slope_k);
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
        if self.balance.own_speed {
            for (root, z) in roots.iter_mut().zip(places) {
                *root = exponential(POWER * logarithm(self.ratio(*z), fused), fused);
            }
        }
        // each a loop of its own without a choice in it
        match (wet, self.balance.order) {
            (true, Order::First) => self.kept_at::<true>(Order::First, places, &roots, to),
            (true, Order::Second) => self.kept_at::<true>(Order::Second, places, &roots, to),
            (false, Order::First) => self.kept_at::<false>(Order::First, places, &roots, to),
            (false, Order::Second) => self.kept_at::<false>(Order::Second, places, &roots, to),
        }
    }

    /// What a wet or dry impact keeps, where the dry speed's fifth root is so many times as large.
    #[inline(always)]
    fn kept_at<const WET: bool>(&self, order: Order, places: &[f64], roots: &Column, to: &mut SettingNodes) {
        let balance = self.balance.of_order(order);
        let to = to.kept.iter_mut().zip(&mut to.slope_k).zip(&mut to.over_stokes);
        for (((kept, slope_k), over_stokes), (z, root)) in to.zip(places.iter().zip(roots)) {
            let impact = self.impact.at_speed_ratio(self.ratio(*z), *root);
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
fn divide_by_root(ln: &mut [f64], variances: &mut Column, fused: bool) {
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

/// The sum of a multiple of [`LANES`], halves first.
#[inline(always)]
fn total(numbers: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    for chunk in numbers.as_chunks::<LANES>().0 {
        for (lane, number) in lanes.iter_mut().zip(chunk) {
            *lane += number;
        }
    }
    of_lanes(lanes)
}

/// The sum of as many products as the shorter has.
#[inline(always)]
fn total_of_products(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for ((lane, a), b) in lanes.iter_mut().zip(a).zip(b) {
            *lane += a * b;
        }
    }
    of_lanes(lanes)
}

#[inline(always)]
fn of_lanes([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
