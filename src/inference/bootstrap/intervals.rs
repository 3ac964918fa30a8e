//! Turns replicates of a quantity into percentile, BCa and studentized intervals.
//!
//! Order statistics are interpolated on the normal scale, as R's boot does. Replicates spread as normal ones do, while
//! the spread they stand for was itself estimated, with some degrees of freedom: percentile and BCa limits are therefore
//! taken at Φ(t_p) where others take p, t_p being Student's quantile. Infinite degrees of freedom give p.

use statrs::distribution::{ContinuousCDF, Normal};

use crate::inference::delta::Interval;
use crate::inference::distributions::student_t_quantile;

/// Φ, by the complementary error function: statrs' own has ten digits only.
fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

fn normal_quantile(p: f64) -> f64 {
    Normal::standard().inverse_cdf(p)
}

/// Finite replicates of one quantity, in increasing order.
#[derive(Debug, Clone)]
pub struct Replicates {
    sorted: Vec<f64>,
    /// replicates that gave no number
    pub failed: usize,
}

impl Replicates {
    /// Sorts the finite replicates and counts the others.
    pub fn new(values: impl Iterator<Item = f64>) -> Replicates {
        let mut failed = 0;
        let mut sorted: Vec<f64> = values
            .filter(|value| {
                failed += usize::from(!value.is_finite());
                value.is_finite()
            })
            .collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Replicates { sorted, failed }
    }

    /// Finite replicates.
    pub fn len(&self) -> usize {
        self.sorted.len()
    }

    /// Whether there is no finite replicate.
    pub fn is_empty(&self) -> bool {
        self.sorted.is_empty()
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
        let below = self.sorted.partition_point(|x| *x < estimate);
        let share = below as f64 / self.sorted.len() as f64;
        match below {
            0 => f64::NEG_INFINITY,
            below if below == self.sorted.len() => f64::INFINITY,
            _ => normal_quantile(share),
        }
    }

    /// The order statistic at rank (R + 1) p, interpolated on the normal scale between its neighbours.
    fn quantile(&self, p: f64) -> Option<f64> {
        let count = self.sorted.len();
        let rank = (count as f64 + 1.0) * p;
        let k = rank.trunc() as usize;
        let at = |k: usize| self.sorted.get(k.checked_sub(1)?).copied();
        if k == 0 {
            return self.sorted.first().copied();
        }
        if k >= count {
            return self.sorted.last().copied();
        }
        if k as f64 == rank {
            return at(k);
        }
        let z = |k: usize| normal_quantile(k as f64 / (count as f64 + 1.0));
        let share = (normal_quantile(p) - z(k)) / (z(k + 1) - z(k));
        let (low, high) = (at(k)?, at(k + 1)?);
        Some(low + share * (high - low))
    }

    fn between(&self, method: &'static str, level: f64, [lo, hi]: [f64; 2]) -> Option<Interval> {
        let (lo, hi) = (self.quantile(lo)?, self.quantile(hi)?);
        Some(Interval { method, level, lo, hi })
    }

    /// Between the quantiles of the replicates at Φ(t) for t of (1 ∓ level)/2; `None` without replicates.
    pub fn percentile(&self, level: f64, degrees_of_freedom: f64) -> Option<Interval> {
        let at = if degrees_of_freedom.is_infinite() {
            tails(level)
        } else {
            wider_tails(level, degrees_of_freedom).map(normal_cdf)
        };
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
        let spread = self.sorted.first() != self.sorted.last();
        if !spread {
            return Err("all replicates equal");
        }
        let z0 = self.z0(estimate);
        if !z0.is_finite() {
            return Err("z0 infinite");
        }
        if !acceleration.is_finite() {
            return Err("acceleration not finite");
        }
        let adjusted = wider_tails(level, degrees_of_freedom).map(|t| {
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

/// estimate − se · quantiles of t* = (θ* − θ̂)/se*, with the upper quantile below; `None` without replicates.
pub fn studentized(t: &Replicates, estimate: f64, se: f64, level: f64) -> Option<Interval> {
    let [low, high] = tails(level);
    let (lo, hi) = (estimate - se * t.quantile(high)?, estimate - se * t.quantile(low)?);
    (lo.is_finite() && hi.is_finite()).then_some(Interval {
        method: "studentized",
        level,
        lo,
        hi,
    })
}

fn tails(level: f64) -> [f64; 2] {
    [0.5 - 0.5 * level, 0.5 + 0.5 * level]
}

/// Student's quantiles at both tails; the normal ones where there are none.
fn wider_tails(level: f64, degrees_of_freedom: f64) -> [f64; 2] {
    tails(level).map(|p| student_t_quantile(p, degrees_of_freedom).unwrap_or_else(|| normal_quantile(p)))
}
