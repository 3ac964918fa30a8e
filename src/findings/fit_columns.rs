//! Lays the runs of a fit out in columns, with each run's own dry speed and its measurement errors.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::ErrorColumns;
use crate::inference::law::Law;
use crate::inference::least_squares::Fit;
use crate::inference::regression::Regression;
use crate::model::parameters::ParameterKind;
use crate::physics::dry::{speed_root, REFERENCE_SPEED};
use crate::physics::Order;
use crate::runs::Runs;
use crate::scene::Scene;

/// The runs that a law is fitted to.
pub(super) struct FitColumns {
    /// v^(1/5), 1/v in s/m, or 1/St
    pub x: Vec<f64>,
    /// v, m/s
    pub speeds: Vec<f64>,
    pub restitution: Vec<f64>,
    /// how many runs each stands for; empty where that is itself
    pub counts: Vec<f64>,
    /// of the square-root law, where the run's own dry speed enters it
    pub offset: Vec<f64>,
}

impl FitColumns {
    /// Some runs in this order.
    pub fn of(
        runs: &Runs,
        some: impl IntoIterator<Item = usize>,
        x: impl Fn(usize) -> f64,
        own: Option<&OwnDrySpeed>,
    ) -> FitColumns {
        let some: Vec<usize> = some.into_iter().collect();
        let select = |column: &[f64]| -> Vec<f64> { some.iter().filter_map(|run| column.get(*run)).copied().collect() };
        let speeds = select(&runs.impact_speed);
        FitColumns {
            x: some.iter().map(|run| x(*run)).collect(),
            restitution: select(&runs.restitution),
            counts: select(&runs.count),
            offset: own.map_or_else(Vec::new, |own| own.offsets(&speeds)),
            speeds,
        }
    }

    /// A law of these runs.
    pub fn regression(&self, law: Law) -> Regression<'_> {
        Regression {
            offset: if law == Law::SQUARE_ROOT { &self.offset } else { &[] },
            counts: &self.counts,
            ..Regression::new(law, &self.x, &self.restitution)
        }
    }
}

/// The run's own dry speed in the square-root law: e_dry(v)² − e_dry(reference)² is a known offset once k is.
pub(super) struct OwnDrySpeed {
    pub(super) dry_k: f64,
    pub(super) dry_k_se: f64,
    pub(super) order: Order,
}

impl OwnDrySpeed {
    pub fn offsets(&self, speeds: &[f64]) -> Vec<f64> {
        let reference = self.order.restitution(self.dry_k, REFERENCE_SPEED);
        let own = |v: &f64| self.order.restitution(self.dry_k, *v);
        speeds.iter().map(|v| own(v) * own(v) - reference * reference).collect()
    }

    /// v o′ and v² o″ of the offset o, in the speed.
    pub fn offset_slopes(&self, v: f64) -> [f64; 2] {
        self.order.square_in_log_speed(self.dry_k * speed_root(v))
    }

    /// Slopes in k of the parameters fitted to runs at these speeds, with these variances of the residuals if they have
    /// their own; 0 where the fit has no covariance.
    pub fn shift(&self, fit: &Fit, regression: &Regression, speeds: &[f64], variance: &[f64]) -> [f64; 2] {
        let slope = |v: f64| 2.0 * self.order.restitution(self.dry_k, v) * self.order.slope_dry_k(self.dry_k, v);
        let reference = slope(REFERENCE_SPEED);
        let slopes: Vec<f64> = speeds.iter().map(|v| slope(*v) - reference).collect();
        regression
            .offset_sensitivity(fit, &slopes, variance)
            .unwrap_or_default()
    }

    /// Adds k's own uncertainty to the covariance of parameters that move so with k.
    pub fn widen(&self, uncertain: &mut Uncertain, shift: [f64; 2]) {
        if let Ok(covariance) = &mut uncertain.covariance {
            let variance = self.dry_k_se * self.dry_k_se;
            *covariance += DMatrix::from_fn(2, 2, |i, j| shift[i] * shift[j] * variance);
        }
    }
}

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
