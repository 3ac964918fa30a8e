//! Tells what measurement errors do: those of the runs, and the error of the speed that would matter.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::law_name;
use super::page::Page;
use crate::findings::error_notices::most_sensitive_to_speed;
use crate::findings::measurement_errors::ErrorSummary;

/// How the errors of the runs entered; nothing where no run carries one.
pub(super) fn errors(page: &mut Page, told: Told) {
    let findings = told.findings;
    let Some(given) = findings.counts.measurement_errors else {
        return;
    };
    page.heading("Measurement errors");
    page.paragraph(&format!(
        "{} of {} runs carry measurement errors: {} of the impact speed, {} of the restitution beyond what it shares with \
         that. e = v_r/v shares the error of v, so about a law m(v) it errs by τ² = u² + s_v² (m/v + ∂m/∂v)². Least squares \
         weighs each run by 1/(σ² + τ²); the intrinsic sd σ is what the restitutions scatter by beyond their errors, and 0 \
         where the errors alone explain the scatter, which are then not made smaller. A run without an error is taken to \
         err like the median of the others; one whose error of v may take it to where nothing rebounds (e² less than three \
         standard deviations from 0) is left out. What errors of v move to second order is taken off. χ² is of the errors alone, \
         a degree of freedom.",
        given.runs,
        findings.counts.used + findings.counts.stuck,
        given.of_impact_speed,
        given.of_restitution
    ));
    let dry = findings.dry.iter().filter_map(|dry| {
        let about = [dry.particle.clone(), "dry".to_owned(), NONE.to_owned()];
        Some((about, dry.runs, dry.measurement_errors?))
    });
    let scaling = findings.scaling.iter().filter_map(|row| {
        let ratio = numbers::short(row.film_ratio?);
        Some((
            [row.particle.clone(), law_name(row.law), ratio],
            row.runs,
            row.measurement_errors?,
        ))
    });
    let balance = findings.energy_balance.iter().filter_map(|balance| {
        let about = [
            balance.particles.join(", "),
            "energy balance".to_owned(),
            "all".to_owned(),
        ];
        Some((about, balance.runs, balance.measurement_errors?))
    });
    let cells = |(about, runs, weighed): ([String; 3], usize, ErrorSummary)| -> Vec<String> {
        let told: [String; 4] = [
            format!("{} of {runs}", weighed.runs_with_errors),
            weighed.runs_left_out.to_string(),
            numbers::significant(weighed.intrinsic_sd, 2),
            numbers::significant(weighed.reduced_chi_squared, 2),
        ];
        about.into_iter().chain(told).collect()
    };
    let rows: Vec<Vec<String>> = dry.chain(scaling).chain(balance).map(cells).collect();
    page.table(
        &[
            "particle",
            "law",
            "δ/D",
            "runs with errors",
            "left out",
            "intrinsic sd",
            "χ²",
        ],
        &rows,
    );
}

/// The error of the speed that would move β.
pub(super) fn of_speed(told: Told) -> Option<String> {
    let (row, share) = most_sensitive_to_speed(&told.findings.scaling)?;
    Some(format!(
        "An error of v biases β in proportion to its square; as little as {} % of v in every run would move β of the \
         square root by a tenth of its standard error ({}, δ/D = {}).",
        numbers::significant(100.0 * share, 2),
        row.particle,
        numbers::short(row.film_ratio?)
    ))
}
