//! Judges whether a posterior may be quoted: convergence, compression, agreement with the dry runs, predictions.

use super::written::{PosteriorFindings, Quantity};
use crate::findings::least_squares::LeastSquares;
use crate::findings::verdicts::{Check, DRY_SHIFT};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::model::parameters::Parameters;
use crate::runs::Runs;

/// Largest R-hat of chains that have mixed.
const RHAT: f64 = 1.01;
/// Fewest effective draws a chain.
const ESS_PER_CHAIN: f64 = 100.0;
/// Smallest energy fraction of a chain that explores its energies.
const E_BFMI: f64 = 0.3;
/// Below this spread runs have no noise to speak of.
const NOISE: f64 = 1e-12;
/// Distance of a band's coverage from its level that a model may show.
const COVERAGE: f64 = 0.05;
/// Mean residual of a group, in σ, that a model may show.
const RESIDUAL: f64 = 0.5;
/// Standard errors that chance may add to either.
const CHANCE: f64 = 3.5;
/// Probability below which the number stuck in any series is not chance, shared among the series.
const STUCK: f64 = 0.01;

const VEHTARI: &str = "Vehtari et al. 2021";
/// Where the line of the shape of importance weights comes from.
pub(in crate::findings) const VEHTARI_PSIS: &str = "Vehtari et al. 2024: min(1 − 1/log10 S, 0.7)";

/// Names of the checks that stand where nothing was sampled.
const DECLINED: [&str; 3] = ["posterior", "noise", "rebounds"];

/// Why no posterior was sampled, though it was asked for; the check fails and gates.
#[derive(Debug)]
pub struct Declined(pub Check);

impl Declined {
    /// Its check among all, if nothing was sampled.
    pub fn among(checks: &[Check]) -> Option<&Check> {
        checks.iter().find(|check| DECLINED.contains(&check.check))
    }
}

/// Why no posterior of these runs should be sampled; `None` if it may be.
pub fn decline(runs: &Runs, least_squares: LeastSquares, parameters: &Parameters) -> Option<Declined> {
    if parameters.sampled.is_empty() {
        let text = "no parameter is left to be sampled: no runs in use, or every prior fixed";
        return Some(declined("posterior", 0.0, 1.0, "a posterior needs parameters", text));
    }
    let dry = least_squares
        .dry
        .iter()
        .filter(|dry| dry.runs > 1)
        .filter_map(|dry| dry.residual_sd);
    let series = least_squares.series.iter().filter(|series| series.runs > 2);
    let wet: Vec<f64> = series.filter_map(|series| series.residual_sd).collect();
    // one noisy series is enough to have a noise
    let wet = wet.into_iter().reduce(f64::max);
    if let Some(smallest) = dry.chain(wet).reduce(f64::min).filter(|sd| *sd < NOISE) {
        let text = format!(
            "the runs have no noise (spread {smallest:.1e}): there is no posterior to sample, and least squares is exact"
        );
        return Some(declined("noise", smallest, NOISE, "a likelihood needs a spread", &text));
    }
    let rebounds = runs.len() - runs.stuck();
    if rebounds == 0 {
        let text = "every run stuck: nothing bounds the parameters from the other side but their priors";
        return Some(declined(
            "rebounds",
            0.0,
            1.0,
            "stuck runs alone give one bound only",
            text,
        ));
    }
    None
}

/// The sampling could not even start.
pub(super) fn no_posterior(why: &str) -> Declined {
    declined("posterior", 0.0, 1.0, "a posterior needs draws", why)
}

fn declined(check: &'static str, value: f64, threshold: f64, source: &'static str, text: &str) -> Declined {
    Declined(Check {
        check,
        value: Some(value),
        threshold,
        passed: false,
        gates: true,
        source,
        text: text.to_owned(),
    })
}

/// Every check of a posterior.
pub(super) fn checks(found: &PosteriorFindings, least_squares: LeastSquares) -> Vec<Check> {
    let mut checks = convergence(found);
    if let Some(compression) = &found.compression {
        let error = compression.max_log_density_error;
        checks.push(Check {
            check: "compression_error",
            value: Some(error).filter(|error| error.is_finite()),
            threshold: compression.bound,
            passed: error <= compression.bound,
            gates: true,
            source: "an error of the log density below 0.001 moves no probability by 0.1 %",
            text: told(
                error <= compression.bound,
                "largest error of the compressed log density".to_owned(),
                "run again with --exact-rows",
            ),
        });
    }
    checks.extend(dry_consistency(found, least_squares));
    checks.extend(predictions(found));
    checks
}

