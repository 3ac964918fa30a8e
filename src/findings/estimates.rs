//! Puts every estimate in a row of one table, which `findings.json` writes and frames of data are made from.
//!
//! A main number stands in its row as it is quoted; others have the standard error of their fit. Of one place and source a
//! quantity has one row.

use std::collections::HashMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::document::Findings;
use super::estimate::{Bootstrapped, Estimate};
use super::main_numbers::{MainNumber, Source};
use super::posterior::Posterior;
use crate::inference::delta::Interval;
use crate::physics::Quantity;
use crate::runs::Runs;
use crate::scene::{Scene, WetLaw};

/// One estimate.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EstimateRow {
    /// name of the quantity
    pub quantity: &'static str,
    /// what it is of
    #[serde(flatten)]
    pub of: EstimatePlace,
    /// whether it is one of the numbers that are quoted first
    pub main: bool,
    /// the number, in the unit of the quantity
    #[serde(flatten)]
    pub number: MainNumber,
    /// every interval that was made, by other methods and at other levels too; of least squares only
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub intervals: Vec<Interval>,
    /// what the replicates say; `None` where there are none
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bootstrap: Option<Bootstrapped>,
}

/// What an estimate is of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct EstimatePlace {
    /// name of the particle; `None` of what particles share
    pub particle: Option<String>,
    /// name of the liquid; `None` of what liquids share, and of several that are taken as one
    pub liquid: Option<String>,
    /// D, m; `None` of what diameters share
    pub diameter_m: Option<f64>,
    /// δ/D; `None` of what films share
    pub film_ratio: Option<f64>,
}

impl EstimatePlace {
    fn of_particle(particle: &str, diameter_m: Option<f64>) -> EstimatePlace {
        EstimatePlace {
            particle: Some(particle.to_owned()),
            diameter_m,
            ..EstimatePlace::default()
        }
    }

    fn at(self, film_ratio: Option<f64>) -> EstimatePlace {
        EstimatePlace { film_ratio, ..self }
    }
}

/// The estimates of a fit, those of the same source together.
pub fn list_estimates(
    scene: &Scene,
    runs: &Runs,
    findings: &Findings,
    posterior: Option<&Posterior>,
) -> Vec<EstimateRow> {
    let mut rows = posterior.map_or(vec![], |own| of_posterior(scene, runs, own));
    of_dry_laws(findings, &mut rows);
    of_balance(scene, runs, findings, &mut rows);
    of_film_ratios(findings, &mut rows);
    of_series(findings, &mut rows);
    // a table may have as many film ratios as runs
    let mut at: HashMap<_, Vec<usize>> = HashMap::new();
    for (place, row) in rows.iter().enumerate() {
        at.entry(row.of.film_ratio.map(f64::to_bits)).or_default().push(place);
    }
    for (quantity, of, number) in main_numbers(scene, runs, findings) {
        let is_it = |row: &EstimateRow| row.quantity == quantity && row.of == of && row.number.source == number.source;
        let here = at.get(&of.film_ratio.map(f64::to_bits)).into_iter().flatten();
        match here.copied().find(|place| is_it(&rows[*place])) {
            Some(place) => (rows[place].main, rows[place].number) = (true, number.clone()),
            None => rows.push(EstimateRow {
                quantity,
                of,
                main: true,
                number: number.clone(),
                intervals: vec![],
                bootstrap: None,
            }),
        }
    }
    rows
}

impl EstimateRow {
    fn of_fit(quantity: Quantity, of: EstimatePlace, estimate: &Estimate, source: Source) -> EstimateRow {
        EstimateRow {
            quantity: quantity.describe().name,
            of,
            main: false,
            number: MainNumber {
                se: estimate.se,
                ..MainNumber::of_fit(estimate, source)
            },
            intervals: estimate.intervals.clone(),
            bootstrap: estimate.bootstrap.clone(),
        }
    }
}

fn of_posterior(scene: &Scene, runs: &Runs, posterior: &Posterior) -> Vec<EstimateRow> {
    let found = &posterior.findings;
    let row = |quantity: &'static str, of: EstimatePlace, summary, draws: &[Vec<f64>]| EstimateRow {
        quantity,
        of,
        main: false,
        number: MainNumber::of_draws(summary, draws, scene.bootstrap.level),
        intervals: vec![],
        bootstrap: None,
    };
    let sampled = posterior
        .sampled
        .parameters
        .sampled
        .iter()
        .zip(&posterior.sampled.values);
    let parameters = found.parameters.iter().zip(sampled).map(|(summary, (own, draws))| {
        let of = own.kind.sphere().map(|sphere| of_sphere(scene, runs, sphere));
        row(own.kind.key(), of.unwrap_or_default(), summary, draws)
    });
    // each is sorted for its interval
    let derived = found.derived.par_iter().zip(&posterior.derived).map(|(summary, own)| {
        let of = match &own.setting {
            Some(setting) => EstimatePlace {
                particle: Some(scene.particles[setting.particle].name.clone()),
                liquid: Some(scene.liquids[setting.liquid].name.clone()),
                diameter_m: setting.diameter,
                film_ratio: Some(setting.film_ratio),
            },
            None => EstimatePlace {
                particle: own.label.clone(),
                ..EstimatePlace::default()
            },
        };
        row(own.quantity.describe().name, of, summary, &own.values)
    });
    parameters.chain(derived.collect::<Vec<_>>()).collect()
}

