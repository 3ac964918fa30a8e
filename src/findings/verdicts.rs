//! Judges what must hold before the numbers are quoted, and collects what wants a second look.

use serde::Serialize;

use super::balance::EnergyBalance;
use super::dry::{self, FittedDry};
use super::scaling::FittedScaling;
use super::series::SeriesFit;
use crate::notice::Notice;
use crate::physics::DrySpeed;
use crate::runs::{Runs, Table};
use crate::scene::{Scene, WetLaw};

/// Probability below which a difference between groups is taken as real.
const DIFFERENCE: f64 = 0.01;

/// A bias above this share of the standard error spoils a 95 % interval by more than a point of coverage.
pub(super) const BIAS: f64 = 0.25;

/// A k that the wet runs move further than this is not the dry runs' k.
pub(super) const DRY_SHIFT: f64 = 3.0;

/// What a fit must be to count as usable.
const USABLE: &str = "every fit must converge, with a standard error and the sign the physics has";

/// One check of the whole.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// a fixed word a script can test for
    pub check: &'static str,
    /// what was found; `None` where nothing could be
    pub value: Option<f64>,
    /// the line it is held against
    pub threshold: f64,
    /// whether it holds
    pub passed: bool,
    /// whether a failure forbids quoting the main numbers
    pub gates: bool,
    /// where the line comes from
    pub source: &'static str,
    /// what it concerns, in words
    pub text: String,
}

/// The check of the energy balance by least squares.
pub const ENERGY_BALANCE: &str = "energy_balance";

/// Whether the main numbers may be quoted: no gating check failed.
pub fn quotable(checks: &[Check]) -> bool {
    checks.iter().all(|check| check.passed || !check.gates)
}

/// Every check of a least-squares analysis.
pub fn find(
    runs: &Runs,
    dry: &[FittedDry],
    series: &[SeriesFit],
    scaling: &[FittedScaling],
    balance: Option<&EnergyBalance>,
) -> Vec<Check> {
    let mut checks = vec![];
    if !dry.is_empty() {
        let failed = dry.iter().filter(|d| !d.dry.verdict.passed);
        let names: Vec<_> = failed.map(|d| named(&d.dry.particle, &d.dry.verdict.reason)).collect();
        checks.push(count("dry_law", &names, dry.len(), "dry law", true));
    }
    let of_law = |law: WetLaw, pooled: bool| {
        scaling
            .iter()
            .filter(move |fit| fit.law == law && fit.scaling.film_ratio.is_none() == pooled)
    };
    let groups: Vec<_> = of_law(WetLaw::Sqrt, false).collect();
    if !groups.is_empty() {
        let failed = groups.iter().filter(|fit| !fit.scaling.verdict.passed);
        let names: Vec<_> = failed
            .map(|fit| {
                let ratio = fit.scaling.film_ratio.unwrap_or_default();
                format!(
                    "{} at film ratio {ratio:.3}: {}",
                    fit.scaling.particle, fit.scaling.verdict.reason
                )
            })
            .collect();
        let all = names.len() == groups.len();
        let what = "square-root law of a film ratio";
        // a film ratio without a law is a gap; only none at all leaves no main number
        checks.push(count("scaling_law", &names, groups.len(), what, all));
    }
    if let Some(balance) = balance {
        let names: Vec<_> = (!balance.verdict.passed)
            .then(|| balance.verdict.reason.clone())
            .into_iter()
            .collect();
        checks.push(count(
            ENERGY_BALANCE,
            &names,
            1,
            "energy balance over all rebounds",
            true,
        ));
        if let Some(shift) = balance.dry_k_shift_in_se {
            checks.push(Check {
                check: "dry_consistency",
                value: Some(shift),
                threshold: DRY_SHIFT,
                passed: shift <= DRY_SHIFT,
                gates: true,
                source: "misfit of the wet law leaks into k",
                text: "largest shift of k by the wet runs, in combined standard errors".to_owned(),
            });
        }
    }
    if runs.is_empty() {
        checks.push(Check {
            check: "runs_in_use",
            value: Some(0.0),
            threshold: 1.0,
            passed: false,
            gates: true,
            source: "no runs, no numbers",
            text: "every run was screened".to_owned(),
        });
    }
    if !series.is_empty() {
        let failed = series.iter().filter(|s| !s.verdict.passed);
        checks.push(Check {
            check: "series",
            value: Some(failed.count() as f64),
            threshold: 0.0,
            passed: series.iter().all(|s| s.verdict.passed),
            gates: false,
            source: USABLE,
            text: format!("series without a usable square-root law, of {}", series.len()),
        });
    }
    for fitted in dry {
        if let Some(test) = &fitted.dry.heterogeneity {
            let name = &fitted.dry.particle;
            checks.push(difference(
                "one_dry_k_for_all_diameters",
                test.p,
                format!("{name}: one k for all diameters"),
            ));
        }
    }
    for (law, check, text) in [
        (
            WetLaw::Sqrt,
            "square_root_law_bias",
            "largest bias of the square-root law by pooling liquids",
        ),
        (
            WetLaw::Linear,
            "linear_law_bias",
            "largest bias of the linear law at a film ratio",
        ),
    ] {
        for (name, share) in worst_bias(of_law(law, false)) {
            checks.push(Check {
                check,
                value: Some(share),
                threshold: BIAS,
                passed: share <= BIAS,
                gates: false,
                source: "a bias of 0.25 standard errors leaves a 95 % interval covering 94 %",
                text: format!("{name}: {text}, in its standard errors"),
            });
        }
    }
    checks
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
    let e_inf = bias.e_inf.abs() / fitted.scaling.e_inf.se?;
    let st_c = bias.st_c.abs() / fitted.scaling.st_c.se?;
    Some(e_inf.max(st_c))
}

