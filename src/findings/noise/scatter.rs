//! Finds the scatter of the runs about the joint fit in a way that outliers do not mislead.

use super::rows::{Rows, RunKind};
use crate::inference::joint::JointRow;
use crate::inference::spreads::{median, SD_OF_MEDIAN_DISTANCE};
use crate::physics::rebound::{kept_of_mean_restitution, slope_mean_restitution};
use crate::runs::is_in_even_share;

/// More runs than this of a kind say little new of its scatter: of longer tables about so many are taken.
const MOST_RUNS: usize = 20_000;

/// A mean this many sds above the limit of sticking is not cut off by it.
const CLEAR: f64 = 3.0;

/// Variance of a restitution: σ² + (σ_r m′(r))² + τ², σ_r = 0 where only the restitution scatters, τ the run's own
/// measurement errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scatter {
    /// σ²
    restitution: f64,
    /// σ_r²
    energy: f64,
}

impl Scatter {
    /// sd of a run.
    pub(super) fn sd(self, row: &JointRow) -> f64 {
        (self.at(row.kept) + row.measured).sqrt()
    }

    /// sd of runs that keep all their energy, without measurement errors.
    pub(super) fn least(self) -> f64 {
        self.at(1.0).sqrt()
    }

    fn at(self, kept: f64) -> f64 {
        if self.energy > 0.0 {
            let slope = slope_mean_restitution(kept);
            self.restitution + self.energy * slope * slope
        } else {
            self.restitution
        }
    }

    /// The sd by which a restitution so far away is judged: m(r) is curved, and what counts is its slope on the way.
    pub(super) fn sd_to(self, row: &JointRow, restitution: f64) -> f64 {
        let away = row.kept - kept_of_mean_restitution(restitution);
        if self.energy > 0.0 && away.abs() > 1e-9 {
            let slope = row.residual / away;
            (self.restitution + self.energy * slope * slope + row.measured).sqrt()
        } else {
            self.sd(row)
        }
    }
}

/// The joint fit without the runs that lie far from it.
pub(super) struct RobustFit {
    pub(super) point: Vec<f64>,
    /// scatter of each kind
    pub(super) scatter: [Scatter; 2],
    /// residuals of each group over the sd of their kind, of those runs that were taken
    pub(super) residuals: Vec<Vec<f64>>,
}

/// A rebound among those that the scatter is told from.
pub(super) struct SampledRun {
    /// index into [`Rows::parts`]
    pub(super) part: usize,
    pub(super) kind: RunKind,
    pub(super) row: JointRow,
    clear: bool,
    accepted: bool,
}

impl SampledRun {
    /// Its sd, with the scatter of each kind.
    pub(super) fn sd(&self, scatter: &[Scatter; 2]) -> f64 {
        scatter[self.kind as usize].sd(&self.row)
    }
}

/// Fits, leaves out what lies further than `far` sds, and fits again until the same runs are left out.
///
/// `None` where the runs show no scatter, or none is clear of the limit of sticking.
pub(super) fn fit_robustly(rows: &Rows, far: f64) -> Option<RobustFit> {
    /// the sets left out settle in a few rounds, or alternate between two that are as good
    const ROUNDS: usize = 10;
    const WORSE: f64 = 1.1;
    let mut point = rows.point.clone();
    let mut taken = take(rows, &point);
    let mut scatter = scatter(rows, &mut taken, None)?;
    for _ in 0..ROUNDS {
        if !accept(&mut taken, &scatter, far) {
            break;
        }
        let step = step(rows, &taken, &scatter);
        let stepped: Vec<f64> = point.iter().zip(step.iter()).map(|(x, dx)| x + dx).collect();
        if !rows.joint.holds(&stepped) {
            break;
        }
        let accepted: Vec<bool> = taken.iter().map(|one| one.accepted).collect();
        let mut next = take(rows, &stepped);
        next.iter_mut()
            .zip(accepted)
            .for_each(|(one, accepted)| one.accepted = accepted);
        let Some(nearer) = self::scatter(rows, &mut next, Some(scatter)) else {
            break;
        };
        // a step along what the runs hardly see may leave the range in which the law is as good as straight
        if RunKind::ALL
            .iter()
            .any(|kind| nearer[*kind as usize].least() > WORSE * scatter[*kind as usize].least())
        {
            break;
        }
        (point, taken, scatter) = (stepped, next, nearer);
    }
    let mut residuals = vec![vec![]; rows.groups.len()];
    for one in taken.iter().filter(|one| one.clear) {
        residuals[rows.parts[one.part].group].push(one.row.residual / one.sd(&scatter));
    }
    Some(RobustFit {
        point,
        scatter,
        residuals,
    })
}

/// Accepts what is clear and near; whether that is another set than before.
fn accept(taken: &mut [SampledRun], scatter: &[Scatter; 2], far: f64) -> bool {
    let mut changed = false;
    for one in taken {
        let accepted = one.clear && one.row.residual.abs() <= far * one.sd(scatter);
        changed |= accepted != one.accepted;
        one.accepted = accepted;
    }
    changed
}

