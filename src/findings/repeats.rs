//! Questions rows that are no runs of their own: those that repeat others, and means of others.

use std::collections::{HashMap, HashSet};

use super::remarks::{self, shortened};
use crate::distributions::chi_squared_tail;
use crate::physics::numbers::GRAVITY;
use crate::remark::Remark;
use crate::rounding::by_number;
use crate::runs::{RowPlaces, Runs};

/// Rebounds of the largest table that is looked at: a laboratory has no larger one, and in a longer one that was simulated a
/// repeated block would show as two equal hashes.
const MOST: usize = 100_000;

/// A rebound with what tells it from others.
struct Rebound {
    row: u32,
    /// file or sheet, which has digits of its own
    table: usize,
    /// dry group or series
    group: usize,
    /// whether it is of a wet run
    wet: bool,
    /// diameter, film, impact speed and errors, to the digits that survive a change of units
    setting: [i64; 6],
    film: f64,
    speed: f64,
    restitution: f64,
}

/// A number by its first nine digits: a value that was written in mm is not to the last bit what it is from µm.
fn digits(x: f64) -> i64 {
    const DIGITS: i32 = 9;
    if x == 0.0 || !x.is_finite() {
        return 0;
    }
    let last = x.abs().log10().floor() as i32 + 1 - DIGITS;
    let mantissa = (x * 10f64.powi(-last)).round() as i64;
    // 9.999… is 10
    match mantissa.abs() == 10i64.pow(DIGITS as u32) {
        true => 1000 * (mantissa / 10) + i64::from(last + 1),
        false => 1000 * mantissa + i64::from(last),
    }
}

/// The checks of a table's rows, and what of them is only named.
pub(super) fn check_rows(runs: &Runs) -> Vec<Remark> {
    let mut questioned = vec![];
    // few that stand for all are no rows
    if !runs.count.is_empty() || runs.len() > MOST {
        return questioned;
    }
    let rebounds = rebounds(runs);
    let grids = Grids::of(&rebounds);
    question_repeats(&rebounds, &grids, &runs.places, &mut questioned);
    if !questioned.iter().any(Remark::forbids) {
        // it says more than a notice of rows that repeat perhaps
        if let Some(check) = rounded_copies(&rebounds, &runs.places) {
            questioned = vec![check];
        }
    }
    question_means(&rebounds, &grids, &runs.places, &mut questioned);
    questioned
}

/// Those that are rows by themselves, in the order of the table. Runs that stuck at one height repeat by nature, and the runs
/// of a mean are of one row.
fn rebounds(runs: &Runs) -> Vec<Rebound> {
    let dry = runs.dry.iter().map(|group| (false, group.rebounds.clone()));
    let wet = runs.series.iter().map(|series| (true, series.rebounds.clone()));
    let mut all = vec![];
    for (group, (wet, range)) in dry.chain(wet).enumerate() {
        for run in range {
            let errors = runs.errors.as_ref().map_or([0.0; 2], |errors| errors.of(run));
            let correlation = runs.errors.as_ref().map_or(0.0, |errors| errors.correlation(run));
            let (diameter, film, speed) = (runs.diameter[run], runs.film[run], runs.impact_speed[run]);
            all.push(Rebound {
                row: runs.row[run],
                table: runs.places.table(runs.row[run]),
                group,
                wet,
                setting: [diameter, film, speed, errors[0], errors[1], correlation].map(digits),
                film,
                speed,
                restitution: runs.restitution[run],
            });
        }
    }
    all.sort_by_key(|rebound| rebound.row);
    let of_row = |row: u32| all.partition_point(|one| one.row <= row) - all.partition_point(|one| one.row < row);
    let is_alone: Vec<bool> = all.iter().map(|one| of_row(one.row) == 1).collect();
    let mut is_alone = is_alone.into_iter();
    all.retain(|_| is_alone.next() == Some(true));
    all
}

/// To how many digits each table has what was measured.
struct Grids(Vec<Grid>);

/// To how many digits a table has what was measured.
struct Grid {
    speed: f64,
    restitution: f64,
    rebound_speed: f64,
    /// of the rebound, above the film or the plate
    height: f64,
}

impl Grids {
    fn of(rebounds: &[Rebound]) -> Grids {
        let tables = rebounds.iter().map(|one| one.table + 1).max().unwrap_or_default();
        let mut of_tables: Vec<Vec<&Rebound>> = vec![vec![]; tables];
        for one in rebounds {
            of_tables[one.table].push(one);
        }
        Grids(of_tables.iter().map(|rebounds| Grid::of(rebounds)).collect())
    }

