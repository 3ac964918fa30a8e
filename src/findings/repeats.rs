//! Questions rows that are no runs of their own: those that repeat others, and means of others.

use std::cmp::Reverse;
use std::ops::RangeInclusive;

use super::remarks::{self, and_more, shortened};
use crate::distributions::chi_squared_tail;
use crate::physics::numbers::GRAVITY;
use crate::remark::Remark;
use crate::rounding::{by_number, significant};
use crate::runs::{RowPlaces, Runs};

/// Rebounds of the largest table that is looked at, each pair of them: a laboratory has no larger one.
const MOST: usize = 10_000;

/// A rebound with what tells it from others.
#[derive(Default)]
struct Rebound {
    row: u32,
    /// file or sheet, which has digits of its own
    table: usize,
    /// dry group or series
    group: usize,
    /// whether it is of a wet run
    wet: bool,
    film: f64,
    speed: f64,
    restitution: f64,
    /// by how much film, speed and restitution change with the last digit that was written
    steps: [f64; 3],
    /// by how much restitutions scatter at its setting
    scatter: f64,
    /// the other runs at its setting, and those of them whose speed agrees with its own to the last digit
    near: [f64; 2],
    /// whether another run of its table has its speed to every digit, which may then be one that was set
    is_set: bool,
    /// whether the runs of one speed in its table have different restitutions, as copies have not
    has_set_speeds: bool,
}

/// The checks of a table's rows, and what of them is only named.
pub(super) fn check_rows(runs: &Runs) -> Vec<Remark> {
    // few that stand for all are no rows
    if !runs.count.is_empty() || runs.len() > MOST {
        return vec![];
    }
    let mut rebounds = rebounds(runs);
    set_steps(&mut rebounds);
    set_scatter(&mut rebounds);
    compare_speeds(&mut rebounds);
    let found = [
        question_repeats(&rebounds, &runs.places),
        question_means(&rebounds, &runs.places),
    ];
    found.into_iter().flatten().collect()
}

/// Those that are rows by themselves, in the order of the table. Runs that stuck at one height repeat by nature, and the runs
/// of a mean are of one row.
fn rebounds(runs: &Runs) -> Vec<Rebound> {
    let dry = runs.dry.iter().map(|group| (false, group.rebounds.clone()));
    let wet = runs.series.iter().map(|series| (true, series.rebounds.clone()));
    let mut all = vec![];
    for (group, (wet, range)) in dry.chain(wet).enumerate() {
        all.extend(range.map(|run| Rebound {
            row: runs.row[run],
            table: runs.places.table(runs.row[run]),
            group,
            wet,
            film: runs.film[run],
            speed: runs.impact_speed[run],
            restitution: runs.restitution[run],
            ..Rebound::default()
        }));
    }
    all.sort_by_key(|rebound| rebound.row);
    let of_row = |row: u32| all.partition_point(|one| one.row <= row) - all.partition_point(|one| one.row < row);
    let is_alone: Vec<bool> = all.iter().map(|one| of_row(one.row) == 1).collect();
    let mut is_alone = is_alone.into_iter();
    all.retain(|_| is_alone.next() == Some(true));
    all
}

/// A step far below every measurement.
const FINEST: f64 = 1e-9;

/// The last digit that each number of a column is written with, which may be fewer than those of its neighbours; [`FINEST`] of
/// many digits.
fn last_digits(column: &[f64]) -> Vec<f64> {
    const MOST_DECIMALS: i32 = 7;
    // a value in other units is not to the last bit what it is in these
    let is_whole = |x: f64| (x - x.round()).abs() < 1e-6;
    let decimals = (0..=MOST_DECIMALS).rev().map(|decimals| 10f64.powi(decimals));
    let mut scales: Vec<f64> = vec![];
    // of ten numbers with a digit more one ends in 0 that may not be written
    let (mut finer, mut those) = (None, column.len() as f64);
    for scale in decimals {
        let whole = column.iter().filter(|x| is_whole(*x * scale)).count() as f64;
        let by_zeros = finer.map_or(0.1, |finer| scale / finer) * those;
        if whole > by_zeros + 2.5 * (0.9 * by_zeros).sqrt() {
            (finer, those) = (Some(scale), whole);
            scales.insert(0, scale);
        }
    }
    let of_number = |x: &f64| {
        let scale = scales.iter().find(|scale| is_whole(*x * **scale));
        scale.map_or(FINEST, |scale| 1.0 / scale)
    };
    column.iter().map(of_number).collect()
}

