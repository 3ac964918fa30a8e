//! Holds runs that share a true speed, setting by setting, with what is known of each.

use super::errors::RunErrors;
use super::hidden::{Hidden, Moves, SettingRuns, SettingSlopes};
use super::run_density::{RunDensity, Seen, Side};
use super::run_noise::{MeasuredRun, RunNoise};
use crate::physics::balance::{Balance, Impact};
use crate::runs::Runs;
use crate::scene::{Scene, Sticking};

/// Runs that share a true speed; `P` is where the parameters of a setting are found.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SharedRuns<P> {
    /// 1; −1 of the probability that runs rebounded, by which their density is divided where stuck ones were not logged
    pub sign: f64,
    /// at least one
    pub settings: Vec<SharedSetting<P>>,
}

/// Those of one setting.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SharedSetting<P> {
    pub place: P,
    /// at the measured speed of the first
    pub impact: Impact,
    /// where the runs are among all
    pub runs: Vec<usize>,
    known: Vec<MeasuredRun>,
}

impl RunErrors {
    /// The groups that share a true speed, of which `place` finds every setting by its first run.
    pub fn shared_runs<P: Copy>(
        &self,
        scene: &Scene,
        runs: &Runs,
        place: impl Fn(usize) -> Option<(P, Impact)>,
    ) -> Vec<SharedRuns<P>> {
        let limit = scene.data.smallest_restitution;
        let rebounded = |run: &usize| runs.restitution[*run] > limit;
        let seen = |run: &usize| {
            if rebounded(run) {
                Seen::Rebound(runs.restitution[*run])
            } else {
                Seen::On(Side::Below, limit)
            }
        };
        let setting = |of: Vec<usize>, seen: &dyn Fn(&usize) -> Seen| {
            let (place, impact) = place(*of.first()?)?;
            let known = of.iter().map(|run| MeasuredRun {
                seen: seen(run),
                errors: self.at(*run, runs.impact_speed[*run]),
            });
            Some(SharedSetting {
                place,
                impact,
                known: known.collect(),
                runs: of,
            })
        };
        let mut found = vec![];
        for shared in self.shared_speeds() {
            let all = shared.settings.iter().filter_map(|of| setting(of.clone(), &seen));
            found.push((1.0, all.collect()));
            if scene.model.sticking == Sticking::Truncated {
                let logged = |of: &Vec<usize>| {
                    let of = of.iter().copied().filter(rebounded).collect();
                    setting(of, &|_| Seen::On(Side::Above, limit))
                };
                found.push((-1.0, shared.settings.iter().filter_map(logged).collect()));
            }
        }
        let found = found.into_iter().map(|(sign, settings)| SharedRuns { sign, settings });
        found.filter(|shared| !shared.settings.is_empty()).collect()
    }
}

impl<P> SharedRuns<P> {
    /// Gives the runs, with the energy balance of each setting, to a function of their integral.
    pub fn hidden<T>(&self, noise: RunNoise, balances: &[&Balance], of: impl FnOnce(Hidden) -> T) -> T {
        let settings = self.settings.iter().zip(balances);
        let settings = settings.map(|(setting, balance)| SettingRuns {
            balance,
            impact: setting.impact,
            runs: &setting.known,
        });
        of(Hidden {
            noise,
            moves: Moves::Speed,
            settings: &settings.collect::<Vec<SettingRuns>>(),
        })
    }

    /// What they add to the log likelihood, and its slopes in what each setting keeps, all with the sign.
    pub fn density(&self, noise: RunNoise, balances: &[&Balance]) -> (RunDensity, Vec<SettingSlopes>) {
        let mut each = vec![SettingSlopes::default(); self.settings.len()];
        let all = self.hidden(noise, balances, |hidden| hidden.integrate(&mut each));
        let each = each.into_iter().map(|of| SettingSlopes {
            kept: self.sign * of.kept,
            viscous: self.sign * of.viscous,
            dry_k: self.sign * of.dry_k,
        });
        (all.times(self.sign), each.collect())
    }
}
