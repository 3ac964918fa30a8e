//! Holds what integrals are over, and what they come to.

use crate::model::likelihood::hidden_speed::{SettingRuns, SettingSlopes};
use crate::model::likelihood::run_density::RunDensity;

/// What integrals came to.
#[derive(Default)]
pub(in crate::model::likelihood) struct Found {
    /// the sum of their log densities, with its slope in σ
    pub all: RunDensity,
    /// slopes in what each setting keeps, by its number
    pub slopes: Vec<SettingSlopes>,
    /// numbers of those that are to be taken by themselves
    pub left: Vec<usize>,
}

/// Runs of one true speed, as a part of a sum.
#[derive(Clone, Copy)]
pub(in crate::model::likelihood) struct SpeedRuns<'b> {
    /// at least one
    pub settings: &'b [SettingRuns<'b>],
    pub number: usize,
    /// the number of the first setting; the others follow
    pub first_setting: usize,
    /// how often it counts
    pub times: f64,
}
