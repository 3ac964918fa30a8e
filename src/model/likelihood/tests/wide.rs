//! Tests that the sums in wide registers are those of the one statement of the energy balance.

use rand::rngs::ChaCha8Rng;
use rand::RngExt;

use super::super::nodes::Nodes;
use super::super::sums::{rebound_sums, BlockSums, HeavyTails, NodeRange};
use crate::physics::balance::{Balance, Impact};
use crate::physics::form::Term;
use crate::physics::rebound::{mean_restitution, slope_mean_restitution};
use crate::physics::{kept_energy, Coefficient, DrySpeed, Form, Inertia, Parameters, Setting, Viscous};
use crate::seed::stream;

/// A setting as laboratories have them, and beyond, down to where nothing rebounds.
fn setting(rng: &mut ChaCha8Rng) -> Setting {
    let diameter = rng.random_range(1e-3..1e-2);
    Setting {
        density: rng.random_range(900.0..8000.0),
        diameter,
        roughness: rng.random_range(1e-7..2e-5),
        liquid_density: rng.random_range(700.0..1300.0),
        viscosity: rng.random_range(1e-3..0.2),
        film: diameter * rng.random_range(0.01..0.4),
        surface_tension: Some(rng.random_range(0.02..0.07)),
    }
}

fn parameters(rng: &mut ChaCha8Rng) -> Parameters {
    Parameters::new(rng.random_range(0.05..0.3))
        .with(Coefficient::LubricationLog, rng.random_range(0.5..6.0))
        .with(Coefficient::InertialPrefactor, rng.random_range(0.0..2.0))
        .with(Coefficient::FilmScale, rng.random_range(0.01..0.3))
        .with(Coefficient::RuptureScale, 10f64.powf(rng.random_range(-4.0..1.0)))
}

/// The sums as they are written, run by run, with the sum of the magnitudes of their terms.
fn plainly(nodes: &Nodes, range: &NodeRange, heavy: Option<HeavyTails>) -> [(f64, f64); 6] {
    let mut sums = [(0.0, 0.0); 6];
    for node in range.nodes.clone() {
        let at = nodes.impact(node);
        let (r, of_k) = range.balance.kept(&at);
        let (e, n) = (nodes.restitution[node], nodes.count[node]);
        let distance = e - mean_restitution(r);
        let q = heavy.map_or(0.0, |heavy| n * distance * distance * heavy.steepness);
        let weight = heavy.map_or(1.0, |heavy| (heavy.nu + 1.0) / (heavy.nu + q));
        let kept = n * distance * slope_mean_restitution(r) * weight;
        let terms = [
            n * distance * distance,
            kept,
            kept * at.over_stokes,
            -0.5 * kept * of_k,
            if heavy.is_some() { weight * q } else { 0.0 },
            heavy.map_or(0.0, |heavy| (q / heavy.nu).ln_1p()),
        ];
        for ((sum, size), term) in sums.iter_mut().zip(terms) {
            *sum += term;
            *size += term.abs();
        }
    }
    sums
}

/// Largest difference of the wide sums from the plain ones, in the size of their terms.
fn largest_difference(wrong: impl Fn(&mut Balance), seed: &str) -> f64 {
    let mut rng = stream(1, seed, 0);
    let mut largest: f64 = 0.0;
    for _ in 0..400 {
        let inertia = Inertia::ALL[rng.random_range(0..4)];
        let usual = [DrySpeed::Impact, DrySpeed::Reference(rng.random_range(0.5..3.0))];
        let mut form = Form {
            viscous: Viscous::NAMED[rng.random_range(0..2)],
            ..Form::new(inertia, usual[rng.random_range(0..2)])
        };
        for term in [Term::Bridge, Term::DrySecondOrder, Term::Viscous] {
            if rng.random_range(0.0..1.0) < 0.4 {
                form = term.toggled(form);
            }
        }
        let (setting, parameters) = (setting(&mut rng), parameters(&mut rng));
        let balance = Balance::new(form, setting.of_film(), &parameters);
        let mut nodes = Nodes::default();
        for _ in 0..rng.random_range(1..40) {
            let v = rng.random_range(0.05..5.0);
            let at = Impact::new(&setting, form, v);
            // the balance is the one that is simulated
            let simulated = kept_energy(&setting, form, &parameters, v);
            assert!((balance.kept(&at).0 - simulated).abs() <= 1e-14 * (1.0 + simulated.abs()));
            let count = f64::from(rng.random_range(1..4));
            nodes.push(at, form.fixed(&setting).is_some(), rng.random_range(0.0..1.0), count);
        }
        let heavy = (rng.random_range(0.0..1.0) < 0.3).then(|| HeavyTails {
            steepness: rng.random_range(100.0..1e4),
            nu: rng.random_range(2.0..50.0),
        });
        let range = NodeRange {
            nodes: 0..nodes.len(),
            balance,
        };
        let plain = plainly(&nodes, &range, heavy);
        let mut other = range.clone();
        wrong(&mut other.balance);
        let BlockSums {
            squares,
            kept,
            viscous,
            dry,
            weighted,
            ln_tails,
        } = rebound_sums(&nodes, form.dry, heavy, &[other])[0];
        for ((sum, size), wide) in plain.into_iter().zip([squares, kept, viscous, dry, weighted, ln_tails]) {
            let difference = (wide - sum).abs() / size.max(1e-300);
            largest = largest.max(if size == 0.0 { wide.abs() } else { difference });
        }
    }
    largest
}

#[test]
fn wide_sums_are_those_of_the_one_statement() {
    let largest = largest_difference(|_| (), "wide_sums_are_those_of_the_one_statement");
    assert!(largest < 1e-12, "{largest:e}");
}

/// A thousandth of a millionth in one loss is seen.
#[test]
fn wide_sums_of_another_statement_are_found() {
    let largest = largest_difference(
        |balance| balance.lost.over_stokes *= 1.0 + 1e-9,
        "wide_sums_of_another_statement_are_found",
    );
    assert!(largest > 1e-10, "{largest:e}");
}
