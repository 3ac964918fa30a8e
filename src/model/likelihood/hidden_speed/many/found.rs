//! Holds what integrals are over, and what they come to.

use crate::model::likelihood::hidden_speed::{SettingRuns, SettingSlopes};
use crate::model::likelihood::run_density::RunDensity;

/// What integrals came to.
pub(in crate::model::likelihood) struct Found {
    /// the sum of their log densities, with its slope in σ
    pub all: RunDensity,
    /// slopes in what each setting keeps, by the place of its balance
    pub slopes: Vec<SettingSlopes>,
    /// numbers of those that are to be taken by themselves
    pub left: Vec<usize>,
}

impl Found {
    /// Of so many energy balances, before any integral.
    pub fn new(balances: usize) -> Found {
        Found {
            all: RunDensity::default(),
            slopes: vec![SettingSlopes::default(); balances],
            left: vec![],
        }
    }
}

/// Runs of one true speed, as a part of a sum.
#[derive(Clone, Copy)]
pub(in crate::model::likelihood) struct SpeedRuns<'b> {
    /// at least one
    pub settings: &'b [SettingRuns<'b>],
    /// the place of the balance of each
    pub balances: &'b [usize],
    pub number: usize,
    /// how often it counts
    pub times: f64,
}
