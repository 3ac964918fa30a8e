//! Marks the methods that another method beats.

use super::results::Rung;
use crate::inference::accuracy::SURE;

/// A method that takes less than this share of another's time is clearly quicker; one with less than this share of
/// another's error clearly more accurate.
const CLEARLY: f64 = 0.8;

impl Rung {
    /// The largest error of a mean or an sd, and never less than chance leaves to its draws.
    ///
    /// `None` for a method that does not give every parameter: it beats nobody.
    pub fn error(&self) -> Option<f64> {
        let whole = self.errors.iter().all(Option::is_some);
        let measured = self.worst_mean?.max(self.worst_sd?);
        whole.then(|| measured.max(self.effective.map_or(0.0, |effective| SURE / effective.sqrt())))
    }
}

/// Marks each method that another is clearly better than, in time or in error, and not clearly worse in the other.
///
/// Methods with the same nodes draw the same; chance alone separates their times.
pub(super) fn mark_dominated(rungs: &mut [Rung]) {
    let marks: Vec<Option<String>> = rungs
        .iter()
        .map(|rung| {
            let error = rung.error()?;
            let better = rungs.iter().find(|other| {
                let Some(of_other) = other.error().filter(|_| other.failed.is_none()) else {
                    return false;
                };
                let same = other.nodes == rung.nodes && other.errors == rung.errors;
                let quicker = other.seconds < CLEARLY * rung.seconds;
                let nearer = of_other < CLEARLY * error;
                let worse = other.seconds > rung.seconds / CLEARLY || of_other > error / CLEARLY;
                !same && (quicker || nearer) && !worse
            });
            better.map(|other| other.name.clone())
        })
        .collect();
    for (rung, mark) in rungs.iter_mut().zip(marks) {
        rung.dominated_by = mark;
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::MarginalError;
    use super::*;

    fn rung(name: &str, seconds: f64, error: f64) -> Rung {
        let miss = MarginalError {
            mean: error,
            sd: 0.0,
            q05: 0.0,
            q95: 0.0,
        };
        Rung {
            name: name.to_owned(),
            seconds,
            nodes: None,
            errors: vec![Some(miss)],
            worst_mean: Some(error),
            worst_sd: Some(0.0),
            vouched: None,
            effective: None,
            effective_per_second: None,
            dominated_by: None,
            failed: None,
        }
    }

    #[test]
    fn a_way_that_is_slower_and_no_better_is_marked() {
        let mut rungs = vec![
            rung("rough", 0.01, 1.0),
            rung("middle", 0.1, 0.1),
            rung("slow", 1.0, 0.11),
            rung("fine", 1.0, 0.01),
        ];
        // quicker than any, but not reliable
        rungs.push(Rung {
            failed: Some("breach".to_owned()),
            ..rung("wrong", 1e-3, 1e-3)
        });
        // says nothing of one parameter
        rungs.push(Rung {
            errors: vec![None],
            ..rung("partial", 1e-3, 1e-3)
        });
        mark_dominated(&mut rungs);
        let marks: Vec<Option<&str>> = rungs.iter().map(|rung| rung.dominated_by.as_deref()).collect();
        assert_eq!(marks, [None, None, Some("middle"), None, None, None]);
    }

    #[test]
    fn chance_in_the_time_of_the_same_draws_marks_nothing() {
        let mut rungs = vec![rung("a", 0.1, 0.1), rung("b", 0.2, 0.1)];
        mark_dominated(&mut rungs);
        assert_eq!(rungs[1].dominated_by, None);
    }

    #[test]
    fn draws_are_as_good_as_chance_lets_them_be() {
        let lucky = Rung {
            effective: Some(100.0),
            ..rung("lucky", 0.1, 1e-6)
        };
        assert!(lucky.error().is_some_and(|error| (error - 0.33).abs() < 1e-12));
    }
}
