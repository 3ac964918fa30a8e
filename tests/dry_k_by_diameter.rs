//! Tests `dry_k = "diameter"`: each diameter's k is read, drawn and fitted; `transcripts` hold its posterior and report.

use crate::common::scenes::{scene_of, AK10, M20, PE, PTFE};
use crate::common::{rows, Place, Told};
use wetcor::findings::estimate::Estimate;
use wetcor::findings::Findings;
use wetcor::model::parameters::ModelParameters;
use wetcor::physics::Quantity;
use wetcor::runs::arrange;
use wetcor::scene::{DryKOf, Prior, PriorChoice};

/// Particle, D in mm and k: those the paper's fall of e with D would ask for.
const TRUE_K: [(&str, f64, f64); 4] = [
    ("PTFE", 4.762, 0.175),
    ("PTFE", 8.0, 0.190),
    ("PE", 4.762, 0.117),
    ("PE", 7.938, 0.129),
];
const L: f64 = 1.85;
const C: f64 = 0.6;

/// The paper's design in small: 2 particles of 2 diameters, 2 liquids of one density, so that the square-root law is the
/// truth itself at each diameter, and none so thick that a run sticks.
fn scene() -> Place {
    let text = format!(
        r#"[model]
dry_k = "diameter"
[truth]
dry_k = {{ PTFE = {{ "4.762" = 0.175, "8" = 0.190 }}, PE = {{ "4.762" = 0.117, "7.938" = 0.129 }} }}
lubrication_log = {L}
inertial_prefactor = {C}
sigma_dry = 0.009
sigma_wet = 0.02
[design]
diameter_mm = {{ PTFE = [4.762, 8], PE = [4.762, 7.938] }}
liquids = ["AK10", "M20"]
film_ratio = {{ PTFE = [0.03, 0.06, 0.12], PE = [0.03, 0.05, 0.08] }}
height_mm = [60, 80, 100, 125, 150]
dry_impact_speed_m_s = [0.5, 1.0, 2.0]
repeats = 5
"#
    );
    Place::new(&scene_of("one k for each diameter", &[PTFE, PE, AK10, M20, &text]))
}

/// e_inf² = e_dry(2 m/s)² − C ρ̃ g with the stepwise g, as they are written.
fn e_inf(k: f64, density_ratio: f64, film_ratio: f64) -> f64 {
    let e_dry = 1.0 - k * 2f64.powf(0.2);
    let shape = film_ratio * (3.0 - 6.0 * film_ratio + 4.0 * film_ratio * film_ratio);
    (e_dry * e_dry - C * density_ratio * shape).sqrt()
}

fn true_k(particle: &str, diameter: f64) -> f64 {
    let own = |(name, mm, _): &&(&str, f64, f64)| *name == particle && (1e3 * diameter / mm - 1.0).abs() < 1e-3;
    TRUE_K.iter().find(own).expect("a diameter of the design").2
}

/// Names of the quantities of a fit, each with its estimate and the truth.
fn with_truths(findings: &Findings) -> Vec<(String, &Estimate, f64)> {
    let balance = findings.balance();
    let mut all = vec![("lubrication_log".to_owned(), L), ("inertial_prefactor".to_owned(), C)];
    all.extend(TRUE_K.map(|(particle, mm, k)| (format!("dry_k[{particle},{mm}]"), k)));
    assert_eq!(balance.parameters.len(), all.len());
    let fitted = |(name, truth): (String, f64)| {
        let estimate = findings.fitted(&name);
        (name, estimate, truth)
    };
    let mut all: Vec<_> = all.into_iter().map(fitted).collect();
    let of_balance = balance.derived.iter().map(|row| {
        let both = [Quantity::EInf, Quantity::StC].map(|quantity| &row.estimates[quantity]);
        ("balance", &row.particle, row.film_ratio, row.diameter_m, both)
    });
    let direct = findings.scaling.iter().filter(|row| row.law.name() == "sqrt");
    let direct = direct.filter_map(|row| {
        let both = [Quantity::EInf, Quantity::StC].map(|quantity| &row.estimates[quantity]);
        Some(("direct", &row.particle, row.film_ratio?, row.diameter_m, both))
    });
    for (fit, particle, film_ratio, diameter, [of_e_inf, of_st_c]) in of_balance.chain(direct) {
        let diameter = diameter.expect("one for each diameter");
        let density = if particle == "PTFE" { 2150.0 } else { 940.0 };
        let truth = e_inf(true_k(particle, diameter), 930.0 / density, film_ratio);
        let name = |quantity: &str| format!("{fit} {quantity}[{particle},{film_ratio},{diameter}]");
        all.push((name("e_inf"), of_e_inf, truth));
        all.push((name("st_c"), of_st_c, 2.0 * L / (truth * truth)));
    }
    for row in &findings.dry {
        let diameter = row.diameter_m.expect("one for each diameter");
        let name = format!("dry runs' k[{},{diameter}]", row.particle);
        all.push((name, &row.dry_k, true_k(&row.particle, diameter)));
    }
    all
}

/// With next to no noise every number is the truth's.
#[test]
fn least_squares_find_each_diameters_k_back() {
    let mut place = scene();
    assert_eq!(place.scene.model.dry_k, DryKOf::Diameter);
    let truth = place.scene.truth.as_mut().expect("given");
    (truth.sigma_dry, truth.sigma_wet) = (Some(1e-9), Some(1e-9));
    let findings = place.infer(1);
    let all = with_truths(&findings);
    assert_eq!(all.len(), 2 + 4 + 2 * 2 * 12 + 4);
    for (name, estimate, truth) in all {
        let value = estimate.value.unwrap_or_else(|| panic!("{name}: {estimate:?}"));
        assert!((value / truth - 1.0).abs() < 1e-6, "{name}: {value}, not {truth}");
    }
    let places = findings.scaling.iter().filter(|row| row.film_ratio.is_none()).count();
    assert_eq!(places, 2 * 4, "both laws over all films, of each diameter");
    assert!(findings.dry.iter().all(|dry| dry.heterogeneity.is_none()));
    let checks: Vec<&str> = findings.checks().map(|check| check.code).collect();
    assert!(!checks.contains(&"one_dry_k_for_all_diameters"), "{checks:?}");
}

/// A truth is read by diameter, and a prior of a particle is that of each of its k.
#[test]
fn a_truth_is_of_a_diameter_and_a_prior_of_them_all() {
    let mut place = scene();
    let truth = place.scene.truth.as_ref().expect("given");
    let both = [truth.k(0, 8e-3), truth.k(1, 4.763e-3)];
    assert_eq!(both, [Some(0.190), Some(0.117)]);
    assert_eq!((truth.k(0, 7.9e-3), truth.dry_k[0]), (None, None));
    place.scene.priors.push(PriorChoice {
        parameter: "dry_k",
        particle: Some(0),
        prior: Prior::Fixed(0.18),
        line: None,
    });
    let runs = arrange(&place.scene, &rows(&place.scene, 1));
    let parameters = ModelParameters::of(&place.scene, &runs, place.scene.model.form()).expect("priors with room");
    let held = parameters.left_out.iter().filter(|left| left.value == Some(0.18));
    let held: Vec<&str> = held.map(|left| left.name.as_str()).collect();
    assert_eq!(held, ["dry_k[PTFE,4.762]", "dry_k[PTFE,8]"]);
    let sampled = parameters.sampled.iter().map(|own| own.name.as_str());
    let of_k: Vec<&str> = sampled.filter(|name| name.starts_with("dry_k[")).collect();
    assert_eq!(of_k, ["dry_k[PE,4.762]", "dry_k[PE,7.938]"]);
}
