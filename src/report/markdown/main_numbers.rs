//! Writes the numbers a reader came for, and the literature's beside them.

use super::super::{numbers, quantities, ReportInput};
use super::cells::{diameter, fitted_runs, interval_header, law_name};
use super::constants::combined;
use super::escape::literal;
use super::page::Page;
use super::posterior::held;
use super::table::ReportTable;
use crate::findings::film_ratio::reference_film_ratio;
use crate::findings::form_choice::{ChosenBy, InertiaChoice, OtherForm};
use crate::findings::main_numbers::{MainNumbers, MainParameter, MainPlace, Source};
use crate::findings::published::PublishedComparison;
use crate::findings::scaling::Scaling;
use crate::findings::Findings;
use crate::physics::loss::{Film, Loss};
use crate::physics::quantity::Place;
use crate::physics::{Coefficient, Inertia, Quantity};
use crate::runs::Sphere;
use crate::scene::{DryKOf, WetLaw};

pub(super) fn main_numbers(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    let main = &findings.main;
    page.heading(if main.provisional {
        "Main numbers (provisional)"
    } else {
        "Main numbers"
    });
    let viscous = findings.form.viscous.definition("δ/D");
    let wet = match input.runs.series.is_empty() {
        true => String::new(),
        false => format!(
            " and e² = {}, with St = ρp D v/(9 η){}",
            findings.form.formula("δ/D"),
            viscous.map_or(String::new(), |l| format!(" and {l}")),
        ),
    };
    page.paragraph(&format!(
        "e_dry = {}{wet}. {}",
        findings.form.dry.formula("v"),
        &what_parameters_are(main, input),
    ));
    if let Some(choice) = &findings.inertia {
        let by = match choice.by {
            ChosenBy::LeastSquares => "the squares it leaves",
            ChosenBy::LeaveOneOut => "how it predicts runs it has not seen (PSIS-LOO)",
        };
        page.paragraph(&format!(
            "The form of the inertial loss, g = {}, was chosen from the runs by {by}; log density of the others over all runs, against it: {}.",
            choice.inertia.name(),
            others(choice)
        ));
    }
    if !main.parameters.is_empty() {
        page.table(&parameters(main, input));
    }
    if main.parameters.iter().any(|own| own.prior_led) {
        page.paragraph(
            "Prior-led: the runs leave this number more than half of the sd that its prior had, so that its value is mostly \
             what was believed before.",
        );
    }
    if let Some(text) = input.posterior.and_then(|posterior| held(&posterior.findings.left_out)) {
        page.paragraph(&text);
    }
    if input.scene.truth.is_some() {
        page.paragraph("Simulated from: what `[truth]` of the scene names; no fit reads it.");
    }
    if !main.at.is_empty() {
        page.paragraph(&what_places_are(main, input));
        let shown = places_shown(main, input);
        let others = main.at.len() - shown.len();
        page.table(&places(shown, input, true));
        if others > 0 {
            page.paragraph(&format!("{others} more stand under {OTHER_FILM_RATIOS}."));
        }
    }
    if let Some(text) = combined(input) {
        page.paragraph(&text);
    }
}

/// The places that stand for the others: of each particle one film ratio, or all of them where they are few.
pub(super) fn places_shown<'a>(main: &'a MainNumbers, input: ReportInput) -> Vec<&'a MainPlace> {
    const FEW: usize = 6;
    let spheres = || 0..input.runs.spheres.len();
    let stands_for_others = |place: &&MainPlace| {
        main.at.len() <= FEW
            || spheres().any(|sphere| {
                let own = &input.runs.spheres[sphere];
                input.scene.particles[own.particle].name == place.particle
                    && (place.diameter_m.is_none() || own.diameter.is_none() || own.diameter == place.diameter_m)
                    && reference_film_ratio(input.scene, input.runs, sphere) == Some(place.film_ratio)
            })
    };
    main.at.iter().filter(stands_for_others).collect()
}

/// e_inf and St_c at the film ratios that do not stand among the main numbers.
pub(super) fn other_film_ratios(page: &mut Page, input: ReportInput) {
    let main = &input.findings.main;
    let shown = places_shown(main, input);
    let others = main.at.iter().filter(|place| !shown.contains(place));
    let others: Vec<&MainPlace> = others.collect();
    if others.is_empty() {
        return;
    }
    page.section(
        OTHER_FILM_RATIOS,
        "As those among the main numbers; their intervals stand in `findings.json`.",
    );
    page.table(&places(others, input, false));
}

