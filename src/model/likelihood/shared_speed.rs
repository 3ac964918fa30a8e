//! Holds runs that share a true speed, setting by setting, with what is known of each.

use super::hidden::{Hidden, SettingRuns};
use super::run_noise::{MeasuredRun, RunNoise};
use crate::physics::balance::{Balance, Impact};

/// Runs that share a true speed.
#[derive(Debug, Clone)]
pub(super) struct SharedRuns {
    /// 1; −1 of the probability that runs rebounded, by which their density is divided where stuck ones were not logged
    pub sign: f64,
    /// at least one
    pub settings: Vec<SharedSetting>,
}

/// Those of one setting.
#[derive(Debug, Clone)]
pub(super) struct SharedSetting {
    /// at the measured speed of the first
    pub impact: Impact,
    /// where the runs are among all; at least one
    pub runs: Vec<usize>,
    pub known: Vec<MeasuredRun>,
}

impl SharedRuns {
    /// The first run of each setting, by its place among all.
    pub fn firsts(&self) -> impl Iterator<Item = usize> + '_ {
        self.settings.iter().map(|setting| setting.runs[0])
    }

    /// Gives the runs, with the energy balance of each setting, to a function of their integral.
    pub fn hidden<T>(&self, noise: RunNoise, balances: &[Balance], of: impl FnOnce(Hidden) -> T) -> T {
        let settings = self.settings.iter().zip(balances);
        let settings = settings.map(|(setting, balance)| SettingRuns {
            balance,
            impact: setting.impact,
            runs: &setting.known,
        });
        of(Hidden {
            noise,
            settings: &settings.collect::<Vec<SettingRuns>>(),
        })
    }
}
