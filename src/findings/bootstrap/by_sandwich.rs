//! Gives the fits of very many runs the intervals that resampling tends to, without replicates.

use super::replicates::Task;
use crate::distributions::normal_quantile;
use crate::findings::estimate::Bootstrapped;
use crate::inference::bootstrap::sandwich::Sandwich;
use crate::inference::delta::Interval;
use crate::scene::IntervalMethod;

/// Runs of the largest table that is resampled: 10,000 replicates of so many take a quarter of a minute on two cores.
pub const MOST_RESAMPLED: usize = 100_000;

/// Runs up to which a fit of a larger table is resampled all the same: with so few the limit is not reached.
pub(super) const FEW_RUNS: usize = 1000;

/// How an interval between z standard errors of the sandwich is named.
const SANDWICH: &str = "sandwich";

/// Why a fit that hangs on a run has no uncertainty.
const HANGS: &str =
    "a single run near the edge of the square root determines more than a twentieth of the fit, so that neither \
                     least squares nor the sandwich says how uncertain it is";

/// Adds an estimate's interval by the sandwiches of its fit and of its k, and quotes it, unless the scene wants that of least
/// squares; where the fit hangs on a run, it has no uncertainty but a profile's.
pub(super) fn add_interval(task: Task, method: IntervalMethod, sandwiches: &[Option<Sandwich>]) {
    let Some(own) = sandwiches[task.fit] else { return };
    if !own.is_near() {
        return task.estimate.withhold_uncertainty(HANGS);
    }
    let of_dry = task.dry.and_then(|dry| sandwiches[dry]);
    let of_k = of_dry.map_or((f64::NAN, 0.0), |dry| (dry.fitted[0], dry.covariance[0]));
    let se = task.variance((own.fitted, own.covariance), of_k).sqrt();
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
