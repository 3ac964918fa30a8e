//! Builds the likelihood of every run from the columns of a scene's runs, one node a run.

use std::collections::HashMap;

use super::dry_sums::DryRuns;
use super::errors::{Errors, RunErrors};
use super::nodes::{DryRow, Nodes, WetBlock};
use super::prepared::Likelihood;
use super::run_law::{ByRow, WetRow};
use super::trend::middle_film_ratio;
use crate::model::parameters::offset_slot;
use crate::physics::Form;
use crate::runs::{Conditions, DryGroup, Runs, Series};
use crate::scene::{self, NoiseOn, Scene, Sticking};

/// The runs and all that is read with them.
struct RunData<'r> {
    scene: &'r Scene,
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
            film_ratios: vec![],
            ln_films: vec![],
            rebounds: Nodes::default(),
            stuck: Nodes::default(),
            own: None,
            wet_rebounds: 0.0,
            leftover: 0.0,
            dry: dry_runs(scene, runs),
        };
        let student = scene.model.likelihood == scene::LikelihoodFamily::Student;
        let both = scene.model.noise == NoiseOn::Both;
        let errors = RunErrors::of(runs);
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
                repeats: vec![],
                dry_repeats: vec![],
            });
        }
        let mut index = BlockIndex::default();
        let middle = middle_film_ratio(runs);
        let table = RunData {
            scene,
            runs,
            errors,
            conditions: Conditions::new(scene, runs, form),
        };
        for (place, series) in runs.series.iter().enumerate() {
            let offset = scene.model.series_offsets.then(|| offset_slot(runs, place));
            likelihood.add(&table, series, offset, &mut index);
        }
        likelihood.add_repeats(errors, &index.rows);
        let ratios = likelihood.film_ratios.iter();
        likelihood.ln_films = ratios.map(|ratio| (ratio / middle).ln()).collect();
        likelihood.wet_rebounds = likelihood.rebounds.len() as f64;
        likelihood
    }

    /// Adds the runs of a series, a block for each film ratio the runs themselves have; `offset` is the place of its own in a
    /// full vector.
    fn add(&mut self, table: &RunData, series: &Series, offset: Option<usize>, index: &mut BlockIndex) {
        /// film ratios differ beyond the rounding of a quotient
        const ROUNDING: f64 = 1e-14;
        let (runs, conditions) = (table.runs, &table.conditions);
        let film_ratio = |run: &usize| runs.impacts.film_ratio[*run];
        let sorted = |range: std::ops::Range<usize>| {
            let mut order: Vec<usize> = range.collect();
            // stable: runs of one film keep their order
            order.sort_by(|a, b| film_ratio(a).total_cmp(&film_ratio(b)));
            order
        };
        let (rebounds, stuck) = (sorted(series.rebounds.clone()), sorted(series.stuck.clone()));
        let (mut next, mut next_stuck) = (0, 0);
        while next < rebounds.len() || next_stuck < stuck.len() {
            let candidates = [rebounds.get(next), stuck.get(next_stuck)];
            let ratio = candidates
                .into_iter()
                .flatten()
                .map(film_ratio)
                .fold(f64::INFINITY, f64::min);
            let film = *index.films.entry((ratio / ROUNDING).round() as i64).or_insert_with(|| {
                self.film_ratios.push(ratio);
                self.film_ratios.len() - 1
            });
            let (first, first_stuck) = (self.rebounds.len(), self.stuck.len());
            let errors = |run: usize| table.errors.map(|errors| errors.at(run, runs.impact_speed[run]));
            let block = self.blocks.len();
            let mut note = |run: usize, of: Option<Errors>, row: WetRow| {
                if of.is_some_and(|of| of.is_shared) {
                    index.rows.insert(run, RowOfBlock { block, row });
                }
            };
            while let Some(run) = rebounds.get(next).filter(|run| film_ratio(run) <= ratio) {
                self.rebounds.push(
                    conditions.wet(*run),
                    conditions.has_fixed(),
                    runs.restitution[*run],
                    1.0,
                );
                if let Some(own) = &mut self.own {
                    let errors = errors(*run);
                    note(*run, errors, WetRow::Rebound(own.rebounds.len()));
                    own.rebounds.extend(errors);
                }
                next += 1;
            }
            while let Some(run) = stuck.get(next_stuck).filter(|run| film_ratio(run) <= ratio) {
                let impact = conditions.wet(*run);
                let last = self.stuck.len().checked_sub(1).filter(|last| *last >= first_stuck);
                // repeats of one setting stick with one probability, which is dear where it is integrated
                let integrated = self.own.as_ref().is_some_and(|own| own.both) && table.errors.is_none();
                match last.filter(|last| integrated && self.stuck.impact(*last) == impact) {
                    Some(last) => self.stuck.count[last] += 1.0,
                    None => self.stuck.push(impact, conditions.has_fixed(), 0.0, 1.0),
                }
                if let Some(own) = &mut self.own {
                    let errors = errors(*run);
                    note(*run, errors, WetRow::Stuck(own.stuck.len()));
                    own.stuck.extend(errors);
                }
                next_stuck += 1;
            }
            self.blocks.push(WetBlock {
                sphere: series.sphere,
                density_ratio: series.density_ratio(table.scene),
                offset,
                film,
                rebounds: first..self.rebounds.len(),
                stuck: first_stuck..self.stuck.len(),
            });
            if ratio.is_infinite() {
                // a film ratio that is no number cannot be compared; the reader lets none through
                break;
            }
        }
    }
}