/// The text of a check, with what to try where it failed.
fn told(passed: bool, text: String, try_this: &str) -> String {
    if passed {
        text
    } else {
        format!("{text}; {try_this}")
    }
}

fn convergence(found: &PosteriorFindings) -> Vec<Check> {
    // constant draws have no R-hat, and are no sign of mixing either
    let worst = |of: fn(&Quantity) -> Option<f64>, sign: f64| {
        let each = found
            .parameters
            .iter()
            .map(|q| (sign * of(q).unwrap_or(f64::INFINITY * sign), q.name.as_str()));
        let (value, name) = each.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, ""));
        (sign * value, name)
    };
    let fewest = ESS_PER_CHAIN * found.chains as f64;
    let longer = "raise draws and warmup in [sampler]";
    let mut checks = vec![];
    let (rhat, name) = worst(|q| q.rhat, 1.0);
    checks.push(Check {
        check: "rhat",
        value: Some(rhat).filter(|rhat| rhat.is_finite()),
        threshold: RHAT,
        passed: rhat <= RHAT,
        gates: true,
        source: VEHTARI,
        text: told(
            rhat <= RHAT,
            format!("largest R-hat ({name}): chains that agree have 1"),
            &format!("the chains do not agree on {name}; {longer}, or give it a narrower prior"),
        ),
    });
    for (check, what, of) in [
        ("ess_bulk", "centre", (|q| q.ess_bulk) as fn(&Quantity) -> Option<f64>),
        ("ess_tail", "5 % and 95 % points", |q| q.ess_tail),
    ] {
        let (ess, name) = worst(of, -1.0);
        let ess = if ess.is_finite() { ess } else { 0.0 };
        checks.push(Check {
            check,
            value: Some(ess),
            threshold: fewest,
            passed: ess >= fewest,
            gates: true,
            source: VEHTARI,
            text: told(
                ess >= fewest,
                format!("fewest effective draws for the {what} ({name})"),
                longer,
            ),
        });
    }
    if let Some(e_bfmi) = found.e_bfmi.iter().copied().flatten().reduce(f64::min) {
        checks.push(Check {
            check: "e_bfmi",
            value: Some(e_bfmi),
            threshold: E_BFMI,
            passed: e_bfmi >= E_BFMI,
            gates: true,
            source: "Betancourt 2016",
            text: told(
                e_bfmi >= E_BFMI,
                "smallest energy fraction of a chain: how freely it changes its energy".to_owned(),
                "the posterior has heavy tails; narrower priors help",
            ),
        });
    }
    if found.method.is_nuts() {
        checks.extend(trajectories(found));
    }
    if let Some(khat) = found.khat {
        // the normal and its weights are taken only below the line
        let threshold = khat_threshold(found.chains * found.draws);
        checks.push(Check {
            check: "khat",
            value: Some(khat),
            threshold,
            passed: khat <= threshold,
            gates: true,
            source: VEHTARI_PSIS,
            text: "shape of the weights of the normal about the mode: whether it reaches the posterior's tails"
                .to_owned(),
        });
    }
    if let Some(accuracy) = &found.accuracy {
        let passed = accuracy.vouched.is_some_and(|error| error <= accuracy.asked);
        checks.push(Check {
            check: "accuracy",
            value: accuracy.vouched,
            threshold: accuracy.asked,
            passed,
            gates: true,
            source: "what was asked for",
            text: told(
                passed,
                "largest error of a mean, in posterior sds, or of an sd that the method vouches for".to_owned(),
                "no method could vouch for what was asked; ask for less",
            ),
        });
    }
    checks
}

/// Checks of trajectories.
fn trajectories(found: &PosteriorFindings) -> [Check; 2] {
    [
        Check {
            check: "divergences",
            value: Some(found.divergences as f64),
            threshold: 0.0,
            passed: found.divergences == 0,
            gates: true,
            source: "Betancourt 2017",
            text: told(
                found.divergences == 0,
                "kept draws whose trajectory diverged".to_owned(),
                "a region of the posterior is too sharp to be followed even in short steps; a narrower prior may help",
            ),
        },
        Check {
            check: "trajectories_cut",
            value: Some(found.trajectories_cut as f64),
            threshold: 0.0,
            passed: found.trajectories_cut == 0,
            gates: false,
            source: "slow, not wrong",
            text: "kept draws whose trajectory was cut at 1024 steps".to_owned(),
        },
    ]
}