/// The step between the values of a column, each known to what rounding left of it, as they are met in each group; [`FINEST`]
/// where there is none. Speeds at even distances have rebounds at nearly even ones: no step, since these scatter.
fn step_between(mut column: Vec<(usize, f64, f64)>) -> f64 {
    /// steps to the next value
    const FEWEST: usize = 4;
    const NEARLY_ALL: f64 = 0.9;
    const NEAR: f64 = 0.15;
    /// by what share a step may be off that a factor, such as gravity, was applied to
    const SCALE_OFF: f64 = 0.02;
    /// steps to a value, of which each is known as far as the rows tell, and of one that is decimal
    const MOST: [f64; 2] = [6.5, 200.0];
    column.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let pairs = column.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let apart = pairs.map(|pair| (pair[1].1 - pair[0].1, pair[0].2 + pair[1].2));
    let mut apart: Vec<(f64, f64)> = apart.filter(|(apart, left)| *apart > left + FINEST).collect();
    apart.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_step = |(step, most): &(f64, f64)| {
        let few = apart.iter().map(|(apart, left)| (apart / step, left / step));
        let few: Vec<(f64, f64)> = few.take_while(|(steps, _)| steps < most).collect();
        let is_near =
            |steps: f64, left: f64| (steps - steps.round()).abs() < NEAR.min((1.0 + steps) * left + SCALE_OFF * steps);
        let whole = few
            .iter()
            .filter(|(steps, left)| *steps > 0.5 && is_near(*steps, *left));
        few.len() >= FEWEST && whole.count() as f64 >= NEARLY_ALL * few.len() as f64
    };
    let smallest = apart.chunk_by(|a, b| b.0 < 1.5 * a.0).take(3);
    let smallest = smallest.map(|alike| (alike[alike.len() / 2].0, MOST[0]));
    let decimal = (0..6).flat_map(|decimals| [1.0, 0.5, 0.2].map(|step| (step * 0.1f64.powi(decimals), MOST[1])));
    let steps = smallest.chain(decimal).filter(is_step).map(|(step, _)| step);
    steps.fold(FINEST, f64::max)
}

/// What a restitution may have been made from, each with by how much the restitution changes with it: itself, the speed of the
/// rebound, and its height above the film or the plate. A height counted with another gravity has the same steps, nearly.
const MADE_FROM: [fn(&Rebound) -> [f64; 2]; 4] = [
    |one| [one.restitution, 1.0],
    |one| [one.rebound_speed(), 1.0 / one.speed],
    |one| [one.rebound_height(), one.height_to_restitution()],
    |one| [one.rebound_height() + one.film, one.height_to_restitution()],
];

impl Rebound {
    fn rebound_speed(&self) -> f64 {
        self.speed * self.restitution
    }

    fn rebound_height(&self) -> f64 {
        self.rebound_speed().powi(2) / (2.0 * GRAVITY)
    }

    fn height_to_restitution(&self) -> f64 {
        GRAVITY / (self.speed * self.rebound_speed())
    }
}

/// Sets by how much each rebound changes with the last digit of what it was made from.
fn set_steps(rebounds: &mut [Rebound]) {
    /// no table has fewer digits of film, speed or restitution than these steps
    const COARSEST: [f64; 3] = [1e-5, 0.1, 0.01];
    for table in rebounds.chunk_by_mut(|one, other| one.table == other.table) {
        let digits = |value: fn(&Rebound) -> f64| last_digits(&table.iter().map(value).collect::<Vec<f64>>());
        let (films, speeds) = (digits(|one| one.film), digits(|one| one.speed));
        let restitutions = digits(|one| one.restitution);
        let mut coarsest = restitutions.clone();
        for quantity in MADE_FROM {
            let made: Vec<[f64; 2]> = table.iter().map(quantity).collect();
            let digits = last_digits(&made.iter().map(|[value, _]| *value).collect::<Vec<f64>>());
            let column = table.iter().zip(&made).enumerate();
            let column = column.map(|(at, (one, [value, slope]))| {
                let left = 0.5 * digits[at].max(restitutions[at] / slope);
                (one.group, *value, left)
            });
            let between = step_between(column.collect());
            for (at, step) in coarsest.iter_mut().enumerate() {
                *step = step.max(digits[at].max(between) * made[at][1]);
            }
        }
        for (at, one) in table.iter_mut().enumerate() {
            one.steps = [films[at], speeds[at], coarsest[at]];
            for (step, coarsest) in one.steps.iter_mut().zip(COARSEST) {
                *step = step.min(coarsest);
            }
        }
    }
}

