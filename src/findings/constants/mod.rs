//! Measures how far results move with the constants that a scene takes as exact, and what that adds to their error.
//!
//! | file | job |
//! |---|---|
//! | `constant.rs` | which constants there are, and how one is changed |
//! | `sample.rs` | as many rebounds as an elasticity needs |
//! | `linearised.rs` | moves the energy balance with the constants, from its linearisation at the fit |
//! | `elasticities.rs` | finds how results move with a constant |
//! | `sensitivity.rs` | how one result moves with the constants |
//! | `exact_constants.rs` | which constant without an uncertainty would widen the results most |

mod constant;
mod elasticities;
mod exact_constants;
mod linearised;
mod sample;
mod sensitivity;

use std::collections::HashSet;

use rayon::prelude::*;

use super::balance::{EnergyBalance, ParameterEstimate};
use super::dry::FittedDry;
use super::estimate::Estimate;
use super::film_ratio;
use super::scaling::FittedScaling;
use crate::model::parameters::ParameterKind;
use crate::notice::Notice;
use crate::physics::Quantity;
use crate::runs::{FilmGroup, Runs};
use crate::scene::{Scene, WetLaw};
use constant::{Constant, MaterialsInUse};
use elasticities::{Output, SensitivityAnalysis};
use linearised::LinearisedBalance;
use sample::RunSample;
pub use sensitivity::{Elasticity, Sensitivity};
use sensitivity::{Subject, BALANCE};

/// Share of itself by which a constant is changed each way. The error of a central difference falls with its square and is
/// 1e-8 of an elasticity on the example, where it is 1e-4 with a share of 1e-4; rounding grows with its inverse, to as much.
const STEP: f64 = 1e-6;

/// More rebounds than this say little new of an elasticity: of longer tables about so many are taken.
pub const MOST_REBOUNDS: usize = 10_000;

/// Elasticities are rounded to so many parts of one: what a difference leaves behind them is its own error.
const PARTS: f64 = 1e5;

/// The sensitivity of what the energy balance gives and, at the film ratio shown of each particle, of e_inf and St_c; a
/// fit that may not be quoted has none. With it, what the reader should look at.
pub fn find_sensitivities(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    scaling: &[FittedScaling],
    balance: Option<&EnergyBalance>,
) -> (Vec<Sensitivity>, Option<Notice>) {
    let balance = balance.filter(|balance| balance.verdict.passed);
    let outputs = outputs_without_constants(scene, runs, scaling, balance);
    if outputs.is_empty() {
        return (vec![], None);
    }
    let targets: Vec<Output> = outputs.iter().map(|(output, _)| *output).collect();
    let in_use = MaterialsInUse::new(scene, runs);
    let sample = RunSample::of(runs, MOST_REBOUNDS);
    let linearised = |balance| LinearisedBalance::new(scene, runs, &sample, dry, balance);
    let analysis = SensitivityAnalysis {
        scene,
        sample: &sample,
        dry,
        in_use: &in_use,
        outputs: &targets,
        balance: balance.and_then(linearised),
    };
    let kinds = in_use.kinds(scene);
    let constants: Vec<Constant> = kinds.iter().flat_map(|kind| kind.varied(&in_use, scene)).collect();
    let columns: Vec<Vec<f64>> = constants
        .par_iter()
        .map(|constant| analysis.elasticities(*constant, STEP))
        .collect();
    let sensitivities: Vec<(Sensitivity, Vec<f64>)> = outputs
        .into_iter()
        .enumerate()
        .filter_map(|(row, (_, blank))| {
            let elasticities: Vec<f64> = columns
                .iter()
                .map(|column| (column[row] * PARTS).round() / PARTS)
                .collect();
            // where a fit gives no number, what its constant does is not known, nor is the sum
            elasticities.iter().all(|x| x.is_finite()).then(|| {
                let by = constants.iter().zip(&elasticities).filter(|(_, x)| **x != 0.0);
                let by = by.map(|(constant, elasticity)| Elasticity {
                    constant: constant.name(scene),
                    elasticity: *elasticity,
                    rel_sd: in_use.rel_sd(scene, *constant),
                });
                (combine(blank, by.collect()), elasticities)
            })
        })
        .collect();
    let notice = exact_constants::exact_constants_notice(scene, &in_use, &kinds, &constants, &sensitivities);
    (
        sensitivities.into_iter().map(|(sensitivity, _)| sensitivity).collect(),
        notice,
    )
}

