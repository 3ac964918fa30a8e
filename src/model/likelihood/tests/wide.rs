//! Tests that the sums in wide registers are those of the one statement of the energy balance.

use rand::rngs::ChaCha8Rng;
use rand::RngExt;

use super::super::block_sums::BlockSums;
use super::super::nodes::{NodeFilm, Nodes};
use super::super::sums::{rebound_sums, HeavyTails, NodeRange};
use super::super::trend::{BlockLaw, FilmParameters};
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Impact;
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
        roughness: Some(rng.random_range(1e-7..2e-5)),
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

/// Trends of L and C, where the form has one.
fn trends(rng: &mut ChaCha8Rng, form: Form) -> [f64; 2] {
    let some = |rng: &mut ChaCha8Rng, has: bool| {
        let trend = rng.random_range(-0.5..0.5);
        if has && trend > -0.2 {
            trend
        } else {
            0.0
        }
    };
    [
        some(rng, form.viscous == Viscous::Constant),
        some(rng, form.inertia != Inertia::None),
    ]
}

fn each(sums: &BlockSums) -> [f64; 10] {
    let BlockSums {
        squares,
        kept,
        viscous,
        dry,
        shape,
        scale,
        viscous_trend,
        inertial_trend,
        weighted,
        ln_tails,
    } = *sums;
    [
        squares,
        kept,
        viscous,
        dry,
        shape,
        scale,
        viscous_trend,
        inertial_trend,
        weighted,
        ln_tails,
    ]
}

/// The sums as they are written, run by run, with the sum of the magnitudes of their terms.
fn plainly(nodes: &Nodes, range: &NodeRange, heavy: Option<HeavyTails>) -> [(f64, f64); 10] {
    let mut all = [(0.0, 0.0); 10];
    for node in range.nodes.clone() {
        let at = nodes.impact(node);
        let film = range.law.at(nodes.film(node));
        let (r, of_k) = film.balance.kept(&at);
        let (e, n) = (nodes.restitution[node], nodes.count[node]);
        let distance = e - mean_restitution(r);
        let q = heavy.map_or(0.0, |heavy| n * distance * distance * heavy.steepness);
        let weight = heavy.map_or(1.0, |heavy| (heavy.nu + 1.0) / (heavy.nu + q));
        let kept = n * distance * slope_mean_restitution(r) * weight;
        let mut own = BlockSums {
            squares: n * distance * distance,
            weighted: if heavy.is_some() { weight * q } else { 0.0 },
            ln_tails: heavy.map_or(0.0, |heavy| (q / heavy.nu).ln_1p()),
            ..BlockSums::default()
        };
        film.add(&mut own, kept, kept * at.over_stokes, -0.5 * kept * of_k);
        for ((sum, size), term) in all.iter_mut().zip(each(&own)) {
            *sum += term;
            *size += term.abs();
        }
    }
    all
}

/// Largest difference of the wide sums from the plain ones, in the size of their terms.
fn largest_difference(wrong: impl Fn(&mut BlockLaw), seed: &str) -> f64 {
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
        let [of_l, of_c] = trends(&mut rng, form);
        let mut full = [0.0; COMMON_SLOTS + 1];
        for coefficient in Coefficient::ALL {
            full[coefficient as usize] = parameters.shared[coefficient];
        }
        full[ParameterKind::LubricationTrend.slot()] = of_l;
        full[ParameterKind::InertialTrend.slot()] = of_c;
        let law = BlockLaw {
            films: FilmParameters::new(form, &full),
            dry_k: parameters.dry_k,
            density_ratio: setting.density_ratio(),
            offset: 0.0,
        };
        let mut nodes = Nodes::default();
        // films of their own, of which some have neighbours
        let mut own = setting;
        for node in 0..rng.random_range(1..200) {
            if node % 3 != 2 {
                own.film = own.diameter * rng.random_range(0.01..0.4);
            }
            let v = rng.random_range(0.05..5.0);
            let at = Impact::new(&own, form, v);
            let ln = (own.film / setting.film).ln();
            let film = NodeFilm {
                ratio: own.film_ratio(),
                ln,
                shape: (!inertia.has_film_scale()).then(|| inertia.shape(own.film_ratio(), 0.0)),
            };
            // the balance is the one that is simulated
            let mut moved = parameters;
            moved.shared[Coefficient::LubricationLog] += of_l * ln;
            moved.shared[Coefficient::InertialPrefactor] *= (of_c * ln).exp();
            let simulated = kept_energy(&own, form, &moved, v);
            let kept = law.at(film).balance.kept(&at).0;
            assert!((kept - simulated).abs() <= 1e-13 * (1.0 + simulated.abs()), "{form:?}");
            let count = f64::from(rng.random_range(1..4));
            nodes.push(at, film, form.fixed(&own).is_some(), rng.random_range(0.0..1.0), count);
        }
        let heavy = (rng.random_range(0.0..1.0) < 0.3).then(|| HeavyTails {
            steepness: rng.random_range(100.0..1e4),
            nu: rng.random_range(2.0..50.0),
        });
        let range = NodeRange {
            nodes: 0..nodes.len(),
            law,
        };
        let plain = plainly(&nodes, &range, heavy);
        let mut other = range.clone();
        wrong(&mut other.law);
        let wide = rebound_sums(&nodes, form.dry, heavy, &[other])[0];
        // of a form without a film scale nothing reads the slope in it
        let places = (0..10).filter(|place| *place != 5 || inertia.has_film_scale());
        for place in places {
            let ((sum, size), wide) = (plain[place], each(&wide)[place]);
            let difference = (wide - sum).abs() / size.max(1e-300);
            largest = largest.max(if size == 0.0 { wide.abs() } else { difference });
        }
    }
    largest
}

#[test]
fn wide_sums_are_those_of_the_one_statement() {
    let largest = largest_difference(|_| (), "wide_sums_are_those_of_the_one_statement");
    // the exponential is one to 1e-14, and near the turn e moves by many times r
    assert!(largest < 1e-11, "{largest:e}");
}

/// A thousandth of a millionth in one loss is seen.
#[test]
fn wide_sums_of_another_statement_are_found() {
    let largest = largest_difference(
        |law| law.density_ratio *= 1.0 + 1e-9,
        "wide_sums_of_another_statement_are_found",
    );
    assert!(largest > 1e-10, "{largest:e}");
}
