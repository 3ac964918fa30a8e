//! Questions rows that are no runs of their own: those that repeat others, means of others (`means.rs`), and second impacts.

mod means;
mod rebounds;

use std::cmp::Reverse;

use self::means::question_means;
use self::rebounds::{chance_of_so_many, rebounds, Rebound, FINEST};
use super::remarks::{self, shortened};
use crate::remark::Remark;
use crate::rounding::by_number;
use crate::runs::{RowPlaces, Runs};

/// Rebounds of the largest table that is looked at, each pair of them: a laboratory has no larger one.
const MOST: usize = 10_000;

/// The checks of a table's rows, and what of them is only named. `residual_sd` is how the runs scatter about the laws fitted to
/// them, where any is.
pub(super) fn check_rows(runs: &Runs, residual_sd: Option<f64>) -> Vec<Remark> {
    // few that stand for all are no rows
    if !runs.count.is_empty() || runs.len() > MOST {
        return vec![];
    }
    let rebounds = rebounds(runs, residual_sd);
    let found = [
        question_repeats(&rebounds, &runs.places),
        question_filled_down(&rebounds, &runs.places),
        question_means(&rebounds, &runs.places),
        question_second_impacts(&rebounds, &runs.places),
    ];
    found.into_iter().flatten().collect()
}

/// Rows in the order of others that they repeat.
#[derive(Clone, Copy)]
struct Block {
    /// places of the last row and of the one that it repeats
    last: [usize; 2],
    length: usize,
    /// probability that one such row after the other is met by rounding
    chance: f64,
}

/// Rows in a block that is no accident by its length alone.
const IN_ORDER: usize = 3;

/// A probability below which repeats that may be chance are named.
const UNLIKELY: f64 = 0.05;

/// The rows of a table that repeat others.
#[derive(Default)]
struct Repeats {
    /// the least likely first
    blocks: Vec<Block>,
    rows: usize,
    /// probability of each row to repeat one before it by chance
    chances: Vec<f64>,
}

impl Repeats {
    fn of(rebounds: &[Rebound]) -> Repeats {
        /// blocks that are kept
        const KEPT: usize = 1000;
        let mut found = Repeats::default();
        // the block that ends at the row before, by the place of the row that this one repeats
        let mut open: Vec<Option<Block>> = vec![None; rebounds.len()];
        for (place, one) in rebounds.iter().enumerate() {
            let mut none = 1.0;
            let mut is_repeat = false;
            for source in (0..place).rev() {
                let before = source.checked_sub(1).and_then(|before| open[before].take());
                let other = &rebounds[source];
                let chance = if one.is_at_setting(other) && one.agrees(other, 0) {
                    Some(one.chance_to_agree(other))
                } else {
                    // the same speed may be set for each film; a restitution is met again by chance
                    (one.group != other.group && one.agrees(other, 1)).then(|| one.chance_of_restitution(other))
                };
                if let Some(chance) = chance {
                    none *= 1.0 - chance;
                    if one.agrees(other, 1) && one.agrees(other, 2) {
                        is_repeat = true;
                        open[source] = Some(Block {
                            last: [place, source],
                            length: before.map_or(1, |block| block.length + 1),
                            chance: before.map_or(1.0, |block| block.chance) * chance,
                        });
                        continue;
                    }
                }
                found.blocks.extend(before);
            }
            found.rows += usize::from(is_repeat);
            found.chances.push(1.0 - none);
            if found.blocks.len() > 2 * KEPT {
                found.sort();
                found.blocks.truncate(KEPT);
            }
        }
        found.blocks.extend(open.into_iter().flatten());
        found.sort();
        found
    }

    fn sort(&mut self) {
        let order = |a: &Block, b: &Block| a.chance.total_cmp(&b.chance).then(b.length.cmp(&a.length));
        self.blocks.sort_by(order);
    }
}

/// Questions rows that have the cells of earlier ones, or these rounded to fewer digits.
fn question_repeats(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    let found = Repeats::of(rebounds);
    let pairs = 0.5 * (rebounds.len() as f64).powi(2);
    let in_order = found.blocks.iter().filter(|block| block.length >= IN_ORDER);
    let of_blocks = in_order.map(|block| pairs * block.chance).fold(1.0, f64::min);
    // the rarer of two
    let of_all = chance_of_so_many(found.rows, &found.chances);
    let p = (2.0 * of_blocks.min(of_all)).min(1.0);
    if found.rows == 0 || p >= UNLIKELY {
        return None;
    }
    let mut named: Vec<&Block> = vec![];
    for block in &found.blocks {
        let overlaps = |other: &&Block| {
            let [first, last] = [block, *other].map(|block| block.last[0] + 1 - block.length);
            first <= other.last[0] && last <= block.last[0]
        };
        if !named.iter().any(overlaps) {
            named.push(block);
        }
    }
    named.sort_by_key(|block| Reverse(block.length));
    let words: Vec<String> = named.iter().map(|block| block.words(rebounds, places)).collect();
    let expected: f64 = found.chances.iter().sum();
    let by_rounding = if of_blocks < of_all {
        "in the order of these".to_owned()
    } else {
        format!("where rounding alone would make it {expected:.1}")
    };
    let rows = found.rows;
    let cells = match named.iter().all(|block| block.is_of_one_group(rebounds)) {
        true => "every measured cell",
        false => "speed and restitution, under another setting too",
    };
    let text = format!(
        "{rows} of {} rebounds {} another in {cells}, {by_rounding}: {}",
        rebounds.len(),
        by_number(rows, "repeats", "repeat"),
        shortened(&words)
    );
    Some(match p < remarks::BEYOND_CHANCE {
        true => remarks::REPEATED_ROWS.check(p, text),
        false => remarks::REPEATS_PERHAPS.notice(rows, text),
    })
}

