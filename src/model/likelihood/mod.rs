//! Computes the log likelihood of all runs at once and its slopes, from rows or from the few nodes that stand for them.
//!
//! The generative statement: a wet run's e* = m(r) + σ_wet z, a dry run's e* = e_dry(v) + σ_dry z; the run stuck if e* is
//! at or below the limit; where such runs were not logged, a rebound's density is that of runs that rebound. A node is a
//! setting with a count and a mean restitution: a row is a node of count 1, and a compressed series has few nodes and a
//! leftover sum of squares, so that rows and nodes share one evaluation. Where z has Student's tails, or runs have errors
//! of their own, or noise acts on the energy kept, `by_row.rs` takes a run at a time.
//!
//! Symbols: r = e_dry² − C ρ̃ g(δ̃) − L x − b with x = 4/St and b = κ/v², as far as the form holds them, and e_dry = 1 − k p
//! (+ (3/5) k² p² to second order) with p = v^(1/5) at the dry speed in use. A trend with the film ratio stands in L and C:
//! L + L′ f and C exp(C′ f), f being the logarithm of the film ratio over the middle one of the runs.

mod by_row;
mod compress;
mod dry;
mod gauss;
pub mod normal;
pub mod pointwise;
mod rows;
mod student;
mod sums;
pub mod tails;
mod trend;

pub use by_row::on_energies;
pub use compress::{Compression, Resolution};

use std::ops::Range;

use self::by_row::{ByRow, Errors, Spreads};
use self::dry::DryRuns;
use self::normal::ln_normal_cdf;
use self::sums::{rebound_sums, Piece, Sums};
use self::tails::Tails;
use self::trend::{Film, OfFilm};
use super::parameters::{Kind, COMMON_SLOTS};
use crate::distributions::LN_ROOT_TWO_PI;
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
    /// whether e_dry is that of the run's own speed
    own_speed: bool,
    k: f64,
    /// C ρ̃ g(δ̃)
    inertial: f64,
    l: f64,
}

impl Law {
    /// That of a dry run, but for its k.
    const DRY: Law = Law {
        order: Order::First,
        own_speed: true,
        k: f64::NAN,
        inertial: 0.0,
        l: 0.0,
    };

    /// r, and its slope in k over −2: e_dry times that of −e_dry.
    fn kept(&self, at: &Abscissa) -> (f64, f64) {
        let (e_dry, fall) = e_dry(self.order, self.k, at.dry_power);
        let lost = self.inertial + self.l * at.viscous + at.bridge.unwrap_or(0.0);
        (e_dry * e_dry - lost, e_dry * fall)
    }

    /// e_dry, its slope in −k, and that slope's slope in k.
    fn dry(&self, p: f64) -> (f64, f64, f64) {
        let (e_dry, fall) = e_dry(self.order, self.k, p);
        let bend = match self.order {
            Order::First => 0.0,
            Order::Second => -2.0 * SECOND_ORDER * p * p,
        };
        (e_dry, fall, bend)
    }

    /// dr/dv at a slowness 1/v, and its slope in k; with p ∝ v^(1/5), x ∝ 1/v and b ∝ 1/v².
    fn by_speed(&self, at: &Abscissa, slowness: f64) -> (f64, f64) {
        let viscous = self.l * at.viscous + 2.0 * at.bridge.unwrap_or(0.0);
        if !self.own_speed {
            return (viscous * slowness, 0.0);
        }
        let (e_dry, fall, bend) = self.dry(at.dry_power);
        let dry = -0.4 * e_dry * fall * self.k;
        let of_k = -0.4 * (e_dry * fall + self.k * (e_dry * bend - fall * fall));
        ((viscous + dry) * slowness, of_k * slowness)
    }