    /// That of the table of a rebound.
    fn at(&self, one: &Rebound) -> &Grid {
        &self.0[one.table]
    }
}

impl Grid {
    fn of(rebounds: &[&Rebound]) -> Grid {
        let speed = |one: &Rebound| one.speed * one.restitution;
        let of_speed = grid(rebounds, |one| one.speed, |_| 0.0);
        let of_restitution = grid(rebounds, |one| one.restitution, |_| 0.0);
        // what rounding of e, and of v where e was not made from the v that is written, leaves of what e was made from
        let coarsest = |value: &dyn Fn(&Rebound) -> f64, to_value: &dyn Fn(&Rebound) -> f64| {
            let grids = [0.0, of_speed].map(|of_speed| {
                let left = |one: &Rebound| 0.5 * (of_restitution * one.speed + of_speed * one.restitution);
                grid(rebounds, value, |one| left(one) * to_value(one))
            });
            f64::max(grids[0], grids[1])
        };
        let of_height = GRAVITIES.map(|gravity| {
            let height = |one: &Rebound| speed(one).powi(2) / (2.0 * gravity);
            let to_height = |one: &Rebound| speed(one) / gravity;
            coarsest(&height, &to_height).max(coarsest(&|one| height(one) + one.film, &to_height))
        });
        Grid {
            speed: of_speed,
            restitution: of_restitution,
            rebound_speed: coarsest(&speed, &|_| 1.0),
            height: of_height.into_iter().fold(0.0, f64::max),
        }
    }

    /// By how much the restitution of a rebound changes with the last digit that was written of it.
    fn of_restitution(&self, one: &Rebound) -> f64 {
        let height_to_restitution = GRAVITY / (one.speed * one.speed * one.restitution);
        let by_rebound = (self.rebound_speed / one.speed).max(self.height * height_to_restitution);
        self.restitution.max(by_rebound)
    }
}

/// By which tables make speeds from heights.
const GRAVITIES: [f64; 3] = [GRAVITY, 9.806_65, 9.8];

/// The largest of 1, 0.5, 0.2, 0.1 and so on that nearly all values are multiples of, as far as what rounding left of them
/// tells; far below every measurement where there is none.
fn grid(rebounds: &[&Rebound], value: impl Fn(&Rebound) -> f64, left: impl Fn(&Rebound) -> f64) -> f64 {
    const MOST_DECIMALS: i32 = 7;
    const NEARLY_ALL: f64 = 0.95;
    const ROUNDING: f64 = 1e-5;
    /// of a step, what rounding may leave so that multiples are still told
    const TOLD: f64 = 0.15;
    let decimals = (0..=MOST_DECIMALS).map(|decimals| 0.1f64.powi(decimals));
    let steps = decimals.flat_map(|step| [step, 0.5 * step, 0.2 * step]);
    let mut found = steps.filter(|step| {
        let is_on = |one: &&&Rebound| {
            let steps = value(one) / step;
            let near = (left(one) / step).max(ROUNDING);
            near < TOLD && (steps - steps.round()).abs() < near
        };
        rebounds.iter().filter(is_on).count() as f64 >= NEARLY_ALL * rebounds.len() as f64
    });
    found.next().unwrap_or(1e-9)
}

