//! Measures how far results move with the constants that a scene takes as exact, and what that adds to their error.
//!
//! | file | job |
//! |---|---|
//! | `constant.rs` | which constants there are, and how one is changed |
//! | `linearised.rs` | moves the energy balance with the constants, from its linearisation at the fit |

mod constant;
mod linearised;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::balance::EnergyBalance;
use super::estimate::Estimate;
use super::film_groups::reference_film_ratio;
use super::places::EstimatePlace;
use super::remarks::described;
use super::scaling::{square_root_of, Scaling};
use super::wet_fit::FitSetup;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::runs::Runs;
use crate::scene::{Scene, WetLaw};
pub(super) use constant::{list_constants, Constant};
use linearised::{LinearisedBalance, MovedBalance};

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

/// How the energy balance is named as the fit behind a result.
const BALANCE: &str = "balance";

/// How one result moves with the constants.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// the name of a shared parameter, `delta_c_m`, `e_inf` or `st_c`
    pub result: String,
    /// what it is of
    #[serde(flatten)]
    pub of: EstimatePlace,
    /// `balance`: over all rebounds; `sqrt`: the square-root law of the film ratio
    pub fit: &'static str,
    /// its value
    pub value: f64,
    /// its statistical standard error, by least squares; `None` where the curvature of the fit forbids one
    pub se: Option<f64>,
    /// the constants that move it; any other moves it by less than 5e-6 of its own share
    pub by: Vec<Elasticity>,
    /// √Σ (value · elasticity · rel_sd)² over the constants whose uncertainty is given; `None` where none is
    pub constants_sd: Option<f64>,
    /// √(se² + constants_sd²); `None` without either
    pub combined: Option<f64>,
}

impl Sensitivity {
    /// Whether it is of the energy balance.
    pub fn is_of_balance(&self) -> bool {
        self.fit == BALANCE
    }

    /// Its name in a table, with the fit that it is of.
    pub fn label(&self) -> String {
        let fit = match self.is_of_balance() {
            true => "energy balance",
            false => "square root",
        };
        self.named(self.of.film_ratio.map(|_| fit))
    }

    /// Its name in a sentence, whichever fit it is of.
    pub fn subject(&self) -> String {
        self.named(None)
    }

    fn named(&self, fit: Option<&str>) -> String {
        let own = described(&self.result, [Quantity::DeltaC, Quantity::EInf, Quantity::StC]);
        let name = own.map_or(self.result.as_str(), |own| own.symbol);
        match self.of.words(fit).as_str() {
            "" => name.to_owned(),
            of => format!("{name} ({of})"),
        }
    }
}

/// Elasticity of a result in one constant.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Elasticity {
    /// `viscosity`, `liquid_density`, `particle_density`, `roughness` or `film`: all of a kind by one factor;
    /// `viscosity[AK10]` and the like: one alone; `film_offset`: all films by one length, in units of their mean;
    /// `speed`: all speeds by one factor
    pub constant: String,
    /// d ln(result)/d ln(constant), to five decimals
    pub elasticity: f64,
    /// sd of the constant over its value, as the scene gives it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rel_sd: Option<f64>,
}

/// A scene and its runs with a constant changed.
struct Changed<'c> {
    setup: FitSetup<'c>,
    /// the energy balance there; `None` without one
    balance: Option<MovedBalance>,
}

/// The value of a result where a constant has changed; `None` where a fit gives none.
type AtChange = Box<dyn Fn(&Changed) -> Option<f64> + Send + Sync>;

/// A result that has a value and a standard error.
struct SensitiveResult {
    /// still without the constants
    blank: Sensitivity,
    at: AtChange,
}

impl SensitiveResult {
    /// By its name and its estimate times a factor; `None` where that has no uncertainty, or is zero, which has no share to
    /// move by.
    fn of(
        named: Sensitivity,
        estimate: &Estimate,
        factor: f64,
        at: impl Fn(&Changed) -> Option<f64> + Send + Sync + 'static,
    ) -> Option<SensitiveResult> {
        let (value, _) = estimate.value_and_scale().filter(|(value, _)| *value != 0.0)?;
        let blank = Sensitivity {
            value: factor * value,
            se: estimate.se.map(|se| factor * se),
            ..named
        };
        let at = Box::new(at);
        Some(SensitiveResult { blank, at })
    }
}

