//! Finds the scatter of the runs about the joint fit in a way that outliers do not mislead.

use super::rows::{Rows, RunAtFit, RunKind};
use crate::inference::joint::JointRow;
use crate::inference::spreads::{median, SD_OF_MEDIAN_DISTANCE};
use crate::physics::rebound::{kept_of_mean_restitution, slope_mean_restitution};
use crate::roots::root_between;
use crate::scene::NoiseOn;

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
    /// every rebound there, part by part
    pub(super) runs: Vec<RunAtFit>,
    /// residuals over their sds of the runs that the scatter is told from, group by group
    pub(super) residuals: Vec<Vec<f64>>,
}

/// Fits, leaves out what lies further than `far` sds, and fits again until the same runs are left out.
///
/// `None` where the runs show no scatter, or none is clear of the limit of sticking.
pub(super) fn fit_robustly(rows: &Rows, far: f64) -> Option<RobustFit> {
    /// the sets left out settle in a few rounds, or alternate between two that are as good
    const ROUNDS: usize = 10;
    const WORSE: f64 = 1.1;
    let mut point = rows.point.clone();
    let mut runs = rows.rebounds(&point);
    // which runs are clear is told by the scatter of all
    measure(rows, &mut runs)?;
    tell_clear(rows, &mut runs);
    let mut scatter = measure(rows, &mut runs)?;
    let mut near = vec![true; runs.len()];
    for _ in 0..ROUNDS {
        let is_near = |run: &RunAtFit| run.clear && run.row.residual.abs() <= far * run.sd;
        let before = std::mem::replace(&mut near, runs.iter().map(is_near).collect());
        if near == before {
            break;
        }
        let mut sums = rows.blank();
        let left = runs.iter().zip(&near).filter(|(_, near)| **near);
        left.for_each(|(run, _)| rows.add(&mut sums, run));
        let step = rows.fit(&[sums]).step;
        let stepped: Vec<f64> = point.iter().zip(&step).map(|(x, dx)| x + dx).collect();
        if !rows.joint.holds(&stepped) {
            break;
        }
        let mut next = rows.rebounds(&stepped);
        set_sds(&mut next, &scatter);
        tell_clear(rows, &mut next);
        let Some(nearer) = measure(rows, &mut next) else {
            break;
        };
        // a step along what the runs hardly see may leave the range in which the law is as good as straight
        let is_worse = |(nearer, before): (&Scatter, &Scatter)| nearer.least() > WORSE * before.least();
        if nearer.iter().zip(&scatter).any(is_worse) {
            break;
        }
        (point, runs, scatter) = (stepped, next, nearer);
    }
    let mut residuals = vec![vec![]; rows.groups.len()];
    for run in runs.iter().filter(|run| run.clear) {
        residuals[rows.group_of[run.part]].push(run.row.residual / run.sd);
    }
    tell_clear(rows, &mut runs);
    Some(RobustFit {
        point,
        scatter,
        runs,
        residuals,
    })
}

fn set_sds(runs: &mut [RunAtFit], scatter: &[Scatter; 2]) {
    for run in runs {
        run.sd = scatter[run.kind as usize].sd(&run.row);
    }
}

fn tell_clear(rows: &Rows, runs: &mut [RunAtFit]) {
    for run in runs {
        run.clear = rows.is_clear(&run.row, run.sd);
    }
}

/// The scatter of each kind by medians of the runs clear of sticking, and the sds by it.
fn measure(rows: &Rows, runs: &mut [RunAtFit]) -> Option<[Scatter; 2]> {
    let of_kind = |kind: RunKind| -> Vec<JointRow> {
        let own = runs.iter().filter(|run| run.clear && run.kind == kind);
        own.map(|run| run.row).collect()
    };
    let dry = of_median(of_kind(RunKind::Dry), false);
    // where the energy kept scatters, too, wet restitutions near the threshold scatter more
    let wet = of_median(of_kind(RunKind::Wet), rows.scene.model.noise == NoiseOn::Both);
    // a kind without scatter of its own has the other's stand for it
    let scatter = [dry.or(wet)?, wet.or(dry)?];
    set_sds(runs, &scatter);
    Some(scatter)
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
    let beyond = |variance: f64| {
        let over = |(distance, row): (&mut f64, &JointRow)| {
            *distance = row.residual.abs() / (variance + row.measured).sqrt();
        };
        distances.iter_mut().zip(rows).for_each(over);
        SD_OF_MEDIAN_DISTANCE * median(&mut distances).unwrap_or(f64::NAN) - 1.0
    };
    root_between([LEAST * all, all], beyond).or(Some(LEAST * all))
}
