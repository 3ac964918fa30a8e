//! Predicts each run from the others: PSIS leave-one-out, from the log likelihood of every run at every draw.

use std::ops::Range;

use rayon::prelude::*;

use super::{pareto, psis, variance, WhyNone};

/// How well one run is predicted by the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutRun {
    /// log predictive density of the run given the others
    pub elpd: f64,
    /// by how much the run raises its own log predictive density
    pub p_loo: f64,
    /// shape of the tail of the weights, as in [`psis::Smoothed`]
    pub khat: Option<f64>,
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
}

impl Loo {
    /// The largest shape, and how many runs have none or one above `threshold`.
    ///
    /// A run that is as likely under every draw, one that stuck for certain say, has no shape and needs none.
    pub fn worst_khat(&self, threshold: f64) -> (Option<f64>, usize) {
        /// below this a run does not move its own prediction
        const NO_INFLUENCE: f64 = 1e-9;
        let shapes = self.runs.iter().filter_map(|run| run.khat);
        let bad = |run: &&LeftOutRun| match run.khat {
            Some(khat) => khat > threshold,
            None => run.p_loo.abs() > NO_INFLUENCE,
        };
        (shapes.reduce(f64::max), self.runs.iter().filter(bad).count())
    }
}

/// A difference of two sums over the same runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// first minus second
    pub value: f64,
    /// its standard error, from the spread of the pairs by n − 1; `None` for fewer than two
    pub se: Option<f64>,
}

/// Runs whose densities are asked for together: they share what a draw says of their film, and their rows stay in cache.
const BLOCK: usize = 16;

/// PSIS-LOO of `runs` runs by `draws` draws (of all chains together).
///
/// `log_likelihood(some, &mut rows)` fills in the log density of some runs at every draw, a row a run; it is called once a
/// run, from several threads, and the sums do not depend on how many. `r_eff` is the relative efficiency of the draws,
/// [`relative_efficiency`]. Fails with the first run that has a value that is not finite. Source: Vehtari, Gelman &
/// Gabry 2017 (Statistics and Computing 27, 1413), the weights as in [`psis::psis`].
pub fn loo(
    runs: usize,
    draws: usize,
    r_eff: f64,
    log_likelihood: impl Fn(Range<usize>, &mut [f64]) + Sync,
) -> Result<Loo, (usize, WhyNone)> {
    let tail = pareto::tail_length(draws, r_eff);
    let left_out = |rows: &mut Vec<f64>, first: usize| {
        let some = first..runs.min(first + BLOCK);
        let rows = &mut rows[..some.len() * draws];
        log_likelihood(some.clone(), rows);
        let each = some.enumerate().map(|(place, run)| {
            let row = &mut rows[place * draws..(place + 1) * draws];
            leave_out(row, tail).map_err(|why| (run, why))
        });
        each.collect::<Vec<_>>()
    };
    let blocks: Vec<_> = (0..runs)
        .into_par_iter()
        .step_by(BLOCK)
        .map_init(|| vec![0.0; BLOCK.min(runs) * draws], left_out)
        .collect();
    let runs: Vec<LeftOutRun> = blocks.into_iter().flatten().collect::<Result<_, _>>()?;
    let elpd: Vec<f64> = runs.iter().map(|run| run.elpd).collect();
    let (elpd, se) = sum(&elpd);
    let p_loo = runs.iter().map(|run| run.p_loo).sum();
    Ok(Loo { runs, elpd, se, p_loo })
}

/// Difference of the predictive densities of two models for the same runs, paired run by run.
///
/// ArviZ's `compare` divides by n where R's loo and this divide by n − 1. `None` where the numbers of runs differ.
pub fn difference(first: &Loo, second: &Loo) -> Option<Difference> {
    if first.runs.len() != second.runs.len() {
        return None;
    }
    let pairs = first.runs.iter().zip(&second.runs);
    let differences: Vec<f64> = pairs.map(|(a, b)| a.elpd - b.elpd).collect();
    Some(Difference::over_runs(&differences))
}

impl Difference {
    /// From the difference at each run.
    pub fn over_runs(differences: &[f64]) -> Difference {
        let (value, se) = sum(differences);
        Difference { value, se }
    }
}

/// Relative efficiency of the draws as ArviZ takes it: mean over the parameters of ESS of the mean, a draw.
///
/// `ess_of_means` has one entry for each parameter ([`super::ess::of_mean`]), `draws` counts those of all chains. A
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