/// Misfit of the wet law leaks into k: the pooled k is held against the dry runs' own.
fn dry_consistency(found: &PosteriorFindings, least_squares: LeastSquares) -> Option<Check> {
    let shifts = least_squares
        .dry
        .iter()
        .filter(|dry| dry.verdict.passed)
        .filter_map(|dry| {
            let (k, se) = dry.dry_k.pair()?;
            let name = format!("dry_k[{}]", dry.particle);
            let pooled = found.parameters.iter().find(|q| q.name == name)?;
            Some(((pooled.mean? - k).abs() / se.hypot(pooled.sd?), name))
        });
    let (shift, name) = shifts.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Check {
        check: "dry_consistency",
        value: Some(shift),
        threshold: DRY_SHIFT,
        passed: shift <= DRY_SHIFT,
        gates: true,
        source: "misfit of the wet law leaks into k",
        text: told(
            shift <= DRY_SHIFT,
            format!("largest distance of a pooled k from that of the dry runs ({name}), in combined standard errors"),
            "the wet law does not fit: try another form of inertia or dry_speed_m_s",
        ),
    })
}

fn predictions(found: &PosteriorFindings) -> Vec<Check> {
    let mut checks = vec![];
    for (band, check) in found.predictive.bands.iter().zip(["predictive_50", "predictive_90"]) {
        let chance = CHANCE * (band.level * (1.0 - band.level) / band.runs.max(1) as f64).sqrt();
        let off = (band.coverage - band.level).abs();
        let allowed = COVERAGE.max(chance);
        checks.push(Check {
            check,
            value: Some(off),
            threshold: allowed,
            passed: off <= allowed,
            gates: true,
            source: "5 points, or 3.5 standard errors where there are too few runs to tell",
            text: told(
                off <= allowed,
                format!(
                    "the {:.0} % predicted band holds {:.1} % of the runs",
                    100.0 * band.level,
                    100.0 * band.coverage
                ),
                "the noise is not the one modelled",
            ),
        });
    }
    let allowed = |runs: usize| RESIDUAL.max(CHANCE / (runs.max(1) as f64).sqrt());
    let share = |group: &super::predictive::Group| group.mean_residual.abs() / allowed(group.runs);
    let worst = found
        .predictive
        .groups
        .iter()
        .max_by(|a, b| share(a).total_cmp(&share(b)));
    if let Some(group) = worst {
        let which = match group.film_ratio {
            Some(ratio) => format!("{} at film ratio {ratio:.3}", group.particle),
            None => format!("{}, dry", group.particle),
        };
        let off = group.mean_residual.abs();
        let passed = off <= allowed(group.runs);
        checks.push(Check {
            check: "predictive_residual",
            value: Some(off),
            threshold: allowed(group.runs),
            passed,
            gates: true,
            source: "half σ, or 3.5 standard errors where there are too few runs to tell",
            text: told(
                passed,
                format!("mean residual of the group that lies worst ({which}), in σ"),
                "the law does not hold there: try another form of inertia, or screen it",
            ),
        });
    }
    let series = found.predictive.stuck.len();
    let worst = found.predictive.stuck.iter().min_by(|a, b| a.p.total_cmp(&b.p));
    if let Some(stuck) = worst {
        let threshold = STUCK / series as f64;
        let passed = stuck.p >= threshold;
        checks.push(Check {
            check: "predictive_stuck",
            value: Some(stuck.p),
            threshold,
            passed,
            gates: true,
            source: "1 %, shared among the series that could stick",
            text: told(
                passed,
                format!(
                    "{} of {} runs stuck, {:.1} expected ({}, {}, film ratio {:.3}): probability of a number so far out",
                    stuck.observed, stuck.runs, stuck.expected, stuck.particle, stuck.liquid, stuck.film_ratio
                ),
                "the noise near the threshold is not the one modelled",
            ),
        });
    }
    checks
}
