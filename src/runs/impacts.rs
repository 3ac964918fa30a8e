//! Computes once, of every run, what the laws and the energy balance read of it.

use std::ops::Range;

use rayon::prelude::*;

use super::series::{Impacts, Runs, Series};
use crate::physics::balance::Impact;
use crate::physics::dry::speed_root;
use crate::physics::numbers::same_diameter;
use crate::physics::viscous::slope_lubrication_log;
use crate::physics::{DrySpeed, Form, Setting};
use crate::scene::Scene;

impl Runs {
    /// Computes the columns of [`Impacts`](super::Impacts): once where runs are arranged, and again where constants of the scene or films
    /// were changed.
    pub fn compute_impacts(&mut self, scene: &Scene) {
        // where all speeds are scaled, k v^(1/5) stays what the dry runs tell: roots that are known stay
        let known = std::mem::take(&mut self.impacts.speed_root);
        let speed_root = match known.len() == self.len() {
            true => known,
            false => self.impact_speed.par_iter().map(|speed| speed_root(*speed)).collect(),
        };
        let mut over_stokes = vec![0.0; self.len()];
        for series in &self.series {
            for run in series.runs() {
                let stokes = self.setting(scene, series, run).stokes(self.impact_speed[run]);
                over_stokes[run] = slope_lubrication_log(stokes);
            }
        }
        let ratio = |(film, diameter): (&f64, &f64)| film / diameter;
        self.impacts = Impacts {
            speed_root,
            over_stokes,
            film_ratio: self.film.iter().zip(&self.diameter).map(ratio).collect(),
        };
    }

    /// 1/St of a wet run.
    pub fn inverse_stokes(&self, run: usize) -> f64 {
        // a power of two: no digit is lost
        0.25 * self.impacts.over_stokes[run]
    }

    /// Sphere, liquid and film of a run of a series.
    pub fn setting(&self, scene: &Scene, series: &Series, run: usize) -> Setting {
        scene.setting(series.particle, series.liquid, self.diameter[run], self.film[run])
    }
}

impl Series {
    /// ρ̃ = ρl/ρp.
    pub fn density_ratio(&self, scene: &Scene) -> f64 {
        scene.liquids[self.liquid].density / scene.particles[self.particle].density
    }

    /// Sphere, liquid and film of the series: its mean diameter in a film of its group's film ratio.
    pub fn setting(&self, scene: &Scene) -> Setting {
        scene.setting(
            self.particle,
            self.liquid,
            self.diameter,
            self.film_ratio * self.diameter,
        )
    }

    /// Whether two series are of one diameter.
    pub fn is_as_large_as(&self, other: &Series) -> bool {
        same_diameter(self.diameter, other.diameter)
    }
}

/// The impacts of a table as an energy balance of one form reads them.
#[derive(Debug, Clone)]
pub struct Conditions<'r> {
    runs: &'r Runs,
    /// v^(1/5) of the dry speed, where one is used for all
    reference_root: Option<f64>,
    /// shares that no parameter moves, with v times their slopes in v; empty where the form has none
    fixed: Vec<[f64; 2]>,
}

impl<'r> Conditions<'r> {
    /// Those of a form.
    pub fn new(scene: &Scene, runs: &'r Runs, form: Form) -> Conditions<'r> {
        let mut fixed = vec![];
        for series in &runs.series {
            for run in series.runs() {
                let Some(of_run) = form.fixed(&runs.setting(scene, series, run)) else {
                    break;
                };
                fixed.resize(runs.len(), [0.0; 2]);
                fixed[run] = of_run.at(runs.impact_speed[run]);
            }
        }
        Conditions {
            runs,
            reference_root: match form.dry_speed {
                DrySpeed::Reference(speed) => Some(speed_root(speed)),
                DrySpeed::Impact => None,
            },
            fixed,
        }
    }

    /// A wet run.
    pub fn wet(&self, run: usize) -> Impact {
        Impact {
            dry_root: self.reference_root.unwrap_or(self.runs.impacts.speed_root[run]),
            over_stokes: self.runs.impacts.over_stokes[run],
            fixed: self.fixed.get(run).copied().unwrap_or_default(),
        }
    }

    /// A dry run.
    pub fn dry(&self, run: usize) -> Impact {
        Impact {
            dry_root: self.runs.impacts.speed_root[run],
            over_stokes: 0.0,
            fixed: [0.0; 2],
        }
    }
}

/// The runs of a range, one after the other, with what changes from film to film computed once for each.
///
/// Neighbours mostly share a film ratio, and an exponential costs more than all the rest.
pub fn by_film<T>(
    runs: &Runs,
    range: Range<usize>,
    mut of_film: impl FnMut(usize) -> T,
    mut each: impl FnMut(usize, &T),
) {
    let mut last: Option<(f64, T)> = None;
    for run in range {
        let ratio = runs.impacts.film_ratio[run];
        if last.as_ref().is_none_or(|(same, _)| *same != ratio) {
            last = Some((ratio, of_film(run)));
        }
        if let Some((_, of_film)) = &last {
            each(run, of_film);
        }
    }
}
