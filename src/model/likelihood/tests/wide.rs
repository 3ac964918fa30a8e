//! Tests that the sums in wide registers are those of the one statement of the energy balance.

use rand::rngs::ChaCha8Rng;
use rand::RngExt;

use super::super::nodes::{Block, Film, Nodes, RunSetting};
use super::super::run_density::{RunDensity, Totals};
use super::super::student::Student;
use super::super::sums::{Asked, NodeSums};
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

/// Log density, its slopes in σ and in the shape, and those in what is kept.
fn each(totals: &Totals) -> [f64; 10] {
    let RunDensity {
        value, sigma, shape, ..
    } = totals.of_kind[1];
    let [kept, viscous, dry_k, of_shape, scale, viscous_trend, inertial_trend] = totals.blocks[0];
    [
        value,
        sigma,
        shape,
        kept,
        viscous,
        dry_k,
        of_shape,
        scale,
        viscous_trend,
        inertial_trend,
    ]
}

fn nothing() -> Totals {
    Totals {
        of_kind: [RunDensity::default(); 2],
        blocks: vec![[0.0; 7]],
    }
}

/// The sums as they are written, run by run, with the sum of the magnitudes of their terms.
fn plainly(settings: &[RunSetting], nodes: &Nodes, law: &BlockLaw, noise: Option<Student>) -> [(f64, f64); 10] {
    let (nu, stretch) = (noise.map(|of| of.nu), noise.map_or(1.0, |of| of.quantile));
    let stretch_slope = noise.map_or(0.0, |of| of.quantile_slope);
    let mut all = [(0.0, 0.0); 10];
    for (node, setting) in settings.iter().enumerate() {
        let at = setting.impact;
        let film = law.at(setting.film);
        let (r, of_k) = film.balance.kept(&at);
        let (e, n) = (nodes.restitution[node], nodes.count[node]);
        let z = (e - mean_restitution(r)) / SIGMA;
        let q = n * (stretch * z).powi(2);
        let weight = nu.map_or(1.0, |nu| (nu + 1.0) / (nu + q));
        let ln_tail = nu.map_or(0.0, |nu| (q / nu).ln_1p());
        let mut own = nothing();
        own.of_kind[1] = RunDensity {
            value: -0.5 * nu.map_or(q, |nu| (nu + 1.0) * ln_tail),
            sigma: weight * q / SIGMA,
            shape: nu.map_or(0.0, |nu| weight * q * (0.5 / nu - stretch_slope) - 0.5 * ln_tail),
            ..RunDensity::default()
        };
        let kept = n * weight * stretch.powi(2) * z / SIGMA * slope_mean_restitution(r);
        film.add(&mut own.blocks[0], [kept, kept * at.over_stokes, kept * of_k], 1.0);
        for ((sum, size), term) in all.iter_mut().zip(each(&own)) {
            *sum += term;
            *size += term.abs();
        }
    }
    all
}

const SIGMA: f64 = 0.03;

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
            block: Block {
                sphere: 0,
                wet: true,
                density_ratio: setting.density_ratio(),
                offset: None,
            },
            films: FilmParameters::new(form, &full),
            dry_k: parameters.dry_k,
            offset: 0.0,
        };
        let (mut nodes, mut settings) = (Nodes::default(), vec![]);
        // films of their own, of which some have neighbours
        let mut own = setting;
        for node in 0..rng.random_range(1..200) {
            if node % 3 != 2 {
                own.film = own.diameter * rng.random_range(0.01..0.4);
            }
            let v = rng.random_range(0.05..5.0);
            let at = Impact::new(&own, form, v);
            let ln = (own.film / setting.film).ln();
            let film = Film {
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
            settings.push(RunSetting {
                block: 0,
                film,
                impact: at,
            });
            nodes.push(settings[node], rng.random_range(0.0..1.0), count);
        }
        nodes.blocks.push(0..nodes.len());
        let is_heavy = rng.random_range(0.0..1.0) < 0.3;
        let noise = is_heavy.then(|| {
            let student = Student::new(rng.random_range(2.0..50.0));
            Student {
                quantile: rng.random_range(1.0..1.5),
                quantile_slope: -0.01,
                ..student
            }
        });
        let plain = plainly(&settings, &nodes, &law, noise);
        let mut other = law;
        wrong(&mut other);
        let mut wide = nothing();
        let sums = NodeSums {
            nodes: &nodes,
            kind: 1,
            laws: &[other],
            order: form.dry,
            sigma: SIGMA,
            asked: Asked::Rebounds(noise),
            times: 1.0,
        };
        sums.add_to(&mut wide);
        // of a form without a film scale nothing reads the slope in it
        let places = (0..10).filter(|place| *place != 7 || inertia.has_film_scale());
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
        |law| law.block.density_ratio *= 1.0 + 1e-9,
        "wide_sums_of_another_statement_are_found",
    );
    assert!(largest > 1e-10, "{largest:e}");
}
