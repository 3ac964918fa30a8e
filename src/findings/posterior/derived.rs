//! Computes what follows from the parameters, draw by draw.

use rayon::prelude::*;

use crate::findings::places::EstimatePlace;
use crate::inference::sampling::Sampled;
use crate::model::parameters::{physical, ParameterKind};
use crate::physics::balance::Balance;
use crate::physics::form::Term;
use crate::physics::loss::Film;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{Coefficient, Form};
use crate::runs::{rounded_film_ratio, Runs};
use crate::scene::Scene;

/// A quantity with its draws, chain by chain; NaN where a draw leaves none.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedDraws {
    /// its name in files, with the label in brackets where it has one
    pub name: String,
    /// what it is
    pub quantity: Quantity,
    /// the particle or the setting it holds for: `PTFE,AK10,0.06`
    pub label: Option<String>,
    /// the same as an estimate has it
    pub of: EstimatePlace,
    /// index into [`Runs::spheres`]: the k of the setting
    pub sphere: Option<usize>,
    /// `values[chain][draw]`
    pub values: Vec<Vec<f64>>,
}

/// A particle in a liquid at a film ratio.
#[derive(Debug, Clone, PartialEq)]
struct WetSetting {
    /// index into the scene's particles
    particle: usize,
    /// index into [`Runs::spheres`]: its k
    sphere: usize,
    /// index into the scene's liquids
    liquid: usize,
    /// δ/D
    film_ratio: f64,
    /// D, m, where k or St_c depends on it
    diameter: Option<f64>,
}

impl WetSetting {
    /// The part of L there that no parameter of a form moves.
    fn fixed_over_stokes(&self, scene: &Scene, form: Form) -> f64 {
        let of = |diameter: f64| {
            let setting = scene.setting(self.particle, self.liquid, diameter, self.film_ratio * diameter);
            form.fixed_over_stokes(&setting)
        };
        self.diameter.map_or(0.0, of)
    }

    fn of(&self, scene: &Scene) -> EstimatePlace {
        EstimatePlace {
            particle: Some(scene.particles[self.particle].name.clone()),
            liquid: Some(scene.liquids[self.liquid].name.clone()),
            diameter_m: self.diameter,
            film_ratio: Some(self.film_ratio),
        }
    }

    /// Its words in the names of draws.
    fn label(&self, scene: &Scene) -> String {
        let (particle, liquid) = (&scene.particles[self.particle].name, &scene.liquids[self.liquid].name);
        let at = format!("{particle},{liquid},{}", rounded_film_ratio(self.film_ratio));
        match self.diameter {
            Some(diameter) => format!("{at},{} mm", rounded_film_ratio(1e3 * diameter)),
            None => at,
        }
    }
}

/// δc/ε, δc of each particle whose roughness is given, then e_inf, St_c and the Stokes number of no rebound at each setting
/// of the runs; without a viscous loss e_inf alone.
pub fn derived_draws(scene: &Scene, runs: &Runs, form: Form, sampled: &Sampled) -> Vec<DerivedDraws> {
    let full = sampled.full_draws();
    let per_chain = full.len() / sampled.chains.len().max(1);
    derived_at(scene, runs, form, &full, per_chain.max(1))
}

/// How many quantities [`derived_draws`] gives.
pub fn count_derived(scene: &Scene, runs: &Runs, form: Form) -> usize {
    derived_at(scene, runs, form, &[], 1).len()
}

