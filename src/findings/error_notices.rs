//! Gives notice of measurement errors that are too large for the scatter, or that matter and were not given.

use super::scaling::Scaling;
use crate::notice::Notice;

/// The error of v, as a share of it, below which there is no notice: calibrating a speed better is hard.
pub const SPEED_ERROR: f64 = 0.01;

/// A χ² this many standard deviations below its expectation is a sign of errors that are too large.
const TOO_SMALL: f64 = 3.0;

/// The film ratio whose β of the square-root law the smallest error of v would move, with that error.
pub fn most_moved(scaling: &[Scaling]) -> Option<(&Scaling, f64)> {
    let shares = scaling
        .iter()
        .filter(|row| row.film_ratio.is_some() && row.verdict.passed)
        .filter_map(|row| Some((row, row.speed_error_of_a_tenth_se?)));
    shares.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Notices of measurement errors that matter or that are too large.
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
    // χ² per degree of freedom and the degrees of freedom
    let with_errors = scaling.iter().filter_map(|row| {
        let errors = row.measurement_errors.filter(|_| row.film_ratio.is_some())?;
        let freedom = row.runs.checked_sub(errors.runs_left_out + 2).filter(|df| *df > 0)?;
        Some((errors.reduced_chi_squared, freedom as f64))
    });
    let too_large: Vec<f64> = with_errors
        .clone()
        .filter(|(chi_squared, df)| *chi_squared < 1.0 - TOO_SMALL * (2.0 / df).sqrt())
        .map(|(chi_squared, _)| chi_squared)
        .collect();
    if let Some(least) = too_large.iter().copied().reduce(f64::min) {
        notices.push(Notice::new(
            "measurement_errors_too_large",
            too_large.len(),
            format!(
                "in {} of {} fits to a film ratio the runs scatter less than their measurement errors say (χ² per degree \
                 of freedom down to {least:.2}); the errors are taken as given, and standard errors follow them",
                too_large.len(),
                with_errors.count()
            ),
            "check whether errors that all runs share, as of a scale, were given as errors of each run",
        ));
    }
    notices
}
