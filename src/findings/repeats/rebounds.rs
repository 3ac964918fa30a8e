//! Holds the rebounds of a table with what tells one from another: the last digits written, and how those near it scatter.

use std::ops::RangeInclusive;

use crate::physics::numbers::GRAVITY;
use crate::runs::Runs;

/// A rebound with what tells it from others.
#[derive(Clone, Default)]
pub(super) struct Rebound {
    pub row: u32,
    /// file or sheet, which has digits of its own
    pub table: usize,
    /// dry group or series
    pub group: usize,
    /// whether it is of a wet run
    pub wet: bool,
    pub film: f64,
    pub speed: f64,
    pub restitution: f64,
    /// by how much film, speed and restitution change with the last digit that was written
    pub steps: [f64; 3],
    /// by how much restitutions scatter at its setting
    pub scatter: f64,
    /// the other runs at its setting, and those of them whose speed agrees with its own to the last digit
    near: [f64; 2],
    /// whether another run of its table has its speed to every digit, which may then be one that was set
    pub is_set: bool,
    /// whether the runs of one speed in its table have different restitutions, as copies have not
    has_set_speeds: bool,
}

/// The rebounds of a table that are rows by themselves, in its order.
pub(super) fn rebounds(runs: &Runs, residual_sd: Option<f64>) -> Vec<Rebound> {
    let mut rebounds = rows_alone(runs);
    set_steps(&mut rebounds);
    set_scatter(
        &mut rebounds,
        residual_sd.map_or(LEAST_SCATTER, |sd| sd.max(LEAST_SCATTER)),
    );
    compare_speeds(&mut rebounds);
    rebounds
}

/// Those that are rows by themselves, in the order of the table. Runs that stuck at one height repeat by nature, and the runs
/// of a mean are of one row.
fn rows_alone(runs: &Runs) -> Vec<Rebound> {
    let dry = runs.dry.iter().map(|group| (false, group.rebounds.clone()));
    let wet = runs.series.iter().map(|series| (true, series.rebounds.clone()));
    let mut all: Vec<Rebound> = vec![];
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
    let alone = all.chunk_by(|one, other| one.row == other.row);
    alone.filter(|of_row| of_row.len() == 1).flatten().cloned().collect()
}

/// A step far below every measurement.
pub(super) const FINEST: f64 = 1e-9;

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
    pub fn rebound_speed(&self) -> f64 {
        self.speed * self.restitution
    }

    fn rebound_height(&self) -> f64 {
        self.rebound_speed().powi(2) / (2.0 * GRAVITY)
    }

    fn height_to_restitution(&self) -> f64 {
        GRAVITY / (self.speed * self.rebound_speed())
    }

    /// Film, speed and restitution.
    pub fn measured(&self) -> [f64; 3] {
        [self.film, self.speed, self.restitution]
    }

    /// Whether one of these is the same in another, as far as the one with fewer digits tells.
    pub fn agrees(&self, other: &Rebound, at: usize) -> bool {
        let apart = self.measured()[at] - other.measured()[at];
        is_rounded(apart, self.steps[at].max(other.steps[at]))
    }

    /// Whether another is of the same group and speed, about.
    pub fn is_near(&self, other: &Rebound) -> bool {
        /// as a share
        const CLOSE: f64 = 0.1;
        other.group == self.group && (other.speed / self.speed - 1.0).abs() <= CLOSE
    }

    /// Whether another is of the same group and speed, but for how speeds of one setting scatter.
    pub fn is_at_setting(&self, other: &Rebound) -> bool {
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

    /// Probability that its restitution and that of another run agree to the last digit r of the one with fewer, which is
    /// r/(2 √π s) where they scatter by s about one law.
    pub fn chance_of_restitution(&self, other: &Rebound) -> f64 {
        /// rather too likely than too rare: no scatter is normal, nor the same everywhere
        const CAUTIOUS: f64 = 1.25;
        let step = self.steps[2].max(other.steps[2]);
        let two_root_pi = 2.0 * std::f64::consts::PI.sqrt();
        let spread = (self.scatter.powi(2) + step * step / 12.0).sqrt();
        (CAUTIOUS * step / (two_root_pi * spread)).min(1.0)
    }

    /// The same of runs at one setting, and of their speeds where these were not set.
    pub fn chance_to_agree(&self, other: &Rebound) -> f64 {
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
        self.chance_of_restitution(other) * of_speeds
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

/// What no experiment scatters less than; only where neither the rows nor the laws fitted to them can tell.
const LEAST_SCATTER: f64 = 0.002;

/// The sd of single runs by their differences, `otherwise` where those that are no copies are few; `None` of few.
fn scatter_of<'d>(differences: impl Iterator<Item = &'d Difference>, otherwise: f64) -> Option<f64> {
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
    let least = if apart.len() < ENOUGH { otherwise } else { 0.0 };
    (rest.len() >= ENOUGH).then_some((0.5 * quarter.min(mean / OF_REST)).sqrt().max(least))
}

/// Sets by how much restitutions scatter at the setting of each rebound: as those near its speed do, or those of its group,
/// whichever is less.
fn set_scatter(rebounds: &mut [Rebound], otherwise: f64) {
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
        scatter_of(own.flat_map(|at| &differences[at]), otherwise).unwrap_or(otherwise)
    });
    let mut scatter = vec![0.0; sorted.len()];
    let mut start = 0;
    for group in sorted.chunk_by(|a, b| rebounds[*a].group == rebounds[*b].group) {
        let end = start + group.len();
        let of_group = scatter_of(differences[start..end].iter().flatten(), otherwise)
            .unwrap_or(of_all[usize::from(rebounds[group[0]].wet)]);
        for at in start..end {
            let near = at.saturating_sub(NEAR).max(start)..(at + NEAR).min(end);
            let near = scatter_of(differences[near].iter().flatten(), otherwise);
            scatter[sorted[at]] = near.map_or(of_group, |near| near.min(of_group));
        }
        start = end;
    }
    for (one, scatter) in rebounds.iter_mut().zip(scatter) {
        one.scatter = scatter;
    }
}

/// Whether rounding to a step explains a difference.
pub(super) fn is_rounded(apart: f64, step: f64) -> bool {
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

/// Bound on the probability of so many or more, each with a chance of its own (Chernoff).
pub(super) fn chance_of_so_many(found: usize, chances: &[f64]) -> f64 {
    let bound = |tilt: f64| {
        let each = chances.iter().map(|chance| (chance * tilt.exp_m1()).ln_1p());
        each.sum::<f64>() - tilt * found as f64
    };
    let tilts = (0..40).map(|step| 0.25 * f64::from(step));
    tilts.map(bound).fold(0.0, f64::min).exp()
}
