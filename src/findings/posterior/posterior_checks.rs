//! Judges whether a posterior may be quoted: convergence, compression, agreement with the dry runs, predictions.

use super::contraction;
use super::summary::{PosteriorFindings, QuantitySummary};
use crate::findings::dry::{name_of_k, Dry};
use crate::findings::least_squares::LeastSquares;
use crate::findings::remarks::{self, Kind};
use crate::inference::accuracy::asked_of_draws;
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::mixing::MixingLines;
use crate::inference::sampling::Method;
use crate::model::parameters::{ModelParameters, ParameterKind, OF_SCENE};
use crate::remark::Remark;
use crate::rounding::{by_number, counted};
use crate::runs::{DryGroup, Runs};
use crate::scene::Scene;

/// Standard errors that chance may add to a coverage or a mean residual.
const CHANCE: f64 = 3.5;

/// The checks that stand where nothing was sampled.
const NOT_SAMPLED: [Kind; 5] = [
    remarks::PARAMETERS_LEFT,
    remarks::RUNS_TO_SPARE,
    remarks::DRAWS_MADE,
    remarks::NOISE,
    remarks::REBOUNDS,
];

/// The checks of how the draws were made, and not of the model or the runs.
pub(super) const OF_SAMPLING: [Kind; 8] = [
    remarks::RHAT,
    remarks::ESS_BULK,
    remarks::ESS_TAIL,
    remarks::E_BFMI,
    remarks::DIVERGENCES,
    remarks::KHAT,
    remarks::ACCURACY,
    remarks::COMPRESSION_ERROR,
];

/// The check that says why nothing was sampled, if nothing was.
pub fn refusal(checks: &[Remark]) -> Option<&Remark> {
    let is_refusal = |check: &&Remark| NOT_SAMPLED.iter().any(|kind| kind.is(check));
    checks.iter().find(is_refusal)
}

/// Why no posterior of these runs should be sampled, though the scene wants one: a check that fails and gates; `None` if it may
/// be.
pub fn why_not_sampled(runs: &Runs, least_squares: &LeastSquares, parameters: &ModelParameters) -> Option<Box<Remark>> {
    let too_little = smallest_noise(least_squares).filter(|sd| *sd < remarks::NOISE.threshold());
    let check = if runs.is_empty() {
        let check = remarks::PARAMETERS_LEFT.check(0.0, "no run is in use");
        check.then("put runs in use: there is nothing to sample")
    } else if parameters.sampled.is_empty() {
        remarks::PARAMETERS_LEFT.check(0.0, "no parameter is left to be sampled: every prior is fixed")
    } else if let Some(few) = too_few_runs(runs, parameters) {
        few
    } else if let Some(smallest) = too_little {
        let text = format!(
            "the runs lie on their law to rounding (spread {smallest:.1e}): without noise there is no posterior to sample"
        );
        remarks::NOISE.check(smallest, text)
    } else if runs.all_measured() == runs.stuck() {
        let text = "every run stuck: nothing bounds the parameters from the other side but their priors";
        remarks::REBOUNDS.check(0.0, text)
    } else {
        return None;
    };
    Some(Box::new(check))
}

/// Whether there are as many parameters as runs, of all runs or of the dry or the wet ones by themselves: a spread could
/// then shrink to nothing, the other parameters passing through every run, and its chains would follow it there.
fn too_few_runs(runs: &Runs, parameters: &ModelParameters) -> Option<Remark> {
    let sampled: Vec<ParameterKind> = parameters.sampled.iter().map(|parameter| parameter.kind).collect();
    let rebounds =
        |groups: &[DryGroup]| -> usize { groups.iter().map(|group| runs.measured(group.rebounds.clone())).sum() };
    let has_dry = |kind: ParameterKind| kind.sphere().is_some_and(|sphere| rebounds(runs.dry_of(sphere)) > 0);
    let is_curve = |kind: ParameterKind| match kind {
        ParameterKind::DryK(_) => !has_dry(kind),
        ParameterKind::Shared(_) | ParameterKind::LubricationTrend | ParameterKind::InertialTrend => true,
        _ => false,
    };
    let of_kind = |of: &dyn Fn(ParameterKind) -> bool| -> Vec<ParameterKind> {
        sampled.iter().copied().filter(|kind| of(*kind)).collect()
    };
    // a spread that is held cannot shrink, and one that no run has is its prior's
    let can_shrink = |runs: usize, sd: ParameterKind| sampled.contains(&sd) && runs > 0;
    let dry = rebounds(&runs.dry);
    let wet: usize = runs.series.iter().map(|own| runs.measured(own.rebounds.clone())).sum();
    let dry = can_shrink(dry, ParameterKind::SigmaDry).then(|| ("dry rebounds", dry, of_kind(&has_dry)));
    let wet = can_shrink(wet, ParameterKind::SigmaWet).then(|| ("wet rebounds", wet, of_kind(&is_curve)));
    // what runs are called, how many they are, and the parameters that they alone have to tell
    let all = ("runs", runs.all_measured(), sampled.clone());
    let mut tallies = [Some(all), dry, wet].into_iter().flatten();
    let (what, few, parameters) = tallies.find(|(_, runs, parameters)| *runs <= parameters.len())?;
    let symbols: Vec<&str> = parameters.iter().map(|kind| kind.symbol()).collect();
    let text = format!(
        "{few} {} for {} ({}): too few to tell how far they scatter",
        by_number(few, what.trim_end_matches('s'), what),
        counted(symbols.len(), "parameter"),
        symbols.join(", ")
    );
    let spare = few as f64 - symbols.len() as f64;
    Some(remarks::RUNS_TO_SPARE.check(spare, text))
}

