//! Writes what measurement errors do: those of the runs, and the error of the speed that would matter.

use super::super::numbers;
use super::super::ReportInput;
use super::cells::law_name;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::error_notices::{most_sensitive_to_speed, SPEED_ERROR};
use crate::findings::measurement_errors::ErrorSummary;

/// How the errors of the runs entered; nothing where no run carries one.
pub(super) fn errors(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    let Some(given) = findings.counts.measurement_errors else {
        return;
    };
    page.section(
        "Measurement errors",
        "What the runs' own errors say of their scatter, and what they move.",
    );
    page.paragraph(&format!(
        "{} of {} runs carry measurement errors: {} of the impact speed, {} of the restitution beyond what it shares with \
         that. e = v_r/v shares the error of v, so about a law m(v) it errs by τ² = u² + s_v² (m/v + ∂m/∂v)². Least squares \
         weighs each run by 1/(σ² + τ²); the intrinsic sd σ is what the restitutions scatter by beyond their errors, and 0 \
         where the errors alone explain the scatter, which are then not made smaller, or where [priors] holds it at 0. A run \
         without an error is taken to err like the median of the others; one whose error of v may take it to where nothing rebounds (e² less than three \
         standard deviations from 0) is left out. What errors of v move to second order is taken off. χ² is of the errors alone, \
         a degree of freedom; p is the probability of as much by chance if nothing else scatters the runs, which must be so \
         only where σ is held at 0.",
        given.runs,
        findings.counts.used + findings.counts.stuck,
        given.of_impact_speed,
        given.of_restitution
    ));
    let dry = findings.dry.iter().filter_map(|dry| {
        Some(FitWithErrors {
            particle: dry.words(),
            law: "dry".to_owned(),
            film_ratio: None,
            runs: dry.runs,
            errors: dry.measurement_errors?,
        })
    });
    let scaling = findings.scaling.iter().filter_map(|row| {
        Some(FitWithErrors {
            particle: row.words(),
            law: law_name(row.law).to_owned(),
            film_ratio: Some(numbers::short(row.film_ratio?)),
            runs: row.runs,
            errors: row.measurement_errors?,
        })
    });
    let balance = findings.energy_balance.iter().filter_map(|balance| {
        Some(FitWithErrors {
            particle: balance.particles.join(", "),
            law: "energy balance".to_owned(),
            film_ratio: Some("all".to_owned()),
            runs: balance.runs,
            errors: balance.measurement_errors?,
        })
    });
    let fits: Vec<FitWithErrors> = dry.chain(scaling).chain(balance).collect();
    let table = ReportTable::of(&fits)
        .column("particle", |fit| &fit.particle)
        .column("law", |fit| &fit.law)
        .column("δ/D", |fit| fit.film_ratio.clone())
        .column("runs with errors", |fit| {
            format!("{} of {}", fit.errors.runs_with_errors, fit.runs)
        })
        .column("left out", |fit| fit.errors.runs_left_out)
        .column("intrinsic sd", |fit| numbers::significant(fit.errors.intrinsic_sd, 2))
        .column("χ²", |fit| numbers::significant(fit.errors.reduced_chi_squared, 2))
        .column("p", |fit| fit.errors.p.map(numbers::probability));
    page.table(&table);
}

/// A fit of runs that carry errors.
struct FitWithErrors {
    particle: String,
    law: String,
    film_ratio: Option<String>,
    runs: usize,
    errors: ErrorSummary,
}

/// The error of the speed that would move β, where it is too large for a caution.
pub(super) fn of_speed(input: ReportInput) -> Option<String> {
    let (row, share) = most_sensitive_to_speed(&input.findings.scaling).filter(|(_, share)| *share >= SPEED_ERROR)?;
    Some(format!(
        "An error of v biases β in proportion to its square: {} % of v in every run would move β of the square root by a tenth of its standard error ({}, δ/D = {}).",
        numbers::significant(100.0 * share, 2),
        row.words(),
        numbers::short(row.film_ratio?)
    ))
}
