//! Builds the likelihood of every run from the columns of a scene's runs, one node a run.

use std::collections::HashMap;
use std::ops::Range;

use super::dry_sums::DryRuns;
use super::errors::{Errors, RunErrors};
use super::nodes::{DryRow, NodeFilm, Nodes, WetBlock};
use super::own_rows::{ByRow, WetPlace};
use super::prepared::Likelihood;
use super::trend::middle_film_ratio;
use crate::model::parameters::offset_slot;
use crate::physics::balance::Impact;
use crate::physics::{Form, Inertia};
use crate::runs::{Conditions, DryGroup, Runs, Series};
use crate::scene::{Scene, Sticking};

/// The runs and all that is read with them.
struct RunData<'r> {
    runs: &'r Runs,
    errors: Option<&'r RunErrors>,
    conditions: Conditions<'r>,
}

impl Likelihood {
    /// The likelihood with one node for each wet run. Dry runs need no more than their sums.
    pub fn of_rows(scene: &Scene, runs: &Runs, form: Form) -> Likelihood {
        let mut likelihood = Likelihood {
            form,
            limit: scene.data.smallest_restitution,
            truncated: scene.model.sticking == Sticking::Truncated,
            blocks: vec![],
            rebounds: Nodes::default(),
            stuck: Nodes::default(),
            own: None,
            wet_rebounds: 0.0,
            leftover: 0.0,
            dry: dry_runs(scene, runs),
        };
        let (student, both) = scene.model.has_own_noise();
        let errors = RunErrors::of(scene, runs);
        let errors = errors.as_ref();
        if student || both || errors.is_some() {
            likelihood.own = Some(ByRow {
                student,
                both,
                rebounds: vec![],
                stuck: vec![],
                dry: if student || errors.is_some() {
                    dry_rows(runs, errors)
                } else {
                    vec![]
                },
                shared: vec![],
                dry_shared: vec![],
            });
        }
        let mut index = BlockIndex {
            middle: middle_film_ratio(runs),
            films: HashMap::new(),
            shared: HashMap::new(),
        };
        let table = RunData {
            runs,
            errors,
            conditions: Conditions::new(scene, runs, form),
        };
        let mut blocks: Vec<(BlockKey, Vec<&Series>)> = vec![];
        let mut places = HashMap::new();
        for (place, series) in runs.series.iter().enumerate() {
            let key = BlockKey {
                sphere: series.sphere,
                density_ratio: series.density_ratio(scene),
                offset: scene.model.series_offsets.then(|| offset_slot(runs, place)),
            };
            let place = *places
                .entry((key.sphere, key.density_ratio.to_bits(), key.offset))
                .or_insert(blocks.len());
            if place == blocks.len() {
                blocks.push((key, vec![]));
            }
            blocks[place].1.push(series);
        }
        for (key, series) in blocks {
            likelihood.add(&table, key, &series, &mut index);
        }
        likelihood.add_true_speeds(scene, &table, &index.shared);
        likelihood.wet_rebounds = likelihood.rebounds.count.iter().sum();
        likelihood
    }

    /// Whether the likelihood of a scene's runs is one of rows, because they have spreads or tails of their own.
    pub fn needs_every_row(scene: &Scene, runs: &Runs) -> bool {
        scene.model.has_own_noise() != (false, false) || RunErrors::of(scene, runs).is_some()
    }

    /// Adds the runs of some series as a block, sorted by film ratio.
    fn add(&mut self, table: &RunData, key: BlockKey, series: &[&Series], index: &mut BlockIndex) {
        let (runs, conditions) = (table.runs, &table.conditions);
        let sorted = |of: fn(&Series) -> &Range<usize>| {
            let mut order: Vec<usize> = series.iter().flat_map(|series| of(series).clone()).collect();
            // stable: runs of one film keep their order
            order.sort_by(|a, b| runs.impacts.film_ratio[*a].total_cmp(&runs.impacts.film_ratio[*b]));
            order
        };
        let (first, first_stuck) = (self.rebounds.len(), self.stuck.len());
        let errors = |run: usize| table.errors.map(|errors| errors.at(run, runs.impact_speed[run]));
        let block = self.blocks.len();
        let (has_fixed, inertia) = (conditions.has_fixed(), self.form.inertia);
        for run in sorted(|series| &series.rebounds) {
            let film = index.film(inertia, runs.impacts.film_ratio[run]);
            let impact = conditions.wet(run);
            self.rebounds
                .push(impact, film, has_fixed, runs.restitution[run], runs.count(run));
            if let Some(own) = &mut self.own {
                let errors = errors(run);
                index.note(run, errors, WetPlace { block, film }, impact);
                own.rebounds.extend(errors);
            }
        }
        for run in sorted(|series| &series.stuck) {
            let film = index.film(inertia, runs.impacts.film_ratio[run]);
            let impact = conditions.wet(run);
            let last = self.stuck.len().checked_sub(1).filter(|last| *last >= first_stuck);
            // repeats of one setting stick with one probability, which is dear where it is integrated
            let integrated = self.own.as_ref().is_some_and(|own| own.both) && table.errors.is_none();
            let repeats =
                |last: &usize| integrated && self.stuck.impact(*last) == impact && self.stuck.film(*last) == film;
            match last.filter(repeats) {
                Some(last) => self.stuck.count[last] += runs.count(run),
                None => self.stuck.push(impact, film, has_fixed, 0.0, runs.count(run)),
            }
            if let Some(own) = &mut self.own {
                let errors = errors(run);
                index.note(run, errors, WetPlace { block, film }, impact);
                own.stuck.extend(errors);
            }
        }
        self.blocks.push(WetBlock {
            sphere: key.sphere,
            density_ratio: key.density_ratio,
            offset: key.offset,
            rebounds: first..self.rebounds.len(),
            stuck: first_stuck..self.stuck.len(),
        });
    }
}

