//! Gathers the integrals that go together whatever the parameters, once for all evaluations.

use super::batch::{Batch, MOST_REBOUNDS};
use super::found::SpeedRuns;
use crate::model::likelihood::normal_nodes::Order;
use crate::model::likelihood::run_density::Seen;

/// Integrals over rebounds alone.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::model::likelihood) struct Together {
    pub(super) batches: Vec<Batch>,
    /// those that have room, by the number of rebounds
    open: [Option<usize>; MOST_REBOUNDS],
}

impl Together {
    /// Takes an integral in where it is one of these, and says so.
    pub fn push(&mut self, runs: &SpeedRuns) -> bool {
        let all = || runs.settings.iter().flat_map(|setting| setting.runs);
        let rebounds = all().count();
        if rebounds > MOST_REBOUNDS || !all().all(|run| matches!(run.seen, Seen::Rebound(_))) {
            return false;
        }
        let open = &mut self.open[rebounds - 1];
        let batch = *open.get_or_insert_with(|| {
            let balance = runs.settings[0].balance;
            let form = (balance.order, balance.own_speed);
            self.batches.push(Batch::new(rebounds, Order::Eight, form));
            self.batches.len() - 1
        });
        self.batches[batch].push(runs, false);
        if self.batches[batch].is_full() {
            *open = None;
        }
        true
    }
}