/// The parameters of the energy balance, and δc of those of its particles whose roughness is given.
fn of_balance(scene: &Scene, balance: &EnergyBalance) -> Vec<SensitiveResult> {
    let named = |result: &str| Sensitivity {
        result: result.to_owned(),
        fit: BALANCE,
        ..Sensitivity::default()
    };
    // k comes from the dry runs, which no constant enters
    let all = balance.parameters.iter().enumerate();
    let shared = all.filter(|(_, own)| own.kind.sphere().is_none());
    let parameters = shared.filter_map(|(place, own)| {
        let at = move |changed: &Changed| changed.balance.as_ref()?.parameters.get(place).copied();
        SensitiveResult::of(named(&own.name), &own.estimate, 1.0, at)
    });
    let particles = scene.particles.iter().enumerate();
    let held = particles.filter(|(_, particle)| balance.particles.contains(&particle.name));
    let lengths = held.filter_map(|(index, particle)| {
        let named = Sensitivity {
            of: EstimatePlace::of_particle(&particle.name, None),
            ..named(Quantity::DeltaC.describe().name)
        };
        let at = move |changed: &Changed| {
            let at = Place {
                roughness: changed.setup.scene.particles[index].roughness,
                ..Place::NONE
            };
            let l = *changed.balance.as_ref()?.parameters.first()?;
            Some(Quantity::DeltaC.value(&at, &Wetted::of_balance(f64::NAN, l)))
        };
        SensitiveResult::of(named, &balance.delta_c_over_roughness, particle.roughness?, at)
    });
    parameters.chain(lengths).collect()
}

/// What the energy balance gives and, at the film ratio shown of each particle, e_inf and St_c.
fn results(scene: &Scene, runs: &Runs, scaling: &[Scaling], balance: Option<&EnergyBalance>) -> Vec<SensitiveResult> {
    let mut results = balance.map_or_else(Vec::new, |balance| of_balance(scene, balance));
    for (sphere, of_sphere) in runs.spheres.iter().enumerate() {
        let Some(film_ratio) = reference_film_ratio(scene, runs, sphere) else {
            continue;
        };
        let particle = &scene.particles[of_sphere.particle].name;
        let named = |quantity: Quantity, diameter_m: Option<f64>, fit: &'static str| Sensitivity {
            result: quantity.describe().name.to_owned(),
            of: EstimatePlace::of_particle(particle, diameter_m).at(Some(film_ratio)),
            fit,
            ..Sensitivity::default()
        };
        let derived = balance.iter().flat_map(|balance| &balance.derived);
        for row in derived.filter(|row| row.sphere == sphere && row.film_ratio == film_ratio) {
            let place = row.place;
            for (quantity, estimate) in row.estimates.iter() {
                let named = named(quantity, row.diameter_m, BALANCE);
                let at = move |changed: &Changed| {
                    let places = &changed.balance.as_ref()?.at_places;
                    Some(places.get(place)?.as_ref()?.value(quantity))
                };
                results.extend(SensitiveResult::of(named, estimate, 1.0, at));
            }
        }
        let is_here = |law: &&Scaling| (law.sphere, law.film_ratio) == (sphere, Some(film_ratio));
        let is_quoted = |law: &&Scaling| law.law == WetLaw::Sqrt && law.verdict.passed;
        let Some(law) = scaling.iter().filter(is_quoted).find(is_here) else {
            continue;
        };
        for (place, quantity) in [Quantity::EInf, Quantity::StC].into_iter().enumerate() {
            let named = named(quantity, of_sphere.diameter, WetLaw::Sqrt.name());
            let series = law.series.clone();
            let at = move |changed: &Changed| {
                let series = &changed.setup.runs.series[series.clone()];
                Some(square_root_of(changed.setup, series)?[place])
            };
            results.extend(SensitiveResult::of(named, &law.estimates[quantity], 1.0, at));
        }
    }
    results
}
