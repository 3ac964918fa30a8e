//! Writes the numbers a reader came for, and the literature's beside them.

use super::super::{numbers, quantities, ReportInput};
use super::cells::{diameter, interval_header, law_name};
use super::constants::combined;
use super::escape::literal;
use super::page::Page;
use super::posterior::held;
use super::table::ReportTable;
use super::verdict::verdict_line;
use crate::findings::balance::DerivedEstimate;
use crate::findings::estimate::Estimate;
use crate::findings::posterior::QuantitySummary;
use crate::model::parameters::ParameterKind;
use crate::physics::loss::Loss;
use crate::physics::{Coefficient, Quantity};
use crate::scene::WetLaw;

pub(super) fn main_numbers(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading("Main numbers");
    let viscous = findings.form.viscous.definition("δ/D");
    page.paragraph(&format!(
        "e_dry = {} and e² = {}, with St = ρp D v/(9 η){}. \
         ± is one standard error (least squares, delta method); k comes from the dry runs, \
         the others from every rebound at once, together with what the dry runs say of k.",
        findings.form.dry.formula("v"),
        findings.form.formula("δ/D"),
        viscous.map_or(String::new(), |l| format!(" and {l}"))
    ));
    if input.posterior.is_some() {
        page.paragraph(
            "Beside them stands the posterior of all runs at once, the stuck ones with them: there ± is one standard \
             deviation about the mean.",
        );
    }
    let rows = numbers_of(input);
    if !rows.is_empty() {
        page.table(&table(&rows, input));
    }
    if let Some(text) = input.posterior.and_then(|posterior| held(&posterior.findings.left_out)) {
        page.paragraph(&text);
    }
    let speed = numbers::short(input.scene.model.dry_speed.reference());
    if let Some(derived) = derived(input) {
        page.paragraph(&format!(
            "From these follow, at each film ratio{}, e_inf = √(e_dry² − C ρ̃ g) with e_dry at {speed} m/s, St_c = 2 L/e_inf², \
             and 2 St_c, below which nothing rebounds.",
            if tells_diameters_apart(derived) { " and diameter" } else { "" }
        ));
        page.table(&of_film_ratios(derived, &interval_header(input)));
    } else if !findings.scaling.is_empty() {
        let why = match &findings.energy_balance {
            None => "Without dry runs there is no energy balance",
            Some(_) => "The energy balance may not be quoted",
        };
        page.paragraph(&format!(
            "{why}: e_inf and St_c are the direct fits under Film thickness."
        ));
    }
    if let Some(text) = combined(input) {
        page.paragraph(&text);
    }
}

/// e_inf and St_c of the energy balance, where it may be quoted.
fn derived(input: ReportInput<'_>) -> Option<&[DerivedEstimate]> {
    let balance = input.findings.energy_balance.as_ref()?;
    (balance.verdict.passed && !balance.derived.is_empty()).then_some(balance.derived.as_slice())
}

/// Whether e_inf and St_c are given of each diameter.
fn tells_diameters_apart(derived: &[DerivedEstimate]) -> bool {
    derived.iter().any(|row| row.diameter_m.is_some())
}

/// e_inf and St_c of each particle and film ratio, and of each diameter where they belong to one.
fn of_film_ratios<'a>(derived: &'a [DerivedEstimate], level: &str) -> ReportTable<&'a DerivedEstimate> {
    let mut table = ReportTable::of(derived)
        .column("particle", |row| &row.particle)
        .column("δ/D", |row| numbers::short(row.film_ratio));
    if tells_diameters_apart(derived) {
        table = table.column("D / mm", |row| row.diameter_m.map(diameter));
    }
    table
        .estimate_and_interval(Quantity::EInf, |row| &row.e_inf, level)
        .estimate_and_interval(Quantity::StC, |row| &row.st_c, level)
        .column(Quantity::StNoRebound.describe().symbol, |row| {
            numbers::estimate_scaled(&row.st_c, |st_c| 2.0 * st_c)
        })
        .column("corr(e_inf, St_c)", |row| numbers::optional(row.correlation, 2))
}

/// A main number by least squares, by the posterior, or both.
struct MainNumber<'a> {
    quantity: Quantity,
    /// its name in files
    name: String,
    /// its name in tables
    label: String,
    estimate: Option<&'a Estimate>,
    posterior: Option<&'a QuantitySummary>,
}

fn table<'a>(rows: &'a [MainNumber], input: ReportInput) -> ReportTable<&'a MainNumber<'a>> {
    let table = ReportTable::of(rows)
        .column("quantity", |row| &row.label)
        .column("value", |row| row.estimate.map(numbers::estimate))
        .column(interval_header(input), |row| row.estimate.map(numbers::interval));
    if input.posterior.is_none() {
        return table;
    }
    table.column("posterior mean ± sd", |row| {
        row.posterior.map(|q| quantities::mean_and_sd(row.quantity, q))
    })
}

impl<'a> MainNumber<'a> {
    fn new(
        input: ReportInput<'a>,
        quantity: Quantity,
        particle: Option<&str>,
        estimate: Option<&'a Estimate>,
    ) -> MainNumber<'a> {
        let name = quantity.describe().name;
        let label = label(input, quantity);
        let (name, label) = match particle {
            Some(particle) => (format!("{name}[{particle}]"), format!("{label}, {particle}")),
            None => (name.to_owned(), label),
        };
        let found = input.posterior.map(|posterior| &posterior.findings);
        let mut sampled = found
            .iter()
            .flat_map(|found| found.parameters.iter().chain(&found.derived));
        MainNumber {
            quantity,
            posterior: sampled.find(|sampled| sampled.name == name),
            name,
            label,
            estimate,
        }
    }
}

