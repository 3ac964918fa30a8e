//! Tests of the likelihood against the statement as it is written, a run at a time.

use std::path::Path;

mod by_row;

use rand::RngExt;

use self::by_row::by_run;
use super::normal::ln_normal_cdf;
use super::pointwise::{EvaluatedLaw, Pointwise};
use super::*;
use crate::model::parameters::{physical, COMMON_SLOTS};
use crate::physics::form::Term;
use crate::physics::{kept_energy, rebound, Coefficient, DrySpeed, Form, Inertia, Setting, Viscous};
use crate::runs::{self, NewRun, Runs};
use crate::scene::{self, NoiseOn, Scene, Sticking};

const SCENE: &str = r#"
title = "two particles, two liquids"
[data]
runs = "runs.csv"
smallest_restitution = 0.05
[particles.PTFE]
density_kg_m3 = 2150
roughness_um = 5
[particles.PE]
density_kg_m3 = 940
roughness_um = 5
[liquids.AK10]
density_kg_m3 = 930
viscosity_mPa_s = 9.3
surface_tension_mN_m = 20.1
[liquids.M50]
density_kg_m3 = 965
viscosity_mPa_s = 48.3
surface_tension_mN_m = 20.9
"#;

/// Places of a full vector of two particles.
const SLOTS: usize = COMMON_SLOTS + 2;

/// L, C, δ̃0, λ, σ_wet, σ_dry, σ_r, L′, C′, ν, the spread of series, k of PTFE and of PE
const FULL: [f64; SLOTS] = [
    1.85, 0.47, 0.069, 0.006, 0.02, 0.009, 0.03, 0.0, 0.0, 6.0, 1.0, 0.183, 0.123,
];

/// With L rising and C falling with the film; over the whole film L has no trend.
fn with_trends(mut full: [f64; SLOTS], form: Form) -> [f64; SLOTS] {
    if form.viscous == Viscous::Constant {
        full[ParameterKind::LubricationTrend.slot()] = 0.3;
    }
    full[ParameterKind::InertialTrend.slot()] = -0.4;
    full
}

const DRY_SPEEDS: [DrySpeed; 2] = [DrySpeed::Reference(2.0), DrySpeed::Impact];

/// Every form of inertia with both dry speeds, and with the other terms in and out.
fn forms() -> Vec<Form> {
    let mut forms = vec![];
    for inertia in Inertia::ALL {
        for dry_speed in DRY_SPEEDS {
            let plain = Form::new(inertia, dry_speed);
            let bridge = Term::Bridge.toggled(plain);
            let [second, both] = [plain, bridge].map(|form| Term::DrySecondOrder.toggled(form));
            let over_the_film = Form {
                viscous: Viscous::Film,
                ..plain
            };
            let without_viscous = Term::Viscous.toggled(plain);
            forms.extend([plain, bridge, second, both, over_the_film, without_viscous]);
        }
    }
    forms
}

fn scene() -> Scene {
    scene::parse(SCENE, Path::new("a/scene.toml"), String::new()).expect("a valid scene")
}

/// Runs at speeds of their own, down to where nothing rebounds.
fn runs(scene: &Scene, each: usize, seed: &str) -> Runs {
    let form = Form::new(Inertia::Saturating, DRY_SPEEDS[0]);
    let mut rng = crate::seed::stream(1, seed, 0);
    let mut new = vec![];
    for particle in ["PTFE", "PE"] {
        for _ in 0..5 {
            let v: f64 = rng.random_range(0.3..2.0);
            new.push((particle, None, 4e-3, None, v, 0.83));
        }
        // a dry run that stuck
        new.push((particle, None, 4e-3, None, 1.9, 0.0));
        for (liquid, ratio) in [("AK10", 0.06), ("M50", 0.06), ("M50", 0.12)] {
            for _ in 0..each {
                let v: f64 = rng.random_range(0.4..1.8);
                new.push((particle, Some(liquid), 4e-3, Some((ratio * 4e-3, ratio)), v, f64::NAN));
            }
        }
    }
    let rows: Vec<NewRun> = new
        .into_iter()
        .map(|(particle, liquid, diameter, film, impact_speed, restitution)| {
            let mut row = NewRun {
                particle,
                liquid,
                diameter,
                film,
                impact_speed,
                restitution,
            };
            if restitution.is_nan() {
                let mean = rebound::mean_restitution(kept(scene, (&row, 1.0), form, &FULL));
                let noise = 0.02 * (rng.random::<f64>() + rng.random::<f64>() + rng.random::<f64>() - 1.5) * 2.0;
                row.restitution = Some(mean + noise).filter(|e| *e > 0.05).unwrap_or(0.0);
            }
            row
        })
        .collect();
    runs::arrange(scene, &rows)
}

/// The energy kept; `middle` is the film ratio at which L and C have no trend.
fn kept(scene: &Scene, (run, middle): (&NewRun, f64), form: Form, full: &[f64]) -> f64 {
    let index = scene
        .particles
        .iter()
        .position(|p| p.name == run.particle)
        .expect("known");
    let liquid = scene
        .liquids
        .iter()
        .find(|l| Some(l.name.as_str()) == run.liquid)
        .expect("known");
    let setting = Setting {
        density: scene.particles[index].density,
        diameter: run.diameter,
        roughness: Some(5e-6),
        liquid_density: liquid.density,
        viscosity: liquid.viscosity,
        film: run.film.expect("wet").0,
        surface_tension: liquid.surface_tension,
    };
    let film: f64 = setting.film_ratio() / middle;
    let mut parameters = physical(full, index);
    parameters.shared[Coefficient::LubricationLog] += full[ParameterKind::LubricationTrend.slot()] * film.ln();
    parameters.shared[Coefficient::InertialPrefactor] *= film.powf(full[ParameterKind::InertialTrend.slot()]);
    kept_energy(&setting, form, &parameters, run.impact_speed)
}

