//! Lists the results whose sensitivity is told, each with its value where the constants have changed.

use super::linearised::MovedBalance;
use super::sensitivity::{Sensitivity, BALANCE};
use crate::findings::balance::EnergyBalance;
use crate::findings::estimate::Estimate;
use crate::findings::film_groups::reference_film_ratio;
use crate::findings::places::EstimatePlace;
use crate::findings::scaling::{square_root_of, Scaling};
use crate::findings::wet_fit::FitSetup;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::runs::Runs;
use crate::scene::{Scene, WetLaw};

/// A scene and its runs with a constant changed.
pub(super) struct Changed<'c> {
    pub(super) setup: FitSetup<'c>,
    /// the energy balance there; `None` without one
    pub(super) balance: Option<MovedBalance>,
}

/// The value of a result where a constant has changed; `None` where a fit gives none.
type AtChange = Box<dyn Fn(&Changed) -> Option<f64> + Send + Sync>;

/// A result that has a value and a standard error.
pub(super) struct SensitiveResult {
    /// still without the constants
    pub(super) blank: Sensitivity,
    pub(super) at: AtChange,
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
pub(super) fn results(
    scene: &Scene,
    runs: &Runs,
    scaling: &[Scaling],
    balance: Option<&EnergyBalance>,
) -> Vec<SensitiveResult> {
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
