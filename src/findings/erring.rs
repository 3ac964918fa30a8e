//! Gathers what the runs of a fit are measured to err by.

use std::ops::Range;

use serde::Serialize;

use super::own_dry_speed::OwnDrySpeed;
use super::scaling::Scaling;
use crate::inference::effective_variance::{Erring, Weighing};
use crate::notice::Notice;
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

/// The error of v, as a share of it, below which nothing is said: calibrating a speed better is hard.
pub const SPEED_ERROR: f64 = 0.01;

/// Squares over the errors' own this many standard deviations below what they should be tell errors that are too large.
const TOO_SMALL: f64 = 3.0;

/// The film ratio whose β of the square-root law the smallest error of v would move, with that error.
pub fn most_moved(scaling: &[Scaling]) -> Option<(&Scaling, f64)> {
    let shares = scaling
        .iter()
        .filter(|row| row.film_ratio.is_some() && row.verdict.passed)
        .filter_map(|row| Some((row, row.speed_error_of_a_tenth_se?)));
    shares.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// What of the measurement errors wants a second look.
pub(super) fn notices(scaling: &[Scaling]) -> Vec<Notice> {
    let mut notices = vec![];
    let below = |row: &&Scaling| {
        let share = row.speed_error_of_a_tenth_se.filter(|_| row.film_ratio.is_some());
        row.verdict.passed && share.is_some_and(|share| share < SPEED_ERROR)
    };
    let count = scaling.iter().filter(below).count();
    if let Some((row, share)) = most_moved(scaling).filter(|_| count > 0) {
        notices.push(Notice::new(
            "speed_error_matters",
            count,
            format!(
                "an error of {:.2} % in the impact speeds would move β of the square-root law of {} at film ratio {:.3} \
                 by a tenth of its standard error; {count} film ratios bear less than {} %",
                100.0 * share,
                row.particle,
                row.film_ratio.unwrap_or(f64::NAN),
                100.0 * SPEED_ERROR
            ),
            "give impact_speed_sd_m_s for each run, or leave out the runs nearest to sticking",
        ));
    }
    let weighed = scaling.iter().filter_map(|row| {
        let weighed = row.measurement_errors.filter(|_| row.film_ratio.is_some())?;
        Some((
            row,
            weighed,
            row.runs.checked_sub(weighed.runs_left_out + 2).filter(|df| *df > 0)? as f64,
        ))
    });
    let too_large: Vec<_> = weighed
        .clone()
        .filter(|(_, weighed, df)| weighed.reduced_chi_squared < 1.0 - TOO_SMALL * (2.0 / df).sqrt())
        .collect();
    let least = too_large.iter().map(|(_, weighed, _)| weighed.reduced_chi_squared);
    if let Some(least) = least.reduce(f64::min) {
        notices.push(Notice::new(
            "measurement_errors_too_large",
            too_large.len(),
            format!(
                "in {} of {} fits to a film ratio the runs scatter less than their measurement errors say (χ² per degree \
                 of freedom down to {least:.2}); the errors are taken as given, and standard errors follow them",
                too_large.len(),
                weighed.count()
            ),
            "check whether errors that all runs share, as of a scale, were given as errors of each run",
        ));
    }
    notices
}
