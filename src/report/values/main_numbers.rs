//! Gathers the main numbers with their labels, and what simulated runs were drawn from.

use minijinja::{context, Value};

use super::super::template::{serialized, with};
use super::super::{quantities, ReportInput};
use crate::findings::constants::Sensitivity;
use crate::findings::film_groups::reference_film_ratio;
use crate::findings::main_numbers::{MainNumber, MainParameter, MainPlace, Source};
use crate::findings::published::PublishedComparison;
use crate::findings::scaling::Scaling;
use crate::findings::Findings;
use crate::physics::loss::Film;
use crate::physics::quantity::Place;
use crate::physics::{Coefficient, Inertia, Quantity};
use crate::rounding;
use crate::runs::Sphere;
use crate::units::millimetres;

pub(super) fn values(input: ReportInput) -> Value {
    let findings = input.findings;
    let main = &findings.main;
    let (shown, other): (Vec<&MainPlace>, Vec<&MainPlace>) =
        main.at.iter().partition(|place| stands_for_others(place, input));
    // where the square-root law serves, the posterior of each liquid stands in the report alone
    let is_law = |place: &MainPlace| place.source == Source::SquareRootLaw;
    let is_same = |a: &MainPlace, b: &MainPlace| {
        (&a.particle, a.film_ratio, a.diameter_m) == (&b.particle, b.film_ratio, b.diameter_m)
    };
    let has_law = |place: &MainPlace| shown.iter().any(|own| is_law(own) && is_same(own, place));
    let in_summary = shown.iter().filter(|place| is_law(place) || !has_law(place));
    let place = |own: &&MainPlace| {
        let truth = |quantity: Quantity| true_value(input, quantity, own);
        let more = context! {
            words => place_name(own),
            source_words => own.source.name(),
            true_e_inf => truth(Quantity::EInf),
            true_st_c => truth(Quantity::StC),
        };
        with(own, more)
    };
    let held = input
        .posterior
        .iter()
        .flat_map(|posterior| &posterior.findings.left_out);
    let held = held.filter_map(|own| Some(context! { name => own.name.as_str(), value => own.value? }));
    let published = input.scene.published.iter();
    let mut sources: Vec<&str> = published.map(|published| published.source.as_str()).collect();
    sources.sort_unstable();
    sources.dedup();
    context! {
        parameters => main.parameters.iter().map(|own| parameter(own, input)).collect::<Vec<_>>(),
        places_shown => shown.iter().map(place).collect::<Vec<_>>(),
        other_places => other.iter().map(place).collect::<Vec<_>>(),
        summary_places => in_summary.map(place).collect::<Vec<_>>(),
        held => held.collect::<Vec<_>>(),
        combined => combined(findings),
        published => findings.published.iter().map(|own| published_row(findings, own)).collect::<Vec<_>>(),
        sources => serialized(sources),
    }
}

fn parameter(own: &MainParameter, input: ReportInput) -> Value {
    let truth = input.scene.truth.as_ref();
    let truth = truth.and_then(|truth| match own.sphere {
        Some(sphere) => true_k(input, &input.runs.spheres[sphere]),
        None => truth.of_quantity(own.quantity),
    });
    let derived = input.posterior.map(|posterior| posterior.findings.derived.as_slice());
    let mut derived = derived.unwrap_or_default().iter();
    let more = context! {
        label => label(input, own),
        median => derived.find(|summary| summary.name == own.quantity.describe().name).map(|summary| summary.median),
        factor => quantities::in_unit(own.quantity, 1.0),
        is_exponential => own.quantity == Quantity::DeltaCOverRoughness,
        source_words => own.number.source.name(),
        truth,
    };
    with(own, more)
}

/// How a parameter is labelled, with what its value cannot be read without.
fn label(input: ReportInput, parameter: &MainParameter) -> String {
    let label = quantities::label(parameter.quantity);
    match (parameter.quantity, parameter.sphere) {
        (_, Some(sphere)) => format!("{label}, {}", input.runs.spheres[sphere].words(input.scene)),
        (Quantity::Shared(Coefficient::InertialPrefactor), None) => {
            let fitted = input.findings.energy_balance.as_ref().map(|balance| balance.inertia);
            let sampled = input.posterior.map(|posterior| posterior.findings.inertia);
            format!("{label} ({})", sampled.or(fitted).map_or("", Inertia::name))
        }
        (Quantity::Shared(Coefficient::FilmScale), None) => format!("{label}, film scale"),
        (Quantity::DeltaCOverRoughness, None) => format!("{label} = exp(L)"),
        (_, None) => label,
    }
}

