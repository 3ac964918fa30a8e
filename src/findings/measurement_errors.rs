//! Gathers the measurement errors of the runs of a fit.

use std::ops::Range;

use super::own_dry_speed::OwnDrySpeed;
use crate::inference::effective_variance::ErrorColumns;
use crate::model::parameters::ParameterKind;
use crate::runs::Runs;
use crate::scene::Scene;

/// Whether columns tell errors of impact speeds.
pub(super) fn speeds_err(runs: &Runs) -> bool {
    let errors = runs.errors.as_ref();
    errors.is_some_and(|errors| errors.counts().of_impact_speed > 0)
}

/// The errors of the runs of some ranges, in the order in which they are fitted, with the dry speed that enters a wet law;
/// `spread` is that of their kind. `None` where the table has none.
pub(super) fn error_columns(
    scene: &Scene,
    runs: &Runs,
    spread: ParameterKind,
    ranges: impl Iterator<Item = Range<usize>> + Clone,
    own: Option<&OwnDrySpeed>,
) -> Option<ErrorColumns> {
    let errors = runs.errors.as_ref()?;
    let all = || ranges.clone().flatten();
    let offset_slopes = all().filter_map(|run| own.map(|own| own.offset_slopes(runs.impact_speed[run])));
    Some(ErrorColumns {
        relative_speed_sd: all()
            .map(|run| errors.impact_speed_sd[run] / runs.impact_speed[run])
            .collect(),
        restitution_sd: all().map(|run| errors.restitution_sd[run]).collect(),
        speed_correlation: if errors.speed_correlation.is_empty() {
            vec![]
        } else {
            all().map(|run| errors.correlation(run)).collect()
        },
        offset_slopes: offset_slopes.collect(),
        are_all: scene.errors_are_all(spread.key()),
    })
}
