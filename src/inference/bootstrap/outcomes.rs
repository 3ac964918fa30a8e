//! Tells which members n − 1 draws of n take, the ways in which several draws fall at once gathered by what they draw.
//!
//! In whichever order draws of a stratum took their members, the sums over them are the same: 3 draws of 7 fall in 343
//! equally likely ways, and draw one of 84 multisets. A sum is tabulated by these, so that the tables of all strata stay
//! in the nearest cache; which of them a way draws is the same for all strata of a size.

use std::sync::LazyLock;

/// Most ways in which draws made at once may fall.
const MOST_WAYS: usize = 1024;

/// Most outcomes of draws made at once.
const MOST_OUTCOMES: usize = 128;

/// Members up to which outcomes are listed: their counts fit into one word of 64 bits.
pub(super) const FEW: usize = 16;

/// Bits of a member's count.
const BITS: usize = 4;

/// Draws made at once from so many members: as many as have few ways and outcomes, one at least.
fn at_once(members: usize) -> usize {
    let (mut draws, mut ways, mut outcomes) = (1, members, members);
    while draws + 1 < members {
        ways = ways.saturating_mul(members);
        outcomes = outcomes.saturating_mul(members + draws) / (draws + 1);
        if ways > MOST_WAYS || outcomes > MOST_OUTCOMES {
            break;
        }
        draws += 1;
    }
    draws
}

/// Draws made by each pick of a stratum of so many members, n − 1 in all.
pub(super) fn draws(members: usize) -> impl Iterator<Item = usize> {
    let all = members.saturating_sub(1);
    let at_once = at_once(members);
    (0..all).step_by(at_once).map(move |made| at_once.min(all - made))
}

/// Ways in which so many draws of so many members fall.
pub(super) fn ways(members: usize, draws: usize) -> usize {
    (0..draws).map(|_| members).product()
}

/// Counts of the members that are drawn where draws fall in this way: its digits to the base of the members.
fn drawn(way: usize, members: usize, draws: usize) -> Counts {
    let digits = (0..draws).scan(way, |left, _| {
        let member = *left % members;
        *left /= members;
        Some(member)
    });
    Counts(digits.map(|member| 1 << (BITS * member)).sum())
}

/// How often each of a few members is drawn, in a register: adding to memory just written would wait for it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Counts(u64);

impl Counts {
    /// With what other draws took.
    pub(super) fn and(self, other: Counts) -> Counts {
        Counts(self.0 + other.0)
    }

    /// Of each member in turn.
    pub(super) fn each(self) -> impl Iterator<Item = f64> {
        (0..FEW).map(move |member| (self.0 >> (BITS * member) & 15) as f64)
    }
}

/// Outcomes of the draws from every number of members up to [`FEW`].
pub(super) struct Outcomes {
    /// outcome of every way, numbered within its number of members
    pub(super) of: Vec<u8>,
    /// by the number of members
    sizes: Vec<Size>,
}

/// What can be drawn from so many members.
#[derive(Default)]
struct Size {
    /// draws made at once, and where their ways start in [`Outcomes::of`]
    starts: Vec<(usize, usize)>,
    counts: Vec<Counts>,
}

impl Outcomes {
    /// The same for all strata of all pools.
    pub(super) fn all() -> &'static Outcomes {
        static ALL: LazyLock<Outcomes> = LazyLock::new(Outcomes::list);
        &ALL
    }

    fn list() -> Outcomes {
        let mut outcomes = Outcomes {
            of: vec![],
            sizes: vec![],
        };
        for members in 0..=FEW {
            let mut size = Size::default();
            let mut kinds: Vec<usize> = draws(members).collect();
            kinds.dedup();
            for draws in kinds {
                let fell: Vec<Counts> = (0..ways(members, draws))
                    .map(|way| drawn(way, members, draws))
                    .collect();
                let mut different = fell.clone();
                different.sort_unstable();
                different.dedup();
                let before = size.counts.len();
                // no number is above 255: at most 128 outcomes, and no more of the fewer draws that are left
                let number = |counts| (before + different.partition_point(|other| other < counts)) as u8;
                size.starts.push((draws, outcomes.of.len()));
                outcomes.of.extend(fell.iter().map(number));
                size.counts.extend(different);
            }
            outcomes.sizes.push(size);
        }
        outcomes
    }

    /// Where the ways of so many draws of so many members start in [`Outcomes::of`]; none for more than [`FEW`].
    pub(super) fn start(&self, members: usize, draws: usize) -> Option<usize> {
        let starts = self.sizes.get(members)?.starts.iter();
        starts.copied().find(|(made, _)| *made == draws).map(|(_, start)| start)
    }

    /// What every outcome of a pick from a few members draws.
    pub(super) fn counts(&self, members: usize) -> &[Counts] {
        &self.sizes[members].counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_made_at_once_while_they_have_few_outcomes() {
        let of = |members: usize| draws(members).collect::<Vec<_>>();
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

    /// Every way is listed with what its digits draw, so that an outcome is as likely as its ways are many.
    #[test]
    fn every_way_has_the_outcome_of_its_digits() {
        let outcomes = Outcomes::all();
        for members in 2..=FEW {
            let counts = outcomes.counts(members);
            assert!(counts.len() <= 256, "{members}: {}", counts.len());
            let mut kinds = vec![];
            for draws in draws(members) {
                let start = outcomes.start(members, draws).expect("listed");
                for way in 0..ways(members, draws) {
                    let listed: Vec<f64> = counts[usize::from(outcomes.of[start + way])].each().collect();
                    let (mut own, mut left) = (vec![0.0; FEW], way);
                    for _ in 0..draws {
                        own[left % members] += 1.0;
                        left /= members;
                    }
                    assert_eq!(listed, own, "{members} {draws} {way}");
                }
                kinds.push(draws);
            }
            kinds.dedup();
            // C(n + d − 1, d) multisets of d draws
            let multisets = |d: usize| (0..d).fold(1, |product, i| product * (members + i) / (i + 1));
            assert_eq!(counts.len(), kinds.into_iter().map(multisets).sum::<usize>());
        }
        assert_eq!(outcomes.start(FEW + 1, 1), None);
    }
}