/// The difference of the restitutions of two runs at one setting.
#[derive(Clone, Copy)]
struct Difference {
    square: f64,
    /// whether rounding explains it
    is_rounding: bool,
}

/// By what share the speeds of one setting may differ.
const SAME_SETTING: f64 = 0.03;

/// Share of the pairs of runs at one speed that may differ in restitution where all others are copies.
const FEW_APART: f64 = 0.1;

/// What no experiment scatters less than; only where the rows cannot tell.
const LEAST_SCATTER: f64 = 0.002;

/// The sd of single runs by their differences; `None` of few.
fn scatter_of<'d>(differences: impl Iterator<Item = &'d Difference>) -> Option<f64> {
    /// pairs that tell a scatter
    const ENOUGH: usize = 20;
    /// mean square of a normal without the largest tenth of its squares
    const OF_REST: f64 = 0.623;
    /// square of a normal that a quarter of its squares are below, of these without the largest tenth
    const OF_QUARTER: f64 = 0.0817;
    let mut rest: Vec<Difference> = differences.copied().collect();
    rest.sort_by(|one, other| one.square.total_cmp(&other.square));
    // without what outliers add
    rest.truncate(rest.len() - rest.len() / 10);
    let mean = rest.iter().map(|one| one.square).sum::<f64>() / rest.len().max(1) as f64;
    // runs in clusters agree more often than their spread says
    let apart: Vec<&Difference> = rest.iter().filter(|one| !one.is_rounding).collect();
    let quarter = apart
        .get(apart.len() / 4)
        .map_or(f64::MAX, |one| one.square / OF_QUARTER);
    let least = if apart.len() < ENOUGH { LEAST_SCATTER } else { 0.0 };
    (rest.len() >= ENOUGH).then_some((0.5 * quarter.min(mean / OF_REST)).sqrt().max(least))
}

/// Sets by how much restitutions scatter at the setting of each rebound: as those near its speed do, or those of its group,
/// whichever is less.
fn set_scatter(rebounds: &mut [Rebound]) {
    /// speeds of one setting, as a share
    const CLOSE: f64 = 0.02;
    /// places in the order of speeds to another of a pair: more than one, since a copy stands beside its original
    const LAGS: RangeInclusive<usize> = 1..=4;
    /// places in that order to those that are near
    const NEAR: usize = 10;
    let mut sorted: Vec<usize> = (0..rebounds.len()).collect();
    // stable: at one speed in the order of the table
    sorted.sort_by(|a, b| {
        let (a, b) = (&rebounds[*a], &rebounds[*b]);
        a.group.cmp(&b.group).then(a.speed.total_cmp(&b.speed))
    });
    let differences = |at: usize| -> Vec<Difference> {
        let one = &rebounds[sorted[at]];
        let others = LAGS.filter_map(|lag| Some(&rebounds[*sorted.get(at + lag)?]));
        let close = others.filter(|other| other.group == one.group && other.speed <= (1.0 + CLOSE) * one.speed);
        let difference = |other: &Rebound| Difference {
            square: (other.restitution - one.restitution).powi(2),
            is_rounding: one.agrees(other, 2),
        };
        close.map(difference).collect()
    };
    let differences: Vec<Vec<Difference>> = (0..sorted.len()).map(differences).collect();
    let of_all = [false, true].map(|wet| {
        let own = (0..sorted.len()).filter(|at| rebounds[sorted[*at]].wet == wet);
        scatter_of(own.flat_map(|at| &differences[at])).unwrap_or(LEAST_SCATTER)
    });
    let mut scatter = vec![0.0; sorted.len()];
    let mut start = 0;
    for group in sorted.chunk_by(|a, b| rebounds[*a].group == rebounds[*b].group) {
        let end = start + group.len();
        let of_group =
            scatter_of(differences[start..end].iter().flatten()).unwrap_or(of_all[usize::from(rebounds[group[0]].wet)]);
        for at in start..end {
            let near = at.saturating_sub(NEAR).max(start)..(at + NEAR).min(end);
            let near = scatter_of(differences[near].iter().flatten());
            scatter[sorted[at]] = near.map_or(of_group, |near| near.min(of_group));
        }
        start = end;
    }
    for (one, scatter) in rebounds.iter_mut().zip(scatter) {
        one.scatter = scatter;
    }
}

