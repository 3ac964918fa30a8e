//! Tells the numbers a reader came for, and the literature's beside them.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::{interval_header, law_name};
use super::constants::combined;
use super::escape::literal;
use super::page::Page;
use super::posterior::held;
use super::verdict::verdict_line;
use crate::findings::balance::DerivedEstimate;
use crate::findings::estimate::Estimate;
use crate::findings::posterior::QuantitySummary;
use crate::scene::WetLaw;

pub(super) fn main_numbers(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("Main numbers");
    page.paragraph(&format!(
        "e_dry = {} and e² = {}, with St = ρp D v/(9 η) and L = ln(δc/ε). \
         ± is one standard error (least squares, delta method); k comes from the dry runs, \
         the others from every rebound at once, together with what the dry runs say of k.",
        findings.form.dry.formula("v"),
        findings.form.formula("δ/D")
    ));
    if told.posterior.is_some() {
        page.paragraph(
            "Beside them stands the posterior of all runs at once, the stuck ones with them: there ± is one standard \
             deviation about the mean.",
        );
    }
    let level = interval_header(told);
    let mut header = vec!["quantity", "value", &level];
    header.extend(told.posterior.map(|_| "posterior mean ± sd"));
    let rows: Vec<Vec<String>> = parameters(told).iter().map(|row| row.cells(told)).collect();
    if !rows.is_empty() {
        page.table(&header, &rows);
    }
    if let Some(text) = told.posterior.and_then(|posterior| held(&posterior.findings.left_out)) {
        page.paragraph(&text);
    }
    let speed = numbers::short(told.scene.model.dry_speed.reference());
    if let Some(derived) = derived(told) {
        page.paragraph(&format!(
            "From these follow, at each film ratio, e_inf = √(e_dry² − C ρ̃ g) with e_dry at {speed} m/s, St_c = 2 L/e_inf², \
             and 2 St_c, below which nothing rebounds."
        ));
        let rows: Vec<Vec<String>> = derived
            .iter()
            .map(|row| {
                vec![
                    row.particle.clone(),
                    numbers::short(row.film_ratio),
                    numbers::estimate(&row.e_inf),
                    numbers::interval(&row.e_inf),
                    numbers::estimate(&row.st_c),
                    numbers::interval(&row.st_c),
                    numbers::estimate_scaled(&row.st_c, |st_c| 2.0 * st_c),
                    numbers::optional(row.correlation, 2),
                ]
            })
            .collect();
        page.table(
            &[
                "particle",
                "δ/D",
                "e_inf",
                &level,
                "St_c",
                &level,
                "2 St_c",
                "corr(e_inf, St_c)",
            ],
            &rows,
        );
    } else if !findings.scaling.is_empty() {
        let why = match &findings.energy_balance {
            None => "Without dry runs there is no energy balance",
            Some(_) => "The energy balance may not be quoted",
        };
        page.paragraph(&format!(
            "{why}: e_inf and St_c are the direct fits under Film thickness."
        ));
    }
    if let Some(text) = combined(told) {
        page.paragraph(&text);
    }
}

/// e_inf and St_c of the energy balance, where it may be quoted.
fn derived(told: Told<'_>) -> Option<&[DerivedEstimate]> {
    let balance = told.findings.energy_balance.as_ref()?;
    (balance.verdict.passed && !balance.derived.is_empty()).then_some(balance.derived.as_slice())
}

/// A main number by least squares, by the posterior, or both.
struct Row<'a> {
    /// its name in files
    key: String,
    label: String,
    estimate: Option<&'a Estimate>,
    quantity: Option<&'a QuantitySummary>,
}

impl Row<'_> {
    fn cells(&self, told: Told) -> Vec<String> {
        let estimate = |text: fn(&Estimate) -> String| self.estimate.map_or(NONE.to_owned(), text);
        let mut cells = vec![
            self.label.clone(),
            estimate(numbers::estimate),
            estimate(numbers::interval),
        ];
        if told.posterior.is_some() {
            cells.push(
                self.quantity
                    .map_or(NONE.to_owned(), |q| numbers::mean_and_sd(q, |x| x)),
            );
        }
        cells
    }
}

