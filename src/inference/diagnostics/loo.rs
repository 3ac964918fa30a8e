//! Predicts each run from the others: PSIS leave-one-out, from the log likelihood of every run at every draw.

use std::ops::Range;

use rayon::prelude::*;

use super::{pareto, psis, variance};

/// How well one run is predicted by the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutRun {
    /// log predictive density of the run given the others
    pub elpd: f64,
    /// by how much the run raises its own log predictive density
    pub p_loo: f64,
    /// shape of the tail of the weights, as in [`psis::Smoothed`]; where draws were made without the run, that of the
    /// roots of its densities
    pub khat: Option<f64>,
}

/// Log predictive density of a run by draws that were made without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutRun {
    /// its place among the runs
    pub run: usize,
    /// log predictive density
    pub elpd: f64,
    /// its Monte Carlo error
    pub mcse: f64,
    /// shape of the heavier tail of the two sets of draws
    pub khat: f64,
}

impl WithoutRun {
    /// From its log density p at draws of the others alone and at draws of all runs, with the relative efficiencies of both;
    /// `None` where one is not finite, or their tail has no shape.
    ///
    /// The mean of p over the first is the integral with the run over that without it; so is that of √p over the first to that
    /// of 1/√p over the second, which reach half as far into tails (a bridge of two sets of draws: Meng & Wong 1996, Statistica
    /// Sinica 6, 831). What has the lighter tail is taken.
    pub fn between(run: usize, of_others: (&[f64], f64), of_all: (&[f64], f64)) -> Option<WithoutRun> {
        let mean_of_power = |(ln, r_eff): (&[f64], f64), power: f64| {
            let powers: Vec<f64> = ln.iter().map(|ln| power * ln).collect();
            let count = powers.len() as f64;
            let shares = psis::psis(&powers, pareto::tail_length(powers.len(), r_eff))?;
            let top = powers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let mean = top + (powers.iter().map(|ln| (ln - top).exp()).sum::<f64>() / count).ln();
            let squares: f64 = shares.log_weights.iter().map(|ln| (2.0 * ln).exp()).sum();
            Some((mean, (squares - 1.0 / count).max(0.0) / r_eff, shares.khat?))
        };
        let by_roots = || {
            let (others, variance, khat) = mean_of_power(of_others, 0.5)?;
            let (all, of_all, khat_of_all) = mean_of_power(of_all, -0.5)?;
            Some((others - all, variance + of_all, khat.max(khat_of_all)))
        };
        let both = [mean_of_power(of_others, 1.0), by_roots()].into_iter().flatten();
        let (elpd, variance, khat) = both.min_by(|a, b| a.2.total_cmp(&b.2))?;
        Some(WithoutRun {
            run,
            elpd,
            mcse: variance.sqrt(),
            khat,
        })
    }
}

/// How well a model predicts runs it has not seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Loo {
    /// one entry a run
    pub runs: Vec<LeftOutRun>,
    /// expected log predictive density, summed over the runs
    pub elpd: f64,
    /// standard error of `elpd` from the spread between runs, by n − 1; `None` for a single run
    pub se: Option<f64>,
    /// effective number of parameters
    pub p_loo: f64,
    /// Monte Carlo error of `elpd`, what another set of as many draws would move it by; without that of runs whose shape lies
    /// above [`pareto::khat_threshold`], which have none
    pub mcse: f64,
}

/// The draws that runs are left out of, all chains together.
#[derive(Debug, Clone, Copy)]
pub struct LooDraws {
    /// how many
    pub count: usize,
    /// their relative efficiency, [`relative_efficiency`]
    pub r_eff: f64,
}

impl Loo {
    /// The runs that have no shape or one above `threshold`.
    ///
    /// A run that is as likely under every draw, one that stuck for certain say, has no shape and needs none.
    pub fn untrusted(&self, threshold: f64) -> impl Iterator<Item = usize> + '_ {
        /// below this a run does not move its own prediction
        const NO_INFLUENCE: f64 = 1e-9;
        let bad = move |run: &LeftOutRun| match run.khat {
            Some(khat) => khat > threshold,
            None => run.p_loo.abs() > NO_INFLUENCE,
        };
        self.runs
            .iter()
            .enumerate()
            .filter(move |(_, run)| bad(run))
            .map(|(at, _)| at)
    }

    /// The largest shape, and how many runs are not to be trusted.
    pub fn worst_khat(&self, threshold: f64) -> (Option<f64>, usize) {
        let shapes = self.runs.iter().filter_map(|run| run.khat);
        (shapes.reduce(f64::max), self.untrusted(threshold).count())
    }

    /// With what draws without some runs say of these.
    pub fn with(mut self, without: &[WithoutRun]) -> Loo {
        let mut squares = self.mcse * self.mcse;
        for WithoutRun { run, elpd, mcse, khat } in without {
            squares += mcse * mcse;
            let of_run = &mut self.runs[*run];
            *of_run = LeftOutRun {
                elpd: *elpd,
                p_loo: of_run.p_loo + of_run.elpd - elpd,
                khat: Some(*khat),
            };
        }
        Loo::of(self.runs, squares.sqrt())
    }

    fn of(runs: Vec<LeftOutRun>, mcse: f64) -> Loo {
        let elpd: Vec<f64> = runs.iter().map(|run| run.elpd).collect();
        let (elpd, se) = sum(&elpd);
        let p_loo = runs.iter().map(|run| run.p_loo).sum();
        Loo {
            runs,
            elpd,
            se,
            p_loo,
            mcse,
        }
    }
}

