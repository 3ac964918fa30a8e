//! Sums the log densities of wet runs whose impact speeds err, over their true speeds.

use std::collections::HashMap;

use super::block_sums::BlockSums;
use super::errors::Errors;
use super::hidden_speed::{ManySpeeds, MeasuredRun, SettingRuns, SettingSlopes, SpeedRuns, Together};
use super::nodes::Nodes;
use super::own_rows::{ByRow, Part, SpeedParts, WetPlace};
use super::prepared::Likelihood;
use super::row_noise::{add_noise_slopes, RowNoise};
use super::run_density::{Seen, Side};
use super::sums::NodeRange;
use super::trend::FilmLaw;
use crate::model::parameters::ParameterKind;
use crate::physics::balance::{Balance, Impact};
use crate::physics::loss::Share;
use crate::runs::MOST_SETTINGS;

/// One of the parts.
#[derive(Clone, Copy)]
struct PartOf<'p> {
    part: Part,
    number: usize,
    /// where the films of its settings are, and of those after it
    films: &'p [usize],
}

impl SpeedParts {
    fn part(&self, number: usize) -> PartOf<'_> {
        let (part, first) = self.parts[number];
        PartOf {
            part,
            number,
            films: &self.settings[first..],
        }
    }
}

impl Likelihood {
    /// The wet runs whose impact speeds err, in parts of one true speed each.
    pub(super) fn speed_parts(&self, own: &ByRow) -> SpeedParts {
        let (mut parts, mut settings, mut films) = (vec![], vec![], vec![]);
        let mut known = HashMap::new();
        let mut add = |part: Part, of: &mut dyn Iterator<Item = WetPlace>| {
            parts.push((part, settings.len()));
            settings.extend(of.map(|place| {
                let film = (place.block, place.film.ratio.to_bits());
                *known.entry(film).or_insert_with(|| {
                    films.push(place);
                    films.len() - 1
                })
            }));
        };
        let errs_alone = |errors: &[Errors], node: usize| {
            let errors = errors.get(node);
            errors.is_some_and(|errors| errors.speed > 0.0 && !errors.is_shared)
        };
        for (block, of) in self.blocks.iter().enumerate() {
            let at = |nodes: &Nodes, node: usize| {
                let film = nodes.film(node);
                std::iter::once(WetPlace { block, film })
            };
            for node in of.rebounds.clone().filter(|node| errs_alone(&own.rebounds, *node)) {
                add(Part::Rebound(node), &mut at(&self.rebounds, node));
                if self.truncated {
                    add(Part::Logged(node), &mut at(&self.rebounds, node));
                }
            }
            for node in of.stuck.clone().filter(|node| errs_alone(&own.stuck, *node)) {
                add(Part::Stuck(node), &mut at(&self.stuck, node));
            }
        }
        for (place, shared) in own.shared.iter().enumerate() {
            add(Part::Shared(place), &mut shared.settings.iter().map(|of| of.place));
        }
        let mut found = SpeedParts {
            parts,
            settings,
            films,
            ..SpeedParts::default()
        };
        // what the losses take is not asked yet
        let balance = Balance::at(self.form, 0.0, Share::default(), 0.0);
        let mut together = Together::default();
        for number in 0..found.parts.len() {
            let goes_together = |runs: SpeedRuns| together.push(&runs);
            if !self.with_part(own, found.part(number), |_| &balance, goes_together) {
                found.apart.push(number);
            }
        }
        SpeedParts { together, ..found }
    }

    /// The log likelihood of the wet runs whose impact speeds err; adds its slopes in the spreads and in ν, and in r to the sums
    /// of each block.
    pub(super) fn over_true_speeds(
        &self,
        noise: &RowNoise,
        blocks: &[NodeRange],
        (slopes, sums): (&mut [f64], &mut [BlockSums]),
    ) -> f64 {
        let own = noise.own;
        let speeds = &own.speeds;
        let law = |place: &WetPlace| blocks[place.block].law.at(place.film);
        let laws: Vec<FilmLaw> = speeds.films.iter().map(law).collect();
        let balances: Vec<Balance> = laws.iter().map(|law| law.balance).collect();
        let mut many = ManySpeeds::new(&noise.noise, &balances);
        many.take(&speeds.together);
        for number in &speeds.apart {
            self.with_part(
                own,
                speeds.part(*number),
                |film| &balances[film],
                |runs| many.push(runs),
            );
        }
        let mut found = many.finish();
        let mut value = found.all.value;
        add_noise_slopes(found.all, ParameterKind::SigmaWet, slopes);
        for number in found.left {
            let of = |runs: SpeedRuns| {
                let mut each = [SettingSlopes::default(); MOST_SETTINGS];
                let each = &mut each[..runs.settings.len()];
                let all = noise.noise.hidden(runs.settings).integrate(each).times(runs.times);
                for (film, of) in runs.balances.iter().zip(each) {
                    let sum = &mut found.slopes[*film];
                    sum.kept += runs.times * of.kept;
                    sum.viscous += runs.times * of.viscous;
                    sum.dry_k += runs.times * of.dry_k;
                }
                all
            };
            let all = self.with_part(own, speeds.part(number), |film| &balances[film], of);
            value += all.value;
            add_noise_slopes(all, ParameterKind::SigmaWet, slopes);
        }
        for ((place, law), of) in speeds.films.iter().zip(&laws).zip(found.slopes) {
            law.add(&mut sums[place.block], of.kept, of.viscous, -0.5 * of.dry_k);
        }
        value
    }

    /// Gives a part, with the balance at each film, to a function.
    fn with_part<'b, T>(
        &self,
        own: &ByRow,
        PartOf { part, number, films }: PartOf,
        balance: impl Fn(usize) -> &'b Balance,
        of: impl FnOnce(SpeedRuns) -> T,
    ) -> T {
        let (times, (impact, run)) = match part {
            Part::Rebound(node) => {
                let seen = Seen::Rebound(self.rebounds.restitution[node]);
                (1.0, measured(&self.rebounds, node, seen, &own.rebounds))
            }
            Part::Logged(node) => {
                let seen = Seen::On(Side::Above, self.limit);
                (-1.0, measured(&self.rebounds, node, seen, &own.rebounds))
            }
            Part::Stuck(node) => {
                let seen = Seen::On(Side::Below, self.limit);
                (self.stuck.count[node], measured(&self.stuck, node, seen, &own.stuck))
            }
            Part::Shared(place) => {
                let shared = &own.shared[place];
                let balances = films.iter().map(|film| balance(*film));
                return shared.with_settings(balances, |settings| {
                    of(SpeedRuns {
                        settings,
                        balances: &films[..settings.len()],
                        number,
                        times: shared.sign,
                    })
                });
            }
        };
        of(SpeedRuns {
            settings: &[SettingRuns {
                balance: balance(films[0]),
                impact,
                runs: &[run],
            }],
            balances: &films[..1],
            number,
            times,
        })
    }
}

/// A node with what is known of it.
fn measured(nodes: &Nodes, node: usize, seen: Seen, errors: &[Errors]) -> (Impact, MeasuredRun) {
    let errors = errors[node];
    (nodes.impact(node), MeasuredRun { seen, errors })
}
