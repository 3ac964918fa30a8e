//! Measures how far results move with the constants that a scene takes as exact, and what that adds to their error.
//!
//! | file | job |
//! |---|---|
//! | `constant.rs` | which constants there are, and how one is changed |
//! | `linearised.rs` | moves the energy balance with the constants, from its linearisation at the fit |
//! | `results.rs` | which results there are, each with its name and its value where the constants have changed |

mod constant;
mod linearised;
mod results;

use rayon::prelude::*;

use super::balance::EnergyBalance;
use super::scaling::Scaling;
use super::wet_fit::FitSetup;
pub(super) use constant::{list_constants, Constant};
use linearised::LinearisedBalance;
use results::{results, Changed, SensitiveResult};
pub use results::{Elasticity, Sensitivity};

/// Share of itself by which a constant is changed each way. The error of a central difference falls with its square and is
/// 1e-8 of an elasticity on the example, where it is 1e-4 with a share of 1e-4; rounding grows with its inverse, to as much.
const STEP: f64 = 1e-6;

/// Elasticities are rounded to so many parts of one: what a difference leaves behind them is its own error.
const PARTS: f64 = 1e5;

/// The sensitivity of what the energy balance gives and, at the film ratio shown of each particle, of e_inf and St_c; a
/// fit that may not be quoted has none.
pub fn find_sensitivities(setup: FitSetup, scaling: &[Scaling], balance: Option<&EnergyBalance>) -> Vec<Sensitivity> {
    let FitSetup { scene, runs, dry } = setup;
    let balance = balance.filter(|balance| balance.verdict.passed);
    let results = results(scene, runs, scaling, balance);
    if results.is_empty() {
        return vec![];
    }
    let listed = list_constants(scene, runs);
    let constants: Vec<&Constant> = listed.iter().filter(|constant| constant.is_varied).collect();
    let balance = balance.and_then(|balance| LinearisedBalance::new(setup, balance));
    // each result's elasticity in a constant
    let column = |constant: &&Constant| -> Vec<f64> {
        let sides = [-STEP, STEP].map(|share| constant.changed(scene, runs, share));
        let [less, more] = sides.each_ref().map(|(scene, runs)| FitSetup { scene, runs, dry });
        let balances = balance.as_ref().and_then(|balance| balance.at([less, more]));
        let [before, after] = balances.map_or([None, None], |balances| balances.map(Some));
        let [less, more] = [(less, before), (more, after)].map(|(setup, balance)| Changed { setup, balance });
        // a power law has no other error than rounding in logarithms; NaN where a fit gives no number
        let slope = |result: &SensitiveResult| -> Option<f64> {
            Some(((result.at)(&more)? / (result.at)(&less)?).ln() / (2.0 * STEP))
        };
        results.iter().map(|result| slope(result).unwrap_or(f64::NAN)).collect()
    };
    let columns: Vec<Vec<f64>> = constants.par_iter().map(column).collect();
    let sensitivity = |(row, SensitiveResult { blank, .. }): (usize, SensitiveResult)| {
        let rounded = columns.iter().map(|column| (column[row] * PARTS).round() / PARTS);
        let elasticities: Vec<f64> = rounded.collect();
        // where a fit gives no number, what its constant does is not known, nor is the sum
        elasticities.iter().all(|x| x.is_finite()).then(|| {
            let by = constants.iter().zip(elasticities).filter(|(_, x)| *x != 0.0);
            let by = by.map(|(constant, elasticity)| Elasticity {
                constant: constant.name.clone(),
                elasticity,
                rel_sd: constant.rel_sd,
            });
            combine(blank, by.collect())
        })
    };
    results.into_iter().enumerate().filter_map(sensitivity).collect()
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
