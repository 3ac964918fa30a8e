//! Computes what follows from the parameters, draw by draw.

use crate::findings::own_dry_speed::reference_dry_speed;
use crate::inference::sampling::Sampled;
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::inertia::Inertia;
use crate::physics::{dry, viscous};
use crate::runs::Runs;
use crate::scene::Scene;

/// A quantity with its draws, chain by chain; NaN where a draw leaves none.
#[derive(Debug, Clone, PartialEq)]
pub struct Derived {
    /// its name in files
    pub name: String,
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

/// δc/ε, δc of each particle, then e_inf, St_c and the Stokes number of no rebound at each setting of the runs.
pub fn find(scene: &Scene, runs: &Runs, inertia: Inertia, sampled: &Sampled) -> Vec<Derived> {
    if runs.series.is_empty() {
        return vec![];
    }
    let full = sampled.full_draws();
    let per_chain = full.len() / sampled.chains.len().max(1);
    let chains = |of: &dyn Fn(&[f64]) -> f64| -> Vec<Vec<f64>> {
        full.chunks(per_chain.max(1))
            .map(|chain| chain.iter().map(|full| of(full)).collect())
            .collect()
    };
    let l = Kind::LubricationLog.slot();
    let mut all = vec![Derived {
        name: "delta_c_over_roughness".to_owned(),
        setting: None,
        values: chains(&|full| full[l].exp()),
    }];
    let wet = |particle: usize| runs.series.iter().any(|series| series.particle == particle);
    for (_, particle) in scene.particles.iter().enumerate().filter(|(index, _)| wet(*index)) {
        all.push(Derived {
            name: format!("delta_c_m[{}]", particle.name),
            setting: None,
            values: chains(&|full| viscous::critical_separation(particle.roughness, full[l])),
        });
    }
    let v = reference_dry_speed(scene);
    let settings = settings(runs);
    let e_inf2 = |setting: &Setting, full: &[f64]| {
        let e_dry = dry::restitution(full[COMMON_SLOTS + setting.particle], v);
        let density_ratio = scene.liquids[setting.liquid].density / scene.particles[setting.particle].density;
        let shape = inertia.shape(setting.film_ratio, full[Kind::FilmScale.slot()]);
        let kept = e_dry * e_dry - full[Kind::InertialPrefactor.slot()] * density_ratio * shape;
        if kept > 0.0 {
            kept
        } else {
            f64::NAN
        }
    };
    type Formula<'f> = &'f dyn Fn(f64, f64) -> f64;
    let formulas: [(&str, Formula); 3] = [
        ("e_inf", &|e_inf2, _| e_inf2.sqrt()),
        ("st_c", &|e_inf2, l| viscous::st_c(l, e_inf2.sqrt())),
        ("st_no_rebound", &|e_inf2, l| viscous::st_no_rebound(l, e_inf2.sqrt())),
    ];
    for (quantity, formula) in formulas {
        for setting in &settings {
            let (particle, liquid) = (&scene.particles[setting.particle], &scene.liquids[setting.liquid]);
            let ratio = four_decimals(setting.film_ratio);
            all.push(Derived {
                name: format!("{quantity}[{},{},{ratio}]", particle.name, liquid.name),
                setting: Some(setting.clone()),
                values: chains(&|full| formula(e_inf2(setting, full), full[l])),
            });
        }
    }
    all
}

/// A film ratio as names have it: nominal ones as they are, measured means to four decimals.
pub fn four_decimals(film_ratio: f64) -> f64 {
    (film_ratio * 1e4).round() / 1e4
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
        if !settings.contains(&setting) {
            settings.push(setting);
        }
    }
    settings
}