/// Leaves one run out, given its log density at every draw; uses `values` up.
///
/// Outside the tail, weight times density is the same for every draw, and the density is the weight's reciprocal: one
/// exponential a draw serves the weights, the predictive density and p_loo.
fn leave_out(values: &mut [f64], tail: usize) -> Result<LeftOutRun, WhyNone> {
    if values.is_empty() || values.iter().any(|log| !log.is_finite()) {
        return Err(WhyNone::NotFinite);
    }
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest - smallest > WIDEST {
        return wide(values, tail, largest);
    }
    if largest - smallest <= SAME {
        // no weight differs from another: leaving the run out changes nothing, and a shape would be that of rounding
        let mean = smallest + values.iter().map(|log| log - smallest).sum::<f64>() / values.len() as f64;
        return Ok(LeftOutRun {
            elpd: mean,
            p_loo: 0.0,
            khat: None,
        });
    }
    // raw weights, the largest being 1
    values.iter_mut().for_each(|log| *log = (smallest - *log).exp());
    let densities: f64 = values.iter().map(|weight| weight.recip()).sum();
    let start = values.len() - tail;
    if tail > 0 {
        values.select_nth_unstable_by(start - 1, f64::total_cmp);
    }
    let (rest, tail) = values.split_at_mut(start);
    tail.sort_unstable_by(f64::total_cmp);
    let cutoff = rest.last().copied().unwrap_or(0.0);
    let pareto = psis::fit_tail(tail, cutoff);
    let (mut weights, mut weighted) = (rest.iter().sum::<f64>(), rest.len() as f64);
    for (rank, &raw) in tail.iter().enumerate() {
        let weight = pareto.map_or(raw, |pareto| psis::smoothed(pareto, cutoff, rank, tail.len()));
        weights += weight;
        weighted += weight / raw;
    }
    let elpd = smallest + (weighted / weights).ln();
    let seen = smallest + (densities / values.len() as f64).ln();
    Ok(LeftOutRun {
        elpd,
        p_loo: seen - elpd,
        khat: pareto.map(|pareto| pareto.shape),
    })
}

/// Widest range of log densities whose reciprocals and sums stay in range.
const WIDEST: f64 = 600.0;

/// The same in logarithms throughout, for a run with densities further apart than [`WIDEST`].
fn wide(values: &[f64], tail: usize, largest: f64) -> Result<LeftOutRun, WhyNone> {
    let ratios: Vec<f64> = values.iter().map(|log| -log).collect();
    let smoothed = psis::psis(&ratios, tail)?;
    let terms: Vec<f64> = smoothed.log_weights.iter().zip(values).map(|(a, b)| a + b).collect();
    let top = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let elpd = top + terms.iter().map(|term| (term - top).exp()).sum::<f64>().ln();
    let mean = values.iter().map(|log| (log - largest).exp()).sum::<f64>() / values.len() as f64;
    Ok(LeftOutRun {
        elpd,
        p_loo: largest + mean.ln() - elpd,
        khat: smoothed.khat,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed;
    use rand::RngExt;

    #[test]
    fn a_run_that_is_as_likely_under_every_draw_needs_no_shape() {
        let found = loo(2, 200, 1.0, |_, rows| {
            for (draw, value) in (0..200).map(f64::from).zip(&mut *rows) {
                *value = -1e-14 * draw;
            }
            rows[200..].fill(-0.7);
        });
        assert_eq!(found.expect("finite").worst_khat(0.7).1, 0);
    }

    #[test]
    fn the_short_way_and_the_way_in_logarithms_agree() {
        let mut rng = seed::stream(1, "the_short_way_and_the_way_in_logarithms_agree", 0);
        for scale in [1e-3, 0.5, 20.0] {
            let values: Vec<f64> = (0..400).map(|_| -scale * rng.random::<f64>().ln().powi(2)).collect();
            let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let short = leave_out(&mut values.clone(), 60).expect("finite");
            let long = wide(&values, 60, largest).expect("finite");
            let close = |a: f64, b: f64| (a - b).abs() < 1e-11 * (1.0 + b.abs());
            assert!(close(short.elpd, long.elpd), "{short:?} {long:?}");
            assert!(close(short.p_loo, long.p_loo), "{short:?} {long:?}");
            let shapes = (short.khat.expect("a tail"), long.khat.expect("a tail"));
            assert!(close(shapes.0, shapes.1), "{short:?} {long:?}");
        }
    }

    #[test]
    fn a_density_that_is_no_number_names_its_run() {
        for bad in [1, BLOCK + 1] {
            let found = loo(BLOCK + 3, 100, 1.0, |runs, rows| {
                rows.iter_mut().enumerate().for_each(|(i, x)| *x = -((i % 100) as f64));
                if runs.contains(&bad) {
                    rows[(bad - runs.start) * 100 + 5] = f64::NEG_INFINITY;
                }
            });
            assert_eq!(found, Err((bad, WhyNone::NotFinite)));
        }
    }

    #[test]
    fn a_run_no_draw_disagrees_about_is_predicted_exactly() {
        let same = loo(2, 100, 1.0, |_, rows| rows[100..].fill(-1.0)).expect("finite");
        assert!((same.elpd + 1.0).abs() < 1e-12 && same.p_loo.abs() < 1e-12, "{same:?}");
        assert_eq!(same.worst_khat(0.7), (None, 0));
        assert!((same.se.expect("two runs") - 1.0).abs() < 1e-12);
        let none = difference(&same, &same).expect("as many runs");
        assert_eq!((none.value, none.se), (0.0, Some(0.0)));
    }
}
