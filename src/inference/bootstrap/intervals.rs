//! Turns replicates of a quantity into percentile and BCa intervals.
//!
//! Order statistics are interpolated on the normal scale, as R's boot does. Replicates spread as normal ones do, while
//! the spread they stand for was itself estimated, with some degrees of freedom: percentile and BCa limits are therefore
//! taken at Φ(t_p) where others take p, t_p being Student's quantile. Infinite degrees of freedom give p.

use crate::distributions::{normal_quantile, student_t_quantile};
use crate::inference::delta::Interval;
use crate::model::likelihood::normal::normal_cdf;

/// Finite replicates of one quantity.
#[derive(Debug, Clone)]
pub struct Replicates {
    sorted: Vec<f64>,
}

impl Replicates {
    /// Keeps the finite replicates.
    pub fn new(values: impl Iterator<Item = f64>) -> Replicates {
        let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Replicates { sorted }
    }

    /// Mean and standard deviation; `None` for fewer than two.
    pub fn mean_sd(&self) -> Option<(f64, f64)> {
        let n = self.sorted.len();
        if n < 2 {
            return None;
        }
        // about the first one, so that equal replicates have no spread at all
        let first = self.sorted[0];
        let mean = self.sorted.iter().map(|x| x - first).sum::<f64>() / n as f64;
        let squares: f64 = self.sorted.iter().map(|x| (x - first - mean).powi(2)).sum();
        Some((first + mean, (squares / (n as f64 - 1.0)).sqrt()))
    }

    /// z0 = Φ⁻¹ of the share of replicates strictly below the estimate; infinite where all or none are.
    pub fn z0(&self, estimate: f64) -> f64 {
        match self.sorted.partition_point(|x| *x < estimate) {
            0 => f64::NEG_INFINITY,
            below if below == self.sorted.len() => f64::INFINITY,
            below => normal_quantile(below as f64 / self.sorted.len() as f64),
        }
    }

    /// The order statistic at rank (R + 1) p, interpolated on the normal scale between its neighbours.
    fn quantile(&self, p: f64) -> Option<f64> {
        let count = self.sorted.len();
        let rank = (count as f64 + 1.0) * p;
        let k = rank.trunc() as usize;
        if k == 0 {
            return self.sorted.first().copied();
        }
        if k >= count {
            return self.sorted.last().copied();
        }
        let low = self.sorted[k - 1];
        if k as f64 == rank {
            return Some(low);
        }
        let z = |k: usize| normal_quantile(k as f64 / (count as f64 + 1.0));
        let share = (normal_quantile(p) - z(k)) / (z(k + 1) - z(k));
        Some(low + share * (self.sorted[k] - low))
    }

    fn between(&self, method: &'static str, level: f64, [lo, hi]: [f64; 2]) -> Option<Interval> {
        let (lo, hi) = (self.quantile(lo)?, self.quantile(hi)?);
        Some(Interval { method, level, lo, hi })
    }

    /// Between the quantiles of the replicates at Φ(t) for t of (1 ∓ level)/2; `None` without replicates.
    pub fn percentile(&self, level: f64, degrees_of_freedom: f64) -> Option<Interval> {
        let at = tails(level, degrees_of_freedom).map(normal_cdf);
        self.between("percentile", level, at)
    }

    /// Bias-corrected and accelerated (Efron 1987), with z0 strictly less and the acceleration given.
    ///
    /// Where it is undefined the reason is returned: all replicates equal, z0 infinite, acceleration not finite.
    pub fn bca(
        &self,
        estimate: f64,
        acceleration: f64,
        level: f64,
        degrees_of_freedom: f64,
    ) -> Result<Interval, &'static str> {
        if self.sorted.first() == self.sorted.last() {
            return Err("all replicates equal");
        }
        let z0 = self.z0(estimate);
        if !z0.is_finite() {
            return Err("z0 infinite");
        }
        if !acceleration.is_finite() {
            return Err("acceleration not finite");
        }
        let adjusted = tails(level, degrees_of_freedom).map(|t| {
            let z = z0 + t;
            normal_cdf(z0 + z / (1.0 - acceleration * z))
        });
        // a strong acceleration can fold the scale: the ends would then change places
        if adjusted[0].partial_cmp(&adjusted[1]) != Some(std::cmp::Ordering::Less) {
            return Err("acceleration folds the scale");
        }
        self.between("bca", level, adjusted).ok_or("no replicates")
    }
}

/// Student's quantiles at both tails; the normal ones where there are none.
fn tails(level: f64, degrees_of_freedom: f64) -> [f64; 2] {
    let quantile = |p| student_t_quantile(p, degrees_of_freedom).unwrap_or_else(|| normal_quantile(p));
    [0.5 - 0.5 * level, 0.5 + 0.5 * level].map(quantile)
}