    /// r and dr/dv; the second 0 for a run whose speed does not err.
    fn kept_and_by_speed(&self, at: &Abscissa, errors: Errors) -> (f64, f64) {
        let by_speed = if errors.speed > 0.0 {
            self.by_speed(at, errors.slowness).0
        } else {
            0.0
        };
        (self.kept(at).0, by_speed)
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

/// A dry run by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DryRow {
    particle: usize,
    /// p
    dry_power: f64,
    /// e; `None` where it stuck
    restitution: Option<f64>,
    errors: Errors,
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
    /// what runs have of their own, where they are taken one at a time
    own: Option<ByRow>,
    /// wet runs that rebounded
    wet_rebounds: f64,
    /// what the nodes leave of the wet rebounds' sum of squares
    leftover: f64,
    dry: Vec<DryRuns>,
}

/// The parameters give no density here: not an error, a place to turn back from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutsideDomain;

/// A stuck run this many σ below the limit stuck for certain: ln Φ(9) is −1e-19.
const CERTAIN: f64 = 9.0;

impl Likelihood {
    /// Whether the likelihood is one of rows and cannot be compressed, because runs have spreads or tails of their own.
    pub fn needs_rows(&self) -> bool {
        self.own.is_some()
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

    /// The law of a block at a full vector of parameters, which `film` has read.
    fn law(&self, block: &Block, full: &[f64], film: &Film) -> Law {
        film.law(self.form, full[COMMON_SLOTS + block.particle], block.density_ratio)
    }

    /// The tails of noise at a full vector of parameters.
    fn tails(&self, full: &[f64]) -> Tails {
        let student = self.own.as_ref().is_some_and(|own| own.student);
        Tails::of(student.then(|| full[Kind::Nu.slot()]))
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
        let tails = self.tails(full);
        let spreads = Spreads {
            sigma,
            energy: at(Kind::SigmaEnergy),
        };
        let films: Vec<Film> = (0..self.film_ratios.len()).map(|film| self.film(film, full)).collect();
        let mut of_films = vec![OfFilm::default(); films.len()];
        let add_slopes = |of_films: Vec<OfFilm>, slopes: &mut [f64]| {
            for (film, sums) in films.iter().zip(of_films) {
                film.add_slopes(sums, slopes);
            }
        };
        let law = |block: &Block| self.law(block, full, &films[block.film]);
        let piece = |block: &Block| (block.rebounds.clone(), law(block));
        let pieces: Vec<Piece> = self.blocks.iter().map(piece).collect();
        if let Some(own) = &self.own {
            let heavy = tails.heavy(sigma).filter(|_| !self.truncated && own.spreads_are_one());
            let all_sums = heavy.map(|heavy| rebound_sums(&self.rebounds, self.form.dry, Some(heavy), &pieces));
            for (place, (block, (rebounds, law))) in self.blocks.iter().zip(&pieces).enumerate() {
                let mut sums = Sums::default();
                let mut one_by_one = rebounds.clone();
                if let Some(all_sums) = &all_sums {
                    sums = all_sums[place];
                    let (value, of_sigma, of_nu, of_distance) = tails.of_sums(sums, rebounds.len(), sigma);
                    stuck_value += value;
                    slopes[Kind::SigmaWet.slot()] += of_sigma;
                    slopes[Kind::Nu.slot()] += of_nu;
                    for sum in [&mut sums.kept, &mut sums.viscous, &mut sums.dry] {
                        *sum *= of_distance;
                    }
                    one_by_one = rebounds.end..rebounds.end;
                }
                let nodes = (one_by_one, block.stuck.clone());
                stuck_value += self.one_by_one(own, nodes, law, (tails, spreads), slopes, &mut sums);
                of_films[block.film].add(block, sums, slopes);
            }
            add_slopes(of_films, slopes);
            return stuck_value;
        }
        let all_sums = rebound_sums(&self.rebounds, self.form.dry, None, &pieces);
        for ((block, (_, law)), mut sums) in self.blocks.iter().zip(&pieces).zip(all_sums) {
            squares += sums.squares;
            sums.kept *= precision;
            sums.viscous *= precision;
            sums.dry *= precision;
            if self.truncated {
                stuck_value -= self.rebound_probability(block.rebounds.clone(), law, sigma, slopes, &mut sums);
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
            of_films[block.film].add(block, sums, slopes);
        }
        add_slopes(of_films, slopes);
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
}

/// m(r) and m′(r) with two roots and one division.
#[inline(always)]
fn mean_and_slope(kept: f64) -> (f64, f64) {
    const TURN4: f64 = TURN * TURN * TURN * TURN;
    let square = kept * kept + TURN4;
    let inverse = 1.0 / (square * square.sqrt().sqrt());
    (kept * square * inverse, (0.5 * kept * kept + TURN4) * inverse)
}

#[cfg(test)]
mod tests;
