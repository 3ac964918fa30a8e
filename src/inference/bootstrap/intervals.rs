//! Turns replicates of a quantity into percentile and BCa intervals.
//!
//! Order statistics are interpolated on the normal scale, as R's boot does. Replicates spread as normal ones do, while
//! the spread they stand for was itself estimated, with some degrees of freedom: percentile and BCa limits are therefore
//! taken at Φ(t_p) where others take p, t_p being Student's quantile. Infinite degrees of freedom give p.

use crate::distributions::{normal_quantile, student_t_quantile};
use crate::inference::delta::Interval;

/// Φ, by the complementary error function: statrs' own has ten digits only.
fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Some numbers, of which only the requested order statistics are put in their places.
#[derive(Debug, Clone, Default)]
struct Ordered {
    values: Vec<f64>,
    /// ranks from 0 that are in place: everything before each is no larger, everything after it no smaller
    placed: Vec<usize>,
}

impl Ordered {
    /// The number of this rank from 0.
    fn at(&mut self, rank: usize) -> Option<f64> {
        if let Err(next) = self.placed.binary_search(&rank) {
            let from = next.checked_sub(1).map_or(0, |before| self.placed[before] + 1);
            let to = self.placed.get(next).copied().unwrap_or(self.values.len());
            let between = self.values.get_mut(from..to).filter(|_| rank < to)?;
            between.select_nth_unstable_by(rank - from, f64::total_cmp);
            self.placed.insert(next, rank);
        }
        self.values.get(rank).copied()
    }
}

/// Finite replicates of one quantity.
#[derive(Debug, Clone)]
pub struct Replicates {
    finite: Ordered,
    /// replicates that gave no number
    pub failed: usize,
}

impl Replicates {
    /// Keeps the finite replicates and counts the others.
    pub fn new(values: impl Iterator<Item = f64>) -> Replicates {
        let (finite, failed): (Vec<f64>, Vec<f64>) = values.partition(|value| value.is_finite());
        Replicates {
            finite: Ordered {
                values: finite,
                placed: vec![],
            },
            failed: failed.len(),
        }
    }

    /// Finite replicates.
    pub fn len(&self) -> usize {
        self.finite.values.len()
    }

    /// Whether there is no finite replicate.
    pub fn is_empty(&self) -> bool {
        self.finite.values.is_empty()
    }

    /// Mean and standard deviation; `None` for fewer than two.
    pub fn mean_sd(&self) -> Option<(f64, f64)> {
        let n = self.finite.values.len();
        if n < 2 {
            return None;
        }
        // about the first one, so that equal replicates have no spread at all
        let first = self.finite.values[0];
        let mean = self.finite.values.iter().map(|x| x - first).sum::<f64>() / n as f64;
        let squares: f64 = self.finite.values.iter().map(|x| (x - first - mean).powi(2)).sum();
        Some((first + mean, (squares / (n as f64 - 1.0)).sqrt()))
    }

    /// z0 = Φ⁻¹ of the share of replicates strictly below the estimate; infinite where all or none are.
    pub fn z0(&self, estimate: f64) -> f64 {
        let below = self.finite.values.iter().filter(|x| **x < estimate).count();
        let share = below as f64 / self.finite.values.len() as f64;
        match below {
            0 => f64::NEG_INFINITY,
            below if below == self.finite.values.len() => f64::INFINITY,
            _ => normal_quantile(share),
        }
    }

    /// The order statistic at rank (R + 1) p, interpolated on the normal scale between its neighbours.
    fn quantile(&mut self, p: f64) -> Option<f64> {
        let count = self.finite.values.len();
        let rank = (count as f64 + 1.0) * p;
        let k = rank.trunc() as usize;
        if k == 0 {
            return self.finite.at(0);
        }
        if k >= count {
            return self.finite.at(count.checked_sub(1)?);
        }
        let low = self.finite.at(k - 1)?;
        if k as f64 == rank {
            return Some(low);
        }
        let z = |k: usize| normal_quantile(k as f64 / (count as f64 + 1.0));
        let share = (normal_quantile(p) - z(k)) / (z(k + 1) - z(k));
        Some(low + share * (self.finite.at(k)? - low))
    }

    fn between(&mut self, method: &'static str, level: f64, [lo, hi]: [f64; 2]) -> Option<Interval> {
        let (lo, hi) = (self.quantile(lo)?, self.quantile(hi)?);
        Some(Interval { method, level, lo, hi })
    }

    /// Between the quantiles of the replicates at Φ(t) for t of (1 ∓ level)/2; `None` without replicates.
    pub fn percentile(&mut self, level: f64, degrees_of_freedom: f64) -> Option<Interval> {
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
        &mut self,
        estimate: f64,
        acceleration: f64,
        level: f64,
        degrees_of_freedom: f64,
    ) -> Result<Interval, &'static str> {
        if self.finite.values.iter().all(|x| *x == self.finite.values[0]) {
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

fn tails(level: f64) -> [f64; 2] {
    [0.5 - 0.5 * level, 0.5 + 0.5 * level]
}

/// Student's quantiles at both tails; the normal ones where there are none.
fn wider_tails(level: f64, degrees_of_freedom: f64) -> [f64; 2] {
    tails(level).map(|p| student_t_quantile(p, degrees_of_freedom).unwrap_or_else(|| normal_quantile(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In whatever order the replicates come, and their ranks are asked for.
    #[test]
    fn order_statistics_are_those_of_a_full_sort() {
        let scattered = |i: usize| (i as f64 * 0.618_033_988_749_895).fract();
        let kinds: [fn(f64, usize) -> f64; 5] = [
            |share, _| normal_quantile(0.5 * share + 0.25),
            |_, i| i as f64,
            |_, i| -(i as f64),
            |share, _| (10.0 * share).floor(),
            |_, _| 0.3,
        ];
        for (kind, of) in kinds.into_iter().enumerate() {
            for count in [1, 2, 1000] {
                let values: Vec<f64> = (0..count).map(|i| of(scattered(i), i)).collect();
                let mut sorted = values.clone();
                sorted.sort_unstable_by(f64::total_cmp);
                let mut replicates = Replicates::new(values.iter().copied());
                for share in [0.5, 0.025, 0.0, 0.975, 0.07, 0.09, 0.95, 1.0] {
                    let rank = (share * (count - 1) as f64) as usize;
                    assert_eq!(replicates.finite.at(rank), Some(sorted[rank]), "{kind} {count} {share}");
                }
                assert_eq!(replicates.finite.at(count), None);
                assert_eq!(replicates.mean_sd().is_some(), count > 1);
            }
        }
    }
}
