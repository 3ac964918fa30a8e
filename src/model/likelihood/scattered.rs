//! Replaces runs of a block that scatter in speed and film by a few of them.
//!
//! m(r) less its value at the reference parameters is smooth in x = 4/St and δ̃, and in whatever else differs between the
//! runs. Where it is a polynomial of degree D in these, the sum of squares about it asks for the moments of the settings up
//! to degree 2D, which a few of the settings have with counts of their own (`condensing`), and for the nearest
//! polynomial to the runs' distances from the reference; what that leaves of their squares is left over. A region whose log
//! density so comes out beyond its share of the bound, as towards the threshold, is halved; one of few settings keeps them.

use super::compressed_block::CompressedBlock;
use super::nodes::Nodes;
use super::normal::ln_normal_cdf;
use super::sums::{kept_of_nodes, rebound_sums, NodeRange};
use super::trend::BlockLaw;
use crate::condensing::nearest::Nearest;
use crate::condensing::polynomials::{functions, Axis, Polynomials};
use crate::condensing::recombination::recombine;
use crate::physics::rebound::mean_restitution;

/// A region with fewer settings keeps them.
const FEW: usize = 16;

/// Degrees D that are tried in turn.
const DEGREES: [usize; 5] = [1, 2, 3, 4, 5];

/// What a block reads of a full vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct LawOfBlock {
    pub law: BlockLaw,
    pub sigma: f64,
}

impl LawOfBlock {
    /// m(r) of each node.
    fn means(&self, nodes: &Nodes) -> Vec<f64> {
        let range = NodeRange {
            nodes: 0..nodes.len(),
            law: self.law,
        };
        let kept = kept_of_nodes(nodes, self.law.films.form.dry, &range);
        kept.into_iter().map(mean_restitution).collect()
    }
}

/// How much of a bound a region may err by.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shares {
    /// its share of the runs: all together keep the bound
    Strict,
    /// the root of that: all together keep it where their signs differ, which has to be looked at
    Loose,
}

impl Shares {
    /// Of a bound, for a region with this share of the runs.
    pub fn of(self, bound: f64, share: f64) -> f64 {
        match self {
            Shares::Strict => bound * share,
            Shares::Loose => bound * share.sqrt(),
        }
    }
}

/// Compresses the rebounds, or the stuck runs, of one block.
#[derive(Clone, Copy)]
pub(super) struct Scattered<'t> {
    pub reference: LawOfBlock,
    pub rebounded: bool,
    pub tests: &'t [LawOfBlock],
    pub limit: f64,
    pub truncated: bool,
    pub shares: Shares,
}