/// Whether a place stands for the others: of each particle one film ratio, or all of them where they are few.
fn stands_for_others(place: &MainPlace, input: ReportInput) -> bool {
    const FEW: usize = 6;
    let (scene, runs) = (input.scene, input.runs);
    input.findings.main.at.len() <= FEW
        || runs.spheres.iter().enumerate().any(|(index, own)| {
            scene.particles[own.particle].name == place.particle
                && (place.diameter_m.is_none() || own.diameter.is_none() || own.diameter == place.diameter_m)
                && reference_film_ratio(scene, runs, index) == Some(place.film_ratio)
        })
}

/// A place in a sentence: particle, film ratio, diameter where it is of one, liquid.
fn place_name(place: &MainPlace) -> String {
    let diameter = place.diameter_m.map(|d| rounding::short(millimetres(d)));
    let diameter = diameter.map_or(String::new(), |d| format!(", D = {d} mm"));
    let liquid = place.liquid.as_deref().unwrap_or("liquids pooled");
    format!(
        "{}, δ/D = {}{diameter}, {liquid}",
        place.particle,
        rounding::short(place.film_ratio)
    )
}

/// The k that simulated runs of a sphere were drawn with.
fn true_k(input: ReportInput, sphere: &Sphere) -> Option<f64> {
    let truth = input.scene.truth.as_ref()?;
    match sphere.diameter {
        Some(diameter) => truth.k(sphere.particle, diameter),
        // one k for all diameters has no truth where each has its own
        None => truth.dry_k[sphere.particle].filter(|_| truth.dry_k_by_diameter[sphere.particle].is_empty()),
    }
}

/// What simulated runs were drawn from at a place of one liquid; of liquids pooled there is no one truth.
fn true_value(input: ReportInput, quantity: Quantity, place: &MainPlace) -> Option<f64> {
    let scene = input.scene;
    let particle = scene.particles.iter().position(|own| own.name == place.particle)?;
    let mut liquids = scene.liquids.iter();
    let liquid = liquids.find(|own| Some(&own.name) == place.liquid.as_ref())?;
    let film = Film {
        film_ratio: place.film_ratio,
        density_ratio: liquid.density / scene.particles[particle].density,
    };
    let sphere = Sphere {
        particle,
        diameter: place.diameter_m,
    };
    let reference = scene.model.dry_speed.reference();
    let wetted = scene.truth.as_ref()?.wetted(true_k(input, &sphere)?, film, reference)?;
    Some(quantity.value(&Place::NONE, &wetted))
}

/// The main numbers with what the scene says of its constants in their ±.
fn combined(findings: &Findings) -> Vec<String> {
    let (main, rows) = (&findings.main, &findings.constants);
    let parameters = main.parameters.iter().filter_map(|own| {
        let row = rows.iter().find(|row| row.is_of_balance() && row.result == own.name)?;
        Some(format!(
            "{} {}",
            own.quantity.describe().symbol,
            widened(row, &own.number)?
        ))
    });
    let places = main.at.iter().flat_map(|place| {
        rows.iter().filter_map(move |row| {
            let (quantity, number) = place.of_result(row)?;
            let (symbol, place) = (quantity.describe().symbol, place_name(place));
            Some(format!("{symbol} ({place}) {}", widened(row, number)?))
        })
    });
    parameters.chain(places).collect()
}

/// A number with what the constants add to its ±, as a share of it that all fits have in common.
fn widened(row: &Sensitivity, number: &MainNumber) -> Option<String> {
    let (value, se) = number.value.zip(number.se)?;
    let of_constants = row.constants_sd? * value / row.value;
    Some(rounding::with_se(value, se.hypot(of_constants)))
}

/// A number of the literature, with whether the fit that it is compared with is usable.
fn published_row(findings: &Findings, own: &PublishedComparison) -> Value {
    let of_ours = |law: &&Scaling| [&law.e_inf, &law.st_c].iter().any(|number| number.value == own.ours);
    let law = findings.scaling.iter().find(of_ours);
    let published = [Quantity::DryK, Quantity::EInf, Quantity::StC].map(Quantity::describe);
    let quantity = published.into_iter().find(|quantity| quantity.name == own.quantity);
    let more = context! {
        symbol => quantity.map_or(own.quantity, |quantity| quantity.symbol),
        usable => law.is_none_or(|law| law.verdict.passed),
        // as published, not rounded again
        as_published => format!("{} ± {}", own.value, own.se),
    };
    with(own, more)
}
