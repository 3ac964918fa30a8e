//! Tells the numbers a reader came for, and the literature's beside them.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::{interval_header, law_name, told_verdict};
use super::laws::bias_cells;
use super::page::Page;
use super::verdict_line;
use crate::findings::estimate::Estimate;
use crate::findings::own_dry_speed::reference_dry_speed;
use crate::scene::{Law, Published};

pub(super) fn main_numbers(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("Main numbers");
    page.paragraph(
        "e_dry = 1 − k v^(1/5) and e² = e_dry² − C ρ̃ g(δ/D) − 4 L/St, with St = ρp D v/(9 η) and L = ln(δc/ε). \
         ± is one standard error (least squares, delta method); k comes from the dry runs, \
         the others from every rebound at once, together with what the dry runs say of k.",
    );
    let level = interval_header(told);
    let mut rows: Vec<Vec<String>> = findings
        .dry
        .iter()
        .map(|dry| number(format!("k / (m/s)^(−1/5), {}", dry.particle), &dry.dry_k))
        .collect();
    if let Some(balance) = &findings.energy_balance {
        for parameter in &balance.parameters {
            if let Some(name) = parameter_name(&parameter.name, balance.inertia) {
                rows.push(number(name, &parameter.estimate));
            }
        }
        rows.push(number("δc/ε = exp(L)".to_owned(), &balance.delta_c_over_roughness));
    }
    page.table(&["quantity", "value", &level], &rows);
    let rows: Vec<Vec<String>> = findings
        .scaling
        .iter()
        .filter(|row| row.law == Law::Sqrt.name())
        .filter_map(|row| {
            Some(vec![
                row.particle.clone(),
                numbers::short(row.film_ratio?),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                row.st_no_rebound.as_ref().map_or(NONE.to_owned(), numbers::estimate),
                numbers::optional(row.correlation, 2),
            ])
            .map(|mut cells| {
                cells.extend(bias_cells(row));
                cells.extend([numbers::optional(row.residual_sd, 2), told_verdict(&row.verdict)]);
                cells
            })
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    let speed = numbers::short(reference_dry_speed(told.scene));
    page.paragraph(&format!(
        "e_inf and St_c by the square-root law e = e_inf √(1 − 2 St_c/St), at each film ratio; it is zero at \
         2 St_c, below which nothing rebounds. e_inf holds for e_dry at {speed} m/s. The law takes liquids of \
         different density ratio as one; its bias is what that gets wrong, by fitting it to the noise-free \
         energy balance at the same runs."
    ));
    page.table(
        &[
            "particle",
            "δ/D",
            "rebounds (stuck)",
            "e_inf",
            "St_c",
            "2 St_c",
            "corr(e_inf, St_c)",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
}

fn number(name: String, estimate: &Estimate) -> Vec<String> {
    vec![name, numbers::estimate(estimate), numbers::interval(estimate)]
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
    let mut sources: Vec<&str> = told
        .scene
        .published
        .iter()
        .map(|p: &Published| p.source.as_str())
        .collect();
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
    for dry in &findings.dry {
        text.push_str(&format!("k[{}] = {}\n", dry.particle, numbers::estimate(&dry.dry_k)));
    }
    if let Some(balance) = &findings.energy_balance {
        for parameter in &balance.parameters {
            if parameter_name(&parameter.name, balance.inertia).is_some() {
                text.push_str(&format!(
                    "{} = {}\n",
                    parameter.name,
                    numbers::estimate(&parameter.estimate)
                ));
            }
        }
    }
    for row in findings.scaling.iter().filter(|row| row.law == Law::Sqrt.name()) {
        if let Some(ratio) = row.film_ratio {
            text.push_str(&format!(
                "{}, δ/D = {}: e_inf = {}, St_c = {}\n",
                row.particle,
                numbers::short(ratio),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c)
            ));
        }
    }
    text
}
