//! Computes the log likelihood of all runs at once and its slopes, from rows or from the few nodes that stand for them.
//!
//! The generative statement: a wet run's e* = m(r) + σ_wet z, a dry run's e* = e_dry(v) + σ_dry z; the run stuck if e* is
//! at or below the limit; where such runs were not logged, a rebound's density is that of runs that rebound. A node is a setting with a count and a mean restitution: a row is a node of count 1, and a
//! compressed series has few nodes and a leftover sum of squares, so that rows and nodes share one evaluation.
//!
//! Symbols: r = e_dry² − C ρ̃ g(δ̃) − L x − b with x = 4/St and b = κ/v², as far as the form holds them, and e_dry = 1 − k p
//! (+ (3/5) k² p² to second order) with p = v^(1/5) at the dry speed in use. A trend with the film ratio stands in L and C:
//! L + L′ f and C exp(C′ f), f being the logarithm of the film ratio over the middle one of the runs.

mod compress;
mod energies;
mod gauss;
pub mod normal;
pub mod pointwise;
mod rows;
mod trend;

pub use compress::{Compression, Resolution};
pub use energies::on_energies;

use std::ops::Range;

use self::energies::{Energies, Spreads};
use self::normal::ln_normal_cdf;
use self::trend::Film;
use super::parameters::{Kind, COMMON_SLOTS};
use super::priors::LN_ROOT_TWO_PI;
use crate::physics::dry::{Order, SECOND_ORDER};
use crate::physics::impact::Form;
use crate::physics::rebound::{kept_of_mean_restitution, TURN};

/// Settings with their counts, as columns.
#[derive(Debug, Clone, Default, PartialEq)]
struct Nodes {
    /// x = 4/St
    viscous: Vec<f64>,
    /// p = v^(1/5) at the dry speed in use, (m/s)^(1/5)
    dry_power: Vec<f64>,
    /// b = κ/v²; empty where the form holds no bridge
    bridge: Vec<f64>,
    /// mean e of the runs; 0 for stuck ones
    restitution: Vec<f64>,
    /// how many runs the node stands for; need not be whole
    count: Vec<f64>,
}

impl Nodes {
    fn len(&self) -> usize {
        self.count.len()
    }

    fn push(&mut self, at: Abscissa, restitution: f64, count: f64) {
        self.viscous.push(at.viscous);
        self.dry_power.push(at.dry_power);
        self.bridge.extend(at.bridge);
        self.restitution.push(restitution);
        self.count.push(count);
    }
}

impl Nodes {
    fn abscissa(&self, node: usize) -> Abscissa {
        Abscissa {
            viscous: self.viscous[node],
            dry_power: self.dry_power[node],
            bridge: self.bridge.get(node).copied(),
        }
    }
}

/// What of a node the energy kept depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Abscissa {
    /// x
    viscous: f64,
    /// p
    dry_power: f64,
    /// b; `None` where the form holds no bridge
    bridge: Option<f64>,
}

/// What of the parameters the energy kept in a block depends on.
#[derive(Debug, Clone, Copy)]
struct Law {
    order: Order,
    k: f64,
    /// C ρ̃ g(δ̃)
    inertial: f64,
    l: f64,
}

impl Law {
    /// r, and its slope in k over −2: e_dry times that of −e_dry.
    fn kept(&self, at: &Abscissa) -> (f64, f64) {
        let (e_dry, fall) = e_dry(self.order, self.k, at.dry_power);
        let lost = self.inertial + self.l * at.viscous + at.bridge.unwrap_or(0.0);
        (e_dry * e_dry - lost, e_dry * fall)
    }
}

/// e_dry and its slope in −k.
#[inline(always)]
fn e_dry(order: Order, k: f64, p: f64) -> (f64, f64) {
    match order {
        Order::First => (1.0 - k * p, p),
        Order::Second => {
            let bent = SECOND_ORDER * k * p;
            (1.0 - k * p * (1.0 - bent), p * (1.0 - 2.0 * bent))
        }
    }
}

/// Wet runs that share particle, liquid and film ratio.
#[derive(Debug, Clone, PartialEq)]
struct Block {
    particle: usize,
    density_ratio: f64,
    /// index into [`Likelihood::film_ratios`]
    film: usize,
    /// range of [`Likelihood::rebounds`]
    rebounds: Range<usize>,
    /// range of [`Likelihood::stuck`]
    stuck: Range<usize>,
}

