//! Questions rows that are means or medians of others.

use std::ops::RangeInclusive;

use super::rebounds::{chance_of_so_many, is_rounded, Rebound};
use crate::distributions::{chi_squared_tail, median};
use crate::error::and_more;
use crate::findings::remarks;
use crate::remark::Remark;
use crate::rounding::{by_number, significant};
use crate::runs::RowPlaces;

/// Rows that are the means of other rows.
struct Means {
    of: MeanOf,
    rows: Vec<u32>,
    expected: f64,
    p: f64,
}

/// How many rows a mean may be of: two, or more. These are two questions, since rows that may be the mean of two by chance
/// would hide means of more.
const ROWS: [RangeInclusive<usize>; 2] = [2..=2, 3..=50];

/// Rows of a group or block at all of its speeds that a mean may be of.
const ROWS_OF_GROUP: [RangeInclusive<usize>; 1] = [3..=400];

/// Which rows a mean, or a median, may be of.
#[derive(Clone, Copy, PartialEq)]
enum MeanOf {
    /// those just above, down to the mean before
    Above,
    /// those just below
    Below,
    /// those just above, as their median
    MedianAbove,
    /// those just below, as their median
    MedianBelow,
    /// all others near its speed
    All,
    /// all others of its group, at whatever speed
    Group,
    /// the same, of the last row of each group, at the foot of a table or of a block
    Last,
    /// those of its group just above, down to the mean before, at whatever speed
    Block,
}

impl MeanOf {
    /// Whether the rows are of one speed, about.
    fn is_of_one_speed(self) -> bool {
        !matches!(self, MeanOf::Group | MeanOf::Last | MeanOf::Block)
    }

    fn is_median(self) -> bool {
        matches!(self, MeanOf::MedianAbove | MeanOf::MedianBelow)
    }
}

/// Questions rows that are means of others, by the least likely of all ways in which these may stand in a table.
pub(super) fn question_means(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    /// digits to which means are rounded at least
    const COARSE: f64 = 0.01;
    const NAMED: usize = 8;
    // to the digits of the runs, or to fewer
    use MeanOf::{Above, All, Below, Block, Group, Last, MedianAbove, MedianBelow};
    let ways = [Above, Below, All, Group, Last, Block].into_iter();
    let ways: Vec<(MeanOf, f64)> = ways.flat_map(|of| [(of, 0.0), (of, COARSE)]).collect();
    // of each question: rows of one speed, and those of a group at all speeds
    let tried = 0.5 * ways.len() as f64;
    let found = ways.iter().flat_map(|(of, step)| {
        let lengths = match of.is_of_one_speed() {
            true => &ROWS[..],
            false => &ROWS_OF_GROUP,
        };
        lengths
            .iter()
            .map(|rows| Means::of_one_kind(rebounds, *of, rows, *step))
    });
    // the median of two is their mean
    let medians = [MedianAbove, MedianBelow]
        .into_iter()
        .flat_map(|of| [0.0, COARSE].map(|step| Means::of_one_kind(rebounds, of, &ROWS[1], step)));
    let at_ends = [Above, Below].into_iter().map(|of| Means::at_one_end(rebounds, of));
    let Means { of, rows, expected, p } = found.chain(medians).chain(at_ends).min_by(|a, b| a.p.total_cmp(&b.p))?;
    let p = (tried * p).min(1.0);
    if rows.is_empty() || p >= remarks::BEYOND_CHANCE {
        return None;
    }
    let named = places.of_each(&rows[..rows.len().min(NAMED)]);
    let others = match of.is_of_one_speed() {
        true => "other rows near that speed",
        false => "the other rows of a group or block",
    };
    let centre = if of.is_median() { "median" } else { "mean" };
    let text = format!(
        "{} {} the {centre} of {others}, in speed and restitution, where chance would make it {}: {}",
        rows.len(),
        by_number(rows.len(), "row is", "rows are"),
        significant(expected, 1),
        and_more(named, rows.len(), ", ")
    );
    Some(remarks::MEAN_ROWS.check(p, text))
}

