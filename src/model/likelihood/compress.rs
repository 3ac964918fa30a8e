//! Replaces the rows of each block by a few nodes, as many as a bound on the log density's error asks for.
//!
//! Runs of one setting become one node exactly. Where a block has more settings than nodes, m(r) less its value at the
//! reference parameters is smooth in x = 4/St, and the block becomes the Gauss quadrature of its own settings: nodes with
//! positive counts and a mean restitution each, and the sum of squares these leave. What is expanded is the difference
//! from the reference, so that the error does not grow with the number of runs. A range of x that the nodes do not
//! describe to its share of the bound, as towards the threshold, is halved; one with few settings keeps them. Runs whose
//! films hardly any other run has are taken together, in film and speed at once (`scattered.rs`).

use std::ops::Range;

use rayon::prelude::*;

use super::compressed_block::CompressedBlock;
use super::gauss::gauss_rule;
use super::nodes::{NodeFilm, Nodes, WetBlock};
use super::prepared::Likelihood;
use super::scattered::{LawOfBlock, Scattered, Shares};
use super::sums::{rebound_sums, NodeRange};
use super::trend::{BlockLaw, FilmParameters};
use crate::model::likelihood::normal::ln_normal_cdf;
use crate::model::parameters::ParameterKind;
use crate::physics::balance::{Balance, Impact};
use crate::physics::rebound::mean_and_slope;

/// A film of fewer runs is taken together with others of its block.
const MANY: usize = 8;

/// Settings of one film that repeat are all kept up to so many.
const MOST_KEPT: usize = 256;

/// A range with no more different settings than this keeps them all.
const FEW: usize = 16;

/// Orders of quadrature that are tried in turn.
const ORDERS: [usize; 3] = [6, 9, 13];

/// What a compression did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compression {
    /// nodes of wet runs, rebounded and stuck
    pub nodes: usize,
    /// wet runs whose own setting is a node
    pub rows_exact: usize,
    /// largest error of the log density at the parameters it was tested at
    pub tested_error: f64,
}

/// What the runs of a block at one film read of a full vector.
#[derive(Debug, Clone, Copy)]
struct LawAtFilm {
    block: BlockLaw,
    balance: Balance,
    sigma: f64,
}

/// Where p comes from inside a block.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DryRoot {
    /// the same for all
    Constant(f64),
    /// this · x^(-1/5): one diameter, the run's own speed
    Falling(f64),
    /// neither, or there are shares that no parameter moves, too
    Unknown,
}

impl DryRoot {
    fn of(nodes: &Nodes) -> DryRoot {
        let (Some(x), Some(p)) = (nodes.over_stokes.first(), nodes.dry_root.first()) else {
            return DryRoot::Unknown;
        };
        if nodes.has_fixed() {
            return DryRoot::Unknown;
        }
        if nodes.dry_root.iter().all(|other| other == p) {
            return DryRoot::Constant(*p);
        }
        let factor = p * x.powf(0.2);
        let pairs = nodes.over_stokes.iter().zip(&nodes.dry_root);
        let mut same = pairs.map(|(x, p)| (p * x.powf(0.2) / factor - 1.0).abs() < 1e-12);
        if same.all(|same| same) {
            DryRoot::Falling(factor)
        } else {
            DryRoot::Unknown
        }
    }

    fn at(self, x: f64) -> Impact {
        let dry_root = match self {
            DryRoot::Constant(p) => p,
            DryRoot::Falling(factor) => factor * x.powf(-0.2),
            DryRoot::Unknown => f64::NAN,
        };
        Impact {
            over_stokes: x,
            dry_root,
            fixed: [0.0; 2],
        }
    }
}

/// Neighbouring settings of a block, with the largest error they may be replaced at.
#[derive(Clone)]
struct SettingRange<'s> {
    nodes: &'s Nodes,
    range: Range<usize>,
    root: DryRoot,
    bound: f64,
}

