//! Judges what must hold before the numbers are quoted, and collects what wants a second look.

use super::balance::EnergyBalance;
use super::checks::{self, Check, Criterion};
use super::dry::{self, FittedDry};
use super::notices::{self, shortened};
use super::scaling::FittedScaling;
use super::series::SeriesFit;
use crate::notice::Notice;
use crate::physics::DrySpeed;
use crate::runs::{Runs, Table};
use crate::scene::{Scene, WetLaw};

/// Whether the main numbers may be quoted: no gating check failed.
pub fn quotable(checks: &[Check]) -> bool {
    checks.iter().all(|check| check.passed || !check.gates)
}

/// Every check of a least-squares analysis.
pub fn check_least_squares(
    runs: &Runs,
    dry: &[FittedDry],
    series: &[SeriesFit],
    scaling: &[FittedScaling],
    balance: Option<&EnergyBalance>,
) -> Vec<Check> {
    let mut checks = vec![];
    checks.extend(dry_laws(dry));
    checks.extend(scaling_laws(scaling));
    checks.extend(balance.into_iter().flat_map(of_balance));
    if runs.is_empty() {
        checks.push(checks::RUNS_IN_USE.check(0.0, "every run was screened"));
    }
    checks.extend(of_series(series));
    checks.extend(dry.iter().filter_map(one_dry_k));
    let biases = [
        (
            WetLaw::Sqrt,
            checks::SQUARE_ROOT_LAW_BIAS,
            "largest bias of the square-root law by pooling liquids",
        ),
        (
            WetLaw::Linear,
            checks::LINEAR_LAW_BIAS,
            "largest bias of the linear law at a film ratio",
        ),
    ];
    for (law, criterion, text) in biases {
        for (name, share) in worst_bias(by_film_ratio(scaling, law)) {
            checks.push(criterion.check(share, format!("{name}: {text}, in its standard errors")));
        }
    }
    checks
}

fn dry_laws(dry: &[FittedDry]) -> Option<Check> {
    let failed = dry.iter().filter(|d| !d.dry.verdict.passed);
    let names = failed.map(|d| format!("{}: {}", d.dry.particle, d.dry.verdict.reason));
    let fits = FailedFits {
        what: "dry law",
        all: dry.len(),
        failed: names.collect(),
    };
    (!dry.is_empty()).then(|| fits.check(checks::DRY_LAW))
}

/// The fits of a law at a film ratio each, not those over all film ratios.
fn by_film_ratio(scaling: &[FittedScaling], law: WetLaw) -> impl Iterator<Item = &FittedScaling> {
    scaling
        .iter()
        .filter(move |fit| fit.law == law && fit.scaling.film_ratio.is_some())
}

fn scaling_laws(scaling: &[FittedScaling]) -> Option<Check> {
    let all = by_film_ratio(scaling, WetLaw::Sqrt).count();
    let failed = by_film_ratio(scaling, WetLaw::Sqrt).filter(|fit| !fit.scaling.verdict.passed);
    let names = failed.map(|fit| {
        let ratio = fit.scaling.film_ratio.unwrap_or_default();
        format!(
            "{} at film ratio {ratio:.3}: {}",
            fit.scaling.particle, fit.scaling.verdict.reason
        )
    });
    let fits = FailedFits {
        what: "square-root law of a film ratio",
        all,
        failed: names.collect(),
    };
    (all > 0).then(|| Check {
        // a film ratio without a law is a gap; only none at all leaves no main number
        gates: fits.failed.len() == all,
        ..fits.check(checks::SCALING_LAW)
    })
}

fn of_balance(balance: &EnergyBalance) -> Vec<Check> {
    let reason = (!balance.verdict.passed).then(|| balance.verdict.reason.clone());
    let fit = FailedFits {
        what: "energy balance over all rebounds",
        all: 1,
        failed: reason.into_iter().collect(),
    };
    let shift = balance.dry_k_shift_in_se.map(|shift| {
        let text = "largest shift of k by the wet runs, in combined standard errors";
        checks::DRY_CONSISTENCY.check(shift, text)
    });
    [fit.check(checks::ENERGY_BALANCE)].into_iter().chain(shift).collect()
}

fn of_series(series: &[SeriesFit]) -> Option<Check> {
    let failed = series.iter().filter(|s| !s.verdict.passed).count();
    let text = format!("series without a usable square-root law, of {}", series.len());
    (!series.is_empty()).then(|| checks::SERIES.check(failed as f64, text))
}

fn one_dry_k(fitted: &FittedDry) -> Option<Check> {
    let test = fitted.dry.heterogeneity.as_ref()?;
    let text = format!("{}: one k for all diameters", fitted.dry.particle);
    Some(checks::ONE_DRY_K.check(test.p, text))
}