/// The dry runs of a particle: their rebounds need four numbers, with y = 1 − e = k p + σ z.
#[derive(Debug, Clone, Default, PartialEq)]
struct DryRuns {
    rebounds: f64,
    /// Σ p y / Σ p²
    slope: f64,
    /// Σ p²
    weight: f64,
    /// Σ (y − slope p)²
    leftover: f64,
    /// Σ p³, Σ p⁴ and Σ p² (y − slope p), which the second order wants
    bent: [f64; 3],
    /// stuck runs, by p
    stuck: Vec<f64>,
    /// rebounds, by p, where stuck runs were not logged
    logged: Vec<f64>,
}

impl DryRuns {
    /// Σ (e − e_dry)² over the rebounds, and its slope in k.
    fn squares(&self, order: Order, k: f64) -> (f64, f64) {
        let distance = k - self.slope;
        let first = (
            self.leftover + self.weight * distance * distance,
            2.0 * self.weight * distance,
        );
        match order {
            Order::First => first,
            // with y − k p + a k² p² = u − distance p + a k² p², where Σ p u = 0
            Order::Second => {
                let [cubes, fourth, bend] = self.bent;
                let a = SECOND_ORDER;
                let square = k * k;
                (
                    first.0 + a * square * (a * square * fourth + 2.0 * (bend - distance * cubes)),
                    first.1 + 4.0 * a * k * (a * square * fourth + bend - distance * cubes) - 2.0 * a * square * cubes,
                )
            }
        }
    }
}

/// The log likelihood of the runs of a scene as a function of a full vector of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Likelihood {
    form: Form,
    /// at or below this e* the run stuck
    limit: f64,
    /// whether runs that stuck were not logged, so that a rebound's density is that of runs that rebound
    truncated: bool,
    blocks: Vec<Block>,
    /// the different film ratios: the shape of the inertial loss is computed once for each
    film_ratios: Vec<f64>,
    /// f of each of them
    ln_films: Vec<f64>,
    rebounds: Nodes,
    stuck: Nodes,
    /// the rebounds on the scale of the energy kept, where noise acts there, too
    energies: Option<Energies>,
    /// wet runs that rebounded
    wet_rebounds: f64,
    /// what the nodes leave of the wet rebounds' sum of squares
    leftover: f64,
    dry: Vec<DryRuns>,
}

/// The parameters give no density here: not an error, a place to turn back from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutsideDomain;

/// Sums over the rebounds of a block: Σ n d², Σ n d m′, Σ n d m′ x, Σ n d m′ e_dry p, with d = e − m(r).
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    squares: f64,
    kept: f64,
    viscous: f64,
    dry: f64,
}

/// Runs taken at once, so that the machine's vector registers fill.
const LANES: usize = 4;

/// A stuck run this many σ below the limit stuck for certain: ln Φ(9) is −1e-19.
const CERTAIN: f64 = 9.0;

impl Likelihood {
    /// Whether the likelihood is one of rows and cannot be compressed: noise on the energy kept gives every run a spread of
    /// its own.
    pub fn needs_rows(&self) -> bool {
        self.energies.is_some()
    }

    /// Nodes of wet runs, rebounded and stuck: the cost of one evaluation.
    pub fn nodes(&self) -> usize {
        self.rebounds.len() + self.stuck.len()
    }

    /// Log likelihood at a full vector of parameters; `slopes`, as long, is overwritten.
    ///
    /// Fails where it is not finite; a full vector with e_dry ≤ 0 or σ ≤ 0 is the caller's to avoid by its bounds.
    pub fn ln_density(&self, full: &[f64], slopes: &mut [f64]) -> Result<f64, OutsideDomain> {
        slopes.fill(0.0);
        let value = self.wet(full, slopes) + self.dry(full, slopes);
        let finite = value.is_finite() && slopes.iter().all(|slope| slope.is_finite());
        if finite {
            Ok(value)
        } else {
            Err(OutsideDomain)
        }
    }