impl Nodes {
    /// A range of nodes as ranges of one film each.
    fn of_one_film(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut first = range.start;
        let films = self.film_ratio[range].chunk_by(|a, b| a == b);
        films.map(move |same| {
            let of_film = first..first + same.len();
            first = of_film.end;
            of_film
        })
    }
}

impl Likelihood {
    /// The same likelihood with fewer nodes, exact where each block has few settings.
    ///
    /// `reference` is a full vector near the best; the log density is off by no more than the bound at each of `tests`.
    pub fn compressed(&self, reference: &[f64], tests: &[Vec<f64>], bound: f64) -> (Likelihood, Compression) {
        // errors of regions mostly have different signs
        let loose = self.compressed_by(reference, tests, (bound, Shares::Loose));
        if loose.1.tested_error > bound {
            self.compressed_by(reference, tests, (bound, Shares::Strict))
        } else {
            loose
        }
    }

    fn compressed_by(
        &self,
        reference: &[f64],
        tests: &[Vec<f64>],
        (bound, shares): (f64, Shares),
    ) -> (Likelihood, Compression) {
        let rows = self.nodes().max(1) as f64;
        let share = |count: usize| bound * count as f64 / rows;
        let compressor = |block: &WetBlock, film: NodeFilm, rebounded: bool| -> Compressor {
            Compressor {
                about: rebounded.then(|| self.read(block, film, reference)),
                tests: tests.iter().map(|full| self.read(block, film, full)).collect(),
                limit: self.limit,
                truncated: self.truncated,
            }
        };
        let compress = |block: &WetBlock, nodes: &Nodes, range: &Range<usize>, rebounded: bool| {
            let mut all = CompressedBlock::new(tests.len());
            let mut others = vec![];
            for of_film in nodes.of_one_film(range.clone()) {
                let film = nodes.film(of_film.start);
                let bound = share(of_film.len());
                let is_done = of_film.len() >= MANY
                    && compressor(block, film, rebounded).compress(nodes, of_film.clone(), bound, &mut all);
                if !is_done {
                    others.extend(of_film);
                }
            }
            let bound = shares.of(bound, others.len() as f64 / rows);
            let settings = settings(nodes, others, &mut all.leftover);
            let of_block = |full: &[f64]| LawOfBlock {
                law: self.law(block, full, FilmParameters::new(self.form, full)),
                sigma: full[ParameterKind::SigmaWet.slot()],
            };
            let tests: Vec<LawOfBlock> = tests.iter().map(|full| of_block(full)).collect();
            let scattered = Scattered {
                reference: of_block(reference),
                rebounded,
                tests: &tests,
                limit: self.limit,
                truncated: self.truncated,
                shares,
            };
            scattered.compress(&settings, bound, &mut all);
            all
        };
        let blocks: Vec<(CompressedBlock, CompressedBlock)> = self
            .blocks
            .par_iter()
            .map(|block| {
                (
                    compress(block, &self.rebounds, &block.rebounds, true),
                    compress(block, &self.stuck, &block.stuck, false),
                )
            })
            .collect();
        let mut short = Likelihood {
            blocks: vec![],
            rebounds: Nodes::default(),
            stuck: Nodes::default(),
            ..self.clone()
        };
        let mut errors = vec![0.0; tests.len()];
        let mut rows_exact = 0;
        for (block, (rebounds, stuck)) in self.blocks.iter().zip(&blocks) {
            short.leftover += rebounds.leftover;
            rows_exact += rebounds.rows_exact + stuck.rows_exact;
            for (sum, (a, b)) in errors.iter_mut().zip(rebounds.errors.iter().zip(&stuck.errors)) {
                *sum += a + b;
            }
            short.blocks.push(WetBlock {
                rebounds: short.rebounds.append(&rebounds.nodes),
                stuck: short.stuck.append(&stuck.nodes),
                ..block.clone()
            });
        }
        let compression = Compression {
            nodes: short.nodes(),
            rows_exact,
            tested_error: errors.into_iter().map(f64::abs).fold(0.0, f64::max),
        };
        (short, compression)
    }