/// For each particle, the largest bias in standard errors.
fn worst_bias<'a>(rows: impl Iterator<Item = &'a FittedScaling>) -> Vec<(&'a str, f64)> {
    let mut worst: Vec<(&str, f64)> = vec![];
    for fitted in rows {
        let name = fitted.scaling.particle.as_str();
        let Some(share) = bias_in_se(fitted) else {
            continue;
        };
        match worst.last_mut() {
            Some((last, most)) if *last == name => *most = most.max(share),
            _ => worst.push((name, share)),
        }
    }
    worst
}

/// The larger of a law's two biases, in standard errors.
fn bias_in_se(fitted: &FittedScaling) -> Option<f64> {
    let bias = fitted.scaling.bias?;
    let e_inf = bias.e_inf.abs() / fitted.scaling.e_inf.scale()?;
    let st_c = bias.st_c.abs() / fitted.scaling.st_c.scale()?;
    Some(e_inf.max(st_c))
}

/// Fits of one kind, and those of them that are not usable.
struct FailedFits {
    /// what they are
    what: &'static str,
    /// how many there are
    all: usize,
    /// name of each that failed, with the reason
    failed: Vec<String>,
}

impl FailedFits {
    fn check(&self, criterion: Criterion) -> Check {
        let FailedFits { what, all, failed } = self;
        let text = match failed.len() {
            0 => format!("{what}: usable"),
            1 if *all == 1 => format!("{what}: not usable ({})", shortened(failed)),
            n => format!("{what}: {n} of {all} fits not usable ({})", shortened(failed)),
        };
        criterion.check(failed.len() as f64, text)
    }
}

/// The check of the replicates of k, e_inf and St_c.
pub fn check_replicates(dry: &[FittedDry], scaling: &[FittedScaling]) -> Option<Check> {
    let of_dry = dry.iter().map(|d| (d.dry.particle.clone(), &d.dry.dry_k));
    let of_scaling = scaling.iter().filter(|fit| fit.scaling.verdict.passed).flat_map(|fit| {
        let ratio = fit
            .scaling
            .film_ratio
            .map_or("all".to_owned(), |ratio| format!("{ratio:.3}"));
        let name = format!("{} at film ratio {ratio}, {}", fit.scaling.particle, fit.law.name());
        [(name.clone(), &fit.scaling.e_inf), (name, &fit.scaling.st_c)]
    });
    let shares = of_dry.chain(of_scaling).filter_map(|(name, estimate)| {
        let boot = estimate.bootstrap.as_ref().filter(|boot| boot.replicates > 0)?;
        Some((boot.failed as f64 / boot.replicates as f64, name))
    });
    let (worst, name) = shares.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let criterion = checks::BOOTSTRAP_FAILURES;
    let text = if criterion.holds(worst) {
        format!("largest share of replicates without a number ({name})")
    } else {
        format!(
            "{:.1} % of the replicates gave no number ({name}), so that its bootstrap interval is one of the others alone",
            100.0 * worst
        )
    };
    Some(criterion.check(worst, text).with_advice())
}

/// A notice of the runs that were screened.
pub fn screened_notice(table: &Table) -> Option<Notice> {
    (!table.screened.is_empty()).then(|| notices::screened(&table.screened))
}

/// What a reader of the estimates should look at.
pub fn fit_notices(scene: &Scene, dry: &[FittedDry], series: &[SeriesFit], scaling: &[FittedScaling]) -> Vec<Notice> {
    let mut found = vec![];
    let stuck: usize = series.iter().map(|s| s.stuck).sum();
    let wet: usize = stuck + series.iter().map(|s| s.runs).sum::<usize>();
    if stuck > 0 {
        found.push(notices::stuck_left_out(stuck, wet));
    }
    let dry_stuck: usize = dry.iter().map(|d| d.dry.stuck).sum();
    if dry_stuck > 0 {
        found.push(notices::dry_run_without_rebound(dry_stuck));
    }
    let failed = series.iter().filter(|s| !s.verdict.passed);
    let failed: Vec<String> = failed
        .map(|s| format!("{} ({})", s.label(), s.verdict.reason))
        .collect();
    if !failed.is_empty() {
        found.push(notices::series_failed(&failed, series.len()));
    }
    let without: Vec<String> = (0..scene.particles.len())
        // fits come in the order of the particles
        .filter(|p| scaling.binary_search_by_key(p, |fit| fit.particle).is_ok())
        .filter(|p| dry::fit_of_particle(dry, *p).is_none())
        .map(|p| scene.particles[p].name.clone())
        .collect();
    if !without.is_empty() {
        let own_speed = scene.model.dry_speed == DrySpeed::Impact;
        found.push(notices::no_dry_runs(&without, own_speed));
    }
    found
}

/// A notice of the settings that no stage reads; those of the bootstrap wait where it is not run.
pub fn unused_settings_notice(scene: &Scene, bootstrap: bool) -> Option<Notice> {
    let waits = |key: &&String| !(bootstrap && key.starts_with("bootstrap."));
    let unused: Vec<String> = scene.unused.iter().filter(waits).cloned().collect();
    (!unused.is_empty()).then(|| notices::settings_unused(&unused))
}