/// Adds what is known of the constants to the statistical error; they are taken as independent of each other.
fn combine(blank: Sensitivity, by: Vec<Elasticity>) -> Sensitivity {
    let value = blank.value;
    let given = by.iter().filter_map(|one| Some(value * one.elasticity * one.rel_sd?));
    let squares: Vec<f64> = given.map(|sd| sd * sd).collect();
    let constants_sd = (!squares.is_empty()).then(|| squares.iter().sum::<f64>().sqrt());
    Sensitivity {
        combined: constants_sd.zip(blank.se).map(|(sd, se)| sd.hypot(se)),
        constants_sd,
        by,
        ..blank
    }
}

/// The results that have a value and a standard error, still without the constants.
fn outputs_without_constants(
    scene: &Scene,
    runs: &Runs,
    scaling: &[FittedScaling],
    balance: Option<&EnergyBalance>,
) -> Vec<(Output, Sensitivity)> {
    let mut outputs = balance.map_or(vec![], |balance| of_balance(scene, balance));
    for sphere in 0..runs.spheres.len() {
        let Some(film_ratio) = film_ratio::reference_film_ratio(scene, runs, sphere) else {
            continue;
        };
        let same = |group: &FilmGroup| (group.sphere, group.film_ratio) == (sphere, film_ratio);
        let Some(group) = runs.film_groups.iter().position(same) else {
            continue;
        };
        let name = &scene.particles[runs.spheres[sphere].particle].name;
        let derived = balance.iter().flat_map(|balance| &balance.derived);
        let derived = derived.filter(|row| row.sphere == sphere && row.film_ratio == film_ratio);
        let direct = scaling.iter().find(|fitted| {
            (fitted.sphere, fitted.law, fitted.scaling.film_ratio) == (sphere, WetLaw::Sqrt, Some(film_ratio))
                && fitted.scaling.verdict.passed
        });
        let mut add = |output: Output, diameter: Option<f64>, fit: &'static str, estimate: &Estimate| {
            let (Output::Derived(_, quantity) | Output::SquareRoot(_, quantity)) = output else {
                return;
            };
            let subject = Subject {
                particle: Some(name.clone()),
                film_ratio: Some(film_ratio),
                diameter,
            };
            let blank = Sensitivity::without_constants(quantity.describe().name, subject, fit, (estimate, 1.0));
            outputs.extend(blank.map(|blank| (output, blank)));
        };
        for row in derived {
            for (quantity, estimate) in [(Quantity::EInf, &row.e_inf), (Quantity::StC, &row.st_c)] {
                add(Output::Derived(row.place, quantity), row.diameter_m, BALANCE, estimate);
            }
        }
        let of_law = direct.iter().flat_map(|fitted| {
            let both = [Quantity::EInf, Quantity::StC].into_iter();
            both.filter_map(|quantity| Some((quantity, fitted.scaling.estimate(quantity)?)))
        });
        for (quantity, estimate) in of_law {
            let diameter = runs.spheres[sphere].diameter;
            add(
                Output::SquareRoot(group, quantity),
                diameter,
                WetLaw::Sqrt.name(),
                estimate,
            );
        }
    }
    outputs
}

/// The parameters of the energy balance, and δc of those of its particles whose roughness is given.
fn of_balance(scene: &Scene, balance: &EnergyBalance) -> Vec<(Output, Sensitivity)> {
    let mut outputs = vec![];
    let mut add = |output: Output, result: &str, particle: Option<&String>, estimate: (&Estimate, f64)| {
        let subject = Subject {
            particle: particle.cloned(),
            ..Subject::default()
        };
        let blank = Sensitivity::without_constants(result, subject, BALANCE, estimate);
        outputs.extend(blank.map(|blank| (output, blank)));
    };
    // k comes from the dry runs, which no constant enters
    let of_k = |parameter: &ParameterEstimate| matches!(parameter.kind, ParameterKind::DryK(_));
    let wet = balance.parameters.iter().enumerate().filter(|(_, own)| !of_k(own));
    for (index, parameter) in wet {
        add(
            Output::Parameter(index),
            &parameter.name,
            None,
            (&parameter.estimate, 1.0),
        );
    }
    let held: HashSet<&String> = balance.particles.iter().collect();
    for (index, particle) in scene.particles.iter().enumerate() {
        if let Some(roughness) = particle.roughness.filter(|_| held.contains(&particle.name)) {
            add(
                Output::CriticalSeparation(index),
                Quantity::DeltaC.describe().name,
                Some(&particle.name),
                (&balance.delta_c_over_roughness, roughness),
            );
        }
    }
    outputs
}