/// A difference of two sums over the same runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// first minus second
    pub value: f64,
    /// its standard error, from the spread of the pairs by n − 1; `None` for fewer than two
    pub se: Option<f64>,
    /// its Monte Carlo error, that of two sets of draws
    pub mcse: f64,
}

/// Runs whose densities are asked for together: they share what a draw says of their film, and their rows stay in cache.
const BLOCK: usize = 16;

/// PSIS-LOO of so many runs.
///
/// `log_likelihood(some, &mut rows)` fills in the log density of some runs at every draw, a row a run; it is called once a
/// run, from several threads, and the sums do not depend on how many. Fails with the first run that has a value that is not
/// finite. Source: Vehtari, Gelman & Gabry 2017 (Statistics and Computing 27, 1413), the weights as in [`psis::psis`].
pub fn loo(
    runs: usize,
    draws: LooDraws,
    log_likelihood: impl Fn(Range<usize>, &mut [f64]) + Sync,
) -> Result<Loo, usize> {
    let LooDraws { count, r_eff } = draws;
    let tail = pareto::tail_length(count, r_eff);
    let left_out = |first: usize| {
        let some = first..runs.min(first + BLOCK);
        let mut rows = vec![0.0; some.len() * count];
        log_likelihood(some.clone(), &mut rows);
        let mut influence = vec![0.0; count];
        let each = some.zip(rows.chunks_exact(count.max(1)));
        let each = each.map(|(run, row)| leave_out(row, tail, &mut influence).ok_or(run));
        (each.collect::<Vec<_>>(), influence)
    };
    let blocks: Vec<_> = (0..runs).into_par_iter().step_by(BLOCK).map(left_out).collect();
    let mut influence = vec![0.0; count];
    let mut found = Vec::with_capacity(runs);
    for (each, of_block) in blocks {
        found.extend(each);
        for (sum, one) in influence.iter_mut().zip(of_block) {
            *sum += one;
        }
    }
    let runs: Vec<LeftOutRun> = found.into_iter().collect::<Result<_, _>>()?;
    let squares: f64 = influence.iter().map(|one| one * one).sum();
    Ok(Loo::of(runs, (squares / r_eff).sqrt()))
}

/// Difference of the predictive densities of two models for the same runs, paired run by run.
///
/// ArviZ's `compare` divides by n where R's loo and this divide by n − 1. `None` where the numbers of runs differ.
pub fn difference(first: &Loo, second: &Loo) -> Option<Difference> {
    trusted_difference(first, second, f64::INFINITY)
}

/// The same over the runs that both models are left out of reliably: no shape above `line` in either.
pub fn trusted_difference(first: &Loo, second: &Loo, line: f64) -> Option<Difference> {
    if first.runs.len() != second.runs.len() {
        return None;
    }
    let is_high = |run: &LeftOutRun| run.khat.is_some_and(|khat| khat > line);
    let pairs = first.runs.iter().zip(&second.runs);
    let trusted = pairs.filter(|(a, b)| !is_high(a) && !is_high(b));
    let differences: Vec<f64> = trusted.map(|(a, b)| a.elpd - b.elpd).collect();
    Some(Difference {
        mcse: first.mcse.hypot(second.mcse),
        ..Difference::over_runs(&differences)
    })
}

impl Difference {
    /// From the difference at each run, known exactly.
    pub fn over_runs(differences: &[f64]) -> Difference {
        let (value, se) = sum(differences);
        Difference { value, se, mcse: 0.0 }
    }
}

/// Relative efficiency of the draws as ArviZ takes it: mean over the parameters of ESS of the mean, a draw.
///
/// `ess_of_means` has one entry for each parameter ([`super::summary::Summary::ess_mean`]), `draws` counts those of all chains. A
/// single chain has 1, and so has a model without parameters.
pub fn relative_efficiency(ess_of_means: &[f64], chains: usize, draws: usize) -> f64 {
    if chains < 2 || ess_of_means.is_empty() {
        return 1.0;
    }
    super::mean(ess_of_means) / draws as f64
}

/// A sum over runs and its standard error.
fn sum(values: &[f64]) -> (f64, Option<f64>) {
    let n = values.len();
    let se = (n > 1).then(|| (n as f64 * variance(values)).sqrt());
    (values.iter().sum(), se)
}

