//! Replaces the rows of each block by a few nodes, as many as a bound on the log density's error asks for.
//!
//! Runs of one setting become one node exactly. Where a film has more settings than a design has, a few of them stand for
//! all (`scattered.rs`); films that hardly any other run has are taken together, in film and speed at once.

use std::ops::Range;

use rayon::prelude::*;

use super::compressed_block::CompressedBlock;
use super::nodes::{Nodes, WetBlock};
use super::prepared::Likelihood;
use super::scattered::{LawOfBlock, Scattered, Shares};
use super::trend::FilmParameters;
use crate::model::parameters::ParameterKind;
use crate::physics::balance::Impact;

/// A film of fewer runs is taken together with others of its block.
const MANY: usize = 8;

/// Settings of one film that repeat are all kept up to so many.
const MOST_KEPT: usize = 256;

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
        let compress = |block: &WetBlock, nodes: &Nodes, range: &Range<usize>, rebounded: bool| {
            let mut all = CompressedBlock::new(tests.len());
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
            let of_share = |shares: Shares, runs: usize| shares.of(bound, runs as f64 / rows);
            // of few films the errors need not differ in sign
            let by_film = Scattered {
                shares: Shares::Strict,
                ..scattered
            };
            let mut others = vec![];
            for of_film in nodes.of_one_film(range.clone()) {
                let runs = of_film.len();
                if runs < MANY {
                    others.extend(of_film);
                    continue;
                }
                let settings = settings(nodes, of_film.collect(), &mut all.leftover);
                if keeps(settings.len(), runs) {
                    all.keep(&settings);
                } else {
                    by_film.compress(&settings, of_share(Shares::Strict, runs), &mut all);
                }
            }
            let bound = of_share(shares, others.len());
            let settings = settings(nodes, others, &mut all.leftover);
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
