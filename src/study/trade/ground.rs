//! Holds what all ways start from.

use crate::findings::posterior::Asked;
use crate::inference::nuts::Effort;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::Parameters;
use crate::runs::Table;
use crate::scene::Scene;

/// What all ways start from.
pub(super) struct Ground<'g> {
    pub(super) scene: &'g Scene,
    pub(super) table: &'g Table,
    pub(super) seed: u64,
    pub(super) asked: Asked,
    pub(super) parameters: Parameters,
    pub(super) effort: Effort,
}

impl Ground<'_> {
    pub(super) fn rows(&self) -> Likelihood {
        Likelihood::of_rows(self.scene, &self.table.runs, self.asked.form)
    }
}
