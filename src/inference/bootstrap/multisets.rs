//! Lists the multisets of members that several draws with replacement can give, and that of every sequence of draws.
//!
//! In whichever order draws of a stratum took their members, the sums over them are the same: 3 draws of 7 have 343
//! equally likely sequences, and give one of 84 multisets. A sum is tabulated by these, so that the tables of all strata
//! stay in the nearest cache; which multiset a sequence gives is the same for all strata of a size.

use std::sync::LazyLock;

/// Most sequences of the draws of a batch.
pub(super) const MOST_SEQUENCES: usize = 1024;

/// Most multisets of the draws of a batch.
const MOST_MULTISETS: usize = 128;

/// Members up to which multisets are listed: their counts fit into one word of 64 bits.
pub(super) const FEW: usize = 16;

/// Bits of a member's count.
const BITS: usize = 4;

/// Draws of a whole batch from so many members: as many as have few sequences and multisets, one at least.
fn largest_batch(members: usize) -> usize {
    let (mut draws, mut sequences, mut multisets) = (1, members, members);
    while draws + 1 < members {
        sequences = sequences.saturating_mul(members);
        multisets = multisets.saturating_mul(members + draws) / (draws + 1);
        if sequences > MOST_SEQUENCES || multisets > MOST_MULTISETS {
            break;
        }
        draws += 1;
    }
    draws
}

/// Draws of each batch of a stratum of so many members, n − 1 in all.
pub(super) fn batch_sizes(members: usize) -> impl Iterator<Item = usize> {
    let all = members.saturating_sub(1);
    let largest = largest_batch(members);
    (0..all).step_by(largest).map(move |made| largest.min(all - made))
}

/// Sequences of so many draws of so many members.
pub(super) fn sequences(members: usize, draws: usize) -> usize {
    (0..draws).map(|_| members).product()
}

/// Counts of the members that a sequence of draws takes: its digits to the base of the members.
fn counts_of(sequence: usize, members: usize, draws: usize) -> MemberCounts {
    let digits = (0..draws).scan(sequence, |left, _| {
        let member = *left % members;
        *left /= members;
        Some(member)
    });
    MemberCounts(digits.map(|member| 1 << (BITS * member)).sum())
}

/// How often each of a few members is drawn, in a register: adding to memory just written would wait for it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MemberCounts(u64);

impl MemberCounts {
    /// With what other draws took.
    pub(super) fn and(self, other: MemberCounts) -> MemberCounts {
        MemberCounts(self.0 + other.0)
    }

    /// Of each member in turn.
    pub(super) fn each(self) -> impl Iterator<Item = f64> {
        (0..FEW).map(move |member| (self.0 >> (BITS * member) & 15) as f64)
    }
}

/// Multisets of the draws from every number of members up to [`FEW`].
#[derive(Debug)]
pub(super) struct Multisets {
    /// multiset of every sequence, numbered within its number of members; [`MOST_SEQUENCES`] follow every start
    pub(super) of_sequence: Vec<u8>,
    /// by the number of members
    sizes: Vec<Size>,
}

/// What can be drawn from so many members.
#[derive(Debug, Default)]
struct Size {
    /// draws of a batch, and where its sequences start in [`Multisets::of_sequence`]
    starts: Vec<(usize, usize)>,
    counts: Vec<MemberCounts>,
}

impl Multisets {
    /// The same for all strata of all pools.
    pub(super) fn all() -> &'static Multisets {
        static ALL: LazyLock<Multisets> = LazyLock::new(Multisets::list);
        &ALL
    }

    fn list() -> Multisets {
        let mut multisets = Multisets {
            of_sequence: vec![],
            sizes: vec![],
        };
        for members in 0..=FEW {
            let mut size = Size::default();
            let mut batches: Vec<usize> = batch_sizes(members).collect();
            batches.dedup();
            for draws in batches {
                let of_sequence: Vec<MemberCounts> = (0..sequences(members, draws))
                    .map(|sequence| counts_of(sequence, members, draws))
                    .collect();
                let mut different = of_sequence.clone();
                different.sort_unstable();
                different.dedup();
                let before = size.counts.len();
                // no number is above 255: at most 128 multisets, and no more of the fewer draws that are left
                let number = |counts| (before + different.partition_point(|other| other < counts)) as u8;
                size.starts.push((draws, multisets.of_sequence.len()));
                multisets.of_sequence.extend(of_sequence.iter().map(number));
                size.counts.extend(different);
            }
            multisets.sizes.push(size);
        }
        multisets.of_sequence.extend([0; MOST_SEQUENCES]);
        multisets
    }

    /// Where the sequences of so many draws of so many members start in [`Multisets::of_sequence`]; none for more than
    /// [`FEW`].
    pub(super) fn start(&self, members: usize, draws: usize) -> Option<usize> {
        let starts = self.sizes.get(members)?.starts.iter();
        starts.copied().find(|(made, _)| *made == draws).map(|(_, start)| start)
    }

    /// The counts of every multiset of a batch of draws from a few members.
    pub(super) fn counts(&self, members: usize) -> &[MemberCounts] {
        &self.sizes[members].counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_batch_is_as_large_as_has_few_multisets() {
        let of = |members: usize| batch_sizes(members).collect::<Vec<_>>();
        assert_eq!(of(1), [0; 0]);
        assert_eq!(of(2), [1]);
        assert_eq!(of(3), [2]);
        assert_eq!(of(4), [3]);
        assert_eq!(of(5), [4]);
        assert_eq!(of(6), [3, 2]);
        assert_eq!(of(7), [3, 3]);
        assert_eq!(of(8), [3, 3, 1]);
        assert_eq!(of(9), [2; 4]);
        assert_eq!(of(10), [2, 2, 2, 2, 1]);
        assert_eq!(of(16), [1; 15]);
        assert_eq!(of(1000), [1; 999]);
    }

    /// Every sequence is listed with the members its digits name, so that a multiset is as likely as its sequences are many.
    #[test]
    fn every_sequence_has_the_multiset_of_its_digits() {
        let multisets = Multisets::all();
        for members in 2..=FEW {
            let counts = multisets.counts(members);
            assert!(counts.len() <= 256, "{members}: {}", counts.len());
            let mut kinds = vec![];
            for draws in batch_sizes(members) {
                let start = multisets.start(members, draws).expect("listed");
                for sequence in 0..sequences(members, draws) {
                    let number = usize::from(multisets.of_sequence[start + sequence]);
                    let listed: Vec<f64> = counts[number].each().collect();
                    let (mut own, mut left) = (vec![0.0; FEW], sequence);
                    for _ in 0..draws {
                        own[left % members] += 1.0;
                        left /= members;
                    }
                    assert_eq!(listed, own, "{members} {draws} {sequence}");
                }
                kinds.push(draws);
            }
            kinds.dedup();
            // C(n + d − 1, d) multisets of d draws
            let of = |d: usize| (0..d).fold(1, |product, i| product * (members + i) / (i + 1));
            assert_eq!(counts.len(), kinds.into_iter().map(of).sum::<usize>());
        }
        assert_eq!(multisets.start(FEW + 1, 1), None);
    }
}
