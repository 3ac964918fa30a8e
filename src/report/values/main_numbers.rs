//! Gathers the main numbers with their labels, and what simulated runs were drawn from.

use minijinja::{context, Value};

use super::super::template::with;
use super::super::{quantities, ReportInput};
use crate::findings::estimates::{EstimateRow, Source};
use crate::findings::film_groups::reference_film_ratio;
use crate::findings::places::EstimatePlace;
use crate::findings::published::PublishedComparison;
use crate::findings::Findings;
use crate::physics::loss::Film;
use crate::physics::quantity::Place;
use crate::physics::Quantity;
use crate::rounding;
use crate::runs::sphere_words;

/// e_inf and St_c of a place.
type Both = [EstimateRow; 2];

pub(super) fn values(input: ReportInput) -> Value {
    let findings = input.findings;
    let main = &findings.main;
    let (shown, other): (Vec<&Both>, Vec<&Both>) = main
        .places
        .iter()
        .partition(|[e_inf, _]| stands_for_others(&e_inf.of, input));
    // where the square-root law serves, the posterior of each liquid stands in the report alone
    let is_law = |[e_inf, _]: &Both| e_inf.source == Source::SquareRootLaw;
    let here = |[own, _]: &Both| own.of.of_all_liquids();
    let has_law = |place: &Both| shown.iter().any(|own| is_law(own) && here(own) == here(place));
    let in_summary = shown.iter().filter(|place| is_law(place) || !has_law(place));
    context! {
        parameters => main.parameters.iter().map(|own| told(own, input)).collect::<Vec<_>>(),
        places_shown => shown.iter().map(|own| place(own, input)).collect::<Vec<_>>(),
        other_places => other.iter().map(|own| place(own, input)).collect::<Vec<_>>(),
        summary_places => in_summary.map(|own| place(own, input)).collect::<Vec<_>>(),
        combined => combined(findings),
        published => findings.published.iter().map(published_row).collect::<Vec<_>>(),
    }
}

/// A place with its numbers by their quantities.
fn place([e_inf, st_c]: &Both, input: ReportInput) -> Value {
    let more = context! {
        words => place_name(&e_inf.of),
        e_inf => told(e_inf, input),
        st_c => told(st_c, input),
    };
    with(&e_inf.of, more)
}

/// A main number with its words.
fn told(own: &EstimateRow, input: ReportInput) -> Value {
    let quantity = own.kind.unwrap_or(Quantity::DryK);
    let more = context! {
        name => own.name(),
        label => quantities::label(quantity),
        sphere => own.of.particle.as_ref().map(|particle| sphere_words(particle, own.of.diameter_m)),
        factor => quantities::factor(quantity),
        is_exponential => own.is(Quantity::DeltaCOverRoughness),
        truth => true_value(input, own),
    };
    with(own, more)
}

/// Whether a place stands for the others: of each particle one film ratio, or all of them where they are few.
fn stands_for_others(place: &EstimatePlace, input: ReportInput) -> bool {
    const FEW: usize = 6;
    let (scene, runs) = (input.scene, input.runs);
    input.findings.main.places.len() <= FEW
        || runs.spheres.iter().enumerate().any(|(index, own)| {
            Some(&scene.particles[own.particle].name) == place.particle.as_ref()
                && (place.diameter_m.is_none() || own.diameter.is_none() || own.diameter == place.diameter_m)
                && reference_film_ratio(scene, runs, index) == place.film_ratio
        })
}

/// A place in a sentence, with its liquid.
fn place_name(place: &EstimatePlace) -> String {
    place.words(Some(place.liquid.as_deref().unwrap_or("liquids pooled")))
}

/// What simulated runs were drawn from; of liquids pooled, and of one k for all diameters where each has its own, there is no
/// one truth.
fn true_value(input: ReportInput, own: &EstimateRow) -> Option<f64> {
    let (scene, of) = (input.scene, &own.of);
    let truth = scene.truth.as_ref()?;
    let quantity = own.kind.unwrap_or(Quantity::DryK);
    let Some(name) = &of.particle else {
        return truth.of_quantity(quantity);
    };
    let particle = scene.particles.iter().position(|particle| particle.name == *name)?;
    let k = match of.diameter_m {
        Some(diameter) => truth.k(particle, diameter),
        None => truth.dry_k[particle].filter(|_| truth.dry_k_by_diameter[particle].is_empty()),
    };
    let Some(film_ratio) = of.film_ratio else {
        return k;
    };
    let mut liquids = scene.liquids.iter();
    let liquid = liquids.find(|own| Some(&own.name) == of.liquid.as_ref())?;
    let film = Film {
        film_ratio,
        density_ratio: liquid.density / scene.particles[particle].density,
    };
    let wetted = truth.wetted(k?, film, scene.model.dry_speed.reference())?;
    Some(quantity.value(&Place::NONE, &wetted))
}

/// The main numbers with what the scene says of its constants in their ±.
fn combined(findings: &Findings) -> Vec<String> {
    let told = |own: &EstimateRow| {
        let row = findings.constants.iter().find(|row| own.is_result(row))?;
        let (value, se) = own.number.pair()?;
        // what they add is a share that all fits have in common
        let widened = rounding::with_se(value, se.hypot(row.constants_sd? * value / row.value));
        let place = own.of.film_ratio.map(|_| format!(" ({})", place_name(&own.of)));
        let symbol = own.kind?.describe().symbol;
        Some(format!("{symbol}{} {widened}", place.unwrap_or_default()))
    };
    findings.main.rows().filter_map(told).collect()
}

/// A number of the literature beside ours.
fn published_row(own: &PublishedComparison) -> Value {
    let more = context! {
        symbol => own.symbol,
        usable => own.usable,
        // as published, not rounded again
        as_published => format!("{} ± {}", own.value, own.se),
    };
    with(own, more)
}