impl Likelihood {
    /// Adds the true speeds of runs whose measured ones err; `wet` are the wet runs among those that share one, by run.
    fn add_true_speeds(&mut self, scene: &Scene, table: &RunData, wet: &HashMap<usize, (WetPlace, Impact)>) {
        let Some(errors) = table.errors else {
            return;
        };
        if let Some(mut own) = self.own.take() {
            own.shared = errors.shared_runs(scene, table.runs, |run| wet.get(&run).copied());
            // dry runs come first, in the order of their rows
            let dry = |run: usize| own.dry.get(run).map(|row| (row.sphere, row.impact()));
            own.dry_shared = errors.shared_runs(scene, table.runs, dry);
            self.own = Some(own);
        }
    }
}

/// What the runs of a block have in common.
struct BlockKey {
    sphere: usize,
    density_ratio: f64,
    /// the place of the offset of a series in a full vector, where series have one
    offset: Option<usize>,
}

/// What was found of runs while blocks are made.
struct BlockIndex {
    /// the middle film ratio
    middle: f64,
    /// the film of each film ratio, by its multiple of a rounding
    films: HashMap<i64, NodeFilm>,
    /// where wet runs that share their true speed are
    shared: HashMap<usize, (WetPlace, Impact)>,
}

impl BlockIndex {
    /// The film of a film ratio.
    fn film(&mut self, inertia: Inertia, ratio: f64) -> NodeFilm {
        /// film ratios differ beyond the rounding of a quotient
        const ROUNDING: f64 = 1e-14;
        let middle = self.middle;
        let new = || NodeFilm {
            ratio,
            ln: (ratio / middle).ln(),
            shape: (!inertia.has_film_scale()).then(|| inertia.shape(ratio, 0.0)),
        };
        *self.films.entry((ratio / ROUNDING).round() as i64).or_insert_with(new)
    }

    fn note(&mut self, run: usize, errors: Option<Errors>, place: WetPlace, impact: Impact) {
        if errors.is_some_and(|errors| errors.is_shared) {
            self.shared.insert(run, (place, impact));
        }
    }
}

fn dry_runs(scene: &Scene, runs: &Runs) -> Vec<DryRuns> {
    let mut dry = vec![DryRuns::default(); runs.spheres.len()];
    for (sphere, sums) in dry.iter_mut().enumerate() {
        let groups = || runs.dry.iter().filter(|group| group.sphere == sphere);
        let numbers = |run: usize| {
            let (count, y) = (runs.count(run), 1.0 - runs.restitution[run]);
            (runs.impacts.speed_root[run], y, count)
        };
        let rebounds = || groups().flat_map(|group| group.rebounds.clone()).map(numbers);
        let (mut count, mut cross) = (0.0, 0.0);
        for (p, y, runs) in rebounds() {
            count += runs;
            sums.weight += runs * p * p;
            cross += runs * p * y;
        }
        sums.rebounds = count;
        if count > 0.0 {
            sums.slope = cross / sums.weight;
            // about the fit, where nothing cancels
            for (p, y, runs) in rebounds() {
                let left = y - sums.slope * p;
                sums.leftover += runs * left * left;
                let square = p * p;
                for (sum, term) in sums.bent.iter_mut().zip([square * p, square * square, square * left]) {
                    *sum += runs * term;
                }
            }
        }
        if scene.model.sticking == Sticking::Truncated {
            sums.logged = rebounds().map(|(p, _, runs)| [p, runs]).collect();
        }
        let stuck = groups().flat_map(|group| group.stuck.clone());
        sums.stuck = stuck
            .map(|run| [runs.impacts.speed_root[run], runs.count(run)])
            .collect();
    }
    dry
}

/// The dry runs one at a time.
fn dry_rows(runs: &Runs, errors: Option<&RunErrors>) -> Vec<DryRow> {
    let row = |sphere: usize, run: usize, rebounded: bool| DryRow {
        sphere,
        dry_root: runs.impacts.speed_root[run],
        restitution: rebounded.then(|| runs.restitution[run]),
        errors: errors.map_or(Errors::NONE, |errors| errors.at(run, runs.impact_speed[run])),
    };
    let of_group = |group: &DryGroup| {
        let sphere = group.sphere;
        let rebounds = group.rebounds.clone().map(move |run| row(sphere, run, true));
        rebounds.chain(group.stuck.clone().map(move |run| row(sphere, run, false)))
    };
    runs.dry.iter().flat_map(of_group).collect()
}
