//! Builds the likelihood of every run from the columns of a scene's runs, one node a run.

use std::collections::HashMap;

use super::dry_sums::DryRuns;
use super::errors::Errors;
use super::law::Abscissa;
use super::nodes::{Block, DryRow, Nodes};
use super::placed::{ByRow, Energies};
use super::prepared::Likelihood;
use super::trend::middle_film_ratio;
use crate::physics::impact::Form;
use crate::physics::{bridge, numbers};
use crate::runs::{DryGroup, MeasurementErrors, Runs, Series};
use crate::scene::{self, NoiseOn, Scene, Sticking};

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
        let student = scene.model.likelihood == scene::Likelihood::Student;
        let both = scene.model.noise == NoiseOn::Both;
        let errors = runs.errors_with_medians();
        let errors = errors.as_ref();
        if student || both || errors.is_some() {
            likelihood.own = Some(ByRow {
                student,
                energies: None,
                rebounds: vec![],
                stuck: vec![],
                dry: if student || errors.is_some() {
                    dry_rows(runs, errors)
                } else {
                    vec![]
                },
            });
        }
        let mut films = HashMap::new();
        let middle = middle_film_ratio(runs);
        for series in &runs.series {
            likelihood.add(scene, (runs, errors), series, &mut films);
        }
        let ratios = likelihood.film_ratios.iter();
        likelihood.ln_films = ratios.map(|ratio| (ratio / middle).ln()).collect();
        likelihood.wet_rebounds = likelihood.rebounds.len() as f64;
        if let Some(own) = likelihood.own.as_mut().filter(|_| both) {
            own.energies = Some(Energies::new(&likelihood.rebounds, likelihood.limit));
        }
        likelihood
    }

    /// Adds the runs of a series, a block for each film ratio the runs themselves have.
    fn add(
        &mut self,
        scene: &Scene,
        (runs, errors): (&Runs, Option<&MeasurementErrors>),
        series: &Series,
        films: &mut HashMap<i64, usize>,
    ) {
        /// film ratios are told apart beyond the rounding of a quotient
        const ROUNDING: f64 = 1e-14;
        let particle = &scene.particles[series.particle];
        let liquid = &scene.liquids[series.liquid];
        let film_ratio = |run: &usize| runs.film[*run] / runs.diameter[*run];
        let form = self.form;
        let node = |run: usize| {
            let (v, d) = (runs.impact_speed[run], runs.diameter[run]);
            let kappa = |gamma| bridge::kappa(gamma, particle.density, d, runs.film[run]);
            Abscissa {
                viscous: 4.0 / numbers::stokes(particle.density, d, v, liquid.viscosity),
                dry_power: form.dry_speed.of(v).powf(0.2),
                bridge: form.bridge.then(|| {
                    liquid
                        .surface_tension
                        .map_or(0.0, |gamma| bridge::loss(kappa(gamma), v))
                }),
            }
        };
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
            let film = *films.entry((ratio / ROUNDING).round() as i64).or_insert_with(|| {
                self.film_ratios.push(ratio);
                self.film_ratios.len() - 1
            });
            let (first, first_stuck) = (self.rebounds.len(), self.stuck.len());
            let errors = |run: usize| Errors::of(errors, run, runs.impact_speed[run]);
            while let Some(run) = rebounds.get(next).filter(|run| film_ratio(run) <= ratio) {
                self.rebounds.push(node(*run), runs.restitution[*run], 1.0);
                if let Some(own) = &mut self.own {
                    own.rebounds.extend(errors(*run));
                }
                next += 1;
            }
            while let Some(run) = stuck.get(next_stuck).filter(|run| film_ratio(run) <= ratio) {
                self.stuck.push(node(*run), 0.0, 1.0);
                if let Some(own) = &mut self.own {
                    own.stuck.extend(errors(*run));
                }
                next_stuck += 1;
            }
            self.blocks.push(Block {
                particle: series.particle,
                density_ratio: liquid.density / particle.density,
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

fn dry_runs(scene: &Scene, runs: &Runs) -> Vec<DryRuns> {
    let mut dry = vec![DryRuns::default(); scene.particles.len()];
    for (particle, sums) in dry.iter_mut().enumerate() {
        let groups = || runs.dry.iter().filter(|group| group.particle == particle);
        let rebounds = || {
            let ranges = groups().map(|group| group.rebounds.clone());
            ranges
                .flatten()
                .map(|run| (runs.impact_speed[run].powf(0.2), 1.0 - runs.restitution[run]))
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
        sums.stuck = stuck.map(|run| runs.impact_speed[run].powf(0.2)).collect();
    }
    dry
}

/// The dry runs one at a time.
fn dry_rows(runs: &Runs, errors: Option<&MeasurementErrors>) -> Vec<DryRow> {
    let row = |particle: usize, run: usize, rebounded: bool| DryRow {
        particle,
        dry_power: runs.impact_speed[run].powf(0.2),
        restitution: rebounded.then(|| runs.restitution[run]),
        errors: Errors::of(errors, run, runs.impact_speed[run]).unwrap_or_default(),
    };
    let of_group = |group: &DryGroup| {
        let particle = group.particle;
        let rebounds = group.rebounds.clone().map(move |run| row(particle, run, true));
        rebounds.chain(group.stuck.clone().map(move |run| row(particle, run, false)))
    };
    runs.dry.iter().flat_map(of_group).collect()
}