fn named(name: &str, reason: &str) -> String {
    format!("{name}: {reason}")
}

fn count(check: &'static str, failed: &[String], of: usize, what: &str, gates: bool) -> Check {
    let text = match failed.len() {
        0 => format!("{what}: usable"),
        1 if of == 1 => format!("{what}: not usable ({})", shortened(failed)),
        n => format!("{what}: {n} of {of} fits not usable ({})", shortened(failed)),
    };
    Check {
        check,
        value: Some(failed.len() as f64),
        threshold: 0.0,
        passed: failed.is_empty(),
        gates,
        source: USABLE,
        text,
    }
}

fn difference(check: &'static str, p: f64, text: String) -> Check {
    Check {
        check,
        value: Some(p),
        threshold: DIFFERENCE,
        passed: p >= DIFFERENCE,
        gates: false,
        source: "F test of nested fits; probability of so large a difference by chance",
        text,
    }
}

/// A list cut to what can be read.
fn shortened(items: &[String]) -> String {
    const SHOWN: usize = 3;
    let mut text = items.iter().take(SHOWN).cloned().collect::<Vec<_>>().join("; ");
    if items.len() > SHOWN {
        text.push_str(&format!("; and {} more", items.len() - SHOWN));
    }
    text
}

/// A larger share of replicates without a number says that the interval is made of the others.
const FAILED_REPLICATES: f64 = 0.01;

/// The check of the replicates of k, e_inf and St_c.
pub fn of_replicates(dry: &[FittedDry], scaling: &[FittedScaling]) -> Option<Check> {
    let of_dry = dry.iter().map(|d| (d.dry.particle.clone(), &d.dry.dry_k));
    let of_scaling = scaling.iter().filter(|fit| fit.scaling.verdict.passed).flat_map(|fit| {
        let ratio = fit
            .scaling
            .film_ratio
            .map_or("all".to_owned(), |ratio| format!("{ratio:.3}"));
        let name = format!("{} at film ratio {ratio}, {}", fit.scaling.particle, fit.scaling.law);
        [(name.clone(), &fit.scaling.e_inf), (name, &fit.scaling.st_c)]
    });
    let shares = of_dry.chain(of_scaling).filter_map(|(name, estimate)| {
        let boot = estimate.bootstrap.as_ref().filter(|boot| boot.replicates > 0)?;
        Some((boot.failed as f64 / boot.replicates as f64, name))
    });
    let (worst, name) = shares.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Check {
        check: "bootstrap_failures",
        value: Some(worst),
        threshold: FAILED_REPLICATES,
        passed: worst <= FAILED_REPLICATES,
        gates: true,
        source: "an interval is made of the replicates that gave a number",
        text: if worst <= FAILED_REPLICATES {
            format!("largest share of replicates without a number ({name})")
        } else {
            format!(
                "{:.1} % of the replicates gave no number ({name}), so that its bootstrap interval is one of the others \
                 alone; add runs there, or screen them",
                100.0 * worst
            )
        },
    })
}

