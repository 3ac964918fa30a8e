//! Resamples the runs and fits every law to each replicate.
//!
//! Strata are particle × liquid × diameter × film ratio (dry: particle × diameter), and inside these the impact speed.
//! From n runs of a stratum n − 1 are drawn, each with the weight n/(n − 1), which keeps the variance of small strata
//! unbiased. A replicate has a random stream of its own, or where runs are drawn inside strata its own stretch of one, so
//! that neither the number of threads nor the number of replicates moves any of them. Draws are counted or summed, never
//! stored beyond their replicate.
//!
//! | file | job |
//! |---|---|
//! | `wide.rs` | runs loops in the widest registers that the machine has |
//! | `kernel.rs` | fits a law to weighted runs in one stream over them |
//! | `target.rs` | describes the fits and how their runs are divided |
//! | `strata.rs` | divides the runs of a series by impact speed |
//! | `multisets.rs` | lists the multisets of members that a batch of draws can give |
//! | `batches.rs` | draws the runs of every stratum in batches |
//! | `lines.rs` | fits lines straight from what was drawn |
//! | `nodes.rs` | gathers runs that share stratum and abscissa |
//! | `schemes.rs` | draws whole series |
//! | `replicated.rs` | keeps the replicates |
//! | `jackknife.rs` | leaves out one run at a time: acceleration and degrees of freedom |
//! | `sandwich.rs` | the covariance of replicates without any, of many runs |
//! | `hanging.rs` | replicates of a fit of many runs that hangs on a few |
//! | `intervals.rs` | percentile and BCa intervals from replicates |

mod batches;
mod hanging;
pub mod intervals;
pub mod jackknife;
pub mod kernel;
mod lines;
mod multisets;
mod nodes;
mod replicated;
pub mod sandwich;
mod schemes;
pub mod strata;
mod target;
mod wide;

pub use replicated::Replicated;
pub use target::{Pool, RunWeights, Target};

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rayon::prelude::*;

use crate::ranks::Shares;
use crate::scene::ResamplingScheme;
use crate::seed::Streams;
use batches::{write_weights, Batches, TOGETHER};
use hanging::Hanging;
use kernel::Failure;
use nodes::{DrawnNodes, StrataNodes};
use replicated::Block;
use sandwich::{normal_replicates, sandwich};
use schemes::draw_series;
use target::solve;

/// How replicates are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// replicates
    pub replicates: usize,
    /// what is resampled
    pub scheme: ResamplingScheme,
    /// seed of the streams
    pub seed: u64,
}

/// One thread's working space.
struct Scratch {
    weights: Vec<f64>,
    drawn: Option<DrawnNodes>,
}

