//! Turns the replicates of a quantity into its interval, and says where there is none.

use super::Bootstrapped;
use crate::findings::estimate::Estimate;
use crate::inference::bootstrap::intervals::{acceleration, studentized, Replicates};
use crate::inference::bootstrap::kernel::Weighted;
use crate::inference::bootstrap::Plan;
use crate::inference::delta::LEVELS;
use crate::scene::IntervalMethod;

/// A quantity as a function of a law's parameters and of k; NaN where it is not defined.
pub(super) type Quantity = Box<dyn Fn([f64; 2], f64) -> f64 + Send + Sync>;

/// An estimate to complete: the targets its parameters and its k come from, and how.
pub(super) struct Task<'e> {
    pub(super) estimate: &'e mut Estimate,
    pub(super) target: usize,
    pub(super) dry: Option<usize>,
    pub(super) quantity: Quantity,
}

/// Every replicate and every leave-one-out fit, by target.
pub(super) struct Replicated {
    pub(super) fits: Vec<Vec<Weighted>>,
    pub(super) without: Vec<Vec<Vec<[f64; 2]>>>,
    pub(super) fitted: Vec<[f64; 2]>,
}

impl Replicated {
    pub(super) fn tell(&self, task: Task, plan: Plan, method: IntervalMethod, keep_all: bool) {
        let Task {
            estimate,
            target,
            dry,
            quantity,
        } = task;
        let (Some(value), Some(se)) = (estimate.value, estimate.se) else {
            return;
        };
        let k_at = |number: usize| dry.map_or(f64::NAN, |dry| self.fits[dry][number].parameters[0]);
        let k_fitted = dry.map_or(f64::NAN, |dry| self.fitted[dry][0]);
        let of = |(number, fit): (usize, &Weighted)| quantity(fit.parameters, k_at(number));
        let replicates = Replicates::new(self.fits[target].iter().enumerate().map(of));
        let Some((mean, sd)) = replicates.mean_sd() else {
            return;
        };
        let influence = |at: f64, without: Vec<f64>| -> Vec<f64> {
            let n = without.len() as f64;
            without.into_iter().map(|left| (n - 1.0) * (at - left)).collect()
        };
        let wet = self.without[target]
            .iter()
            .map(|stratum| influence(value, stratum.iter().map(|p| quantity(*p, k_fitted)).collect()));
        let of_dry = dry.iter().flat_map(|dry| &self.without[*dry]).map(|stratum| {
            influence(
                value,
                stratum.iter().map(|p| quantity(self.fitted[target], p[0])).collect(),
            )
        });
        // a stratum of one run cannot be left out and says nothing of the skewness
        let acceleration = acceleration(wet.chain(of_dry).filter(|stratum| stratum.len() > 1));
        let t = self.studentized(target, dry, &quantity, value);
        let mut fallback = None;
        let mut make = |method: IntervalMethod, level: f64| match method {
            IntervalMethod::Bca => match replicates.bca(value, acceleration, level) {
                Ok(made) => Some(made),
                Err(reason) => {
                    fallback = Some(reason);
                    None
                }
            },
            IntervalMethod::Percentile => replicates.percentile(level),
            IntervalMethod::Studentized => studentized(&t, value, se, level),
            IntervalMethod::Delta => None,
        };
        let mut levels: Vec<f64> = LEVELS.to_vec();
        if !levels.contains(&estimate.level) {
            levels.push(estimate.level);
        }
        let all = [
            IntervalMethod::Percentile,
            IntervalMethod::Bca,
            IntervalMethod::Studentized,
        ];
        for level in levels {
            for other in all.into_iter().filter(|other| keep_all || *other == method) {
                estimate.intervals.extend(make(other, level));
            }
        }
        let quoted = match method {
            IntervalMethod::Delta => None,
            method => make(method, estimate.level).or_else(|| replicates.percentile(estimate.level)),
        };
        if let Some(quoted) = quoted {
            estimate.interval = Some([quoted.lo, quoted.hi]);
            estimate.method = quoted.method;
        }
        estimate.bootstrap = Some(Bootstrapped {
            se: sd,
            bias: mean - value,
            failed: replicates.failed,
            replicates: plan.replicates,
            fallback,
        });
    }

    /// t* = (θ* − θ̂)/se*, with each replicate's own delta-method standard error.
    fn studentized(&self, target: usize, dry: Option<usize>, quantity: &Quantity, value: f64) -> Replicates {
        let t = self.fits[target].iter().enumerate().map(|(number, fit)| {
            let k = dry.map(|dry| &self.fits[dry][number]);
            let k_at = k.map_or(f64::NAN, |k| k.parameters[0]);
            let p = fit.parameters;
            // central differences: the quantities are smooth and the parameters of order one
            let step = |x: f64| 1e-5 * x.abs().max(1e-3);
            let (h0, h1, hk) = (step(p[0]), step(p[1]), step(k_at));
            let g0 = (quantity([p[0] + h0, p[1]], k_at) - quantity([p[0] - h0, p[1]], k_at)) / (2.0 * h0);
            let g1 = (quantity([p[0], p[1] + h1], k_at) - quantity([p[0], p[1] - h1], k_at)) / (2.0 * h1);
            let [aa, ab, bb] = fit.covariance;
            let mut variance = g0 * g0 * aa + 2.0 * g0 * g1 * ab + g1 * g1 * bb;
            if let Some(k) = k {
                let gk = (quantity(p, k_at + hk) - quantity(p, k_at - hk)) / (2.0 * hk);
                variance += gk * gk * k.covariance[0];
            }
            (quantity(p, k_at) - value) / variance.sqrt()
        });
        Replicates::new(t)
    }
}