/// How restitutions scatter at one setting, for each group.
fn scatter_of_groups(rebounds: &[&Rebound]) -> Vec<f64> {
    /// speeds of one setting, as a share
    const CLOSE: f64 = 0.02;
    /// pairs that tell a scatter
    const ENOUGH: usize = 10;
    /// what no experiment scatters less than; only where the rows cannot tell
    const LEAST: f64 = 0.002;
    let groups = rebounds.iter().map(|one| one.group + 1).max().unwrap_or_default();
    let mut of_groups: Vec<Vec<&Rebound>> = vec![vec![]; groups];
    for one in rebounds {
        of_groups[one.group].push(one);
    }
    let squares_of = |group: &mut Vec<&Rebound>| -> Vec<f64> {
        // stable: at one speed in the order of the table
        group.sort_by(|one, other| one.speed.total_cmp(&other.speed));
        let pairs = group.windows(2);
        let close = pairs.filter(|pair| pair[1].speed <= (1.0 + CLOSE) * pair[0].speed);
        close
            .map(|pair| (pair[1].restitution - pair[0].restitution).powi(2))
            .collect()
    };
    let squares: Vec<Vec<f64>> = of_groups.iter_mut().map(squares_of).collect();
    let is_wet = |group: usize| of_groups[group].first().is_some_and(|one| one.wet);
    let sd = |mut squares: Vec<f64>| {
        squares.sort_by(f64::total_cmp);
        // without what outliers add
        squares.truncate(squares.len() - squares.len() / 10);
        (0.5 * squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    };
    let of_all = [false, true].map(|wet| {
        let own = (0..groups).filter(|group| is_wet(*group) == wet);
        let all: Vec<f64> = own.flat_map(|group| squares[group].clone()).collect();
        let differing = all.iter().filter(|square| **square > 0.0).count();
        sd(all).max(if differing < ENOUGH { LEAST } else { 0.0 })
    });
    let of_group = |group: usize| match squares[group].len() >= ENOUGH {
        true => sd(squares[group].clone()),
        false => of_all[usize::from(is_wet(group))],
    };
    (0..groups).map(of_group).collect()
}

/// Rows in the order of others that they repeat.
struct Block {
    rows: [u32; 2],
    repeats: [u32; 2],
    length: usize,
    /// probability that one such row after the other is met by rounding
    chance: f64,
}

/// Rows in a block that is no accident by its length alone.
const IN_ORDER: usize = 3;

/// The places of rows that repeat an earlier one, each with that one's, cut where the order of the earlier ones ends.
fn copied_blocks(rebounds: &[Rebound]) -> Vec<Vec<[usize; 2]>> {
    let key = |one: &Rebound| (one.group, one.setting, digits(one.restitution));
    let mut first = HashMap::new();
    let mut blocks: Vec<Vec<[usize; 2]>> = vec![];
    // the row that the one before repeats
    let mut last: Option<usize> = None;
    for (place, one) in rebounds.iter().enumerate() {
        let earliest = *first.entry(key(one)).or_insert(place);
        let next = last
            .map(|last| last + 1)
            .filter(|next| *next < place && key(&rebounds[*next]) == key(one));
        last = next.or(Some(earliest).filter(|earliest| *earliest < place));
        let Some(source) = last else {
            continue;
        };
        match blocks.last_mut().filter(|_| next.is_some()) {
            Some(block) => block.push([place, source]),
            None => blocks.push(vec![[place, source]]),
        }
    }
    blocks
}

/// Probability that of two runs at one setting the restitutions are the same to the last digit r written, which is
/// r/(2 √π s) where they scatter by s.
fn chance_of_same(step: f64, scatter: f64) -> f64 {
    /// rather too likely than too rare: no scatter is normal, nor the same everywhere
    const CAUTIOUS: f64 = 1.5;
    let two_root_pi = 2.0 * std::f64::consts::PI.sqrt();
    let spread = (scatter.powi(2) + step * step / 12.0).sqrt();
    (CAUTIOUS * step / (two_root_pi * spread)).min(1.0)
}

/// Questions rows that have the cells of earlier ones.
fn question_repeats(rebounds: &[Rebound], grids: &Grids, places: &RowPlaces, questioned: &mut Vec<Remark>) {
    let copied = copied_blocks(rebounds);
    if copied.is_empty() {
        return;
    }
    // copies scatter by nothing, and would make themselves likely
    let in_order = copied.iter().filter(|block| block.len() >= IN_ORDER).flatten();
    let in_order: HashSet<usize> = in_order.map(|[place, _]| *place).collect();
    let others = rebounds
        .iter()
        .enumerate()
        .filter(|(place, _)| !in_order.contains(place));
    let others: Vec<&Rebound> = others.map(|(_, one)| one).collect();
    let scatter = scatter_of_groups(&others);
    let chance = |one: &Rebound| chance_of_same(grids.at(one).of_restitution(one), scatter[one.group]);
    let mut at_setting: HashMap<(usize, [i64; 6]), usize> = HashMap::new();
    let mut expected = 0.0;
    for one in rebounds {
        let before = at_setting.entry((one.group, one.setting)).or_default();
        expected += (*before as f64 * chance(one)).min(1.0);
        *before += 1;
    }
    let block = |pairs: &Vec<[usize; 2]>| {
        let ends = |which: usize| [pairs[0], pairs[pairs.len() - 1]].map(|pair| rebounds[pair[which]].row);
        Block {
            rows: ends(0),
            repeats: ends(1),
            length: pairs.len(),
            chance: pairs.iter().map(|[place, _]| chance(&rebounds[*place])).product(),
        }
    };
    let mut blocks: Vec<Block> = copied.iter().map(block).collect();
    let repeated: usize = copied.iter().map(Vec::len).sum();
    let pairs = 0.5 * (rebounds.len() as f64).powi(2);
    let in_order = blocks.iter().filter(|block| block.length >= IN_ORDER);
    let of_blocks = in_order.map(|block| pairs * block.chance).fold(1.0, f64::min);
    // the rarer of two
    let of_all = at_least(repeated, expected);
    let p = (2.0 * of_blocks.min(of_all)).min(1.0);
    blocks.sort_by_key(|block| std::cmp::Reverse(block.length));
    let words: Vec<String> = blocks.iter().map(|block| block.words(places)).collect();
    let by_rounding = if of_blocks < of_all {
        "in the order of these".to_owned()
    } else {
        format!("where rounding alone would make it {expected:.1}")
    };
    let text = format!(
        "{repeated} of {} rebounds {} another in every measured cell, {by_rounding}: {}",
        rebounds.len(),
        by_number(repeated, "repeats", "repeat"),
        shortened(&words)
    );
    if p < remarks::BEYOND_CHANCE {
        questioned.push(remarks::REPEATED_ROWS.check(p, text));
    } else if p < UNLIKELY {
        questioned.push(remarks::REPEATS_PERHAPS.notice(repeated, text));
    }
}

/// The digits after the point that a block has of speeds and restitutions, beyond which none are told.
const MOST_DECIMALS: i32 = 6;

/// The fewest decimals that a number is written with.
fn decimals(x: f64) -> i32 {
    let is_whole = |decimals: &i32| {
        let scaled = x * 10f64.powi(*decimals);
        (scaled - scaled.round()).abs() < 1e-6
    };
    (0..MOST_DECIMALS).find(is_whole).unwrap_or(MOST_DECIMALS)
}

impl Rebound {
    /// Speed and restitution.
    fn measured(&self) -> [f64; 2] {
        [self.speed, self.restitution]
    }

    /// Whether another may be it with other digits, for steps of speed and restitution.
    fn may_be(&self, other: &Rebound, steps: [f64; 2]) -> bool {
        /// films are written with fewer digits, too
        const SAME_FILM: f64 = 0.03;
        let is_near = |at: usize| {
            let apart = (self.measured()[at] - other.measured()[at]).abs();
            apart <= 0.5 * steps[at] * (1.0 + 1e-6) + 1e-12
        };
        self.group == other.group
            && self.setting[0] == other.setting[0]
            && (self.film - other.film).abs() <= SAME_FILM * self.film
            && is_near(0)
            && is_near(1)
    }
}

/// The check of rows that have in the order of others the cells of these, rounded to fewer digits; `None` without such rows
/// beyond chance.
fn rounded_copies(rebounds: &[Rebound], places: &RowPlaces) -> Option<Remark> {
    /// rebounds of the largest table in which each pair is looked at
    const MOST: usize = 5000;
    /// no table has fewer digits of speed or restitution than these steps
    const COARSEST: [f64; 2] = [0.1, 0.01];
    /// rows of a block, at least
    const FEWEST: usize = 6;
    let count = rebounds.len();
    let mut blocks: Vec<Block> = vec![];
    let first = if count <= MOST { FEWEST } else { count };
    for offset in first..count {
        let mut start = offset;
        while start < count {
            let agree = |place: &usize| rebounds[*place].may_be(&rebounds[*place - offset], COARSEST);
            let end = (start..count).find(|place| !agree(place)).unwrap_or(count);
            if end - start >= FEWEST {
                blocks.extend(rounded_block(rebounds, [start, end], offset, FEWEST));
            }
            start = end + 1;
        }
    }
    let pairs = 0.5 * (count as f64).powi(2);
    blocks.retain(|block| pairs * block.chance < remarks::BEYOND_CHANCE);
    blocks.sort_by_key(|block| std::cmp::Reverse(block.length));
    let mut named: Vec<Block> = vec![];
    for block in blocks {
        let overlaps = |other: &Block| block.rows[0] <= other.rows[1] && other.rows[0] <= block.rows[1];
        if !named.iter().any(overlaps) {
            named.push(block);
        }
    }
    let p = pairs * named.iter().map(|block| block.chance).reduce(f64::min)?;
    let repeated: usize = named.iter().map(|block| block.length).sum();
    let words: Vec<String> = named.iter().map(|block| block.words(places)).collect();
    let text = format!(
        "{repeated} of {count} rebounds repeat others in every measured cell but for rounding to fewer digits, in the order of \
         these: {}",
        shortened(&words)
    );
    Some(remarks::REPEATED_ROWS.check(p, text))
}

/// The longest part of some rows that repeats those so many places before with other digits; `None` where it has the same.
fn rounded_block(rebounds: &[Rebound], [start, end]: [usize; 2], offset: usize, fewest: usize) -> Option<Block> {
    let digits_of = |rows: &[Rebound]| {
        [0, 1].map(|at| {
            rows.iter()
                .map(|one| decimals(one.measured()[at]))
                .max()
                .unwrap_or(MOST_DECIMALS)
        })
    };
    let digits = [start, start - offset].map(|from| digits_of(&rebounds[from..from + end - start]));
    if digits[0] == digits[1] {
        return None;
    }
    let steps = [0, 1].map(|at| 0.1f64.powi(digits[0][at].min(digits[1][at])));
    let is_copy = |place: usize| rebounds[place].may_be(&rebounds[place - offset], steps);
    let mut longest = [start, start];
    let mut from = start;
    for place in start..end {
        if !is_copy(place) {
            from = place + 1;
        } else if place + 1 - from > longest[1] - longest[0] {
            longest = [from, place + 1];
        }
    }
    let [start, end] = longest;
    if end - start < fewest {
        return None;
    }
    // the copies would make themselves likely
    let others = rebounds
        .iter()
        .enumerate()
        .filter(|(place, _)| !(start..end).contains(place));
    let others: Vec<&Rebound> = others.map(|(_, one)| one).collect();
    let scatter = scatter_of_groups(&others);
    let of_speeds = scatter_of_speeds(&others);
    let chance = |one: &Rebound| {
        let of_group = scatter.get(one.group).copied().unwrap_or(0.0);
        chance_of_same(steps[1], of_group) * chance_of_same(steps[0], of_speeds * one.speed)
    };
    let ends = |offset: usize| [start, end - 1].map(|place| rebounds[place - offset].row);
    Some(Block {
        rows: ends(0),
        repeats: ends(offset),
        length: end - start,
        chance: rebounds[start..end].iter().map(chance).product(),
    })
}

/// How speeds scatter from one run to the next at one setting, as a share; 0 where too few runs tell.
fn scatter_of_speeds(rebounds: &[&Rebound]) -> f64 {
    const ENOUGH: usize = 10;
    let next = rebounds
        .windows(2)
        .filter(|pair| pair[0].group == pair[1].group && pair[0].is_near(pair[1]));
    let mut squares: Vec<f64> = next.map(|pair| (pair[1].speed / pair[0].speed).ln().powi(2)).collect();
    if squares.len() < ENOUGH {
        return 0.0;
    }
    // the median, since steps from one setting to the next may be as small; of squares of a normal it is 0.455
    squares.sort_by(f64::total_cmp);
    (0.5 * squares[squares.len() / 2] / 0.455).sqrt()
}

/// A probability below which repeats that may be chance are named.
const UNLIKELY: f64 = 0.05;

impl Block {
    fn words(&self, places: &RowPlaces) -> String {
        let rows = places.of_range(self.rows, None);
        let repeats = places.of_range(self.repeats, Some(self.rows[0]));
        let verb = if self.length == 1 { "repeats" } else { "repeat" };
        format!("{rows} {verb} {repeats}")
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
    rows: Vec<u32>,
    expected: f64,
    p: f64,
}

/// Which rows a mean may be of.
#[derive(Clone, Copy)]
enum MeanOf {
    /// those just above, down to the mean before
    Above,
    /// those just below
    Below,
    /// all others near its speed
    All,
}

/// Questions rows that are means of others, by the least likely of all ways in which these may stand in a table.
fn question_means(rebounds: &[Rebound], grids: &Grids, places: &RowPlaces, questioned: &mut Vec<Remark>) {
    /// digits to which means are rounded at least
    const COARSE: f64 = 0.01;
    const NAMED: usize = 8;
    let near = Neighbours::of(rebounds);
    // to the digits of the runs, or to fewer
    let ways = [MeanOf::Above, MeanOf::Below, MeanOf::All].into_iter();
    let ways = ways.flat_map(|of| [(of, 0.0), (of, COARSE)]);
    let found: Vec<Means> = ways
        .map(|(of, step)| Means::of_one_kind(rebounds, grids, &near, of, step))
        .collect();
    let tried = found.len() as f64;
    let Some(Means { rows, expected, p }) = found.into_iter().min_by(|a, b| a.p.total_cmp(&b.p)) else {
        return;
    };
    let p = (tried * p).min(1.0);
    if rows.is_empty() || p >= remarks::BEYOND_CHANCE {
        return;
    }
    let mut named = places.of_each(&rows[..rows.len().min(NAMED)]);
    if rows.len() > NAMED {
        named.push(format!("and {} more", rows.len() - NAMED));
    }
    let text = format!(
        "{} {} the mean of other rows near that speed, in speed and restitution, where chance would make it {expected:.1}: {}",
        rows.len(),
        by_number(rows.len(), "row is", "rows are"),
        named.join(", ")
    );
    questioned.push(remarks::MEAN_ROWS.check(p, text));
}

impl Means {
    /// Those of one way, their restitutions rounded to this step at least.
    fn of_one_kind(rebounds: &[Rebound], grids: &Grids, near: &Neighbours, of: MeanOf, rounded_to: f64) -> Means {
        /// rows of a block
        const ROWS: std::ops::RangeInclusive<usize> = 3..=50;
        let mut rows: Vec<u32> = vec![];
        let mut expected = 0.0;
        // where the next block may begin
        let mut begin = 0;
        for (place, one) in rebounds.iter().enumerate() {
            let steps = one.restitution / rounded_to;
            if rounded_to > 0.0 && (steps - steps.round()).abs() > 1e-6 {
                continue;
            }
            let is_near = |other: &&Rebound| one.is_near(other);
            let most = ROWS.end() + 1;
            let block: Vec<&Rebound> = match of {
                MeanOf::Above => rebounds[begin..place]
                    .iter()
                    .rev()
                    .take_while(is_near)
                    .take(most)
                    .collect(),
                MeanOf::Below => rebounds[place + 1..].iter().take_while(is_near).take(most).collect(),
                MeanOf::All => near.of_one(rebounds, place, most),
            };
            let speeds = Spread::of(block.iter().map(|other| other.speed));
            let restitutions = Spread::of(block.iter().map(|other| other.restitution));
            // equal rows are repeats
            if !ROWS.contains(&block.len()) || restitutions.sd == 0.0 {
                continue;
            }
            let step = grids.at(one).of_restitution(one).max(rounded_to);
            let speed_step = grids.at(one).speed.max(rounded_to);
            expected += speeds.chance(speed_step) * restitutions.chance(step);
            if speeds.has_mean(one.speed, speed_step) && restitutions.has_mean(one.restitution, step) {
                rows.push(one.row);
                begin = place + 1;
            }
        }
        let p = at_least(rows.len(), expected);
        Means { rows, expected, p }
    }
}

impl Rebound {
    /// Whether another is of the same group and speed, about.
    fn is_near(&self, other: &Rebound) -> bool {
        /// as a share
        const CLOSE: f64 = 0.1;
        other.group == self.group && (other.speed / self.speed - 1.0).abs() <= CLOSE
    }
}

/// The places of rows by group and speed.
struct Neighbours {
    sorted: Vec<usize>,
    /// where each stands among the sorted
    rank: Vec<usize>,
}

impl Neighbours {
    fn of(rebounds: &[Rebound]) -> Neighbours {
        let mut sorted: Vec<usize> = (0..rebounds.len()).collect();
        let key = |place: &usize| (rebounds[*place].group, rebounds[*place].speed);
        sorted.sort_by(|a, b| {
            let (a, b) = (key(a), key(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let mut rank = vec![0; sorted.len()];
        sorted.iter().enumerate().for_each(|(at, place)| rank[*place] = at);
        Neighbours { sorted, rank }
    }

    /// All others near one, cut beyond so many.
    fn of_one<'r>(&self, rebounds: &'r [Rebound], place: usize, most: usize) -> Vec<&'r Rebound> {
        let at = self.rank[place];
        let is_near = |other: &&Rebound| rebounds[place].is_near(other);
        let slower = self.sorted[..at].iter().rev().map(|other| &rebounds[*other]);
        let faster = self.sorted[at + 1..].iter().map(|other| &rebounds[*other]);
        slower
            .take_while(is_near)
            .take(most)
            .chain(faster.take_while(is_near).take(most))
            .collect()
    }
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
        (value - self.mean).abs() <= 0.5 * step * (1.0 + 1e-6) + 1e-12
    }

    /// Probability that one more value is.
    fn chance(&self, step: f64) -> f64 {
        let root_two_pi = (2.0 * std::f64::consts::PI).sqrt();
        let sd = self.sd * (1.0 + 1.0 / self.count).sqrt();
        (step / (root_two_pi * sd)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::RngExt;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::runs::{arrange, NewRun};
    use crate::scene::{self, Scene};
    use crate::seed::stream;

    fn scene() -> Scene {
        let text = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n\
                    [liquids.oil]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
        scene::parse(text, Path::new("a/scene.toml"), String::new()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// How the tables of one kind are made.
    #[derive(Clone, Copy)]
    struct Kind {
        /// the last digit of a restitution
        step: f64,
        /// what restitutions scatter by
        sd: f64,
        /// runs of a setting
        repeats: usize,
        /// what speeds are spread by about the set ones, as a share
        speeds: f64,
    }

    fn rounded(x: f64, step: f64) -> f64 {
        format!("{:.6}", (x / step).round() * step).parse().unwrap_or(x)
    }

    /// Dry runs and those of two films, down to near sticking; a few scatter more than the others.
    fn table(kind: Kind, set: u64) -> Vec<NewRun<'static>> {
        let mut rng = stream(7, "tables without repeats", set);
        let mut all = vec![];
        for film in [None, Some((286e-6, 0.06)), Some((381e-6, 0.08))] {
            for speed in [0.45, 0.77, 1.08, 1.4, 1.71] {
                for _ in 0..kind.repeats {
                    let noise: f64 = StandardNormal.sample(&mut rng);
                    let wider = if rng.random_range(0..20) == 0 { 3.0 } else { 1.0 };
                    let spread: f64 = StandardNormal.sample(&mut rng);
                    let v = rounded(speed * (1.0 + kind.speeds * spread), 0.001);
                    let loss = film.map_or(0.0, |_| 0.15 / v);
                    let e = (1.0 - 0.18 * v.powf(0.2) - loss + wider * kind.sd * noise).max(0.0);
                    all.push(NewRun {
                        particle: "PTFE",
                        liquid: film.map(|_| "oil"),
                        diameter: 4.762e-3,
                        film,
                        impact_speed: v,
                        restitution: rounded(e, kind.step),
                    });
                }
            }
        }
        all
    }

    fn codes(rows: &[NewRun]) -> Vec<&'static str> {
        let found = check_rows(&arrange(&scene(), rows));
        let forbidding = found.iter().filter(|remark| remark.forbids());
        forbidding.map(|remark| remark.code).collect()
    }

    fn kinds() -> Vec<Kind> {
        let mut kinds = vec![];
        for (step, sd) in [
            (0.01, 0.015),
            (0.01, 0.003),
            (0.001, 0.015),
            (0.001, 0.004),
            (1e-4, 0.01),
        ] {
            for repeats in [3, 10] {
                for speeds in [0.0, 0.01] {
                    kinds.push(Kind {
                        step,
                        sd,
                        repeats,
                        speeds,
                    });
                }
            }
        }
        kinds
    }

    #[test]
    fn runs_that_agree_by_rounding_are_let_be() {
        const SETS: u64 = 100;
        let mut found = vec![];
        for (place, kind) in kinds().into_iter().enumerate() {
            let alarms = (0..SETS).filter(|set| !codes(&table(kind, 1000 * place as u64 + set)).is_empty());
            found.push(alarms.count());
        }
        // 1 % of 2,000 tables, and no kind of table with many
        assert!(
            found.iter().sum::<usize>() <= 20 && found.iter().all(|alarms| *alarms <= 3),
            "{found:?}"
        );
    }

    #[test]
    fn pasted_blocks_and_means_are_found() {
        for (place, kind) in kinds().into_iter().enumerate() {
            let rows = table(kind, 50_000 + place as u64);
            // half of the table pasted below it, all of it, and all of it twice
            let (half, all) = (&rows[..rows.len() / 2], &rows[..]);
            for pasted in [[half].concat(), [all].concat(), [all, all].concat()] {
                let again: Vec<NewRun> = [&rows[..], &pasted].concat();
                let found = codes(&again);
                // where nearly every run has the same digits as its neighbours, nobody can tell
                let is_plain = kind.sd < 0.5 * kind.step;
                assert!(is_plain || found.contains(&"repeated_rows"), "{place}: {found:?}");
            }
            let mean = |block: &[NewRun<'static>], step: f64| {
                let mean = |of: fn(&NewRun) -> f64| block.iter().map(of).sum::<f64>() / block.len() as f64;
                NewRun {
                    impact_speed: rounded(mean(|run| run.impact_speed), 0.001),
                    restitution: rounded(mean(|run| run.restitution), step),
                    ..block[0]
                }
            };
            let blocks = || rows.chunks(kind.repeats);
            let below = blocks().flat_map(|block| [block, &[mean(block, kind.step)]].concat());
            let above = blocks().flat_map(|block| [&[mean(block, kind.step)], block].concat());
            let foot = rows.iter().copied().chain(blocks().map(|block| mean(block, kind.step)));
            let coarse = blocks().flat_map(|block| [block, &[mean(block, 0.01)]].concat());
            let tables: [Vec<NewRun>; 4] = [below.collect(), above.collect(), foot.collect(), coarse.collect()];
            let is_fine = kind.step <= 0.1 * kind.sd;
            for (at, table) in tables.iter().enumerate() {
                // where the mean is known to about the digits that the last has, nobody can tell
                let is_told = is_fine && (at < 3 || kind.repeats > 3 && kind.sd > 0.01);
                assert!(!is_told || codes(table).contains(&"mean_rows"), "{place}, {at}");
            }
        }
    }

    /// Written with four digits, but made from heights of rebound read to a millimetre, or from speeds read to 0.01 m/s.
    #[test]
    fn restitutions_of_coarse_readings_are_let_be() {
        // without the digits of its own a table is as fine as it is read
        for (place, kind) in kinds().into_iter().enumerate().filter(|(_, kind)| kind.step < 0.01) {
            let made = |one: &NewRun<'static>, by_height: bool| {
                let v = one.impact_speed;
                let rebound = v * one.restitution;
                let e = if by_height {
                    let height = rounded(rebound * rebound / (2.0 * GRAVITY), 0.001);
                    (2.0 * GRAVITY * height).sqrt() / v
                } else {
                    rounded(rebound, 0.01) / v
                };
                NewRun {
                    restitution: rounded(e, 1e-4),
                    ..*one
                }
            };
            let is_clear = |one: &NewRun| one.impact_speed > 0.7;
            for by_height in [true, false] {
                let alarms = (0..20).filter(|set| {
                    let rows = table(kind, 70_000 + 100 * place as u64 + set);
                    let rows: Vec<NewRun> = rows
                        .iter()
                        .filter(|one| is_clear(one))
                        .map(|one| made(one, by_height))
                        .collect();
                    !codes(&rows).is_empty()
                });
                assert!(alarms.count() <= 1, "{place} {by_height}");
            }
        }
    }

    #[test]
    fn a_copy_with_fewer_digits_is_one() {
        let fewer = |run: &NewRun<'static>, speed: f64, restitution: f64| NewRun {
            impact_speed: rounded(run.impact_speed, speed),
            restitution: rounded(run.restitution, restitution),
            ..*run
        };
        let is_rounded_copy = |rows: &[NewRun]| {
            let found = check_rows(&arrange(&scene(), rows));
            found
                .iter()
                .any(|check| check.forbids() && check.text.contains("fewer digits"))
        };
        for (place, kind) in kinds().into_iter().enumerate() {
            let rows = table(kind, 90_000 + place as u64);
            // where nearly every run of a setting has the same digits then, nobody can tell
            let is_told = kind.sd > 0.0075 && kind.step < 0.01;
            let from = [0, rows.len() / 3];
            for (speed, from) in [(0.01, from[0]), (1e-3, from[0]), (0.01, from[1])] {
                let copied = rows[from..].iter().map(|run| fewer(run, speed, 0.01));
                let copied: Vec<NewRun> = copied.collect();
                // fewer digits repeat each other, too, which may be what is told
                let is_found = codes(&[&rows[..], &copied].concat()).contains(&"repeated_rows");
                assert!(is_found || !is_told || copied.len() < 40, "{place} {speed} {from}");
                // the same design anew, written with fewer digits
                let anew = table(kind, 95_000 + place as u64);
                let anew: Vec<NewRun> = anew.iter().map(|run| fewer(run, speed, 0.01)).collect();
                assert!(!is_rounded_copy(&[&rows[..], &anew].concat()), "{place} {speed}");
            }
        }
    }

    #[test]
    fn a_copy_in_other_units_is_one() {
        let mut rows = table(kinds()[8], 3);
        let copied = rows.iter().map(|run| NewRun {
            impact_speed: run.impact_speed * 1000.0 / 1e3 * (1.0 + f64::EPSILON),
            film: run.film.map(|(film, ratio)| (film * (1.0 - f64::EPSILON), ratio)),
            ..*run
        });
        let copied: Vec<NewRun> = copied.collect();
        rows.extend(copied);
        assert_eq!(codes(&rows), ["repeated_rows"]);
    }

    #[test]
    fn a_block_is_named_by_its_rows() {
        let kind = Kind {
            step: 0.001,
            sd: 0.01,
            repeats: 3,
            speeds: 0.01,
        };
        let rows = table(kind, 1);
        let found = check_rows(&arrange(&scene(), &[&rows[..], &rows[3..12]].concat()));
        let texts: Vec<&str> = found.iter().map(|check| check.text.as_str()).collect();
        assert!(
            texts.len() == 1 && texts[0].contains("rows 46 to 54 repeat rows 4 to 12"),
            "{texts:?}"
        );
    }

    #[test]
    fn runs_that_stuck_repeat_by_nature() {
        let kind = kinds()[6];
        let mut rows = table(kind, 2);
        let stuck = NewRun {
            impact_speed: 0.2,
            restitution: 0.0,
            ..rows[20]
        };
        rows.extend([stuck; 20]);
        assert_eq!(codes(&rows), Vec::<&str>::new());
    }
}
