//! Sums the log densities of wet runs whose impact speeds err, over their true speeds.

use super::block_sums::BlockSums;
use super::errors::Errors;
use super::hidden_speed::{ManySpeeds, MeasuredRun, SettingRuns, SettingSlopes, SpeedRuns};
use super::nodes::Nodes;
use super::prepared::Likelihood;
use super::row_noise::{add_noise_slopes, RowNoise};
use super::run_density::{Seen, Side};
use super::sums::NodeRange;
use super::trend::FilmLaw;
use crate::model::parameters::ParameterKind;
use crate::physics::balance::Impact;
use crate::runs::MOST_SETTINGS;

/// Runs of one true speed, or a run at one of its own.
#[derive(Debug, Clone, Copy)]
pub(super) enum Part {
    /// node of a rebound
    Rebound(usize),
    /// the same, as a run that was logged because it rebounded
    Logged(usize),
    /// node of a stuck run
    Stuck(usize),
    /// place among those that share a true speed
    Shared(usize),
}

/// The parts of a sum, each with its settings.
pub(super) struct TrueSpeeds<'l> {
    likelihood: &'l Likelihood,
    noise: &'l RowNoise<'l>,
    many: ManySpeeds,
    /// each with the number of its first setting
    parts: Vec<(Part, usize)>,
    /// of each setting, with the block it belongs to
    laws: Vec<(usize, FilmLaw)>,
}

impl<'l> TrueSpeeds<'l> {
    pub fn new(likelihood: &'l Likelihood, noise: &'l RowNoise) -> TrueSpeeds<'l> {
        TrueSpeeds {
            likelihood,
            noise,
            many: ManySpeeds::new(&noise.noise),
            parts: vec![],
            laws: vec![],
        }
    }

    /// Adds a run of a block at a film.
    pub fn push(&mut self, run: Part, block: usize, film: FilmLaw) {
        // neighbours mostly share a film
        if self.laws.last() != Some(&(block, film)) {
            self.laws.push((block, film));
        }
        self.push_part(run, self.laws.len() - 1);
    }

    /// Adds all runs that share their true speeds.
    pub fn push_shared(&mut self, blocks: &[NodeRange]) {
        let shared = &self.noise.own.shared;
        self.parts.reserve(shared.len());
        self.laws.reserve(shared.iter().map(|of| of.settings.len()).sum());
        for (place, shared) in shared.iter().enumerate() {
            let first = self.laws.len();
            for setting in &shared.settings {
                let place = setting.place;
                self.laws.push((place.block, blocks[place.block].law.at(place.film)));
            }
            self.push_part(Part::Shared(place), first);
        }
    }

    fn push_part(&mut self, part: Part, first_setting: usize) {
        let number = self.parts.len();
        self.parts.push((part, first_setting));
        let TrueSpeeds {
            likelihood,
            noise,
            many,
            laws,
            ..
        } = self;
        let times = likelihood.times(noise, part);
        likelihood.with_settings(noise, part, &laws[first_setting..], |settings| {
            many.push(SpeedRuns {
                settings,
                number,
                first_setting,
                times,
            });
        });
    }

    /// The log likelihood; adds its slopes in the spreads and in ν, and in r to the sums of each block.
    pub fn finish(self, slopes: &mut [f64], sums: &mut [BlockSums]) -> f64 {
        let TrueSpeeds {
            likelihood,
            noise,
            many,
            parts,
            laws,
        } = self;
        let found = many.finish();
        let mut value = found.all.value;
        add_noise_slopes(found.all, ParameterKind::SigmaWet, slopes);
        let mut add = |setting: usize, of: SettingSlopes, times: f64| {
            let (block, film) = &laws[setting];
            film.add(
                &mut sums[*block],
                times * of.kept,
                times * of.viscous,
                -0.5 * times * of.dry_k,
            );
        };
        for (setting, of) in found.slopes.into_iter().enumerate() {
            add(setting, of, 1.0);
        }
        for (part, first) in found.left.into_iter().map(|number| parts[number]) {
            let mut each = [SettingSlopes::default(); MOST_SETTINGS];
            let times = likelihood.times(noise, part);
            let (all, count) = likelihood.with_settings(noise, part, &laws[first..], |settings| {
                let each = &mut each[..settings.len()];
                (noise.noise.hidden(settings).integrate(each), settings.len())
            });
            let all = all.times(times);
            value += all.value;
            add_noise_slopes(all, ParameterKind::SigmaWet, slopes);
            for (place, of) in each[..count].iter().enumerate() {
                add(first + place, *of, times);
            }
        }
        value
    }
}

impl Likelihood {
    /// How often a part counts.
    fn times(&self, noise: &RowNoise, part: Part) -> f64 {
        match part {
            Part::Rebound(_) => 1.0,
            Part::Logged(_) => -1.0,
            Part::Stuck(node) => self.stuck.count[node],
            Part::Shared(place) => noise.own.shared[place].sign,
        }
    }

    /// Gives the settings of a part, which have these laws, to a function.
    fn with_settings<T>(
        &self,
        noise: &RowNoise,
        part: Part,
        laws: &[(usize, FilmLaw)],
        of: impl FnOnce(&[SettingRuns]) -> T,
    ) -> T {
        let one = |nodes: &Nodes, node: usize, seen: Seen, errors: &[Errors]| -> (Impact, MeasuredRun) {
            let errors = errors[node];
            (nodes.impact(node), MeasuredRun { seen, errors })
        };
        let own = noise.own;
        let (impact, run) = match part {
            Part::Rebound(node) => {
                let seen = Seen::Rebound(self.rebounds.restitution[node]);
                one(&self.rebounds, node, seen, &own.rebounds)
            }
            Part::Logged(node) => one(&self.rebounds, node, Seen::On(Side::Above, self.limit), &own.rebounds),
            Part::Stuck(node) => one(&self.stuck, node, Seen::On(Side::Below, self.limit), &own.stuck),
            Part::Shared(place) => {
                let balances = laws.iter().map(|(_, film)| &film.balance);
                return own.shared[place].with_settings(balances, of);
            }
        };
        of(&[SettingRuns {
            balance: &laws[0].1.balance,
            impact,
            runs: &[run],
        }])
    }
}
