//! Keeps the replicates of all targets, in the order in which they are made.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::kernel::{Failure, WeightedFit};
use crate::ranks::Shares;

/// Replicates handled by one thread at a time, a multiple of those drawn together.
const BLOCK: usize = 64;

/// Every replicate of every target: parameters and covariance, or NaN and the reason where a replicate has no fit.
#[derive(Debug, Clone)]
pub struct Replicated {
    targets: usize,
    replicates: usize,
    /// a block after another, in which one target's replicates follow another's
    fits: Vec<Numbers>,
    failures: Vec<Option<Failure>>,
}

/// Parameters and covariance. Plain numbers: memory for them comes as zeros, where filling it with fits that are none
/// would take a tenth of the time that the fits take.
type Numbers = [f64; 5];

impl Replicated {
    /// Room for so many of each of some targets.
    pub(super) fn room(targets: usize, replicates: usize) -> Replicated {
        let all = targets * replicates;
        Replicated {
            targets,
            replicates,
            fits: vec![[0.0; 5]; all],
            failures: vec![None; all],
        }
    }

    /// Replicates of each of some targets, so many of each.
    pub(super) fn from_targets(targets: &[Vec<Result<WeightedFit, Failure>>], replicates: usize) -> Replicated {
        let mut made = Replicated::room(targets.len(), replicates);
        made.blocks().for_each(|mut block| {
            let first = block.first as usize;
            for (target, of_target) in targets.iter().enumerate() {
                for replicate in 0..block.replicates {
                    block.put(target, replicate, of_target[first + replicate]);
                }
            }
        });
        made
    }

    /// The replicates of one target, in order, or why one has no fit.
    pub(super) fn results(&self, target: usize) -> Vec<Result<WeightedFit, Failure>> {
        let each = self.of(target).zip(self.failures(target));
        each.map(|(fit, failure)| failure.map_or(Ok(fit), Err)).collect()
    }

    /// The room, in blocks to be filled by any thread.
    pub(super) fn blocks(&mut self) -> impl IndexedParallelIterator<Item = Block<'_>> {
        let targets = self.targets.max(1);
        let fits = self.fits.par_chunks_mut(BLOCK * targets);
        let blocks = fits.zip(self.failures.par_chunks_mut(BLOCK * targets)).enumerate();
        blocks.map(move |(block, (fits, failures))| Block {
            number: block,
            first: (block * BLOCK) as u64,
            replicates: fits.len() / targets,
            fits,
            failures,
        })
    }

    /// How many blocks there are.
    pub(super) fn count_of_blocks(&self) -> u64 {
        if self.targets == 0 {
            return 0;
        }
        self.replicates.div_ceil(BLOCK) as u64
    }

    /// Takes in the blocks that others have filled.
    pub(super) fn put_together<S: Shares>(&mut self, shares: &S) -> Result<(), S::Error> {
        /// fits that are exchanged at once: some hundred megabytes
        const AT_ONCE: usize = 1 << 21;
        let length = BLOCK * self.targets.max(1);
        let end = self.fits.len();
        let places = |block: u64| block as usize * length..((block as usize + 1) * length).min(end);
        let blocks = self.count_of_blocks();
        // of as many blocks of each
        let step = ((AT_ONCE / length) as u64 / shares.count()).max(1) * shares.count();
        for first in (0..blocks).step_by(step as usize) {
            let next = step.min(blocks - first);
            let held = |block: &u64| Held {
                fits: self.fits[places(first + block)].to_vec(),
                failures: self.failures[places(first + block)].to_vec(),
            };
            let all = shares.put_together(shares.own(next).iter().map(held).collect())?;
            for (held, block) in all.into_iter().zip(first..) {
                self.fits[places(block)].copy_from_slice(&held.fits);
                self.failures[places(block)].copy_from_slice(&held.failures);
            }
        }
        Ok(())
    }

    /// The replicates of one target, in order.
    pub fn of(&self, target: usize) -> impl Iterator<Item = WeightedFit> + use<'_> {
        self.column(&self.fits, target).map(|&[a, b, aa, ab, bb]| WeightedFit {
            parameters: [a, b],
            covariance: [aa, ab, bb],
        })
    }

    /// Why each replicate of one target has no fit; `None` where it has.
    pub fn failures(&self, target: usize) -> impl Iterator<Item = Option<Failure>> + use<'_> {
        self.column(&self.failures, target).copied()
    }

    fn column<'a, T>(&self, all: &'a [T], target: usize) -> impl Iterator<Item = &'a T> + use<'a, T> {
        let targets = self.targets;
        let blocks = all.chunks(BLOCK * targets.max(1));
        let every = blocks.flat_map(move |block| {
            let made = block.len() / targets;
            &block[target * made..(target + 1) * made]
        });
        every.take(self.replicates)
    }
}

/// What a block of replicates holds.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Held {
    fits: Vec<Numbers>,
    failures: Vec<Option<Failure>>,
}

/// Replicates to be made, of all targets.
pub(super) struct Block<'a> {
    /// its number
    pub number: usize,
    /// number of the first of them
    pub first: u64,
    /// how many
    pub replicates: usize,
    fits: &'a mut [Numbers],
    failures: &'a mut [Option<Failure>],
}

impl Block<'_> {
    /// Keeps what one replicate of a target is, numbered from the first.
    pub fn put(&mut self, target: usize, replicate: usize, fit: Result<WeightedFit, Failure>) {
        let place = target * self.replicates + replicate;
        let WeightedFit {
            parameters: [a, b],
            covariance: [aa, ab, bb],
        } = fit.unwrap_or(WeightedFit::NONE);
        self.fits[place] = [a, b, aa, ab, bb];
        self.failures[place] = fit.err();
    }
}