fn of_sphere(scene: &Scene, runs: &Runs, sphere: usize) -> EstimatePlace {
    let sphere = &runs.spheres[sphere];
    EstimatePlace::of_particle(&scene.particles[sphere.particle].name, sphere.diameter)
}

fn of_dry_laws(findings: &Findings, rows: &mut Vec<EstimateRow>) {
    for dry in &findings.dry {
        let own = (dry.diameter_m, &dry.dry_k);
        let several = dry.by_diameter.len() > 1;
        let by_diameter = dry
            .by_diameter
            .iter()
            .filter(|_| several)
            .map(|one| (Some(one.diameter_m), &one.dry_k));
        rows.extend([own].into_iter().chain(by_diameter).map(|(diameter, estimate)| {
            let of = EstimatePlace::of_particle(&dry.particle, diameter);
            EstimateRow::of_fit(Quantity::DryK, of, estimate, Source::DryLaw)
        }));
    }
}

fn of_balance(scene: &Scene, runs: &Runs, findings: &Findings, rows: &mut Vec<EstimateRow>) {
    let Some(balance) = &findings.energy_balance else {
        return;
    };
    let row = |quantity, of, estimate| EstimateRow::of_fit(quantity, of, estimate, Source::EnergyBalance);
    rows.extend(balance.parameters.iter().filter_map(|own| {
        let of = own.kind.sphere().map(|sphere| of_sphere(scene, runs, sphere));
        Some(row(own.kind.quantity()?, of.unwrap_or_default(), &own.estimate))
    }));
    let ratio = &balance.delta_c_over_roughness;
    rows.push(row(Quantity::DeltaCOverRoughness, EstimatePlace::default(), ratio));
    rows.extend(balance.derived.iter().flat_map(|own| {
        let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(Some(own.film_ratio));
        [(Quantity::EInf, &own.e_inf), (Quantity::StC, &own.st_c)].map(|(quantity, one)| row(quantity, of.clone(), one))
    }));
}

fn of_film_ratios(findings: &Findings, rows: &mut Vec<EstimateRow>) {
    let source = |law| match law {
        WetLaw::Sqrt => Source::SquareRootLaw,
        WetLaw::Linear => Source::LinearLaw,
    };
    for own in &findings.scaling {
        let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(own.film_ratio);
        let end = own.st_no_rebound.as_ref().map(|end| (Quantity::StNoRebound, end));
        let numbers = [(Quantity::EInf, &own.e_inf), (Quantity::StC, &own.st_c)]
            .into_iter()
            .chain(end);
        rows.extend(numbers.map(|(quantity, one)| EstimateRow::of_fit(quantity, of.clone(), one, source(own.law))));
    }
    for own in &findings.energy {
        let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(Some(own.film_ratio));
        let numbers = [
            (Quantity::InertialLoss, &own.loss_over_density_ratio),
            (Quantity::StCEInf2, &own.st_c_e_inf2),
            (Quantity::DeltaC, &own.delta_c_m),
        ];
        rows.extend(numbers.map(|(quantity, one)| EstimateRow::of_fit(quantity, of.clone(), one, source(own.law))));
    }
}

fn of_series(findings: &Findings, rows: &mut Vec<EstimateRow>) {
    for own in &findings.series {
        let of = EstimatePlace {
            liquid: Some(own.liquid.clone()),
            ..EstimatePlace::of_particle(&own.particle, Some(own.diameter_m)).at(Some(own.film_ratio))
        };
        let numbers = [
            (Quantity::Alpha, &own.alpha),
            (Quantity::Beta, &own.beta),
            (Quantity::EInf, &own.e_inf),
            (Quantity::ThresholdSpeed, &own.threshold_speed_m_s),
        ];
        let row = |(quantity, one)| EstimateRow::of_fit(quantity, of.clone(), one, Source::SquareRootLaw);
        rows.extend(numbers.map(row));
    }
}

/// The main numbers, each with the place that its row has: a law of several liquids has none of one.
fn main_numbers<'f>(
    scene: &'f Scene,
    runs: &'f Runs,
    findings: &'f Findings,
) -> impl Iterator<Item = (&'static str, EstimatePlace, &'f MainNumber)> {
    let parameters = findings.main.parameters.iter().map(move |own| {
        let of = own.sphere.map(|sphere| of_sphere(scene, runs, sphere));
        (own.quantity.describe().name, of.unwrap_or_default(), &own.number)
    });
    let places = findings.main.at.iter().flat_map(|own| {
        let of = EstimatePlace {
            liquid: own.liquid.clone().filter(|_| own.source == Source::Posterior),
            ..EstimatePlace::of_particle(&own.particle, own.diameter_m).at(Some(own.film_ratio))
        };
        let numbers = [(Quantity::EInf, &own.e_inf), (Quantity::StC, &own.st_c)];
        numbers.map(|(quantity, number)| (quantity.describe().name, of.clone(), number))
    });
    parameters.chain(places)
}
