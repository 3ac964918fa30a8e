//! Holds that formulas and estimates stay right at the extremes, and writes how right into `reports/stability.md`.

#[path = "../common/mod.rs"]
mod common;
mod formulas;

use formulas::{measure, ours, NOTHING, ROUNDINGS};

#[test]
fn no_formula_cancels_worse_than_its_condition_number_excuses() {
    let (formulas, laws) = measure(ours);
    assert!(formulas.len() > 30 && laws.len() == 3);
    for (name, measured) in &formulas {
        println!("{name} {measured:?}");
        assert!(measured.worst_share <= ROUNDINGS, "{name}: {measured:?}");
    }
    for (name, fitted) in &laws {
        assert!(
            fitted.distance <= NOTHING && fitted.of_se <= NOTHING,
            "{name}: {fitted:?}"
        );
        assert!(fitted.declined.is_empty(), "{name}: {fitted:?}");
    }
}

/// The planted faults: formulas as one would first write them, right in exact arithmetic.
#[test]
fn formulas_that_cancel_are_found() {
    let naive = |scene: &mut _, name: &str, x: &[f64]| {
        let mut answers = ours(scene, name, x);
        match name {
            "inertia::stepwise" => answers[1] = 3.0 + x[0] * (-12.0 + 12.0 * x[0]),
            "inertia::saturating" => answers[0] = 1.0 - (-x[0] / x[1]).exp(),
            "normal::ln_normal_cdf" => {
                let density = (-0.5 * x[0] * x[0]).exp() / (2.0 * std::f64::consts::PI).sqrt();
                answers[1] = density / (0.5 * libm::erfc(-x[0] / std::f64::consts::SQRT_2));
            }
            _ => {}
        }
        answers
    };
    let (formulas, _) = measure(naive);
    for name in ["inertia::stepwise", "inertia::saturating", "normal::ln_normal_cdf"] {
        assert!(
            formulas[name].worst_share > 50.0 * ROUNDINGS,
            "{name}: {:?}",
            formulas[name]
        );
    }
}
