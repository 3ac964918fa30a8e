//! Writes what several tables of the posterior share: names of parameters, R-hat, and checks.

use super::super::super::numbers::NONE;
use super::super::super::quantities::parameter_label;
use super::super::super::ReportInput;
use super::super::cells::check_table;
use super::super::page::Page;
use crate::findings::checks::{self, Check};
use crate::findings::posterior::{Posterior, PriorSummary, QuantitySummary};

/// A sampled parameter before and after the runs.
pub(super) struct SampledParameter<'a> {
    /// its name in tables: `k, PTFE`
    pub(super) label: String,
    pub(super) prior: &'a PriorSummary,
    pub(super) found: &'a QuantitySummary,
}

impl SampledParameter<'_> {
    /// Posterior mean less the centre of the prior, in sds of the prior on its scale.
    pub(super) fn shift(&self) -> Option<f64> {
        self.prior.distance
    }
}

/// Every sampled parameter.
pub(super) fn parameters<'a>(input: ReportInput, posterior: &'a Posterior) -> Vec<SampledParameter<'a>> {
    let sampled = posterior.sampled.parameters.sampled.iter();
    let both = sampled.zip(&posterior.findings.parameters);
    both.filter_map(|(parameter, found)| {
        let label = parameter_label(input.scene, input.runs, parameter.kind, parameter.kind.symbol());
        Some(SampledParameter {
            label: found
                .from
                .map_or(label.clone(), |from| format!("{label} (from {from})")),
            prior: found.prior.as_ref()?,
            found,
        })
    })
    .collect()
}

/// R-hat, to the thousandths its line of 1.01 asks for.
pub(super) fn rhat(value: Option<f64>) -> String {
    value.map_or(NONE.to_owned(), |rhat| format!("{rhat:.3}"))
}

/// A table of checks with what was found, the line it is held against, and whether it holds.
pub(super) fn checks<'c>(page: &mut Page, checks: impl Iterator<Item = &'c Check>) {
    let outcome = |check: &Check| if check.passed { "holds" } else { "fails" };
    page.table(&check_table(checks, 4, |check| check.text.clone(), outcome));
}

/// Whether a check asks how the model predicts, not how it was sampled.
pub(super) fn of_prediction(check: &Check) -> bool {
    check.check.starts_with("predictive") || check.check == checks::DRY_CONSISTENCY.code
}

/// Whether a check is in a table of this section, so that the cautions need not list it again where it holds.
pub(in super::super) fn lists(input: ReportInput, check: &Check) -> bool {
    let own = input.posterior.map(|posterior| posterior.checks.iter());
    own.is_some_and(|mut own| own.any(|own| own.check == check.check))
}
