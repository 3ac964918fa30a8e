//! Says which measurement errors want a second look: too large for the scatter, or large enough to matter and not given.

use super::fit_columns::speeds_err;
use super::remarks;
use super::scaling::Scaling;
use crate::remark::{Level, Remark};
use crate::runs::Runs;

/// The error of v, as a share of it, below which nothing is said: calibrating a speed better is hard.
const SPEED_ERROR: f64 = 0.01;

/// Squares over the errors' own this many standard deviations below what they should be tell errors that are too large.
const TOO_SMALL: f64 = 3.0;

/// The error of v, as a share of it, that would move β of a usable square-root law of a film ratio by a tenth of its standard
/// error.
fn error_that_matters(row: &Scaling) -> Option<f64> {
    let share = row.speed_error_of_a_tenth_se;
    share.filter(|_| row.film_ratio.is_some() && row.verdict.passed)
}

/// What of the measurement errors wants a second look. A law that `is_main` says no main number of cautions of nothing.
pub(super) fn measurement_error_notices(
    runs: &Runs,
    scaling: &[Scaling],
    is_main: impl Fn(&Scaling) -> bool,
) -> Vec<Remark> {
    let mut found = vec![];
    let shares = scaling.iter().filter_map(|row| Some((row, error_that_matters(row)?)));
    let all: Vec<(&Scaling, f64)> = shares.filter(|(_, share)| *share < SPEED_ERROR).collect();
    let main: Vec<(&Scaling, f64)> = all.iter().copied().filter(|(row, _)| is_main(row)).collect();
    let (level, told) = match main.is_empty() {
        true => (Level::Informs, all),
        false => (Level::Cautions, main),
    };
    let count = told.len();
    // the law that the smallest error would move
    let most_sensitive = told.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    // where they are given they are asked for no more
    if let Some((row, share)) = most_sensitive.filter(|_| !speeds_err(runs)) {
        let at = match count {
            1 => "one film ratio".to_owned(),
            some => format!("{some} film ratios"),
        };
        let text = format!(
            "an error of {:.2} % in the impact speeds would move β of the square-root law of {} at film ratio {:.3} by a \
             tenth of its standard error; at {at} less than {} % would",
            100.0 * share,
            row.words(),
            row.film_ratio.unwrap_or(f64::NAN),
            100.0 * SPEED_ERROR
        );
        found.push(remarks::SPEED_ERROR_MATTERS.notice(count, text).at(level));
    }
    let weighed = scaling.iter().filter_map(|row| {
        let weighed = row.measurement_errors.filter(|_| row.film_ratio.is_some())?;
        let df = row.runs.checked_sub(weighed.runs_left_out + 2).filter(|df| *df > 0)?;
        Some((weighed.reduced_chi_squared, df as f64))
    });
    let is_too_large = |(reduced, df): &(f64, f64)| *reduced < 1.0 - TOO_SMALL * (2.0 / df).sqrt();
    let too_large: Vec<f64> = weighed.clone().filter(is_too_large).map(|own| own.0).collect();
    if let Some(least) = too_large.iter().copied().reduce(f64::min) {
        let text = format!(
            "in {} of {} fits to a film ratio the runs scatter less than their measurement errors say (χ² per degree of \
             freedom down to {least:.2}); the errors are taken as given, and standard errors follow them",
            too_large.len(),
            weighed.count()
        );
        found.push(remarks::MEASUREMENT_ERRORS_TOO_LARGE.notice(too_large.len(), text));
    }
    found
}
