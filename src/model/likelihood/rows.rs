//! Builds the likelihood from the columns of a scene's runs: a node for each setting, or for each run where these differ in
//! more than that.

use std::cmp::Ordering;
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
use crate::scene::{LikelihoodFamily, NoiseOn, Scene, Sticking};

/// The runs and all that is read with them.
struct RunData<'r> {
    runs: &'r Runs,
    errors: Option<&'r RunErrors>,
    conditions: Conditions<'r>,
}

impl Likelihood {
    /// The likelihood of the runs of a scene. Dry runs need no more than their sums.
    pub fn new(scene: &Scene, runs: &Runs, form: Form) -> Likelihood {
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
        let family = scene.model.likelihood;
        let errors = RunErrors::of(scene, runs);
        let errors = errors.as_ref();
        if scene.model.has_own_noise() || errors.is_some() {
            likelihood.own = Some(ByRow {
                family,
                both: scene.model.noise == NoiseOn::Both,
                rebounds: vec![],
                stuck: vec![],
                dry: if family != LikelihoodFamily::Normal || errors.is_some() {
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
        scene.model.has_own_noise() || RunErrors::of(scene, runs).is_some()
    }

    /// Adds the runs of some series as a block, sorted by film ratio.
    fn add(&mut self, table: &RunData, key: BlockKey, series: &[&Series], index: &mut BlockIndex) {
        let (runs, conditions) = (table.runs, &table.conditions);
        let (first, first_stuck) = (self.rebounds.len(), self.stuck.len());
        let (block, has_fixed, inertia) = (self.blocks.len(), conditions.has_fixed(), self.form.inertia);
        let mut sorted = |of: fn(&Series) -> &Range<usize>| {
            let mut setting = |run: usize| WetSetting {
                film: index.film(inertia, runs.impacts.film_ratio[run]),
                impact: conditions.wet(run),
            };
            let all = series.iter().flat_map(|series| of(series).clone());
            let mut all: Vec<(usize, WetSetting)> = all.map(|run| (run, setting(run))).collect();
            // stable: runs of one setting keep their order
            all.sort_by(|(_, a), (_, b)| a.order(b));
            all
        };
        let (rebounds, stuck) = (sorted(|series| &series.rebounds), sorted(|series| &series.stuck));
        let same = |(_, a): &(usize, WetSetting), (_, b): &(usize, WetSetting)| a == b;
        // noise of one spread is summed over runs of one setting
        let is_joined = self.own.is_none();
        for runs_of_one in rebounds.chunk_by(|a, b| is_joined && same(a, b)) {
            let WetSetting { film, impact } = runs_of_one[0].1;
            let each = || {
                runs_of_one
                    .iter()
                    .map(|(run, _)| (runs.count(*run), runs.restitution[*run]))
            };
            let count: f64 = each().map(|(count, _)| count).sum();
            let mean = each().map(|(count, e)| count * e).sum::<f64>() / count;
            self.leftover += each().map(|(count, e)| count * (e - mean).powi(2)).sum::<f64>();
            self.rebounds.push(impact, film, has_fixed, mean, count);
        }
        // of runs without errors of their own repeats stick with one probability
        for runs_of_one in stuck.chunk_by(|a, b| table.errors.is_none() && same(a, b)) {
            let WetSetting { film, impact } = runs_of_one[0].1;
            let count = runs_of_one.iter().map(|(run, _)| runs.count(*run)).sum();
            self.stuck.push(impact, film, has_fixed, 0.0, count);
        }
        if let (Some(own), Some(errors)) = (&mut self.own, table.errors) {
            for (each, to) in [(rebounds, &mut own.rebounds), (stuck, &mut own.stuck)] {
                for (run, WetSetting { film, impact }) in each {
                    let of_run = errors.at(run, runs.impact_speed[run]);
                    if of_run.is_shared {
                        index.shared.insert(run, (WetPlace { block, film }, impact));
                    }
                    to.push(of_run);
                }
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

/// The setting of a wet run in its block.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WetSetting {
    film: NodeFilm,
    impact: Impact,
}

impl WetSetting {
    /// By film, then by speed and diameter.
    fn order(&self, other: &WetSetting) -> Ordering {
        let key = |own: &WetSetting| {
            let at = own.impact;
            [own.film.ratio, at.over_stokes, at.dry_root, at.fixed[0]]
        };
        let mut orders = key(self).into_iter().zip(key(other)).map(|(a, b)| a.total_cmp(&b));
        orders.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
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
