//! Reads a row that is the mean of several runs as those runs.

use super::raw_row::{bad_cell, refuse, BadCell, RawRow, LARGEST_RESTITUTION, MEASUREMENT_SDS};
use crate::distributions::normal_quantile;
use crate::scene::RunColumn;

/// Runs that one row may be the mean of.
const MOST_IN_ROW: u32 = 10_000;

/// Runs that the averaged rows of one scene may stand for together.
pub(super) const MOST_AVERAGED: usize = 1_000_000;

/// Standard deviation and standard error of one mean, both rounded, agree to this share.
const ROUNDING: f64 = 0.2;

/// What the mean of several runs says of them besides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeanOf {
    /// how many, more than one
    pub runs: u32,
    /// standard deviation of their restitutions, with n − 1
    sd: f64,
}

impl MeanOf {
    /// As many restitutions, of exactly this mean and standard deviation, with the spacing of normal quantiles.
    ///
    /// A normal law has mean and sd as sufficient statistics: fits, their degrees of freedom and the posterior are then
    /// those of the single runs, and bands of the runs hold the share that they should.
    pub fn restitutions(self, mean: f64) -> impl Iterator<Item = f64> {
        let runs = f64::from(self.runs);
        // Blom's places of the expected order statistics
        let score = move |rank: u32| normal_quantile((f64::from(rank) + 0.625) / (runs + 0.25));
        let squares: f64 = match self.sd > 0.0 {
            true => (0..self.runs).map(|rank| score(rank).powi(2)).sum(),
            false => 1.0,
        };
        let scale = self.sd * ((runs - 1.0) / squares).sqrt();
        (0..self.runs).map(move |rank| if scale > 0.0 { mean + scale * score(rank) } else { mean })
    }
}

/// What a row says of the runs that it is the mean of; `None` of a single run, and where a cell is wrong. Restitutions up to
/// `limit` stuck.
pub(super) fn mean_of(raw: &RawRow, restitution: f64, limit: f64, problems: &mut Vec<BadCell>) -> Option<MeanOf> {
    let runs = raw[RunColumn::Runs].unwrap_or(1.0);
    if !(runs >= 1.0 && runs <= f64::from(MOST_IN_ROW) && runs.fract() == 0.0) {
        let expected = format!("expected how many runs the row is the mean of, a whole number from 1 to {MOST_IN_ROW}");
        return refuse(problems, RunColumn::Runs, expected);
    }
    let of_runs = [RunColumn::RestitutionSdOfRuns, RunColumn::RestitutionSe];
    let is_above_zero = |column: RunColumn| raw[column].is_some_and(|sd| sd > 0.0);
    for column in of_runs {
        if raw[column].is_some_and(|sd| !(0.0..=LARGEST_RESTITUTION).contains(&sd)) {
            let expected = format!("expected a spread of restitutions, from 0 to {LARGEST_RESTITUTION}");
            return refuse(problems, column, expected);
        }
    }
    if runs == 1.0 {
        for column in of_runs {
            if is_above_zero(column) {
                let expected =
                    "expected nothing or 0, since the row is one run: an error of its measurement goes into \
                                `restitution_sd`";
                problems.push(bad_cell(column, expected));
            }
        }
        return None;
    }
    for column in MEASUREMENT_SDS {
        if is_above_zero(column) {
            let expected = "expected nothing, since the row is the mean of several runs: the sd of these runs goes into \
                            `restitution_sd_of_runs`, or the standard error of their mean into `restitution_se`; it holds \
                            the errors of measurement";
            problems.push(bad_cell(column, expected));
        }
    }
    let of_se = raw[RunColumn::RestitutionSe].map(|se| se * runs.sqrt());
    let sd = match (raw[RunColumn::RestitutionSdOfRuns], of_se) {
        (Some(sd), Some(of_se)) if (sd - of_se).abs() > ROUNDING * sd.max(of_se) => {
            let expected = format!(
                "expected `restitution_sd_of_runs` over the square root of `runs` ({:.2e}), or one of the two alone",
                sd / runs.sqrt()
            );
            return refuse(problems, RunColumn::RestitutionSe, expected);
        }
        (Some(sd), _) | (None, Some(sd)) => sd,
        // runs that stuck are all at 0
        (None, None) if restitution <= limit => 0.0,
        (None, None) => {
            let expected =
                "expected the sd of the single runs in `restitution_sd_of_runs`, or the standard error of their \
                            mean in `restitution_se`, since the row is the mean of several";
            return refuse(problems, RunColumn::RestitutionSdOfRuns, expected);
        }
    };
    let mean_of = MeanOf { runs: runs as u32, sd };
    let least = mean_of.restitutions(restitution).next().unwrap_or(restitution);
    let most = 2.0 * restitution - least;
    let some_stuck = if restitution <= limit { sd > 0.0 } else { least <= limit };
    if some_stuck || most > LARGEST_RESTITUTION {
        let what = if some_stuck { "stuck" } else { "rebounded far too fast" };
        let expected = format!("expected single runs, a row each: by its mean and sd some of these {what}");
        problems.push(bad_cell(RunColumn::Restitution, expected));
    }
    Some(mean_of)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(runs: f64, [sd, se]: [Option<f64>; 2], restitution: f64) -> Result<Option<MeanOf>, Vec<BadCell>> {
        let mut raw = RawRow::default();
        raw.set(RunColumn::Runs, Some(runs));
        raw.set(RunColumn::RestitutionSdOfRuns, sd);
        raw.set(RunColumn::RestitutionSe, se);
        let mut problems = vec![];
        let found = mean_of(&raw, restitution, 0.0, &mut problems);
        match problems.is_empty() {
            true => Ok(found),
            false => Err(problems),
        }
    }

    #[test]
    fn runs_that_stuck_need_no_sd() {
        let stuck = of(4.0, [None, None], 0.0).expect("a right row").expect("a mean");
        assert_eq!(stuck.restitutions(0.0).collect::<Vec<_>>(), [0.0; 4]);
        assert_eq!(of(1.0, [None, Some(0.0)], 0.7), Ok(None));
    }

    #[test]
    fn what_cannot_be_runs_is_refused() {
        let column = |found: Result<_, Vec<BadCell>>| found.err().map(|bad| bad[0].column);
        let (sd, se) = (RunColumn::RestitutionSdOfRuns, RunColumn::RestitutionSe);
        for (runs, spread, restitution, expected) in [
            (0.0, [Some(0.01), None], 0.7, RunColumn::Runs),
            (2.5, [Some(0.01), None], 0.7, RunColumn::Runs),
            (1e9, [Some(0.01), None], 0.7, RunColumn::Runs),
            (f64::NAN, [Some(0.01), None], 0.7, RunColumn::Runs),
            (5.0, [None, None], 0.7, sd),
            (5.0, [Some(-0.01), None], 0.7, sd),
            (5.0, [None, Some(f64::NAN)], 0.7, se),
            (1.0, [None, Some(0.01)], 0.7, se),
            // the se is the sd again
            (5.0, [Some(0.01), Some(0.01)], 0.7, se),
            (5.0, [Some(0.05), None], 0.06, RunColumn::Restitution),
            (5.0, [Some(0.05), None], 0.0, RunColumn::Restitution),
            (5.0, [Some(0.3), None], 0.9, RunColumn::Restitution),
        ] {
            assert_eq!(
                column(of(runs, spread, restitution)),
                Some(expected),
                "{runs} {spread:?} {restitution}"
            );
        }
        assert!(of(5.0, [Some(0.010), Some(0.0045)], 0.7).is_ok());
    }
}