/// The quantities at draws of every parameter, so many of each chain.
fn derived_at(scene: &Scene, runs: &Runs, form: Form, full: &[Vec<f64>], per_chain: usize) -> Vec<DerivedDraws> {
    if runs.series.is_empty() {
        return vec![];
    }
    let chains = |values: Vec<f64>| values.chunks(per_chain).map(<[f64]>::to_vec).collect();
    let has_viscous = Term::Viscous.is_held(form);
    let mut all = vec![];
    if form.has(Coefficient::LubricationLog) {
        let of_l = |quantity: Quantity, roughness: Option<f64>| {
            let at = Place {
                roughness,
                ..Place::NONE
            };
            let value = |full: &Vec<f64>| {
                let l = full[ParameterKind::LUBRICATION_LOG.slot()];
                quantity.value(&at, &Wetted::of_balance(f64::NAN, l))
            };
            full.iter().map(value).collect::<Vec<f64>>()
        };
        let ratio = Quantity::DeltaCOverRoughness;
        all.push(derived(ratio, None, chains(of_l(ratio, None))));
        let particles = runs.wet_particles().map(|index| &scene.particles[index]);
        for particle in particles.filter(|own| own.roughness.is_some()) {
            let values = chains(of_l(Quantity::DeltaC, particle.roughness));
            all.push(DerivedDraws {
                of: EstimatePlace::of_particle(&particle.name, None),
                ..derived(Quantity::DeltaC, Some(particle.name.clone()), values)
            });
        }
    }
    let settings = settings(runs, form);
    // what each setting's quantities follow from, draw by draw
    let reference = scene.model.dry_speed.reference();
    let of_draws = |setting: &WetSetting| -> Vec<Wetted<f64>> {
        let density_ratio = scene.liquids[setting.liquid].density / scene.particles[setting.particle].density;
        let film = Film {
            film_ratio: setting.film_ratio,
            density_ratio,
        };
        let fixed = setting.fixed_over_stokes(scene, form);
        let of_draw = |full: &Vec<f64>| {
            let balance = Balance::new(form, film, &physical(full, setting.sphere));
            Wetted::of_balance(balance.e_inf(reference), balance.lost.over_stokes + fixed)
        };
        full.iter().map(of_draw).collect()
    };
    let wetted: Vec<Vec<Wetted<f64>>> = settings.par_iter().map(of_draws).collect();
    let of_setting = [Quantity::EInf, Quantity::StC, Quantity::StNoRebound];
    // without a viscous loss there is no St_c
    for quantity in of_setting.into_iter().take(if has_viscous { 3 } else { 1 }) {
        let one = |(setting, wetted): (&WetSetting, &Vec<Wetted<f64>>)| {
            let label = setting.label(scene);
            let values = wetted.iter().map(|wetted| quantity.value(&Place::NONE, wetted));
            DerivedDraws {
                of: setting.of(scene),
                sphere: Some(setting.sphere),
                ..derived(quantity, Some(label), chains(values.collect()))
            }
        };
        all.par_extend(settings.par_iter().zip(&wetted).map(one));
    }
    all
}

/// The draws of the physical parameters, and of e_inf and St_c at each setting, with their names.
pub(in crate::findings) fn main_draws<'d>(
    sampled: &'d Sampled,
    derived: &'d [DerivedDraws],
) -> impl Iterator<Item = (&'d String, &'d Vec<Vec<f64>>)> {
    let parameters = sampled.parameters.sampled.iter().zip(&sampled.values);
    let parameters = parameters.filter(|(own, _)| own.kind.quantity().is_some());
    let quoted = |own: &&DerivedDraws| matches!(own.quantity, Quantity::EInf | Quantity::StC);
    let derived = derived.iter().filter(quoted).map(|own| (&own.name, &own.values));
    parameters.map(|(own, values)| (&own.name, values)).chain(derived)
}

fn derived(quantity: Quantity, label: Option<String>, values: Vec<Vec<f64>>) -> DerivedDraws {
    let name = quantity.describe().name;
    DerivedDraws {
        name: label
            .as_ref()
            .map_or(name.to_owned(), |label| format!("{name}[{label}]")),
        quantity,
        label,
        of: EstimatePlace::default(),
        sphere: None,
        values,
    }
}

/// The different particles, liquids and film ratios of the runs, in their order; and diameters where the form or k
/// tells these apart.
fn settings(runs: &Runs, form: Form) -> Vec<WetSetting> {
    let by_form = form.viscous.tells_diameters_apart();
    let mut settings: Vec<WetSetting> = vec![];
    for series in &runs.series {
        let setting = WetSetting {
            particle: series.particle,
            sphere: series.sphere,
            liquid: series.liquid,
            film_ratio: series.film_ratio,
            diameter: runs.spheres[series.sphere]
                .diameter
                .or(by_form.then_some(series.diameter)),
        };
        // diameters of one setting come one after the other
        if settings.last() != Some(&setting) {
            settings.push(setting);
        }
    }
    settings
}