/// What a reader of the estimates should look at.
pub fn notices(
    scene: &Scene,
    table: &Table,
    dry: &[FittedDry],
    series: &[SeriesFit],
    scaling: &[FittedScaling],
    bootstrap: bool,
) -> Vec<Notice> {
    let mut notices = vec![];
    let screened: usize = table.screened.iter().map(|s| s.runs).sum();
    if screened > 0 {
        let reasons: Vec<_> = table
            .screened
            .iter()
            .map(|s| format!("{} with {}", s.runs, s.reason))
            .collect();
        notices.push(Notice::new(
            "screened",
            screened,
            format!("{screened} runs left out: {}", reasons.join(", ")),
            "widen the limits in [data] to use them",
        ));
    }
    let stuck: usize = series.iter().map(|s| s.stuck).sum();
    let wet: usize = stuck + series.iter().map(|s| s.runs).sum::<usize>();
    if stuck > 0 {
        notices.push(Notice::new(
            "stuck_left_out",
            stuck,
            format!(
                "{stuck} of {wet} wet runs stuck and are left out of least squares. Where the noise is on the \
                 restitution this leaves the square-root law nearly unbiased and takes the linear law too high in \
                 e_inf and St_c; where the energy balance itself fluctuates, the square-root estimates tend to fall"
            ),
            "quote the square-root law, and compare film ratios by how many of their runs stuck",
        ));
    }
    let dry_stuck: usize = dry.iter().map(|d| d.dry.stuck).sum();
    if dry_stuck > 0 {
        notices.push(Notice::new(
            "dry_run_without_rebound",
            dry_stuck,
            format!("{dry_stuck} dry runs have no rebound and are left out; were it noise that kept them down, k is too small"),
            "check that they were dry: nothing in the dry law makes a sphere stick",
        ));
    }
    let failed: Vec<String> = series
        .iter()
        .filter(|s| !s.verdict.passed)
        .map(|s| format!("{} ({})", s.label(), s.verdict.reason))
        .collect();
    if !failed.is_empty() {
        notices.push(Notice::new(
            "series_failed",
            failed.len(),
            format!(
                "{} of {} series give no square-root law: {}",
                failed.len(),
                series.len(),
                shortened(&failed)
            ),
            "their runs still count in the scaling with St; more speeds or more rebounds would give them their own",
        ));
    }
    let without: Vec<String> = (0..scene.particles.len())
        // fits come in the order of the particles
        .filter(|p| scaling.binary_search_by_key(p, |fit| fit.particle).is_ok())
        .filter(|p| dry::of(dry, *p).is_none())
        .map(|p| scene.particles[p].name.clone())
        .collect();
    if !without.is_empty() {
        let mut text = format!(
            "no dry runs of {}: the inertial loss cannot be told from the dry loss",
            without.join(", ")
        );
        if scene.model.dry_speed == DrySpeed::Impact {
            text.push_str(", and the run's own dry speed is not used for it");
        }
        notices.push(Notice::new(
            "no_dry_runs",
            without.len(),
            text,
            "add dry runs over the same speeds",
        ));
    }
    let waits = |key: &&String| !(bootstrap && key.starts_with("bootstrap."));
    let unused: Vec<String> = scene.unused.iter().filter(waits).cloned().collect();
    if !unused.is_empty() {
        notices.push(Notice::new(
            "settings_unused",
            unused.len(),
            format!("settings that no stage of this run reads: {}", unused.join(", ")),
            "nothing: they were checked and wait for the stage that reads them; intervals here are delta-method ones",
        ));
    }
    notices
}