/// Questions restitutions that several runs of other speeds have one after the other, as cells that were filled down have.
fn question_filled_down(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    /// digits with which a restitution tells
    const COARSEST: f64 = 0.001;
    let is_asked = |pair: &&[Rebound]| {
        let is_next = pair[0].group == pair[1].group && pair[1].row == pair[0].row + 1;
        is_next && pair[1].steps[2] < 1.5 * COARSEST && !pair[1].agrees(&pair[0], 1)
    };
    let pairs: Vec<&[Rebound]> = rebounds.windows(2).filter(is_asked).collect();
    let is_same = |pair: &&&[Rebound]| (pair[1].restitution - pair[0].restitution).abs() < FINEST;
    let same: Vec<u32> = pairs.iter().filter(is_same).map(|pair| pair[1].row).collect();
    let chances: Vec<f64> = pairs
        .iter()
        .map(|pair| pair[1].chance_of_restitution(&pair[0]))
        .collect();
    let p = chance_of_so_many(same.len(), &chances);
    (p < remarks::BEYOND_CHANCE).then(|| {
        let text = format!(
            "{} of {} rebounds have the restitution of the row above to every digit, at another speed, where chance would make \
             it {:.1}: {}",
            same.len(),
            rebounds.len(),
            chances.iter().sum::<f64>(),
            shortened(&places.of_each(&same))
        );
        let mut check = remarks::REPEATED_ROWS.check(p, text);
        check.next_step = "look whether the restitutions were filled down, and write each run's own".to_owned();
        check
    })
}

/// Questions wet runs that fall, to the last digit, with the speed at which the row before them of the same film rebounded:
/// second impacts of a drop, on a film that the first has thinned and set in motion.
fn question_second_impacts(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    /// how far around, in the digits written, a speed may lie that is near by accident
    const AROUND: f64 = 10.0;
    /// share of those around that agree by accident, with room for speeds that were set where most rebounds end
    const BY_ACCIDENT: f64 = 0.2;
    /// digits with which a speed tells, as a share of it
    const COARSEST: f64 = 0.005;
    let is_next = |pair: &&[Rebound]| pair[1].wet && pair[0].group == pair[1].group && pair[1].row == pair[0].row + 1;
    let mut around = vec![];
    let mut second = vec![];
    for pair in rebounds.windows(2).filter(is_next) {
        let digits = pair[1].steps[1] + pair[0].speed * pair[0].steps[2] + FINEST;
        let apart = (pair[0].rebound_speed() - pair[1].speed).abs();
        if apart <= AROUND * digits && digits <= COARSEST * pair[1].speed {
            around.push(BY_ACCIDENT);
            if apart <= digits {
                second.push(pair[1].row);
            }
        }
    }
    let p = chance_of_so_many(second.len(), &around);
    (p < remarks::BEYOND_CHANCE).then(|| {
        let text = format!(
            "{} of {} wet rebounds fall with the speed at which the row above rebounded, to the last digit: {}",
            second.len(),
            rebounds.iter().filter(|one| one.wet).count(),
            shortened(&places.of_each(&second))
        );
        remarks::SECOND_IMPACTS.check(p, text)
    })
}

impl Block {
    /// Whether it repeats rows of its own dry runs or series.
    fn is_of_one_group(&self, rebounds: &[Rebound]) -> bool {
        rebounds[self.last[0]].group == rebounds[self.last[1]].group
    }

    fn words(&self, rebounds: &[Rebound], places: &RowPlaces) -> String {
        let [rows, repeats] = self.last.map(|last| {
            let ends = [last + 1 - self.length, last];
            ends.map(|place| rebounds[place].row)
        });
        let is_finer = |place: usize| {
            let [one, other] = [place, place + self.last[1] - self.last[0]].map(|place| rebounds[place].measured());
            (1..3).any(|at| (one[at] - other[at]).abs() > FINEST)
        };
        let by_digits = match (self.last[0] + 1 - self.length..=self.last[0]).any(is_finer) {
            true => " apart from rounding",
            false => "",
        };
        format!(
            "{} {} {}{by_digits}",
            places.of_range(rows, None),
            by_number(self.length, "repeats", "repeat"),
            places.of_range(repeats, Some(rows[0]))
        )
    }
}

#[cfg(test)]
mod tests;
