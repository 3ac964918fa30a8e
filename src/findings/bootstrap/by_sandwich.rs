//! Gives the fits of very many runs the intervals that resampling tends to, without replicates.

use super::replicates::Task;
use crate::distributions::normal_quantile;
use crate::findings::estimate::Bootstrapped;
use crate::inference::bootstrap::Target;
use crate::inference::delta::Interval;
use crate::scene::IntervalMethod;

/// Runs of the largest table that is resampled: 10,000 replicates of so many take a quarter of a minute on two cores.
pub const MOST_RESAMPLED: usize = 100_000;

/// How an interval between z standard errors of the sandwich is named.
const SANDWICH: &str = "sandwich";

/// The covariance of a fit's parameters where the sandwich stands for replicates.
pub(super) type Sandwich = Option<[f64; 3]>;

/// A fit and the k that a quantity also depends on, with their covariances.
pub(super) struct FittedBySandwich {
    law: ([f64; 2], [f64; 3]),
    k: (f64, f64),
}

impl FittedBySandwich {
    /// What a task's quantity follows from; `None` where one of its fits is resampled.
    pub(super) fn of_task(task: &Task, targets: &[Target], sandwiches: &[Sandwich]) -> Option<FittedBySandwich> {
        let fitted = |target: usize| Some((targets[target].fitted, sandwiches[target]?));
        let of_k = |dry: usize| fitted(dry).map(|(parameters, covariance)| (parameters[0], covariance[0]));
        Some(FittedBySandwich {
            law: fitted(task.target)?,
            k: task.dry.map_or(Some((f64::NAN, 0.0)), of_k)?,
        })
    }

    /// Adds an estimate's interval, and quotes it, unless the scene wants that of least squares.
    pub(super) fn add_interval(&self, task: Task, method: IntervalMethod) {
        let se = task.variance(self.law, self.k).sqrt();
        let estimate = task.estimate;
        let Some(value) = estimate.value.filter(|_| se > 0.0 && se.is_finite()) else {
            return;
        };
        estimate.bootstrap = Some(Bootstrapped::of_limit(se));
        if method == IntervalMethod::Delta {
            return;
        }
        let interval = |level: f64| {
            let half = normal_quantile(0.5 + 0.5 * level) * se;
            let (lo, hi) = (value - half, value + half);
            let method = SANDWICH;
            Interval { method, level, lo, hi }
        };
        estimate.add_bootstrap_intervals(estimate.levels().into_iter().map(interval).collect());
        if !estimate.is_curved() {
            let Interval { lo, hi, .. } = interval(estimate.level);
            estimate.interval = Some([lo, hi]);
            estimate.method = SANDWICH;
        }
    }
}
