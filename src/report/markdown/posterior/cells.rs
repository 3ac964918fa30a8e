//! Writes what several tables of the posterior share: names of parameters, and R-hat.

use super::super::super::numbers::NONE;
use super::super::super::quantities::parameter_label;
use super::super::super::ReportInput;
use crate::findings::posterior::{Posterior, PriorSummary, QuantitySummary};
use crate::model::parameters::ParameterKind;

/// A sampled parameter before and after the runs.
pub(super) struct SampledParameter<'a> {
    /// its name in tables: `k, PTFE`
    pub(super) label: String,
    pub(super) prior: &'a PriorSummary,
    pub(super) found: &'a QuantitySummary,
    pub(super) is_dry_k: bool,
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
            is_dry_k: matches!(parameter.kind, ParameterKind::DryK(_)),
        })
    })
    .collect()
}

/// R-hat, to the thousandths its line of 1.01 asks for.
pub(super) fn rhat(value: Option<f64>) -> String {
    value.map_or(NONE.to_owned(), |rhat| format!("{rhat:.3}"))
}
