//! Leaves out one run at a time, or one series, for the skewness and the degrees of freedom of a quantity.

use super::target::{Pool, Target};
use crate::inference::law::Response;
use crate::scene::ResamplingScheme;

/// Runs up to which leave-one-out fits are made one by one; above, they are taken to first order, off by 1/runs.
const EXACT: usize = 500;

/// Parameters without each member in turn, by stratum; a stratum of one member has none.
///
/// Members are runs inside their strata, or whole series where these are resampled. The others of the stratum weigh
/// n/(n − 1), so that it keeps its weight.
pub fn leave_one_out(pool: &Pool, target: &Target, scheme: ResamplingScheme) -> Vec<Vec<[f64; 2]>> {
    let first = pool.first_run(target);
    let within = |range: &std::ops::Range<usize>| range.start - first..range.end - first;
    let strata: Vec<Vec<std::ops::Range<usize>>> = if scheme == ResamplingScheme::Series {
        vec![pool.series[target.series.clone()].iter().map(within).collect()]
    } else {
        let runs = |stratum: &std::ops::Range<usize>| within(stratum).map(|run| run..run + 1).collect();
        pool.strata[target.strata.clone()].iter().map(runs).collect()
    };
    let slopes = (target.regression.x.len() > EXACT).then(|| first_order(target).0);
    let mut weights = vec![1.0; target.regression.x.len()];
    strata
        .iter()
        .filter(|members| members.len() > 1)
        .map(|members| {
            let n = members.len() as f64;
            match &slopes {
                Some(slopes) => without_to_first_order(target, slopes, members),
                None => {
                    let whole = members[0].start..members[members.len() - 1].end;
                    let left = members.iter().map(|member| {
                        weights[whole.clone()].fill(n / (n - 1.0));
                        weights[member.clone()].fill(0.0);
                        target.fit_weighted(&weights).unwrap_or([f64::NAN; 2])
                    });
                    let left = left.collect();
                    weights[whole].fill(1.0);
                    left
                }
            }
        })
        .collect()
}

fn without_to_first_order(target: &Target, slopes: &[[f64; 2]], members: &[std::ops::Range<usize>]) -> Vec<[f64; 2]> {
    let n = members.len() as f64;
    let sums: Vec<[f64; 2]> = members
        .iter()
        .map(|member| {
            let add = |sum: [f64; 2], slope: &[f64; 2]| [sum[0] + slope[0], sum[1] + slope[1]];
            slopes[member.clone()].iter().fold([0.0; 2], add)
        })
        .collect();
    let mean = [0, 1].map(|p| sums.iter().map(|sum| sum[p]).sum::<f64>() / n);
    let without = |sum: &[f64; 2]| [0, 1].map(|p| target.fitted[p] - n / (n - 1.0) * (sum[p] - mean[p]));
    sums.iter().map(without).collect()
}

/// What the weights of runs do to a fit, to first order. The variances of runs with measurement errors are held: how they
/// follow the scatter moves the fit of a law that holds to second order only.
///
/// dθ/dw of both parameters for each run, or for all that one stands for: −H⁻¹ times their own gradient, both of
/// ½ Σ w (e − F)². And the largest share that one run has in H, its leverage: to first order what is left out of it is of that
/// order.
pub(super) fn first_order(target: &Target) -> (Vec<[f64; 2]>, f64) {
    let Target { regression, fitted, .. } = target;
    let count = |run: usize| regression.counts.get(run).copied().unwrap_or(1.0);
    let gradient_and_bend = |run: usize| -> ([f64; 2], f64) {
        let weight = count(run) * target.errors.map_or(1.0, |errors| errors.weights[run]);
        if weight == 0.0 {
            return ([0.0; 2], 0.0);
        }
        let Response { value, slope, bend } = regression.response(*fitted, run);
        let residual = value - regression.restitution[run];
        let gradient = regression.law.design(regression.x[run]);
        let bend = weight * (slope * slope + residual * bend);
        (gradient.map(|c| weight * residual * slope * c), bend)
    };
    let mut hessian = [0.0; 3];
    for (run, x) in regression.x.iter().enumerate() {
        let (_, bend) = gradient_and_bend(run);
        let [a, b] = regression.law.design(*x);
        for (sum, product) in hessian.iter_mut().zip([a * a, a * b, b * b]) {
            *sum += bend * product;
        }
    }
    let mut leverage: f64 = 0.0;
    let slopes = regression.x.iter().enumerate().map(|(run, x)| {
        let (gradient, bend) = gradient_and_bend(run);
        let design = regression.law.design(*x);
        let pulled = regression.law.solve(hessian, design);
        leverage = leverage.max((bend / count(run) * (design[0] * pulled[0] + design[1] * pulled[1])).abs());
        regression.law.solve(hessian, gradient).map(|step| -step)
    });
    let slopes = slopes.collect();
    (slopes, leverage)
}

/// Influence values l = (n_s − 1)(θ̂ − θ_(i)) of a quantity, from its values without each member of a stratum.
pub fn influence(at: f64, without: impl ExactSizeIterator<Item = f64>) -> Vec<f64> {
    let n = without.len() as f64;
    without.map(|left| (n - 1.0) * (at - left)).collect()
}

/// a = Σ n_s⁻³ Σ l³ / (6 (Σ n_s⁻² Σ l²)^1.5) from influence values by stratum.
pub fn acceleration(strata: &[Vec<f64>]) -> f64 {
    let sum = |power: i32| -> f64 {
        let of_stratum = |influence: &Vec<f64>| {
            influence.iter().map(|l| l.powi(power)).sum::<f64>() / (influence.len() as f64).powi(power)
        };
        strata.iter().map(of_stratum).sum()
    };
    sum(3) / (6.0 * sum(2).powf(1.5))
}

/// Degrees of freedom of the variance V = Σ V_s with V_s = Σ (l − l̄)²/(n_s (n_s − 1)): V² / Σ V_s²/(n_s − 1).
///
/// `None` without a stratum that varies. Source: Satterthwaite 1946, doi:10.2307/3002019.
pub fn degrees_of_freedom(strata: &[Vec<f64>]) -> Option<f64> {
    let (mut all, mut squares) = (0.0, 0.0);
    for influence in strata.iter().filter(|influence| influence.len() > 1) {
        let n = influence.len() as f64;
        let mean = influence.iter().sum::<f64>() / n;
        let variance = influence.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
        all += variance;
        squares += variance * variance / (n - 1.0);
    }
    Some(all * all / squares).filter(|df| *df > 0.0 && df.is_finite())
}