/// Whether rounding to a step explains a difference.
fn is_rounded(apart: f64, step: f64) -> bool {
    apart.abs() <= 0.5 * step * (1.0 + 1e-6) + 1e-12
}

/// Sets how the speed of each rebound compares with those of its setting.
fn compare_speeds(rebounds: &mut [Rebound]) {
    let compare = |one: &Rebound| {
        let is_other = |other: &&Rebound| other.is_at_setting(one) && other.row != one.row;
        let (mut near, mut same) = ([0.0; 2], [0.0; 2]);
        for other in rebounds.iter().filter(is_other) {
            near[0] += 1.0;
            near[1] += f64::from(u8::from(is_rounded(one.speed - other.speed, one.steps[1])));
            if other.table == one.table && other.has_speed_of(one) {
                same[usize::from(other.agrees(one, 2))] += 1.0;
            }
        }
        (near, same)
    };
    let mut compared: Vec<([f64; 2], [f64; 2])> = rebounds.iter().map(compare).collect();
    for table in rebounds.chunk_by_mut(|one, other| one.table == other.table) {
        let own: Vec<_> = compared.drain(..table.len()).collect();
        let [apart, agree] = [0, 1].map(|at| own.iter().map(|(_, same)| same[at]).sum::<f64>());
        for (one, (near, same)) in table.iter_mut().zip(own) {
            one.near = near;
            one.is_set = same[0] + same[1] > 0.0;
            one.has_set_speeds = apart > FEW_APART * (apart + agree);
        }
    }
}

impl Rebound {
    /// Film, speed and restitution.
    fn measured(&self) -> [f64; 3] {
        [self.film, self.speed, self.restitution]
    }

    /// Whether one of these is the same in another, as far as the one with fewer digits tells.
    fn agrees(&self, other: &Rebound, at: usize) -> bool {
        let apart = self.measured()[at] - other.measured()[at];
        is_rounded(apart, self.steps[at].max(other.steps[at]))
    }

    /// Whether another is of the same group and speed, about.
    fn is_near(&self, other: &Rebound) -> bool {
        /// as a share
        const CLOSE: f64 = 0.1;
        other.group == self.group && (other.speed / self.speed - 1.0).abs() <= CLOSE
    }

    /// Whether another is of the same group and speed, but for how speeds of one setting scatter.
    fn is_at_setting(&self, other: &Rebound) -> bool {
        other.group == self.group && (other.speed - self.speed).abs() <= SAME_SETTING * self.speed
    }

    /// Probability that the speed of another run at its setting agrees with its own to the last digit: by all others there, and
    /// by one more that is anywhere near.
    fn chance_of_speed(&self, other: &Rebound) -> f64 {
        let own = f64::from(u8::from(is_rounded(self.speed - other.speed, self.steps[1])));
        let by_width = (self.steps[1] / (2.0 * SAME_SETTING * self.speed)).min(1.0);
        (self.near[1] - own + by_width) / self.near[0].max(1.0)
    }

    /// Whether another has the same speed to every digit.
    fn has_speed_of(&self, other: &Rebound) -> bool {
        (self.speed - other.speed).abs() <= FINEST * self.speed
    }

