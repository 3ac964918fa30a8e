//! Gathers what the runs of a fit are measured to err by.

use std::ops::Range;

use serde::Serialize;

use super::own_dry_speed::OwnDrySpeed;
use crate::inference::effective_variance::{Erring, Weighing};
use crate::runs::Runs;

/// Which runs carry measurement errors above 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Given {
    /// with any
    pub runs: usize,
    /// with one of the impact speed
    pub of_impact_speed: usize,
    /// with one of the restitution beyond what it shares with the impact speed
    pub of_restitution: usize,
}

impl Given {
    /// `None` where no run carries one.
    pub(super) fn of(runs: &Runs) -> Option<Given> {
        let [runs, of_impact_speed, of_restitution] = runs.errors.as_ref()?.counts();
        Some(Given {
            runs,
            of_impact_speed,
            of_restitution,
        })
    }
}

/// What a fit says of the measurement errors of its runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Weighed {
    /// runs that carry an error above 0; the others are taken to err like the median of these
    pub runs_with_errors: usize,
    /// runs left out, since their error of v may take them to where nothing rebounds
    pub runs_left_out: usize,
    /// what the restitutions scatter by beyond their measurement errors; 0 where these explain more than the scatter
    pub intrinsic_sd: f64,
    /// squares of the residuals over their measurement errors', a degree of freedom
    pub reduced_chi_squared: f64,
}

impl Weighed {
    pub(super) fn of(weighing: &Weighing) -> Weighed {
        Weighed {
            runs_with_errors: weighing.erring,
            runs_left_out: weighing.left_out,
            intrinsic_sd: weighing.intrinsic_sd,
            reduced_chi_squared: weighing.reduced_chi_squared,
        }
    }
}

/// Speeds and errors of some runs, in the order in which they are fitted.
pub(super) struct Columns {
    speed: Vec<f64>,
    impact_speed_sd: Vec<f64>,
    restitution_sd: Vec<f64>,
    offset_slopes: Vec<[f64; 2]>,
}

impl Columns {
    /// The runs of some ranges, with the dry speed that enters their law; `None` where the table has no errors.
    pub(super) fn of(
        runs: &Runs,
        ranges: impl Iterator<Item = Range<usize>> + Clone,
        own: Option<&OwnDrySpeed>,
    ) -> Option<Columns> {
        let errors = runs.errors.as_ref()?;
        let gather = |column: &[f64]| -> Vec<f64> { ranges.clone().flat_map(|range| column[range].to_vec()).collect() };
        let speed = gather(&runs.impact_speed);
        let of_run = |v: &f64| own.map(|own| own.offset_slopes(*v).map(|slope| slope / v));
        // the second has v twice
        let offset_slopes = speed
            .iter()
            .filter_map(|v| of_run(v).map(|[first, second]| [first, second / v]));
        Some(Columns {
            offset_slopes: offset_slopes.collect(),
            impact_speed_sd: gather(&errors.impact_speed_sd),
            restitution_sd: gather(&errors.restitution_sd),
            speed,
        })
    }

    pub(super) fn erring(&self) -> Erring<'_> {
        Erring {
            speed: &self.speed,
            impact_speed_sd: &self.impact_speed_sd,
            restitution_sd: &self.restitution_sd,
            offset_slopes: &self.offset_slopes,
        }
    }
}