/// k of each particle, what the energy balance gives, δc/ε: each that least squares or the posterior has.
fn numbers_of(input: ReportInput<'_>) -> Vec<MainNumber<'_>> {
    let new = |quantity, particle, estimate| MainNumber::new(input, quantity, particle, estimate);
    let balance = input.findings.energy_balance.as_ref();
    let of_particles = input.scene.particles.iter().map(|particle| {
        let dry = input.findings.dry.iter().find(|dry| dry.particle == particle.name);
        new(Quantity::DryK, Some(&particle.name), dry.map(|dry| &dry.dry_k))
    });
    let of_balance = Coefficient::ALL.into_iter().map(|coefficient| {
        let estimate = balance.and_then(|balance| balance.estimate(ParameterKind::Shared(coefficient)));
        new(Quantity::Shared(coefficient), None, estimate)
    });
    let has_delta_c = input.scene.model.viscous.why_no_critical_separation().is_none();
    let delta_c = balance
        .filter(|_| has_delta_c)
        .map(|balance| &balance.delta_c_over_roughness);
    of_particles
        .chain(of_balance)
        .chain([new(Quantity::DeltaCOverRoughness, None, delta_c)])
        .filter(|number| number.estimate.is_some() || number.posterior.is_some())
        .collect()
}

/// How a main number is labelled, with what its value cannot be read without.
fn label(input: ReportInput, quantity: Quantity) -> String {
    let label = quantities::label(quantity);
    match quantity {
        Quantity::Shared(Coefficient::InertialPrefactor) => {
            let fitted = input.findings.energy_balance.as_ref().map(|balance| balance.inertia);
            let sampled = || Some(input.posterior?.findings.inertia);
            format!("{label} ({})", fitted.or_else(sampled).unwrap_or_default())
        }
        Quantity::Shared(Coefficient::FilmScale) => format!("{label}, film scale"),
        Quantity::DeltaCOverRoughness => format!("{label} = exp(L)"),
        _ => label,
    }
}

pub(super) fn published(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.published.is_empty() {
        return;
    }
    page.heading("Beside the literature");
    page.paragraph("Difference: ours minus published, in combined standard errors.");
    let table = ReportTable::of(&findings.published)
        .column("particle", |row| &row.particle)
        .column("quantity", |row| symbol(row.quantity))
        .column("δ/D", |row| row.film_ratio.map_or("all".to_owned(), numbers::short))
        .column("law", |row| row.law.map(law_name))
        .column("ours", |row| match (row.ours, row.ours_se) {
            (Some(value), Some(se)) => numbers::with_se(value, se),
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

/// The symbol of a quantity that can be published, by its name in files.
fn symbol(name: &str) -> &str {
    let published = [Quantity::DryK, Quantity::EInf, Quantity::StC].map(Quantity::describe);
    let own = published.into_iter().find(|quantity| quantity.name == name);
    own.map_or(name, |own| own.symbol)
}

/// The first of some lines for a terminal, and how many more there are.
fn first_of(lines: Vec<String>) -> String {
    const SHOWN: usize = 20;
    let mut text = lines.iter().take(SHOWN).map(String::as_str).collect::<String>();
    if lines.len() > SHOWN {
        text.push_str(&format!(
            "and {} more lines of this kind in findings.json\n",
            lines.len() - SHOWN
        ));
    }
    text
}

/// The main numbers as lines for a terminal.
pub fn summary(input: ReportInput) -> String {
    let findings = input.findings;
    let mut text = verdict_line(findings).replace("**", "");
    text.push('\n');
    let numbers = numbers_of(input);
    for number in numbers
        .iter()
        .filter(|number| number.quantity != Quantity::DeltaCOverRoughness)
    {
        let least_squares = number.estimate.map(numbers::estimate);
        let posterior = number.posterior.map(|q| quantities::mean_and_sd(number.quantity, q));
        let both = match (least_squares, posterior) {
            (Some(least_squares), Some(posterior)) => format!("{least_squares} (se); posterior {posterior} (sd)"),
            (Some(least_squares), None) => least_squares,
            (None, posterior) => format!("posterior {} (sd)", posterior.unwrap_or_default()),
        };
        text.push_str(&format!("{} = {both}\n", number.name));
    }
    let [e_inf, st_c] = [Quantity::EInf, Quantity::StC].map(|quantity| quantity.describe().symbol);
    let line = |particle: &str, ratio: f64, of_one: Option<f64>, both: [&Estimate; 2]| {
        let [of_e_inf, of_st_c] = both.map(numbers::estimate);
        let ratio = numbers::short(ratio);
        let of_one = of_one.map_or(String::new(), |d| format!(", D = {} mm", diameter(d)));
        format!("{particle}, δ/D = {ratio}{of_one}: {e_inf} = {of_e_inf}, {st_c} = {of_st_c}\n")
    };
    match derived(input) {
        Some(derived) => {
            let lines = derived
                .iter()
                .map(|row| line(&row.particle, row.film_ratio, row.diameter_m, [&row.e_inf, &row.st_c]));
            text.push_str(&first_of(lines.collect()));
        }
        // without an energy balance the direct fits are what there is
        None => {
            let direct = findings.scaling.iter().filter(|row| row.law == WetLaw::Sqrt);
            let lines =
                direct.filter_map(|row| Some(line(&row.particle, row.film_ratio?, None, [&row.e_inf, &row.st_c])));
            text.push_str(&first_of(lines.collect()));
        }
    }
    text
}
