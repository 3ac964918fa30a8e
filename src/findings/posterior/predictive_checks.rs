//! Posterior predictive checks: whether new runs drawn from the posterior look like the ones that were made.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use crate::distributions::normal_quantile;
use crate::model::likelihood::normal::{ln_normal_cdf, normal_cdf};
use crate::model::likelihood::pointwise::{EvaluatedLaw, Pointwise};
use crate::model::likelihood::tails::Tails;
use crate::physics::Form;
use crate::runs::{sphere_words, DryGroup, Runs, Series};
use crate::scene::{Scene, Sticking};

/// Draws of the parameters the checks are averaged over.
const DRAWS: usize = 200;

/// Draws over which the number stuck in a series is averaged.
const STUCK_DRAWS: usize = 40;

/// Runs times draws that the checks may evaluate: a million runs are checked with fewer draws, not for minutes.
const AFFORDABLE: usize = 20_000_000;

/// Fewest draws, however many runs there are.
const FEWEST: usize = 10;

/// A series longer than this has so many stuck runs that their number is as good as normal.
const EXACT_TO: usize = 500;

/// How new runs compare with the ones made.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct PredictiveChecks {
    /// share of the runs inside their predicted bands
    pub bands: Vec<BandCoverage>,
    /// dry runs of a sphere with a k of its own, or one of its film ratios
    pub groups: Vec<GroupResidual>,
    /// series in which the number of stuck runs was in doubt
    pub stuck: Vec<StuckCount>,
}

/// How often runs lie inside their central predicted band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct BandCoverage {
    /// probability the band was made for
    pub level: f64,
    /// share of runs inside
    pub coverage: f64,
    /// runs
    pub runs: usize,
}

/// Residuals of a group of runs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GroupResidual {
    /// name of the particle
    pub particle: String,
    /// D, m, where each diameter has a k of its own
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// film ratio; `None` for dry runs
    pub film_ratio: Option<f64>,
    /// runs
    pub runs: usize,
    /// mean of (e − predicted)/σ, a stuck run counting as the mean of what stuck runs have
    pub mean_residual: f64,
    /// its standard error from the spread between runs; `None` for one run
    pub mean_residual_se: Option<f64>,
}

impl GroupResidual {
    /// The particle's words in a text: `PTFE`, `PTFE of 4.762 mm`.
    pub fn words(&self) -> String {
        sphere_words(&self.particle, self.diameter_m)
    }
}

/// Runs of a series that stuck, and how many were to be expected.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StuckCount {
    /// name of the particle
    pub particle: String,
    /// name of the liquid
    pub liquid: String,
    /// D, m
    pub diameter_m: f64,
    /// film ratio
    pub film_ratio: f64,
    /// runs
    pub runs: usize,
    /// those that stuck
    pub observed: usize,
    /// those expected to
    pub expected: f64,
    /// probability of a number at least as far out, on both sides
    pub p: f64,
}

/// How one run lies in its posterior predictive distribution.
#[derive(Clone, Copy)]
struct RunPrediction {
    /// probability of a smaller restitution; of sticking, where the run stuck
    below: f64,
    /// mean residual in σ; of other than normal noise, the normal z that is as improbable
    residual: f64,
}

/// Checks the runs against predictions from full vectors of parameters, as many or a few of them.
pub fn check_predictions(scene: &Scene, runs: &Runs, form: Form, full_draws: &[Vec<f64>]) -> PredictiveChecks {
    let affordable = (AFFORDABLE / runs.len().max(1)).max(FEWEST);
    let pointwise = &Pointwise::new(scene, runs, form);
    let some = evenly(full_draws, DRAWS.min(affordable)).into_par_iter();
    let some: Vec<EvaluatedLaw> = some.map(|full| pointwise.at(full)).collect();
    let predict = |run: usize| predict_run(pointwise, run, runs.restitution[run], &some);
    let predictions: Vec<RunPrediction> = (0..pointwise.len()).into_par_iter().map(predict).collect();
    let few = evenly(&some, STUCK_DRAWS.min(affordable));
    PredictiveChecks {
        bands: [0.5, 0.9].map(|level| band(pointwise, &predictions, level)).to_vec(),
        groups: groups(scene, runs, &predictions),
        stuck: match scene.model.sticking {
            Sticking::Censored => stuck(scene, runs, &few),
            Sticking::Truncated | Sticking::Excluded => vec![],
        },
    }
}

/// So many of the items, evenly.
fn evenly<T>(items: &[T], most: usize) -> Vec<&T> {
    items.iter().step_by(items.len().div_ceil(most).max(1)).collect()
}

/// Probability beyond which a run is as far off as any.
const FARTHEST: f64 = 1e-12;

fn predict_run(pointwise: &Pointwise, run: usize, e: f64, draws: &[EvaluatedLaw]) -> RunPrediction {
    let stuck = pointwise.is_stuck(run);
    let (mut below, mut residual) = (0.0, 0.0);
    for at in draws {
        let tails = at.tails();
        // heavy tails have outliers, whose mean says nothing: each counts as the normal z that is as improbable
        let score = |z: f64| match tails {
            Tails::Normal => z,
            _ => normal_quantile(tails.probability(z).clamp(FARTHEST, 1.0 - FARTHEST)),
        };
        let z = score(if stuck { at.limit_z(run) } else { at.z(run, e) });
        // mean of what lies below a normal z
        let mean_below = |z: f64| -ln_normal_cdf(z).1;
        if stuck {
            below += normal_cdf(z);
            residual += mean_below(z);
        } else if at.is_truncated() {
            // of those that rebound: 1 − F(−z)/F(−l), about their mean, which mirrors that of those below
            let limit = -score(at.limit_z(run));
            let ln = |z| ln_normal_cdf(z).0;
            below += -(ln(-z) - ln(limit)).exp_m1();
            residual += z + mean_below(limit);
        } else {
            below += normal_cdf(z);
            residual += z;
        }
    }
    let n = draws.len() as f64;
    RunPrediction {
        below: below / n,
        residual: residual / n,
    }
}