/// k of each particle, what the energy balance gives, δc/ε: each that least squares or the posterior has.
fn parameters(told: Told<'_>) -> Vec<Row<'_>> {
    let mut keys: Vec<(String, String, Option<&Estimate>)> = vec![];
    for particle in &told.scene.particles {
        let dry = told.findings.dry.iter().find(|dry| dry.particle == particle.name);
        let label = format!("k / (m/s)^(−1/5), {}", particle.name);
        keys.push((format!("dry_k[{}]", particle.name), label, dry.map(|dry| &dry.dry_k)));
    }
    let balance = told.findings.energy_balance.as_ref();
    let inertia = balance.map(|balance| balance.inertia);
    let inertia = inertia.or(told.posterior.map(|posterior| posterior.findings.inertia));
    for key in ["lubrication_log", "inertial_prefactor", "film_scale"] {
        let mut fitted = balance.iter().flat_map(|balance| &balance.parameters);
        let estimate = fitted
            .find(|parameter| parameter.name == key)
            .map(|found| &found.estimate);
        let label = parameter_name(key, inertia.unwrap_or_default()).unwrap_or_default();
        keys.push((key.to_owned(), label, estimate));
    }
    let delta_c = balance.map(|balance| &balance.delta_c_over_roughness);
    keys.push(("delta_c_over_roughness".to_owned(), "δc/ε = exp(L)".to_owned(), delta_c));
    let quantity = |key: &str| {
        let found = &told.posterior?.findings;
        found.parameters.iter().chain(&found.derived).find(|q| q.name == key)
    };
    keys.into_iter()
        .map(|(key, label, estimate)| Row {
            quantity: quantity(&key),
            key,
            label,
            estimate,
        })
        .filter(|row| row.estimate.is_some() || row.quantity.is_some())
        .collect()
}

/// How the report names a parameter of the energy balance; k is told from the dry runs alone.
fn parameter_name(name: &str, inertia: &str) -> Option<String> {
    match name {
        "lubrication_log" => Some("L".to_owned()),
        "inertial_prefactor" => Some(format!("C ({inertia})")),
        "film_scale" => Some("δ̃0, film scale".to_owned()),
        _ => None,
    }
}

pub(super) fn published(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.published.is_empty() {
        return;
    }
    page.heading("Beside the literature");
    page.paragraph("Difference: ours minus published, in combined standard errors.");
    let rows: Vec<Vec<String>> = findings
        .published
        .iter()
        .map(|row| {
            let ours = match (row.ours, row.ours_se) {
                (Some(value), Some(se)) => numbers::with_se(value, se),
                (value, _) => numbers::optional(value, 4),
            };
            vec![
                row.particle.clone(),
                symbol(row.quantity).to_owned(),
                row.film_ratio.map_or("all".to_owned(), numbers::short),
                row.law.map_or(NONE.to_owned(), law_name),
                ours,
                // as published, not rounded again
                format!("{} ± {}", row.value, row.se),
                row.difference_in_se.map_or(NONE.to_owned(), numbers::signed),
            ]
        })
        .collect();
    page.table(
        &["particle", "quantity", "δ/D", "law", "ours", "published", "difference"],
        &rows,
    );
    let published = told.scene.published.iter();
    let mut sources: Vec<String> = published.map(|published| literal(&published.source)).collect();
    sources.dedup();
    sources.sort_unstable();
    sources.dedup();
    page.paragraph(&format!("Published: {}.", sources.join("; ")));
}

fn symbol(quantity: &str) -> &str {
    match quantity {
        "dry_k" => "k",
        "st_c" => "St_c",
        other => other,
    }
}

/// The main numbers as lines for a terminal.
pub fn summary(told: Told) -> String {
    let findings = told.findings;
    let mut text = verdict_line(findings).replace("**", "");
    text.push('\n');
    for row in parameters(told)
        .iter()
        .filter(|row| row.key != "delta_c_over_roughness")
    {
        let least_squares = row.estimate.map(numbers::estimate);
        let posterior = row.quantity.map(|q| numbers::mean_and_sd(q, |x| x));
        let both = match (least_squares, posterior) {
            (Some(least_squares), Some(posterior)) => format!("{least_squares} (se); posterior {posterior} (sd)"),
            (Some(least_squares), None) => least_squares,
            (None, posterior) => format!("posterior {} (sd)", posterior.unwrap_or_default()),
        };
        text.push_str(&format!("{} = {both}\n", row.key));
    }
    let line = |particle: &str, ratio: f64, e_inf: &Estimate, st_c: &Estimate| {
        format!(
            "{particle}, δ/D = {}: e_inf = {}, St_c = {}\n",
            numbers::short(ratio),
            numbers::estimate(e_inf),
            numbers::estimate(st_c)
        )
    };
    match derived(told) {
        Some(derived) => {
            text.extend(
                derived
                    .iter()
                    .map(|row| line(&row.particle, row.film_ratio, &row.e_inf, &row.st_c)),
            );
        }
        // without an energy balance the direct fits are what there is
        None => {
            let direct = findings.scaling.iter().filter(|row| row.law == WetLaw::Sqrt.name());
            let lines = direct.filter_map(|row| Some(line(&row.particle, row.film_ratio?, &row.e_inf, &row.st_c)));
            text.extend(lines);
        }
    }
    text
}