impl Means {
    /// Those of one way, their restitutions rounded to this step at least.
    fn of_one_kind(rebounds: &[Rebound], of: MeanOf, length: &RangeInclusive<usize>, rounded_to: f64) -> Means {
        let mut rows: Vec<u32> = vec![];
        let mut expected = 0.0;
        // speeds of rows that have the mean speed: where a design is repeated, the first tells of all
        let mut mean_speeds: Vec<f64> = vec![];
        // where the next block may begin
        let mut begin = 0;
        for (place, one) in rebounds.iter().enumerate() {
            let steps = one.restitution / rounded_to;
            if rounded_to > 0.0 && (steps - steps.round()).abs() > 1e-6 {
                continue;
            }
            if of == MeanOf::Last && rebounds[place + 1..].iter().any(|other| other.group == one.group) {
                continue;
            }
            let belongs = |other: &&Rebound| match of.is_of_one_speed() {
                true => one.is_near(other),
                false => other.group == one.group,
            };
            let most = length.end() + 1;
            let (above, below) = (rebounds[begin..place].iter().rev(), rebounds[place + 1..].iter());
            let others = rebounds.iter().filter(|other| other.row != one.row);
            let block: Vec<&Rebound> = match of {
                MeanOf::Above | MeanOf::MedianAbove | MeanOf::Block => above.take_while(belongs).take(most).collect(),
                MeanOf::Below | MeanOf::MedianBelow => below.take_while(belongs).take(most).collect(),
                MeanOf::All | MeanOf::Group | MeanOf::Last => others.filter(belongs).take(most).collect(),
            };
            let mut speeds = Spread::of(block.iter().map(|other| other.speed));
            let mut restitutions = Spread::of(block.iter().map(|other| other.restitution));
            if of.is_median() {
                let middle = |of: fn(&Rebound) -> f64| median(&mut block.iter().map(|one| of(one)).collect::<Vec<_>>());
                speeds.mean = middle(|one| one.speed).unwrap_or(speeds.mean);
                restitutions.mean = middle(|one| one.restitution).unwrap_or(restitutions.mean);
            }
            // equal rows are repeats
            if !length.contains(&block.len()) || restitutions.sd == 0.0 {
                continue;
            }
            let step = one.steps[2].max(rounded_to);
            let speed_step = one.steps[1].max(rounded_to);
            let has_speed = speeds.has_mean(one.speed, speed_step);
            if of.is_of_one_speed() {
                // the speed itself tells nothing: one that was set is the mean of those beside it where they are evenly apart
                if !has_speed {
                    continue;
                }
                expected += restitutions.chance(step, one.scatter);
            } else {
                // repeats of a set speed have its mean restitution together
                if one.is_set {
                    continue;
                }
                let is_known = has_speed && mean_speeds.contains(&one.speed);
                let of_speed = if is_known {
                    1.0
                } else {
                    chance_of_mean_speed(&block, speed_step)
                };
                expected += of_speed * chance_about_line(&block, step);
                mean_speeds.extend(has_speed.then_some(one.speed));
            }
            let has_restitution = restitutions.has_mean(one.restitution, step) || {
                let rebounds = Spread::of(block.iter().map(|other| other.rebound_speed()));
                !of.is_of_one_speed() && rebounds.has_mean(one.rebound_speed(), step * one.speed)
            };
            if has_speed && has_restitution {
                rows.push(one.row);
                begin = place + 1;
            }
        }
        let p = at_least(rows.len(), expected);
        Means { of, rows, expected, p }
    }

    /// The last rows of settings, or the first, that are the means of the others there. Runs of one setting may stand in any
    /// order: each is as likely at the end as those that are means of the others, too, whatever digits and scatter are.
    fn at_one_end(rebounds: &[Rebound], of: MeanOf) -> Means {
        /// share by which speeds of one setting follow each other: wider designs may end with their middle
        const APART: f64 = 0.05;
        let is_repeat =
            |one: &Rebound, other: &Rebound| one.group == other.group && (other.speed / one.speed - 1.0).abs() <= APART;
        let mut rows = vec![];
        let mut chances = vec![];
        for setting in rebounds.chunk_by(is_repeat) {
            if !ROWS[1].contains(&(setting.len() - 1)) {
                continue;
            }
            let is_mean = |at: usize| {
                let others = || setting[..at].iter().chain(&setting[at + 1..]);
                let of_others = |value: fn(&Rebound) -> f64| Spread::of(others().map(value));
                let one = &setting[at];
                of_others(|other| other.speed).has_mean(one.speed, one.steps[1])
                    && of_others(|other| other.restitution).has_mean(one.restitution, one.steps[2])
            };
            let means: Vec<bool> = (0..setting.len()).map(is_mean).collect();
            let count = means.iter().filter(|is_mean| **is_mean).count();
            let end = if of == MeanOf::Above { setting.len() - 1 } else { 0 };
            rows.extend(means[end].then_some(setting[end].row));
            chances.push(count as f64 / setting.len() as f64);
        }
        Means {
            of,
            p: chance_of_so_many(rows.len(), &chances),
            expected: chances.iter().sum(),
            rows,
        }
    }
}