impl Scattered<'_> {
    /// Adds what stands for some settings; the log density may be off by the bound.
    pub fn compress(&self, settings: &Nodes, bound: f64, to: &mut CompressedBlock) {
        if settings.len() >= FEW {
            let region = Region::of(settings);
            let exact: Vec<f64> = self.tests.iter().map(|at| self.ln_density(at, settings, 0.0)).collect();
            if DEGREES
                .into_iter()
                .any(|degree| self.try_degree(&region, degree, (&exact, bound), to))
            {
                return;
            }
            if let Some(halves) = region.halves(&self.reference.means(settings)) {
                let whole: f64 = settings.count.iter().sum();
                for half in halves {
                    let share = half.count.iter().sum::<f64>() / whole;
                    self.compress(&half, self.shares.of(bound, share), to);
                }
                return;
            }
        }
        to.keep(settings);
    }

    /// Takes the nodes of a degree if they keep the bound at every test.
    fn try_degree(
        &self,
        region: &Region,
        degree: usize,
        (exact, bound): (&[f64], f64),
        to: &mut CompressedBlock,
    ) -> bool {
        let settings = region.settings;
        let of_degree = |degree: usize| functions(region.axes.len(), degree);
        let functions = of_degree(2 * degree);
        // a first look, without points to keep the bound at, is no finer than this
        let is_wanted = !self.tests.is_empty() || degree == 3 || of_degree(2 * degree + 2) * 2 > settings.len();
        if !is_wanted || 2 * functions > settings.len() {
            return false;
        }
        let kept = recombine(&settings.count, &Polynomials::new(&region.axes, 2 * degree));
        let mut short = Nodes::default();
        for (place, weight) in &kept {
            short.push(
                settings.impact(*place),
                settings.film(*place),
                settings.has_fixed(),
                0.0,
                *weight,
            );
        }
        let mut leftover = 0.0;
        if self.rebounded {
            let means = self.reference.means(settings);
            let distances: Vec<f64> = settings.restitution.iter().zip(&means).map(|(e, m)| e - m).collect();
            let polynomials = Polynomials::new(&region.axes, degree);
            let Some(nearest) = Nearest::new(&polynomials, &kept, &settings.count, &distances) else {
                return false;
            };
            leftover = nearest.leftover;
            let places = || kept.iter().map(|(place, _)| *place);
            let each = places().zip(nearest.at(&polynomials, places()));
            for (e, (place, value)) in short.restitution.iter_mut().zip(each) {
                *e = means[place] + value;
            }
        }
        let mut errors = vec![];
        for (at, exact) in self.tests.iter().zip(exact) {
            let error = self.ln_density(at, &short, leftover) - exact;
            if error.is_nan() || error.abs() > bound {
                return false;
            }
            errors.push(error);
        }
        to.add(&short, leftover, &errors);
        true
    }

    /// The log density of some nodes without what does not move with r.
    fn ln_density(&self, at: &LawOfBlock, nodes: &Nodes, leftover: f64) -> f64 {
        let on = |sign: f64| -> f64 {
            let means = at.means(nodes).into_iter().zip(&nodes.count);
            let each = means.map(|(mean, count)| count * ln_normal_cdf(sign * (self.limit - mean) / at.sigma).0);
            each.sum()
        };
        if !self.rebounded {
            return on(1.0);
        }
        let range = NodeRange {
            nodes: 0..nodes.len(),
            law: at.law,
        };
        let sums = rebound_sums(nodes, at.law.films.form.dry, None, &[range]);
        let squares = leftover + sums.iter().map(|sums| sums.squares).sum::<f64>();
        let logged = if self.truncated { on(-1.0) } else { 0.0 };
        -0.5 * squares / (at.sigma * at.sigma) - logged
    }
}

/// Settings with what differs between them, each on a range of its own from −1 to 1.
struct Region<'n> {
    settings: &'n Nodes,
    axes: Vec<Axis<'n>>,
}

impl<'n> Region<'n> {
    fn of(settings: &'n Nodes) -> Region<'n> {
        /// what differs by rounding
        const ROUNDING: f64 = 1e-9;
        // in one diameter p follows x
        let ratio = |place: usize| settings.dry_root[place] * settings.over_stokes[place].powf(0.2);
        let first = ratio(0);
        let follows = (0..settings.len()).all(|place| (ratio(place) / first - 1.0).abs() < ROUNDING);
        let own_root: &[f64] = if follows { &[] } else { &settings.dry_root };
        let columns = [&settings.over_stokes, &settings.film_ratio, own_root, &settings.fixed];
        Region {
            settings,
            axes: columns.into_iter().filter_map(Axis::new).collect(),
        }
    }

    /// The settings on both sides of the middle of the axis along which these means differ most.
    fn halves(&self, means: &[f64]) -> Option<[Nodes; 2]> {
        let average = means.iter().sum::<f64>() / means.len() as f64;
        let along = |axis: &&Axis| -> f64 {
            let (mut cross, mut square) = (0.0, 0.0);
            for (place, mean) in means.iter().enumerate() {
                let t = axis.at(place);
                cross += t * (mean - average);
                square += t * t;
            }
            (cross / square).abs()
        };
        let longest = self.axes.iter().max_by(|a, b| along(a).total_cmp(&along(b)))?;
        let (low, high): (Vec<usize>, Vec<usize>) = (0..means.len()).partition(|place| longest.at(*place) <= 0.0);
        if low.is_empty() || high.is_empty() {
            return None;
        }
        Some([low, high].map(|places| self.settings.some(&places)))
    }
}
