//! Gathers the measurement errors of the runs of a fit.

use std::ops::Range;

use super::own_dry_speed::OwnDrySpeed;
use crate::inference::effective_variance::ErrorColumns;
use crate::model::parameters::ParameterKind;
use crate::runs::Runs;
use crate::scene::Scene;

/// Whether columns tell errors of impact speeds.
pub(super) fn speeds_err(runs: &Runs) -> bool {
    runs.errors.iter().any(|error| error.impact_speed_sd > 0.0)
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
    if runs.errors.is_empty() {
        return None;
    }
    let all = || ranges.clone().flatten();
    let offset_slopes = all().filter_map(|run| own.map(|own| own.offset_slopes(runs.impact_speed[run])));
    Some(ErrorColumns {
        relative_speed_sd: all()
            .map(|run| runs.errors[run].impact_speed_sd / runs.impact_speed[run])
            .collect(),
        restitution_sd: all().map(|run| runs.errors[run].restitution_sd).collect(),
        speed_correlation: all().map(|run| runs.errors[run].speed_correlation).collect(),
        offset_slopes: offset_slopes.collect(),
        are_all: scene.errors_are_all(spread.key()),
    })
}