    fn wet(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        if self.blocks.is_empty() {
            return 0.0;
        }
        let at = |kind: Kind| full[kind.slot()];
        let sigma = at(Kind::SigmaWet);
        let precision = 1.0 / (sigma * sigma);
        let mut squares = self.leftover;
        let mut stuck_value = 0.0;
        let certain = kept_of_mean_restitution(self.limit - CERTAIN * sigma);
        let films: Vec<Film> = (0..self.film_ratios.len()).map(|film| self.film(film, full)).collect();
        for block in &self.blocks {
            let film = &films[block.film];
            let law = film.law(self.form.dry, full[COMMON_SLOTS + block.particle], block.density_ratio);
            let mut sums = Sums::default();
            if let Some(energies) = &self.energies {
                let spreads = Spreads {
                    sigma,
                    energy: at(Kind::SigmaEnergy),
                };
                stuck_value += self.of_energies(energies, block, &law, spreads, slopes, &mut sums);
                film.add_slopes(block, sums, slopes);
                continue;
            }
            if !block.rebounds.is_empty() {
                sums = rebound_sums(&self.rebounds, block.rebounds.clone(), &law);
                squares += sums.squares;
                sums.kept *= precision;
                sums.viscous *= precision;
                sums.dry *= precision;
            }
            if self.truncated {
                stuck_value -= self.rebound_probability(block.rebounds.clone(), &law, sigma, slopes, &mut sums);
            }
            for node in block.stuck.clone() {
                let at = self.stuck.abscissa(node);
                let (r, dry) = law.kept(&at);
                if r < certain {
                    continue;
                }
                let (mean, slope) = mean_and_slope(r);
                let z = (self.limit - mean) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                let count = self.stuck.count[node];
                stuck_value += count * ln_cdf;
                slopes[Kind::SigmaWet.slot()] -= count * mills * z / sigma;
                let kept = -count * mills / sigma * slope;
                sums.kept += kept;
                sums.viscous += kept * at.viscous;
                sums.dry += kept * dry;
            }
            film.add_slopes(block, sums, slopes);
        }
        if self.energies.is_some() {
            return stuck_value;
        }
        slopes[Kind::SigmaWet.slot()] += (squares * precision - self.wet_rebounds) / sigma;
        stuck_value - self.wet_rebounds * (sigma.ln() + LN_ROOT_TWO_PI) - 0.5 * squares * precision
    }

    /// Σ n ln P(e* > limit) over the rebounds of a block; its slopes are taken off those of σ and of the sums.
    fn rebound_probability(
        &self,
        nodes: Range<usize>,
        law: &Law,
        sigma: f64,
        slopes: &mut [f64],
        sums: &mut Sums,
    ) -> f64 {
        let mut value = 0.0;
        for node in nodes {
            let at = self.rebounds.abscissa(node);
            let (r, dry) = law.kept(&at);
            let (mean, slope) = mean_and_slope(r);
            let z = (mean - self.limit) / sigma;
            if z > CERTAIN {
                continue;
            }
            let (ln_cdf, mills) = ln_normal_cdf(z);
            let count = self.rebounds.count[node];
            value += count * ln_cdf;
            slopes[Kind::SigmaWet.slot()] += count * mills * z / sigma;
            let kept = -count * mills / sigma * slope;
            sums.kept += kept;
            sums.viscous += kept * at.viscous;
            sums.dry += kept * dry;
        }
        value
    }

    fn dry(&self, full: &[f64], slopes: &mut [f64]) -> f64 {
        let sigma = full[Kind::SigmaDry.slot()];
        let precision = 1.0 / (sigma * sigma);
        let mut value = 0.0;
        for (particle, runs) in self.dry.iter().enumerate() {
            if runs.rebounds == 0.0 && runs.stuck.is_empty() {
                continue;
            }
            let k = full[COMMON_SLOTS + particle];
            let (squares, slope) = runs.squares(self.form.dry, k);
            value -= runs.rebounds * (sigma.ln() + LN_ROOT_TWO_PI) + 0.5 * squares * precision;
            slopes[COMMON_SLOTS + particle] -= 0.5 * slope * precision;
            slopes[Kind::SigmaDry.slot()] += (squares * precision - runs.rebounds) / sigma;
            for p in &runs.logged {
                let (e_dry, fall) = e_dry(self.form.dry, k, *p);
                let z = (e_dry - self.limit) / sigma;
                if z > CERTAIN {
                    continue;
                }
                let (ln_cdf, mills) = ln_normal_cdf(z);
                value -= ln_cdf;
                slopes[COMMON_SLOTS + particle] += mills * fall / sigma;
                slopes[Kind::SigmaDry.slot()] += mills * z / sigma;
            }
            for p in &runs.stuck {
                let (e_dry, fall) = e_dry(self.form.dry, k, *p);
                let z = (self.limit - e_dry) / sigma;
                let (ln_cdf, mills) = ln_normal_cdf(z);
                value += ln_cdf;
                slopes[COMMON_SLOTS + particle] += mills * fall / sigma;
                slopes[Kind::SigmaDry.slot()] -= mills * z / sigma;
            }
        }
        value
    }
}

/// m(r) and m′(r) with two roots and one division.
#[inline(always)]
fn mean_and_slope(kept: f64) -> (f64, f64) {
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let square = kept * kept + TURN4;
    let inverse = 1.0 / (square * square.sqrt().sqrt());
    (kept * square * inverse, (0.5 * kept * kept + TURN4) * inverse)
}

/// So many numbers, one after another in memory.
type Lanes = [f64; LANES];

#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn(of)
}

fn rebound_sums(nodes: &Nodes, range: Range<usize>, law: &Law) -> Sums {
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

#[cfg(test)]
mod tests;