/// A run whose log densities lie no further apart is as likely under every draw.
pub const SAME: f64 = 1e-7;

/// Leaves one run out, given its log density at every draw; adds what each draw moves its predictive density by. `None` where
/// a value is not finite.
fn leave_out(values: &[f64], tail_length: usize, influence: &mut [f64]) -> Option<LeftOutRun> {
    if !values.iter().all(|log| log.is_finite()) {
        return None;
    }
    let count = values.len() as f64;
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    if largest - smallest <= SAME {
        // no weight differs from another: leaving the run out changes nothing, and a shape would be that of rounding
        let above: f64 = values.iter().map(|log| log - smallest).sum();
        return Some(LeftOutRun {
            elpd: smallest + above / count,
            p_loo: 0.0,
            khat: None,
        });
    }
    let ratios: Vec<f64> = values.iter().map(|log| -log).collect();
    let smoothed = psis::psis(&ratios, tail_length)?;
    let weighted = smoothed.log_weights.iter().zip(values).map(|(a, b)| a + b);
    let weighted: Vec<f64> = weighted.collect();
    let top = weighted.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let terms: Vec<f64> = weighted.iter().map(|log| (log - top).exp()).collect();
    let sum: f64 = terms.iter().sum();
    let elpd = top + sum.ln();
    let threshold = pareto::khat_threshold(values.len());
    if smoothed.khat.is_none_or(|khat| khat <= threshold) {
        for ((influence, term), weight) in influence.iter_mut().zip(&terms).zip(&smoothed.weights) {
            *influence += term / sum - weight;
        }
    }
    let seen: f64 = values.iter().map(|log| (log - largest).exp()).sum();
    Some(LeftOutRun {
        elpd,
        p_loo: largest + (seen / count).ln() - elpd,
        khat: smoothed.khat,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed;
    use rand_distr::{Distribution, StandardNormal};

    fn draws(count: usize) -> LooDraws {
        LooDraws { count, r_eff: 1.0 }
    }

    #[test]
    fn a_run_that_is_as_likely_under_every_draw_needs_no_shape() {
        let found = loo(2, draws(200), |_, rows| {
            for (draw, value) in (0..200).map(f64::from).zip(&mut *rows) {
                *value = -1e-14 * draw;
            }
            rows[200..].fill(-0.7);
        });
        assert_eq!(found.expect("finite").worst_khat(0.7).1, 0);
    }

    #[test]
    fn runs_of_a_known_elpd_are_left_out_to_its_monte_carlo_error() {
        const RUNS: usize = 30;
        const DRAWS: usize = 1000;
        const SETS: usize = 100;
        let mut rng = seed::stream(1, "runs_of_a_known_elpd_are_left_out_to_its_monte_carlo_error", 0);
        let normal = StandardNormal;
        let values: Vec<f64> = (0..RUNS).map(|_| normal.sample(&mut rng)).collect();
        let n = RUNS as f64;
        let mean = values.iter().sum::<f64>() / n;
        let exact: f64 = values
            .iter()
            .map(|y| {
                let variance = n / (n - 1.0);
                let distance = (y - mean) * variance;
                -0.5 * (distance * distance / variance + (std::f64::consts::TAU * variance).ln())
            })
            .sum();
        for (shift, wide, right) in [(0.0, 1.0, true), (0.3, 1.2, false)] {
            let (mut off, mut stated) = (0.0, 0.0);
            for _ in 0..SETS {
                let z: Vec<f64> = (0..DRAWS).map(|_| normal.sample(&mut rng)).collect();
                let at = |z: f64| mean + (shift + wide * z) / n.sqrt();
                let found = loo(RUNS, draws(DRAWS), |some, rows| {
                    for (y, row) in values[some].iter().zip(rows.chunks_exact_mut(DRAWS)) {
                        for (value, z) in row.iter_mut().zip(&z) {
                            *value = -0.5 * ((y - at(*z)).powi(2) + std::f64::consts::TAU.ln());
                        }
                    }
                });
                let found = found.expect("finite");
                off += (found.elpd - exact).powi(2) / SETS as f64;
                stated += found.mcse.powi(2) / SETS as f64;
            }
            let ratio = (off / stated).sqrt();
            assert_eq!((0.8..1.25).contains(&ratio), right, "{ratio}");
            assert!(!right || stated.sqrt() < 0.06, "{stated}");
        }
    }

    #[test]
    fn a_density_that_is_no_number_names_its_run() {
        for bad in [1, BLOCK + 1] {
            let found = loo(BLOCK + 3, draws(100), |runs, rows| {
                rows.iter_mut().enumerate().for_each(|(i, x)| *x = -((i % 100) as f64));
                if runs.contains(&bad) {
                    rows[(bad - runs.start) * 100 + 5] = f64::NEG_INFINITY;
                }
            });
            assert_eq!(found, Err(bad));
        }
    }
}