/// How far the forms that were not chosen are from the chosen one.
pub(super) fn others(choice: &InertiaChoice) -> String {
    let one = |other: &OtherForm| {
        let of_prior = other.prior_difference.map_or(String::new(), |difference| {
            format!(" ({} by the prior of its C)", numbers::signed_to(difference, 1))
        });
        format!(
            "{} {}{of_prior}",
            other.inertia.name(),
            numbers::signed_to(other.difference, 1)
        )
    };
    choice.others.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Where the parameters come from, and what their ± is.
fn what_parameters_are(main: &MainNumbers, input: ReportInput) -> String {
    if main.provisional {
        return "The posterior was not sampled: least squares stands in for it. ± is one standard error by the delta method; k \
                comes from the dry runs, the others from every rebound at once, together with what the dry runs say of k."
            .to_owned();
    }
    let few = main.parameters.iter().any(|own| own.number.source == Source::DryLaw);
    let of_few = if few {
        " k of a few dry runs alone is the dry law's, ± its standard error, the interval by Student's t: the prior of their \
         spread would make the posterior's wider than they say."
    } else {
        ""
    };
    let runs = fitted_runs(input);
    format!("Posterior means ± one standard deviation, from a joint fit to {runs}.{of_few}")
}

/// What e_inf and St_c are, and where those of the table come from.
fn what_places_are(main: &MainNumbers, input: ReportInput) -> String {
    let speed = numbers::short(input.scene.model.dry_speed.reference());
    let mut text = format!(
        "e_inf = √(e_dry² − C ρ̃ g) with e_dry at {speed} m/s, St_c = 2 L/e_inf², and nothing rebounds below 2 St_c."
    );
    let has = |source: Source| main.at.iter().any(|place| place.source == source);
    if has(Source::SquareRootLaw) {
        text.push_str(
            " From the square-root law, fitted at one film ratio with its liquids as one: ± is one standard error.",
        );
    }
    if has(Source::Posterior) {
        text.push_str(" From the posterior, for each liquid: ± is one standard deviation.");
        if has(Source::SquareRootLaw) {
            text.push_str(
                " It stands alone where a run stuck or carries measurement errors, with noise on the energy kept, and where \
                 taking liquids as one would bias the law.",
            );
        }
    }
    if has(Source::EnergyBalance) {
        text.push_str(
            " From the energy balance over all rebounds at once, at the mean density ratio of the runs: ± is one standard error.",
        );
    }
    text
}

fn parameters<'a>(main: &'a MainNumbers, input: ReportInput<'a>) -> ReportTable<&'a MainParameter> {
    let table = ReportTable::of(&main.parameters)
        .column("quantity", |row| label(input, row))
        .column("value", |row| quantities::main(row.quantity, &row.number))
        .column(interval_header(input), |row| {
            quantities::main_interval(row.quantity, &row.number)
        })
        .column("from", source);
    let Some(truth) = &input.scene.truth else {
        return table;
    };
    table.column(SIMULATED_FROM, |row| {
        let value = match row.sphere {
            Some(sphere) => true_k(input, &input.runs.spheres[sphere]),
            None => truth.of_quantity(row.quantity),
        };
        numbers::optional(value, 4)
    })
}

/// Where a parameter comes from, and what leads it.
pub(super) fn source(parameter: &MainParameter) -> String {
    let mut text = parameter.number.source.name().to_owned();
    if let Some(from) = parameter.from {
        text.push_str(&format!(", {from} alone"));
    }
    if parameter.prior_led {
        text.push_str(", prior-led");
    }
    text
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

/// The heading over the film ratios that do not stand among the main numbers.
const OTHER_FILM_RATIOS: &str = "Other film ratios";

/// The header of what simulated runs were drawn from.
const SIMULATED_FROM: &str = "simulated from";

/// e_inf and St_c at some places, with their intervals or without.
fn places<'a>(at: Vec<&'a MainPlace>, input: ReportInput, with_intervals: bool) -> ReportTable<&'a MainPlace> {
    let by_diameter = at.iter().any(|row| row.diameter_m.is_some());
    let of_one_source = at.windows(2).all(|pair| pair[0].source == pair[1].source);
    // of liquids pooled there is no one truth
    let is_simulated = input.scene.truth.is_some() && at.iter().any(|row| row.liquid.is_some());
    let mut table = ReportTable::of(at)
        .column("particle", |row| &row.particle)
        .column("δ/D", |row| numbers::short(row.film_ratio));
    if by_diameter {
        table = table.column("D / mm", |row| row.diameter_m.map(diameter));
    }
    let interval = interval_header(input);
    table = table.column("liquid", liquid);
    let number_of = |quantity: Quantity| {
        move |row: &'a MainPlace| match quantity {
            Quantity::EInf => &row.e_inf,
            _ => &row.st_c,
        }
    };
    for quantity in [Quantity::EInf, Quantity::StC] {
        let number = number_of(quantity);
        table = table.column(quantities::label(quantity), |row| {
            quantities::main(quantity, number(row))
        });
        if with_intervals {
            table = table.column(interval.clone(), |row| quantities::main_interval(quantity, number(row)));
        }
        if is_simulated {
            table = table.column(SIMULATED_FROM, |row| {
                numbers::optional(true_value(input, quantity, row), 4)
            });
        }
    }
    if of_one_source {
        return table;
    }
    table.column("from", |row| row.source.name())
}