    /// Probability that its restitution and that of another run at one setting agree to the last digit r of the one with fewer,
    /// which is r/(2 √π s) where they scatter by s, and their speeds, where these were not set.
    fn chance_to_agree(&self, other: &Rebound) -> f64 {
        /// rather too likely than too rare: no scatter is normal, nor the same everywhere
        const CAUTIOUS: f64 = 1.25;
        let step = self.steps[2].max(other.steps[2]);
        let two_root_pi = 2.0 * std::f64::consts::PI.sqrt();
        let spread = (self.scatter.powi(2) + step * step / 12.0).sqrt();
        let [coarse, fine] = match self.steps[1] > other.steps[1] {
            true => [self, other],
            false => [other, self],
        };
        // of speeds that were set only those that agree are compared
        let is_set = self.has_set_speeds && (fine.is_set || fine.steps[1] == coarse.steps[1]);
        let of_speeds = match is_set {
            true => f64::from(u8::from(self.agrees(other, 1))),
            false => coarse.chance_of_speed(fine),
        };
        (CAUTIOUS * step / (two_root_pi * spread)).min(1.0) * of_speeds
    }
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
                if one.is_at_setting(other) && one.agrees(other, 0) {
                    let chance = one.chance_to_agree(other);
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

/// Bound on the probability of so many or more, each with a chance of its own (Chernoff).
fn chance_of_so_many(found: usize, chances: &[f64]) -> f64 {
    let bound = |tilt: f64| {
        let each = chances.iter().map(|chance| (chance * tilt.exp_m1()).ln_1p());
        each.sum::<f64>() - tilt * found as f64
    };
    let tilts = (0..40).map(|step| 0.25 * f64::from(step));
    tilts.map(bound).fold(0.0, f64::min).exp()
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
    let text = format!(
        "{rows} of {} rebounds {} another in every measured cell, {by_rounding}: {}",
        rebounds.len(),
        by_number(rows, "repeats", "repeat"),
        shortened(&words)
    );
    Some(match p < remarks::BEYOND_CHANCE {
        true => remarks::REPEATED_ROWS.check(p, text),
        false => remarks::REPEATS_PERHAPS.notice(rows, text),
    })
}

impl Block {
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

/// Probability of at least so many where so many are expected (Poisson).
fn at_least(found: usize, expected: f64) -> f64 {
    if found == 0 {
        return 1.0;
    }
    chi_squared_tail(2.0 * expected, 2.0 * found as f64).map_or(1.0, |fewer| 1.0 - fewer)
}

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

/// Which rows a mean may be of.
#[derive(Clone, Copy, PartialEq)]
enum MeanOf {
    /// those just above, down to the mean before
    Above,
    /// those just below
    Below,
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
        matches!(self, MeanOf::Above | MeanOf::Below | MeanOf::All)
    }
}

/// Questions rows that are means of others, by the least likely of all ways in which these may stand in a table.
fn question_means(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    /// digits to which means are rounded at least
    const COARSE: f64 = 0.01;
    const NAMED: usize = 8;
    // to the digits of the runs, or to fewer
    use MeanOf::{Above, All, Below, Block, Group, Last};
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
    let at_ends = [Above, Below].into_iter().map(|of| Means::at_one_end(rebounds, of));
    let Means { of, rows, expected, p } = found.chain(at_ends).min_by(|a, b| a.p.total_cmp(&b.p))?;
    let p = (tried * p).min(1.0);
    if rows.is_empty() || p >= remarks::BEYOND_CHANCE {
        return None;
    }
    let named = places.of_each(&rows[..rows.len().min(NAMED)]);
    let others = match of.is_of_one_speed() {
        true => "other rows near that speed",
        false => "the other rows of a group or block",
    };
    let text = format!(
        "{} {} the mean of {others}, in speed and restitution, where chance would make it {}: {}",
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
                MeanOf::Above | MeanOf::Block => above.take_while(belongs).take(most).collect(),
                MeanOf::Below => below.take_while(belongs).take(most).collect(),
                MeanOf::All | MeanOf::Group | MeanOf::Last => others.filter(belongs).take(most).collect(),
            };
            let speeds = Spread::of(block.iter().map(|other| other.speed));
            let restitutions = Spread::of(block.iter().map(|other| other.restitution));
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

#[cfg(test)]
mod tests;
