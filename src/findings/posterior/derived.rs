//! Computes what follows from the parameters, draw by draw.

use rayon::prelude::*;

use crate::findings::shown::four_decimals;
use crate::inference::sampling::Sampled;
use crate::model::parameters::{physical, Kind};
use crate::physics::balance::Balance;
use crate::physics::form::Term;
use crate::physics::loss::Film;
use crate::physics::{viscous, Form};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// A quantity with its draws, chain by chain; NaN where a draw leaves none.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// its name in files, with the label in brackets where it has one
    pub name: String,
    /// what it is: `st_c`
    pub quantity: &'static str,
    /// the particle or the setting it holds for: `PTFE,AK10,0.06`
    pub label: Option<String>,
    /// the setting it holds for
    pub setting: Option<Setting>,
    /// `values[chain][draw]`
    pub values: Vec<Vec<f64>>,
}

/// A particle in a liquid at a film ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// index into the scene's particles
    pub particle: usize,
    /// index into the scene's liquids
    pub liquid: usize,
    /// δ/D
    pub film_ratio: f64,
}

/// δc/ε, δc of each particle, then e_inf, St_c and the Stokes number of no rebound at each setting of the runs; without a
/// viscous loss e_inf alone.
pub fn find(scene: &Scene, runs: &Runs, form: Form, sampled: &Sampled) -> Vec<Derived> {
    if runs.series.is_empty() {
        return vec![];
    }
    let full = sampled.full_draws();
    let per_chain = full.len() / sampled.chains.len().max(1);
    let chains = |values: &[f64]| values.chunks(per_chain.max(1)).map(<[f64]>::to_vec).collect();
    let of_draws = |of: &dyn Fn(&[f64]) -> f64| -> Vec<Vec<f64>> {
        chains(&full.iter().map(|full| of(full)).collect::<Vec<f64>>())
    };
    let l = Kind::LUBRICATION_LOG.slot();
    let mut all = vec![];
    if Term::Viscous.is_held(form) {
        all.push(Derived {
            name: "delta_c_over_roughness".to_owned(),
            quantity: "delta_c_over_roughness",
            label: None,
            setting: None,
            values: of_draws(&|full| full[l].exp()),
        });
        let wet = |particle: usize| !runs.series_of(particle).is_empty();
        for (_, particle) in scene.particles.iter().enumerate().filter(|(index, _)| wet(*index)) {
            all.push(Derived {
                name: format!("delta_c_m[{}]", particle.name),
                quantity: "delta_c_m",
                label: Some(particle.name.clone()),
                setting: None,
                values: of_draws(&|full| viscous::critical_separation(particle.roughness, full[l])),
            });
        }
    }
    let v = scene.model.dry_speed.reference();
    let settings = settings(runs);
    let e_inf = |setting: &Setting, full: &[f64]| {
        let film = Film {
            film_ratio: setting.film_ratio,
            density_ratio: scene.liquids[setting.liquid].density / scene.particles[setting.particle].density,
        };
        Balance::new(form, film, &physical(full, setting.particle)).e_inf(v)
    };
    let e_inf: Vec<Vec<f64>> = settings
        .par_iter()
        .map(|setting| full.iter().map(|full| e_inf(setting, full)).collect())
        .collect();
    type Formula = fn(f64, f64) -> f64;
    let formulas: [(&str, Formula); 3] = [
        ("e_inf", |_, e_inf| e_inf),
        ("st_c", viscous::st_c),
        ("st_no_rebound", viscous::st_no_rebound),
    ];
    // without a viscous loss there is no St_c
    for (quantity, formula) in formulas
        .into_iter()
        .take(if Term::Viscous.is_held(form) { 3 } else { 1 })
    {
        let of_setting = |(setting, e_inf): (&Setting, &Vec<f64>)| {
            let (particle, liquid) = (&scene.particles[setting.particle], &scene.liquids[setting.liquid]);
            let ratio = four_decimals(setting.film_ratio);
            let label = format!("{},{},{ratio}", particle.name, liquid.name);
            let values: Vec<f64> = full
                .iter()
                .zip(e_inf)
                .map(|(full, e_inf)| formula(full[l], *e_inf))
                .collect();
            Derived {
                name: format!("{quantity}[{label}]"),
                quantity,
                label: Some(label),
                setting: Some(setting.clone()),
                values: chains(&values),
            }
        };
        all.par_extend(settings.par_iter().zip(&e_inf).map(of_setting));
    }
    all
}

/// How many quantities [`find`] gives.
pub fn count(runs: &Runs, form: Form) -> usize {
    if runs.series.is_empty() {
        return 0;
    }
    let settings = settings(runs).len();
    if !Term::Viscous.is_held(form) {
        return settings;
    }
    let of = |series: &Series| series.particle;
    let particles = runs.series.chunk_by(|a, b| of(a) == of(b)).count();
    1 + particles + 3 * settings
}

/// The different particles, liquids and film ratios of the runs, in their order.
fn settings(runs: &Runs) -> Vec<Setting> {
    let mut settings: Vec<Setting> = vec![];
    for series in &runs.series {
        let setting = Setting {
            particle: series.particle,
            liquid: series.liquid,
            film_ratio: series.film_ratio,
        };
        // diameters of one setting come one after the other
        if settings.last() != Some(&setting) {
            settings.push(setting);
        }
    }
    settings
}