fn band(pointwise: &Pointwise, predictions: &[RunPrediction], level: f64) -> BandCoverage {
    let (lo, hi) = (0.5 - 0.5 * level, 0.5 + 0.5 * level);
    let inside = predictions.iter().enumerate().map(|(run, prediction)| {
        if pointwise.is_stuck(run) {
            // somewhere below the limit, nobody knows where: the share of that which the band holds
            (hi.min(prediction.below) - lo).max(0.0) / prediction.below.max(f64::MIN_POSITIVE)
        } else {
            f64::from(u8::from((lo..=hi).contains(&prediction.below)))
        }
    });
    BandCoverage {
        level,
        coverage: inside.sum::<f64>() / predictions.len() as f64,
        runs: predictions.len(),
    }
}

fn groups(scene: &Scene, runs: &Runs, predictions: &[RunPrediction]) -> Vec<GroupResidual> {
    let group = |(sphere, film_ratio, members): (usize, Option<f64>, Vec<usize>)| {
        let n = members.len() as f64;
        let residuals = || members.iter().map(|run| predictions[*run].residual);
        let mean = residuals().sum::<f64>() / n;
        let squares: f64 = residuals().map(|residual| (residual - mean).powi(2)).sum();
        GroupResidual {
            particle: scene.particles[runs.spheres[sphere].particle].name.clone(),
            diameter_m: runs.spheres[sphere].diameter,
            film_ratio,
            runs: members.len(),
            mean_residual: mean,
            mean_residual_se: (members.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt()),
        }
    };
    let dry = (0..runs.spheres.len()).map(|sphere| {
        let members = runs.dry_of(sphere).iter().flat_map(DryGroup::runs);
        (sphere, None, members.collect::<Vec<usize>>())
    });
    let dry = dry.filter(|(_, _, members)| !members.is_empty());
    let wet = runs.film_groups.iter().map(|film| {
        let members = runs.series[film.series.clone()].iter().flat_map(Series::runs);
        (film.sphere, Some(film.film_ratio), members.collect())
    });
    dry.chain(wet).map(group).collect()
}

fn stuck(scene: &Scene, runs: &Runs, draws: &[&EvaluatedLaw]) -> Vec<StuckCount> {
    let of_series = |series: &Series| {
        let observed = series.stuck.len();
        let (mut expected, mut lower, mut upper) = (0.0, 0.0, 0.0);
        for at in draws {
            let sticks = |run: usize| at.tails().probability(at.limit_z(run));
            let p: Vec<f64> = series.runs().map(sticks).collect();
            expected += p.iter().sum::<f64>();
            let (at_most, at_least) = tails(&p, observed);
            lower += at_most;
            upper += at_least;
        }
        let n = draws.len() as f64;
        StuckCount {
            particle: scene.particles[series.particle].name.clone(),
            liquid: scene.liquids[series.liquid].name.clone(),
            diameter_m: series.diameter,
            film_ratio: series.film_ratio,
            runs: series.runs().len(),
            observed,
            expected: expected / n,
            p: (2.0 * f64::min(lower, upper) / n).min(1.0),
        }
    };
    let all: Vec<StuckCount> = runs.series.par_iter().map(of_series).collect();
    all.into_iter().filter(in_doubt).collect()
}

/// Whether the number that stuck could have been another: runs far from the threshold check nothing.
fn in_doubt(stuck: &StuckCount) -> bool {
    const CERTAIN: f64 = 1e-3;
    (stuck.expected - stuck.observed as f64).abs() > CERTAIN
}

/// Probability of at most, and of at least, so many successes of independent trials with these probabilities.
fn tails(p: &[f64], observed: usize) -> (f64, f64) {
    if p.len() > EXACT_TO {
        let mean: f64 = p.iter().sum();
        let variance: f64 = p.iter().map(|p| p * (1.0 - p)).sum();
        let sd = variance.sqrt().max(f64::MIN_POSITIVE);
        let observed = observed as f64;
        return (
            normal_cdf((observed + 0.5 - mean) / sd),
            normal_cdf((mean - observed + 0.5) / sd),
        );
    }
    let mut probability = vec![0.0; p.len() + 1];
    probability[0] = 1.0;
    for (trials, p) in p.iter().enumerate() {
        for successes in (0..=trials).rev() {
            let success = probability[successes] * p;
            probability[successes + 1] += success;
            probability[successes] -= success;
        }
    }
    let at_most = probability[..=observed].iter().sum::<f64>();
    let at_least = probability[observed..].iter().sum::<f64>();
    (at_most.clamp(0.0, 1.0), at_least.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_equal_trials_are_binomial() {
        let (at_most, at_least) = tails(&[0.3; 4], 1);
        assert!((at_most - (0.7f64.powi(4) + 4.0 * 0.3 * 0.7f64.powi(3))).abs() < 1e-14);
        assert!((at_least - (1.0 - 0.7f64.powi(4))).abs() < 1e-14);
    }

    #[test]
    fn many_trials_are_as_good_as_normal() {
        let (exact, _) = tails(&[0.2; 500], 110);
        let (near, _) = tails(&[0.2; 501], 110);
        assert!((exact - near).abs() < 0.01, "{exact} {near}");
    }
}