impl Likelihood {
    /// Notes which rows have one true speed; `rows` are the wet ones among them, by run.
    fn add_repeats(&mut self, errors: Option<&RunErrors>, rows: &HashMap<usize, RowOfBlock>) {
        let (Some(own), Some(errors)) = (&mut self.own, errors) else {
            return;
        };
        own.repeats = vec![vec![]; self.blocks.len()];
        for group in errors.shared_speeds() {
            // repeats are runs of one setting, and so of one block
            match rows.get(&group[0]) {
                Some(first) => {
                    let repeats = group.iter().filter_map(|run| Some(rows.get(run)?.row));
                    own.repeats[first.block].push(repeats.collect());
                }
                // dry runs come first, in the order of their rows
                None => own.dry_repeats.push(group.clone()),
            }
        }
    }
}

/// What was found of runs while blocks are made.
#[derive(Default)]
struct BlockIndex {
    /// the place of each film ratio, by its multiple of a rounding
    films: HashMap<i64, usize>,
    /// wet runs that share their true speed
    rows: HashMap<usize, RowOfBlock>,
}

/// Where a run is.
struct RowOfBlock {
    block: usize,
    row: WetRow,
}

fn dry_runs(scene: &Scene, runs: &Runs) -> Vec<DryRuns> {
    let mut dry = vec![DryRuns::default(); runs.spheres.len()];
    for (sphere, sums) in dry.iter_mut().enumerate() {
        let groups = || runs.dry.iter().filter(|group| group.sphere == sphere);
        let rebounds = || {
            let ranges = groups().map(|group| group.rebounds.clone());
            ranges
                .flatten()
                .map(|run| (runs.impacts.speed_root[run], 1.0 - runs.restitution[run]))
        };
        let (mut count, mut cross) = (0.0, 0.0);
        for (p, y) in rebounds() {
            count += 1.0;
            sums.weight += p * p;
            cross += p * y;
        }
        sums.rebounds = count;
        if count > 0.0 {
            sums.slope = cross / sums.weight;
            // about the fit, where nothing cancels
            for (p, y) in rebounds() {
                let left = y - sums.slope * p;
                sums.leftover += left * left;
                let square = p * p;
                for (sum, term) in sums.bent.iter_mut().zip([square * p, square * square, square * left]) {
                    *sum += term;
                }
            }
        }
        if scene.model.sticking == Sticking::Truncated {
            sums.logged = rebounds().map(|(p, _)| p).collect();
        }
        let stuck = groups().flat_map(|group| group.stuck.clone());
        sums.stuck = stuck.map(|run| runs.impacts.speed_root[run]).collect();
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
