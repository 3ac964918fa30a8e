//! Takes as many rebounds as an elasticity needs.

use crate::runs::{is_in_even_share, Runs};

/// The dry rebounds of a table and some of the wet ones.
pub(super) struct RunSample {
    pub(super) runs: Runs,
    /// share of the wet rebounds that is in it
    pub(super) share: f64,
    /// the share that was wanted
    wanted: f64,
}

impl RunSample {
    /// The dry rebounds and about `most` of the wet ones, spread over each series; at least one a series.
    pub(super) fn of(runs: &Runs, most: usize) -> RunSample {
        let rebounds = |runs: &Runs| runs.series.iter().map(|series| series.rebounds.len()).sum::<usize>();
        let all = rebounds(runs);
        let wanted = if all > most { most as f64 / all as f64 } else { 1.0 };
        let sample = runs.with_rebounds(|place| is_in_even_share(place, wanted));
        RunSample {
            share: rebounds(&sample) as f64 / all.max(1) as f64,
            runs: sample,
            wanted,
        }
    }

    /// Whether it has the rebound at this place of a series.
    pub(super) fn holds(&self, place: usize) -> bool {
        is_in_even_share(place, self.wanted)
    }
}