/// Every replicate of every target, of which others make their shares. `done` is called with the number of replicates just
/// finished.
///
/// A target with a single series has no replicates where series are resampled.
pub fn replicate<S: Shares>(
    pool: &Pool,
    targets: &[Target],
    plan: Plan,
    shares: &S,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Replicated, S::Error> {
    let most = targets
        .iter()
        .map(|target| target.regression.x.len())
        .max()
        .unwrap_or(0);
    let alike = targets.iter().all(|target| target.run_weights.is_none());
    let replication = Replication {
        pool,
        targets,
        nodes: (plan.scheme == ResamplingScheme::Cases && alike).then(|| StrataNodes::new(pool, targets)),
        batches: (plan.scheme == ResamplingScheme::Cases && !alike).then(|| Batches::new(&pool.strata)),
        cases: Streams::new(plan.seed, CASES),
        streams: Streams::new(plan.seed, "bootstrap"),
    };
    let mut made = Replicated::room(targets.len(), plan.replicates);
    let blocks = made.count_of_blocks();
    let mut is_own = vec![false; blocks as usize];
    shares
        .own(blocks)
        .iter()
        .for_each(|block| is_own[*block as usize] = true);
    let made_here = AtomicUsize::new(0);
    made.blocks().filter(|block| is_own[block.number]).for_each_init(
        || Scratch {
            weights: vec![0.0; most],
            drawn: replication.nodes.as_ref().map(StrataNodes::room),
        },
        |scratch, mut block| {
            replication.draw(scratch, &mut block);
            made_here.fetch_add(block.replicates, Relaxed);
            done(block.replicates);
        },
    );
    if shares.count() > 1 {
        made.put_together(shares)?;
        done(plan.replicates - made_here.into_inner().min(plan.replicates));
    }
    Ok(made)
}

/// The same of fits to very many runs: where a fit has a [`sandwich()`] its replicates are normal, where it hangs on a few runs
/// these are drawn, and where it has few all are.
pub fn replicate_many<S: Shares>(
    pool: &Pool,
    targets: &[Target],
    plan: Plan,
    shares: &S,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Replicated, S::Error> {
    let streams = Streams::new(plan.seed, "bootstrap of many runs");
    let made: Vec<Option<Vec<_>>> = targets
        .par_iter()
        .enumerate()
        .map(|(number, target)| {
            let rng = streams.at(number as u64);
            match sandwich(pool, target) {
                Some(covariance) => Some(normal_replicates(target.fitted, covariance, plan.replicates, rng)),
                None => Hanging::new(pool, target).map(|hanging| hanging.replicates(plan.replicates, rng)),
            }
        })
        .collect();
    let by_rows = targets.iter().zip(&made).filter(|(_, made)| made.is_none());
    let by_rows: Vec<Target> = by_rows.map(|(target, _)| target.clone()).collect();
    let (own_pool, by_rows) = pool.of_targets(&by_rows);
    let drawn = replicate(&own_pool, &by_rows, plan, shares, done)?;
    let mut rows = (0..by_rows.len()).map(|row| drawn.results(row));
    let each = made.into_iter().filter_map(|made| made.or_else(|| rows.next()));
    Ok(Replicated::from_targets(&each.collect::<Vec<_>>(), plan.replicates))
}

/// The name of the stream of which a replicate of [`ResamplingScheme::Cases`] has its own stretch.
const CASES: &str = "bootstrap cases";

/// Weights of all runs of a pool in one replicate of [`ResamplingScheme::Cases`], for fits other than those made here.
pub fn weights(pool: &Pool, seed: u64, number: u64) -> Vec<f64> {
    drawn_weights(&Batches::new(&pool.strata), pool, &Streams::new(seed, CASES), number)
}

fn drawn_weights(batches: &Batches, pool: &Pool, cases: &Streams, number: u64) -> Vec<f64> {
    let mut drawn = batches.room::<1>();
    batches.draw(&mut cases.stretch(number, batches.words()), &mut drawn);
    let mut weights = vec![0.0; pool.strata.last().map_or(0, |stratum| stratum.end)];
    for (stratum, of_stratum) in pool.strata.iter().zip(&batches.strata) {
        write_weights(
            batches.drawn(of_stratum.clone(), &drawn, 0),
            &mut weights[stratum.clone()],
        );
    }
    weights
}

/// What every replicate is drawn from.
struct Replication<'a> {
    pool: &'a Pool,
    targets: &'a [Target<'a>],
    /// runs drawn inside strata
    nodes: Option<StrataNodes>,
    /// the same where runs of one abscissa weigh differently, and are no node
    batches: Option<Batches>,
    /// stream of [`ResamplingScheme::Cases`], of which each replicate has a stretch
    cases: Streams,
    /// streams of [`ResamplingScheme::Series`], one a replicate
    streams: Streams,
}

impl Replication<'_> {
    fn draw(&self, scratch: &mut Scratch, block: &mut Block) {
        let Scratch { weights, drawn } = scratch;
        if let (Some(nodes), Some(drawn)) = (&self.nodes, drawn) {
            let mut rng = self.cases.stretch(block.first, nodes.words());
            for start in (0..block.replicates).step_by(TOGETHER) {
                let together = start..block.replicates.min(start + TOGETHER);
                nodes.draw(&mut rng, drawn);
                for (target, column) in nodes.columns.iter().enumerate() {
                    if let Some(lines) = &column.lines {
                        for (replicate, fit) in together.clone().zip(&lines.fit(drawn.of_batch())) {
                            block.put(target, replicate, fit.finite());
                        }
                    }
                }
                if nodes.by_lines() {
                    continue;
                }
                for (lane, replicate) in together.enumerate() {
                    nodes.gather(lane, drawn);
                    for (number, (target, column)) in self.targets.iter().zip(&nodes.columns).enumerate() {
                        if column.lines.is_none() {
                            let fit = kernel::fit(target.regression.law, &drawn.sample(column), target.fitted);
                            block.put(number, replicate, fit);
                        }
                    }
                }
            }
            return;
        }
        if let Some(batches) = &self.batches {
            for replicate in 0..block.replicates {
                let weights = drawn_weights(batches, self.pool, &self.cases, block.first + replicate as u64);
                for (number, target) in self.targets.iter().enumerate() {
                    let first = self.pool.first_run(target);
                    let weights = &weights[first..first + target.regression.x.len()];
                    block.put(number, replicate, solve(target, target.regression.restitution, weights));
                }
            }
            return;
        }
        for replicate in 0..block.replicates {
            let mut rng = self.streams.at(block.first + replicate as u64);
            for (number, target) in self.targets.iter().enumerate() {
                let fit = if target.series.len() > 1 {
                    let weights = &mut weights[..target.regression.x.len()];
                    let series = &self.pool.series[target.series.clone()];
                    draw_series(&mut rng, series, self.pool.first_run(target), weights);
                    solve(target, target.regression.restitution, weights)
                } else {
                    Err(Failure::OneSeries)
                };
                block.put(number, replicate, fit);
            }
        }
    }
}