/// A run of PTFE in a film of AK10.
fn wet(impact_speed: f64, restitution: f64) -> NewRun<'static> {
    NewRun {
        particle: "PTFE",
        liquid: Some("AK10"),
        diameter: 4e-3,
        film: Some((2.4e-4, 0.06)),
        impact_speed,
        restitution,
    }
}

fn shifted(full: &[f64], place: usize, step: f64) -> Vec<f64> {
    let mut full = full.to_vec();
    full[place] += step;
    full
}

/// Without noise on the energy, far from the threshold, it is the noise on e to first order in σ.
#[test]
fn noise_on_the_energy_goes_over_into_none() {
    let [both, usual] = [NoiseOn::Both, NoiseOn::Restitution].map(|noise| {
        let mut scene = scene();
        scene.model.noise = noise;
        scene
    });
    let form = Form::new(Inertia::Saturating, DRY_SPEEDS[1]);
    let runs = |restitutions: &[f64]| {
        let run = |restitution: &f64| wet(1.2, *restitution);
        runs::arrange(&both, &restitutions.iter().map(run).collect::<Vec<_>>())
    };
    let (mean, _) = Pointwise::new(&both, &runs(&[0.6]), form).at(&FULL).mean_and_sigma(0);
    let about: Vec<f64> = (0..20).map(|i| mean + 0.001 * (f64::from(i) - 9.5)).collect();
    let likelihoods = [&both, &usual].map(|scene| Likelihood::new(scene, &runs(&about), form));
    let (mut full, mut unused) = (FULL, [0.0; SLOTS]);
    full[ParameterKind::SigmaWet.slot()] = 0.005;
    for energy in [1e-5, 1e-6, 1e-7, 1e-8, 3e-9, 1e-9, 1e-10] {
        full[ParameterKind::SigmaEnergy.slot()] = energy;
        let [value, expected] = likelihoods
            .each_ref()
            .map(|of| of.ln_density(&full, &mut unused).expect("inside"));
        assert!((value - expected).abs() < 1e-4, "{energy}: {value} {expected}");
    }
}

#[test]
fn a_point_without_a_density_is_told_and_is_no_number() {
    let scene = scene();
    let runs = runs(&scene, 10, "a_point_without_a_density");
    let likelihood = Likelihood::new(&scene, &runs, Form::new(Inertia::Saturating, DRY_SPEEDS[0]));
    let mut slopes = [0.0; SLOTS];
    for (kind, value) in [
        (ParameterKind::SigmaWet, 0.0),
        (ParameterKind::LUBRICATION_LOG, f64::NAN),
        (ParameterKind::FILM_SCALE, 0.0),
        (ParameterKind::SigmaWet, 1e-200),
    ] {
        let mut full = FULL;
        full[kind.slot()] = value;
        assert_eq!(
            likelihood.ln_density(&full, &mut slopes),
            Err(OutsideDomain),
            "{kind:?} {value}"
        );
    }
}

/// Runs repeated at a few settings, as designed ones are, are one node a setting and lose nothing.
#[test]
fn runs_of_one_setting_are_one_node() {
    let scene = scene();
    let run = |i: i32| {
        // at two of the settings some stick
        let rebounds = f64::from(u8::from(i % 9 > 0 || i % 7 > 1));
        let e = (0.6 + 0.02 * (f64::from(i) * 0.7).sin()) * rebounds;
        wet(0.8 + 0.1 * f64::from(i % 7), e)
    };
    let rows: Vec<NewRun> = (0..4000).map(run).collect();
    let runs = runs::arrange(&scene, &rows);
    let bridge = Term::Bridge.toggled(Form::new(Inertia::Cap, DRY_SPEEDS[0]));
    for form in [Form::new(Inertia::Cap, DRY_SPEEDS[1]), bridge] {
        let likelihood = Likelihood::new(&scene, &runs, form);
        assert_eq!(likelihood.nodes(), 7 + 2);
        let mut slopes = [0.0; SLOTS];
        for sigma in [1e-2, 0.1, 1.0] {
            let mut full = FULL;
            full[ParameterKind::SigmaWet.slot()] = sigma;
            let value = likelihood.ln_density(&full, &mut slopes).expect("inside");
            let expected = by_run(&scene, &runs, form, &full);
            assert!((value / expected - 1.0).abs() < 1e-11, "{sigma} {value} {expected}");
        }
    }
}

/// A film measured anew for every run is a column as its speed is.
#[test]
fn films_of_their_own_are_one_block() {
    let scene = scene();
    let run = |i: i32| NewRun {
        film: Some((2.4e-4 * (1.0 + 1e-3 * f64::from(i % 20)), 0.06)),
        ..wet(0.8 + 0.01 * f64::from(i), 0.4)
    };
    let rows: Vec<NewRun> = (0..60).map(run).collect();
    let runs = runs::arrange(&scene, &rows);
    let form = Form::new(Inertia::Stepwise, DRY_SPEEDS[0]);
    let likelihood = Likelihood::new(&scene, &runs, form);
    assert_eq!((likelihood.rows.blocks.len(), likelihood.nodes()), (1, 60));
    let mut slopes = [0.0; SLOTS];
    let value = likelihood.ln_density(&FULL, &mut slopes).expect("inside");
    let expected = by_run(&scene, &runs, form, &FULL);
    assert!((value / expected - 1.0).abs() < 1e-12);
}
