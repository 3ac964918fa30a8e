//! Gathers the measurement errors of the runs of a fit, and warns where they matter.

use std::ops::Range;

use serde::Serialize;

use super::own_dry_speed::OwnDrySpeed;
use crate::distributions::chi_squared_tail;
use crate::inference::effective_variance::{ErrorColumns, ErrorWeights};
use crate::model::parameters::ParameterKind;
use crate::runs::Runs;
use crate::scene::Scene;

/// Which runs carry measurement errors above 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RunsWithErrors {
    /// with any
    pub runs: usize,
    /// with one of the impact speed
    pub of_impact_speed: usize,
    /// with one of the restitution beyond what it shares with the impact speed
    pub of_restitution: usize,
}

impl RunsWithErrors {
    /// `None` where no run carries one.
    pub(super) fn of(runs: &Runs) -> Option<RunsWithErrors> {
        let [runs, of_impact_speed, of_restitution] = runs.errors.as_ref()?.counts();
        Some(RunsWithErrors {
            runs,
            of_impact_speed,
            of_restitution,
        })
    }
}

/// How measurement errors entered a fit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// runs that carry an error above 0; the others are taken to err like the median of these
    pub runs_with_errors: usize,
    /// runs left out, since their error of v may take them to where nothing rebounds
    pub runs_left_out: usize,
    /// what the restitutions scatter by beyond their measurement errors; 0 where these explain more than the scatter
    pub intrinsic_sd: f64,
    /// squares of the residuals over their measurement errors', a degree of freedom
    pub reduced_chi_squared: f64,
    /// those degrees of freedom
    pub degrees_of_freedom: usize,
    /// probability of squares as large by chance, if nothing but the errors scatters the runs
    pub p: Option<f64>,
}

impl ErrorSummary {
    pub(super) fn of(weights: &ErrorWeights) -> ErrorSummary {
        let freedom = weights.degrees_of_freedom as f64;
        ErrorSummary {
            runs_with_errors: weights.runs_with_errors,
            runs_left_out: weights.runs_left_out,
            intrinsic_sd: weights.intrinsic_sd,
            reduced_chi_squared: weights.reduced_chi_squared,
            degrees_of_freedom: weights.degrees_of_freedom,
            p: chi_squared_tail(weights.reduced_chi_squared * freedom, freedom),
        }
    }
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