/// The smaller spread of the runs about the laws, of the dry ones and of the wet: zero, but for rounding, of an exact fit.
fn smallest_noise(least_squares: &LeastSquares) -> Option<f64> {
    // one noisy particle or series is enough to have a noise
    let dry = least_squares.dry.iter().filter(|dry| dry.runs > 1);
    let dry = dry.filter_map(|dry| dry.residual_sd).reduce(f64::max);
    let series = least_squares.series.iter().filter(|series| series.runs > 2);
    let wet = series.filter_map(|series| series.residual_sd).reduce(f64::max);
    let balance = least_squares
        .energy_balance
        .as_ref()
        .and_then(|balance| balance.residual_sd);
    [dry, wet, balance].into_iter().flatten().reduce(f64::min)
}

/// Every check of a posterior.
pub(super) fn check_posterior(found: &PosteriorFindings, least_squares: &LeastSquares) -> Vec<Remark> {
    let mut checks = convergence(found);
    checks.extend(approximations(found));
    checks.extend(compression(found));
    checks.extend(dry_consistency(found, least_squares));
    checks.extend(contraction::prior_conflict(found));
    checks.extend(bands(found));
    checks.extend(worst_group(found));
    checks.extend(stuck_runs(found));
    checks
}

/// By how much the true speeds of the wet runs are not known, as a share of them; `None` where no speed errs.
pub fn speed_errors(scene: &Scene, runs: &Runs) -> Option<Remark> {
    let speeds = runs.true_speeds(scene, &runs.errors_with_medians()?);
    let wet = || runs.series.iter().flat_map(|series| series.runs());
    let squares: f64 = wet().map(|run| speeds.of_run[run].sd.powi(2)).sum();
    let rms = (squares / wet().count().max(1) as f64).sqrt();
    (rms > 0.0).then(|| {
        let text = "true impact speeds of the wet runs, root mean square of their relative standard deviation";
        remarks::SPEED_ERRORS.check(rms, text)
    })
}

fn compression(found: &PosteriorFindings) -> Option<Remark> {
    let compression = found.compression.as_ref()?;
    let error = Some(compression.max_log_density_error).filter(|error| error.is_finite());
    let criterion = remarks::COMPRESSION_ERROR.at(compression.bound);
    let text = "largest error of the log density of the few runs that stand for all";
    Some(criterion.check(error, text))
}

/// The largest of a number of the parameters and offsets, and whose it is; one without it comes first.
fn largest(found: &PosteriorFindings, of: impl Fn(&QuantitySummary) -> Option<f64>) -> (f64, &str) {
    // constant draws have no R-hat, and are no sign of mixing either
    let offsets = found.series_offsets.iter().map(|of| &of.offset);
    let all = found.parameters.iter().chain(offsets);
    let each = all.map(|q| (of(q).unwrap_or(f64::INFINITY), q.name.as_str()));
    each.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, ""))
}

fn convergence(found: &PosteriorFindings) -> Vec<Remark> {
    let mut checks = vec![];
    let requested = found.accuracy.as_ref().map(|accuracy| accuracy.requested);
    let MixingLines { rhat: line, effective } = asked_of_draws(found.method, found.chains, requested);
    let drawn_on = found.draws_asked.filter(|asked| found.draws > *asked);
    let drawn_on = drawn_on.map(|asked| format!("after {} draws a chain in place of {asked}", found.draws));
    let told = |check: Remark| match &drawn_on {
        Some(words) => check.if_failed(words),
        None => check,
    };
    if let Some(line) = line {
        let (rhat, name) = largest(found, |q| q.rhat);
        let text = format!("largest R-hat ({name}): chains that agree have 1");
        let rhat = Some(rhat).filter(|rhat| rhat.is_finite());
        let apart = format!("the chains do not agree on {name}");
        checks.push(told(remarks::RHAT.at(line).check(rhat, text).if_failed(&apart)));
    }
    let fewest = |criterion: Kind, what: &str, of: fn(&QuantitySummary) -> Option<f64>| {
        let (value, name) = largest(found, |q| of(q).map(|ess| -ess));
        let ess = if value.is_finite() { -value } else { 0.0 };
        let text = format!("fewest effective draws for the {what} ({name})");
        told(criterion.at(effective).check(ess, text))
    };
    checks.push(fewest(remarks::ESS_BULK, "centre", |q| q.ess_bulk));
    checks.push(fewest(remarks::ESS_TAIL, "5 % and 95 % points", |q| q.ess_tail));
    if let Some(e_bfmi) = found.e_bfmi.iter().copied().flatten().reduce(f64::min) {
        let text = "smallest energy fraction of a chain: how freely it changes its energy";
        checks.push(remarks::E_BFMI.check(e_bfmi, text));
    }
    if found.method == Method::Nuts {
        let diverged = "kept draws whose trajectory diverged";
        let diverged = remarks::DIVERGENCES.check(found.divergences as f64, diverged);
        let cut = "kept draws whose trajectory was cut at 1024 steps";
        let cut = remarks::TRAJECTORIES_CUT.check(found.trajectories_cut as f64, cut);
        checks.extend([diverged, cut]);
    }
    checks
}