/// The rebounds about a point, spread over each part where they are many; all of them accepted.
pub(super) fn take(rows: &Rows, point: &[f64]) -> Vec<SampledRun> {
    let mut taken = vec![];
    for kind in RunKind::ALL {
        let parts = || rows.parts.iter().enumerate();
        let of_kind = || parts().filter(|(_, part)| rows.kind(part) == kind);
        let all: usize = of_kind().map(|(_, part)| part.rebounds.len()).sum();
        let share = MOST_RUNS as f64 / all.max(1) as f64;
        for (index, part) in of_kind() {
            rows.each(part, part.rebounds.clone(), point, |row| {
                if is_in_even_share(row.run - part.rebounds.start, share) {
                    taken.push(SampledRun {
                        part: index,
                        kind,
                        row,
                        clear: true,
                        accepted: true,
                    });
                }
            });
        }
    }
    taken
}

/// The scatter of each kind by medians, and which runs are clear of sticking with the scatter `before` or without any.
fn scatter(rows: &Rows, taken: &mut [SampledRun], before: Option<[Scatter; 2]>) -> Option<[Scatter; 2]> {
    let of_kind = |taken: &[SampledRun], kind: RunKind| -> Vec<JointRow> {
        let own = taken.iter().filter(|one| one.clear && one.kind == kind);
        own.map(|one| one.row).collect()
    };
    let both = |taken: &[SampledRun]| -> Option<[Scatter; 2]> {
        let dry = of_median(of_kind(taken, RunKind::Dry), false);
        let wet = of_median(of_kind(taken, RunKind::Wet), rows.energy_scatters());
        // a kind without scatter of its own has the other's stand for it
        let (first, second) = (dry.or(wet)?, wet.or(dry)?);
        Some([first, second])
    };
    let before = before.or_else(|| both(taken))?;
    for one in taken.iter_mut() {
        one.clear = is_clear(rows, &one.row, one.sd(&before));
    }
    both(taken)
}

/// Whether a rebound belongs to a setting that hardly ever sticks; a lucky one among stuck ones has no fair residual.
pub(super) fn is_clear(rows: &Rows, row: &JointRow, sd: f64) -> bool {
    row.residual + rows.runs.restitution[row.run] - rows.scene.data.smallest_restitution > CLEAR * sd
}

/// σ from the median distance; with the energy's scatter σ and σ_r from the medians of the runs with less and with more
/// of it.
fn of_median(mut rows: Vec<JointRow>, energy_scatters: bool) -> Option<Scatter> {
    let one = variance(&rows)?;
    let alone = Scatter {
        restitution: one,
        energy: 0.0,
    };
    if !energy_scatters || rows.len() < 4 {
        return Some(alone);
    }
    let middle = rows.len() / 2;
    rows.select_nth_unstable_by(middle, |a, b| b.kept.total_cmp(&a.kept));
    let halves = rows.split_at(middle);
    let slope2 = |half: &[JointRow]| {
        let sum: f64 = half.iter().map(|row| slope_mean_restitution(row.kept).powi(2)).sum();
        sum / half.len() as f64
    };
    let [less, more] = [halves.0, halves.1].map(|half| (slope2(half), variance(half).unwrap_or(one)));
    let energy = ((more.1 - less.1) / (more.0 - less.0)).clamp(0.0, less.1 / less.0);
    Some(if energy.is_finite() && energy > 0.0 {
        Scatter {
            restitution: (less.1 - energy * less.0).max(0.0),
            energy,
        }
    } else {
        alone
    })
}

/// σ² of runs, beside which each has its own measurement errors; `None` without any scatter.
fn variance(rows: &[JointRow]) -> Option<f64> {
    /// each halves what is left of the range
    const HALVINGS: usize = 30;
    /// runs do not scatter less than this share of what they seem to without measurement errors
    const LEAST: f64 = 1e-6;
    let mut distances: Vec<f64> = rows.iter().map(|row| row.residual.abs()).collect();
    let all = (SD_OF_MEDIAN_DISTANCE * median(&mut distances)?).powi(2);
    if all <= 1e-24 {
        return None;
    }
    if rows.iter().all(|row| row.measured == 0.0) {
        return Some(all);
    }
    // over their own sds, half of normal distances lie below the median of one
    let (mut lo, mut hi) = (LEAST * all, all);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (lo + hi);
        let over =
            |(distance, row): (&mut f64, &JointRow)| *distance = row.residual.abs() / (middle + row.measured).sqrt();
        distances.iter_mut().zip(rows).for_each(over);
        if SD_OF_MEDIAN_DISTANCE * median(&mut distances)? > 1.0 {
            lo = middle;
        } else {
            hi = middle;
        }
    }
    Some(0.5 * (lo + hi))
}

/// The step to the least squares of what is accepted.
fn step(rows: &Rows, taken: &[SampledRun], scatter: &[Scatter; 2]) -> nalgebra::DVector<f64> {
    let mut sums = rows.blank();
    for one in taken.iter().filter(|one| one.accepted) {
        rows.add(&mut sums, &rows.parts[one.part], &one.row, one.sd(scatter));
    }
    rows.fit(&[sums]).step
}