    fn read(&self, block: &WetBlock, film: NodeFilm, full: &[f64]) -> LawAtFilm {
        let law = self.law(block, full, FilmParameters::new(self.form, full));
        LawAtFilm {
            block: law,
            balance: law.at(film).balance,
            sigma: full[ParameterKind::SigmaWet.slot()],
        }
    }
}

impl LawAtFilm {
    fn mean(&self, at: &Impact) -> f64 {
        mean_and_slope(self.balance.kept(at).0).0
    }
}

/// The different settings of some rows, sorted by film and x, with their counts and mean restitutions.
fn settings(rows: &Nodes, mut order: Vec<usize>, leftover: &mut f64) -> Nodes {
    let key = |row: usize| (rows.impact(row), rows.film_ratio[row]);
    let compare = |a: &usize, b: &usize| {
        let (one, other) = (key(*a), key(*b));
        let of = |(at, film): (Impact, f64)| [film, at.over_stokes, at.dry_root, at.fixed[0]];
        let pairs = of(one).into_iter().zip(of(other));
        let mut orders = pairs.map(|(a, b)| a.total_cmp(&b));
        orders.find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    if !order.is_sorted_by(|a, b| compare(a, b).is_le()) {
        order.sort_by(compare);
    }
    let mut settings = Nodes::default();
    for same in order.chunk_by(|a, b| key(*a) == key(*b)) {
        let count: f64 = same.iter().map(|row| rows.count[*row]).sum();
        let mean = same
            .iter()
            .map(|row| rows.count[*row] * rows.restitution[*row])
            .sum::<f64>()
            / count;
        let squares = same
            .iter()
            .map(|row| rows.count[*row] * (rows.restitution[*row] - mean).powi(2));
        *leftover += squares.sum::<f64>();
        settings.push(rows.impact(same[0]), rows.film(same[0]), rows.has_fixed(), mean, count);
    }
    settings
}

/// Whether a film keeps its settings: where they are those of a few diameters at a few speeds, or of many that repeat.
fn keeps(settings: usize, runs: usize) -> bool {
    /// settings that a design has at one film
    const OF_A_DESIGN: usize = 48;
    /// runs a setting where they repeat
    const REPEATED: usize = 2;
    let repeat = settings <= MOST_KEPT && REPEATED * settings <= runs;
    settings <= OF_A_DESIGN || repeat
}

/// Compresses the rebounds, or the stuck runs, of one block at one film.
struct Compressor {
    /// the reference, for rebounds; `None` for stuck runs
    about: Option<LawAtFilm>,
    tests: Vec<LawAtFilm>,
    limit: f64,
    truncated: bool,
}

impl Compressor {
    /// Adds what stands for the runs of a film; `false` and nothing where these differ in more than x.
    fn compress(&self, rows: &Nodes, range: Range<usize>, bound: f64, to: &mut CompressedBlock) -> bool {
        let runs = range.len();
        let mut leftover = 0.0;
        let settings = settings(rows, range.collect(), &mut leftover);
        let is_kept = keeps(settings.len(), runs);
        let root = DryRoot::of(&settings);
        if !is_kept && root == DryRoot::Unknown {
            return false;
        }
        to.leftover += leftover;
        if is_kept {
            to.keep(&settings);
        } else {
            let all = SettingRange {
                nodes: &settings,
                range: 0..settings.len(),
                root,
                bound,
            };
            self.split(all, to);
        }
        true
    }

    fn split(&self, settings: SettingRange, block: &mut CompressedBlock) {
        let SettingRange {
            nodes, range, bound, ..
        } = settings.clone();
        if range.len() > FEW {
            if ORDERS.iter().any(|order| self.try_order(&settings, *order, block)) {
                return;
            }
            let x = &nodes.over_stokes[range.clone()];
            let middle = 0.5 * (x[0] + x[x.len() - 1]);
            let inside = x.partition_point(|x| *x <= middle).clamp(1, x.len() - 1);
            let cut = range.start + inside;
            let whole: f64 = nodes.count[range.clone()].iter().sum();
            for side in [range.start..cut, cut..range.end] {
                let runs: f64 = nodes.count[side.clone()].iter().sum();
                let half = SettingRange {
                    range: side,
                    bound: bound * runs / whole,
                    ..settings.clone()
                };
                self.split(half, block);
            }
            return;
        }
        let kept: Vec<usize> = range.collect();
        block.keep(&nodes.some(&kept));
    }

    /// Takes the rule of an order if it keeps the bound at every test.
    fn try_order(&self, settings: &SettingRange, order: usize, block: &mut CompressedBlock) -> bool {
        let SettingRange {
            nodes,
            range,
            root,
            bound,
        } = settings;
        let (x, count) = (&nodes.over_stokes[range.clone()], &nodes.count[range.clone()]);
        let about = |at: &Impact| self.about.map_or(0.0, |reference| reference.mean(at));
        let distances: Vec<f64> = range
            .clone()
            .map(|i| nodes.restitution[i] - about(&nodes.impact(i)))
            .collect();
        let Some(rule) = gauss_rule(x, count, &distances, order) else {
            return false;
        };
        let mut short = Nodes::default();
        for ((x, weight), value) in rule.nodes.iter().zip(&rule.weights).zip(&rule.values) {
            let at = root.at(*x);
            short.push(at, nodes.film(range.start), false, about(&at) + value, *weight);
        }
        let total: f64 = count.iter().zip(&distances).map(|(n, d)| n * d * d).sum();
        let leftover = (total - rule.explained).max(0.0);
        let mut errors = vec![];
        for at in &self.tests {
            let error = self.error(at, settings, &short, leftover);
            if error.is_nan() || error.abs() > *bound {
                return false;
            }
            errors.push(error);
        }
        block.add(&short, if self.about.is_some() { leftover } else { 0.0 }, &errors);
        true
    }

    /// Error of the log density where a few nodes, with the sum of squares they leave, stand for some settings.
    fn error(&self, at: &LawAtFilm, settings: &SettingRange, short: &Nodes, leftover: f64) -> f64 {
        let (nodes, range) = (settings.nodes, &settings.range);
        if self.about.is_none() {
            return self.stuck(at, short, 0..short.len()) - self.stuck(at, nodes, range.clone());
        }
        let squares = |nodes: &Nodes, range| {
            let range = NodeRange {
                nodes: range,
                law: at.block,
            };
            let sums = rebound_sums(nodes, at.balance.order, None, &[range]);
            sums.iter().map(|sums| sums.squares).sum::<f64>()
        };
        let gap = squares(short, 0..short.len()) + leftover - squares(nodes, range.clone());
        let rebound = |nodes: &Nodes, range| {
            if self.truncated {
                self.rebound_probability(at, nodes, range)
            } else {
                0.0
            }
        };
        -0.5 * gap / (at.sigma * at.sigma) - rebound(short, 0..short.len()) + rebound(nodes, range.clone())
    }

    fn rebound_probability(&self, at: &LawAtFilm, nodes: &Nodes, range: Range<usize>) -> f64 {
        let each = range.map(|i| {
            let mean = at.mean(&nodes.impact(i));
            nodes.count[i] * ln_normal_cdf((mean - self.limit) / at.sigma).0
        });
        each.sum()
    }

    fn stuck(&self, at: &LawAtFilm, nodes: &Nodes, range: Range<usize>) -> f64 {
        let each = range.map(|i| {
            let mean = at.mean(&nodes.impact(i));
            nodes.count[i] * ln_normal_cdf((self.limit - mean) / at.sigma).0
        });
        each.sum()
    }
}
