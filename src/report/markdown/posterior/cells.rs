//! Writes what several tables of the posterior share: names of parameters, R-hat, and checks.

use super::super::super::numbers::{self as print, NONE};
use super::super::super::Told;
use super::super::page::Page;
use crate::findings::checks::{self, Check};
use crate::findings::posterior::{Posterior, QuantitySummary};

/// How the tables name a parameter: `k, PTFE`.
pub(super) fn label(quantity: &QuantitySummary) -> String {
    let symbol = quantity
        .prior
        .as_ref()
        .map_or(quantity.name.as_str(), |prior| prior.symbol);
    match quantity.name.split_once('[') {
        Some((_, particle)) => format!("{symbol}, {}", particle.trim_end_matches(']')),
        None => symbol.to_owned(),
    }
}

/// R-hat, to the thousandths its line of 1.01 asks for.
pub(super) fn rhat(value: Option<f64>) -> String {
    value.map_or(NONE.to_owned(), |rhat| format!("{rhat:.3}"))
}

/// A table of checks with what was found, the line it is held against, and whether it holds.
pub(super) fn checks<'c>(page: &mut Page, checks: impl Iterator<Item = &'c Check>) {
    let rows: Vec<Vec<String>> = checks
        .map(|check| {
            vec![
                check.text.clone(),
                print::optional(check.value, 4),
                print::significant(check.threshold, 3),
                if check.passed { "holds" } else { "fails" }.to_owned(),
                check.source.to_owned(),
            ]
        })
        .collect();
    page.table(&["check", "value", "line", "outcome", "why this line"], &rows);
}

/// Whether a check asks how the model predicts, not how it was sampled.
pub(super) fn of_prediction(check: &Check) -> bool {
    check.check.starts_with("predictive") || check.check == checks::DRY_CONSISTENCY.code
}

/// Checks told here, which the table of cautions need not tell again where they hold.
pub(in super::super) fn tells(told: Told, check: &Check) -> bool {
    let same = |own: &&Check| own.check == check.check;
    told.posterior
        .is_some_and(|posterior: &Posterior| posterior.checks.iter().find(same).is_some())
}