/// Probability of at least so many where so many are expected (Poisson).
fn at_least(found: usize, expected: f64) -> f64 {
    if found == 0 {
        return 1.0;
    }
    chi_squared_tail(2.0 * expected, 2.0 * found as f64).map_or(1.0, |fewer| 1.0 - fewer)
}

/// Density of a normal at its middle, times its sd.
const PEAK: f64 = 0.398_942_280_401_432_7;

/// Bound on the probability that one more speed is the mean of a block to the last digit: the middle of a design that is even
/// but for some scatter lies within this scatter of the mean.
fn chance_of_mean_speed(block: &[&Rebound], step: f64) -> f64 {
    let mut speeds: Vec<f64> = block.iter().map(|one| one.speed).collect();
    speeds.sort_by(f64::total_cmp);
    let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
    let middles = speeds.iter().zip(speeds.iter().rev());
    let squares = middles.map(|(slow, fast)| (0.5 * (slow + fast) - mean).powi(2));
    let uneven = (squares.sum::<f64>() / speeds.len() as f64).sqrt();
    (PEAK * step / uneven).min(1.0)
}

/// Bound on the probability that one more run at the mean speed of a block has its mean restitution, or its mean speed of
/// rebounds, to the last digit: by the scatter about the straight line in the speed, to which a bent law adds what it differs by.
fn chance_about_line(block: &[&Rebound], step: f64) -> f64 {
    let count = block.len() as f64;
    let mean = |of: fn(&Rebound) -> f64| block.iter().map(|one| of(one)).sum::<f64>() / count;
    let (speed, restitution) = (mean(|one| one.speed), mean(|one| one.restitution));
    let [mut square, mut product, mut rest] = [0.0; 3];
    for one in block {
        let (v, e) = (one.speed - speed, one.restitution - restitution);
        square += v * v;
        product += v * e;
        rest += e * e;
    }
    if square > 0.0 {
        rest -= product * product / square;
    }
    let sd = (rest.max(0.0) / (count - 2.0)).sqrt();
    (2.0 * PEAK * step / sd).min(1.0)
}

/// Mean and standard deviation of a block.
struct Spread {
    count: f64,
    mean: f64,
    sd: f64,
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Spread {
        let count = values.clone().count() as f64;
        let first = values.clone().next().unwrap_or_default();
        let mean = first + values.clone().map(|x| x - first).sum::<f64>() / count;
        let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
        Spread {
            count,
            mean,
            sd: (squares / (count - 1.0)).sqrt(),
        }
    }

    /// Whether a value is the mean, to the last digit written.
    fn has_mean(&self, value: f64, step: f64) -> bool {
        is_rounded(value - self.mean, step)
    }

    /// Probability that one more value is: of a mean halfway between two that can be written, either. Two values may lie close
    /// together by chance: they scatter by this at least.
    fn chance(&self, step: f64, scatter: f64) -> f64 {
        let root_two_pi = (2.0 * std::f64::consts::PI).sqrt();
        let own = if self.count < 3.0 {
            self.sd.max(scatter)
        } else {
            self.sd
        };
        let sd = own * (1.0 + 1.0 / self.count).sqrt();
        let is_halfway = ((self.mean / step).fract() - 0.5).abs() < 1e-6;
        let written = if is_halfway { 2.0 } else { 1.0 };
        (written * step / (root_two_pi * sd)).min(1.0)
    }
}
