//! Tests the viscous loss over the whole film: drawn by a plain sum, found back, told apart from one L for all.

use std::f64::consts::PI;

use crate::common::scenes::{scene_of, AK10, PE, PTFE};
use crate::common::{compare, sample_as_usual, seed_of, Place, Told};
use wetcor::findings;
use wetcor::findings::compare::ComparedModel;
use wetcor::model::parameters::ParameterKind;
use wetcor::physics::viscous::RUPTURE_SCALE;
use wetcor::physics::Quantity::{DeltaC, EInf, StC};
use wetcor::physics::{Coefficient, Viscous};

/// Two particles of three diameters, whose roughness differs.
fn scene(fitted: &str, truth: &str, noise: f64) -> Place {
    let text = format!(
        r#"[model]
inertia = "stepwise"
viscous = "{fitted}"
[sampler]
chains = 2
warmup = 200
draws = 200
[truth]
dry_k = {{ PTFE = 0.183, PE = 0.12 }}
viscous = "{truth}"
rupture_scale = 0.9
lubrication_log = 4.0
inertial_prefactor = 0.5
sigma_dry = {noise}
sigma_wet = {noise}
[design]
diameter_mm = {{ PTFE = [3, 6], PE = [5] }}
liquids = ["AK10"]
film_ratio = {{ PTFE = [0.03, 0.06, 0.12], PE = [0.05, 0.10] }}
impact_speed_m_s = [0.8, 1.0, 1.3, 1.7, 2.2]
dry_impact_speed_m_s = [0.5, 0.8, 1.2, 1.6, 2.0]
repeats = 2
"#
    );
    let rough = PE.replace("roughness_um = 5", "roughness_um = 12");
    Place::new(&scene_of(
        "lubrication over the whole film",
        &[PTFE, &rough, AK10, &text],
    ))
}

fn roughness(particle: &str) -> f64 {
    if particle == "PTFE" {
        5e-6
    } else {
        12e-6
    }
}

/// ½ (ln(δ/ε) + ln(δr/ε)), δr = λ V_b^(1/3), V_b = π δ² (D/2 − δ/3), as it is written (eq. visc0).
fn lubrication_log(particle: &str, diameter: f64, film: f64, scale: f64) -> f64 {
    let volume = PI * film * film * (diameter / 2.0 - film / 3.0);
    let rupture = scale * volume.powf(1.0 / 3.0);
    0.5 * ((film / roughness(particle)).ln() + (rupture / roughness(particle)).ln())
}

/// With next to no noise every number is the truth's; St_c belongs to a film and a diameter, and there is no δc.
#[test]
fn least_squares_find_the_truth_back() {
    let findings = scene("film", "film", 1e-9).infer(1);
    let balance = findings.balance();
    let estimate = |coefficient| balance.estimate(ParameterKind::Shared(coefficient));
    let scale = estimate(Coefficient::RuptureScale).and_then(|estimate| estimate.value);
    assert!((scale.expect("a value") / 0.9 - 1.0).abs() < 1e-6, "{scale:?}");
    assert_eq!(estimate(Coefficient::LubricationLog), None);
    assert_eq!(balance.derived.len(), 3 * 2 + 2, "{:?}", balance.derived);
    for row in &balance.derived {
        let diameter = row.diameter_m.expect("one for each diameter");
        let l = lubrication_log(&row.particle, diameter, row.film_ratio * diameter, 0.9);
        let e_inf = row.estimates[EInf].value.expect("a value");
        let st_c = row.estimates[StC].value.expect("a value");
        assert!((st_c / (2.0 * l / (e_inf * e_inf)) - 1.0).abs() < 1e-7, "{row:?}");
    }
    let [small, large] =
        [&balance.derived[0], &balance.derived[1]].map(|row| row.estimates[StC].value.expect("a value"));
    assert!(large > small + 1.0, "{small} {large}");
    let why = balance.delta_c_over_roughness.why_none.as_deref();
    assert_eq!(why, Viscous::Film.why_no_critical_separation());
    for row in findings.scaling.iter().filter(|law| law.energy.is_some()) {
        let delta_c = &row.estimates[DeltaC];
        assert_eq!((delta_c.value, delta_c.why_none.as_deref()), (None, why));
    }
    assert!(findings.tells("viscous_form"));
}

/// The scene's own form and its posterior, and how the forms compare.
fn compared(place: &Place, seed: u64) -> Vec<ComparedModel> {
    let table = place.table(seed);
    let mut findings = findings::fit_least_squares(&place.scene, &table, seed, false);
    let posterior = sample_as_usual(&mut findings, &place.scene, &table.runs);
    let sampled = &posterior.findings.parameters;
    let both = [RUPTURE_SCALE.name, "lubrication_log"];
    let own = sampled
        .iter()
        .filter(|parameter| both.contains(&parameter.name.as_str()));
    // they are one constant: never sampled together
    assert_eq!(own.count(), 1, "{sampled:?}");
    compare(&mut findings, &place.scene, &table.runs, &posterior)
}

/// Each form predicts its own runs better, whichever the scene asks for.
#[test]
fn leave_one_out_tells_the_forms_apart() {
    for (fitted, truth) in [("film", "film"), ("constant", "film"), ("film", "constant")] {
        let models = compared(
            &scene(fitted, truth, 0.01),
            seed_of("leave_one_out_tells_the_forms_apart"),
        );
        let of = |name: &str| models.iter().find(|row| row.model == name).expect("compared");
        let (film, constant) = (of("stepwise/2+film"), of("stepwise/2"));
        assert_eq!((film.own, constant.own), (fitted == "film", fitted == "constant"));
        let gain = film.elpd_loo - constant.elpd_loo;
        let gain = if truth == "film" { gain } else { -gain };
        assert!(gain > 20.0, "{fitted} {truth}: {gain}");
    }
}