/// What the normal about the mode, and the method that was chosen for an accuracy, vouch for.
fn approximations(found: &PosteriorFindings) -> Vec<Remark> {
    let mut checks = vec![];
    if let Some(khat) = found.khat {
        // the normal and its weights are taken only below the line
        let criterion = remarks::KHAT.at(khat_threshold(found.chains * found.draws));
        let text = "shape of the weights of the normal about the mode: whether it reaches the posterior's tails";
        checks.push(criterion.check(khat, text));
    }
    if let Some(accuracy) = &found.accuracy {
        let criterion = remarks::ACCURACY.at(accuracy.requested);
        let text = "largest error of a mean, in posterior sds, or of an sd that the method vouches for";
        checks.push(criterion.check(accuracy.vouched, text));
    }
    checks
}

/// Misfit of the wet law leaks into k: the pooled k is held against the dry runs' own.
fn dry_consistency(found: &PosteriorFindings, least_squares: &LeastSquares) -> Option<Remark> {
    let shift = |dry: &Dry| {
        let (k, se) = dry.dry_k.pair()?;
        let name = name_of_k(&dry.particle, dry.diameter_m);
        let pooled = found.parameters.iter().find(|q| q.name == name)?;
        Some(((pooled.mean? - k).abs() / se.hypot(pooled.sd?), pooled))
    };
    let passed = least_squares.dry.iter().filter(|dry| dry.verdict.passed);
    let (shift, pooled) = passed.filter_map(shift).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let name = &pooled.name;
    let text =
        format!("largest distance of a pooled k from that of the dry runs ({name}), in combined standard errors");
    let check = remarks::DRY_CONSISTENCY.check(shift, text);
    let next = format!("widen or drop the prior of {name} in [priors]: it holds the pooled k");
    Some(match &pooled.prior {
        Some(prior) if prior.source == OF_SCENE => check.then(next),
        _ => check,
    })
}

/// Coverage of the predicted bands.
fn bands(found: &PosteriorFindings) -> Vec<Remark> {
    let criteria = [remarks::PREDICTIVE_50, remarks::PREDICTIVE_90];
    let both = found.predictive.bands.iter().zip(criteria);
    both.map(|(band, criterion)| {
        let chance = CHANCE * (band.level * (1.0 - band.level) / band.runs.max(1) as f64).sqrt();
        let [level, share] = [band.level, band.coverage].map(|share| 100.0 * share);
        let text =
            format!("distance from {level:.0} % of the share of runs in the {level:.0} % predicted band, {share:.1} %");
        let criterion = criterion.at(criterion.threshold().max(chance));
        let check = criterion.check((band.coverage - band.level).abs(), text);
        check.if_failed("the noise is not the one modelled")
    })
    .collect()
}

/// The group whose mean residual lies worst.
fn worst_group(found: &PosteriorFindings) -> Option<Remark> {
    let criterion = remarks::PREDICTIVE_RESIDUAL;
    let allowed = |runs: usize| criterion.threshold().max(CHANCE / (runs.max(1) as f64).sqrt());
    let share = |group: &super::predictive_checks::GroupResidual| group.mean_residual.abs() / allowed(group.runs);
    let groups = found.predictive.groups.iter();
    let group = groups.max_by(|a, b| share(a).total_cmp(&share(b)))?;
    let which = match group.film_ratio {
        Some(ratio) => format!("{} at film ratio {ratio:.3}", group.words()),
        None => format!("{}, dry", group.words()),
    };
    let text = format!("mean residual of the group that lies worst ({which}), in σ");
    let criterion = criterion.at(allowed(group.runs));
    Some(criterion.check(group.mean_residual.abs(), text))
}

/// The series whose number of stuck runs is least probable.
fn stuck_runs(found: &PosteriorFindings) -> Option<Remark> {
    let series = &found.predictive.stuck;
    let stuck = series.iter().min_by(|a, b| a.p.total_cmp(&b.p))?;
    let criterion = remarks::PREDICTIVE_STUCK;
    let criterion = criterion.at(criterion.threshold() / series.len() as f64);
    let text = format!(
        "{} of {} runs stuck, {:.1} expected ({}, {}, film ratio {:.3}): probability of a number so far out",
        stuck.observed, stuck.runs, stuck.expected, stuck.particle, stuck.liquid, stuck.film_ratio
    );
    let near = "the noise near the threshold is not the one modelled";
    Some(criterion.check(stuck.p, text).if_failed(near))
}