/// What simulated runs were drawn from at a place of one liquid.
fn true_value(input: ReportInput, quantity: Quantity, place: &MainPlace) -> Option<f64> {
    let scene = input.scene;
    let particle = scene.particles.iter().position(|own| own.name == place.particle)?;
    let liquid = scene
        .liquids
        .iter()
        .find(|own| Some(&own.name) == place.liquid.as_ref())?;
    let film = Film {
        film_ratio: place.film_ratio,
        density_ratio: liquid.density / scene.particles[particle].density,
    };
    let reference = scene.model.dry_speed.reference();
    let sphere = Sphere {
        particle,
        diameter: place.diameter_m,
    };
    let wetted = scene.truth.as_ref()?.wetted(true_k(input, &sphere)?, film, reference)?;
    Some(quantity.value(&Place::NONE, &wetted))
}

/// The liquid of a place, or that its liquids are pooled.
fn liquid(place: &MainPlace) -> String {
    let pooled = || "pooled".to_owned();
    place.liquid.clone().unwrap_or_else(pooled)
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

pub(super) fn published(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.published.is_empty() {
        return;
    }
    page.section(
        "Beside the literature",
        "Difference: ours minus published, in combined standard errors.",
    );
    if input.scene.truth.is_some() {
        page.paragraph("These runs are simulated: agreement only shows how the truth was chosen.");
    }
    if input.scene.model.dry_k == DryKOf::Diameter {
        page.paragraph("A published number is of all diameters; a particle of several has none to set beside it here, where each has its own k.");
    }
    if findings.published.iter().any(|row| row.law == Some(WetLaw::Linear)) {
        page.paragraph(
            "A published linear law is compared with our linear law, which has the same bias and gives no main number; where that \
             bias makes it unusable, it has no ±.",
        );
    }
    let table = ReportTable::of(&findings.published)
        .column("particle", |row| &row.particle)
        .column("quantity", |row| symbol(row.quantity))
        .column("δ/D", |row| row.film_ratio.map_or("all".to_owned(), numbers::short))
        .column("law", |row| row.law.map(law_name))
        .column("ours", |row| match (row.ours, row.ours_se) {
            (Some(value), Some(se)) if is_usable(findings, row) => numbers::with_se(value, se),
            (value, _) => numbers::optional(value, 4),
        })
        // as published, not rounded again
        .column("published", |row| format!("{} ± {}", row.value, row.se))
        .column("difference", |row| row.difference_in_se.map(numbers::signed));
    page.table(&table);
    let published = input.scene.published.iter();
    let mut sources: Vec<String> = published.map(|published| literal(&published.source)).collect();
    sources.dedup();
    sources.sort_unstable();
    sources.dedup();
    page.paragraph(&format!("Published: {}.", sources.join("; ")));
}

/// Whether the fit that a published number is compared with is usable.
fn is_usable(findings: &Findings, published: &PublishedComparison) -> bool {
    let of_ours = |own: &&Scaling| [&own.e_inf, &own.st_c].iter().any(|own| own.value == published.ours);
    let law = findings.scaling.iter().find(of_ours);
    law.is_none_or(|law| law.verdict.passed)
}

/// The symbol of a quantity that can be published, by its name in files.
fn symbol(name: &str) -> &str {
    let published = [Quantity::DryK, Quantity::EInf, Quantity::StC].map(Quantity::describe);
    let own = published.into_iter().find(|quantity| quantity.name == name);
    own.map_or(name, |own| own.symbol)
}
