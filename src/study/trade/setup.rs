//! Holds what all methods start from.

use crate::findings::posterior::SamplingSetup;
use crate::inference::nuts::Effort;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::ModelParameters;
use crate::runs::Table;
use crate::scene::Scene;

/// What all methods start from.
pub(super) struct TradeSetup<'g> {
    pub(super) scene: &'g Scene,
    pub(super) table: &'g Table,
    pub(super) seed: u64,
    pub(super) model: SamplingSetup,
    pub(super) parameters: ModelParameters,
    pub(super) effort: Effort,
}

impl TradeSetup<'_> {
    pub(super) fn rows(&self) -> Likelihood {
        Likelihood::of_rows(self.scene, &self.table.runs, self.model.form)
    }
}
