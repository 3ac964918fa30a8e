//! Tells the dry law, the wet series, the scaling with St, the film thickness and the energy.

use super::super::figures;
use super::super::numbers::{self, NONE};
use super::super::Told;
use super::cells::{estimated, interval_header, law_name, list, told_verdict};
use super::errors::of_speed;
use super::page::Page;
use crate::findings::scaling::Scaling;
use crate::physics::DrySpeed;
use crate::units::{micrometres, millimetres};

pub(super) fn dry(page: &mut Page, told: Told) {
    if told.findings.dry.is_empty() {
        return;
    }
    page.heading("Dry law");
    let mut rows = vec![];
    for dry in &told.findings.dry {
        let all = if dry.by_diameter.len() > 1 {
            "all".to_owned()
        } else {
            list(&diameters(dry), millimetres)
        };
        rows.push(vec![
            dry.particle.clone(),
            all,
            dry.runs.to_string(),
            numbers::estimate(&dry.dry_k),
            numbers::interval(&dry.dry_k),
            numbers::optional(dry.residual_sd, 2),
            told_verdict(&dry.verdict),
        ]);
        if dry.by_diameter.len() > 1 {
            rows.extend(dry.by_diameter.iter().map(|one| {
                vec![
                    dry.particle.clone(),
                    numbers::short(millimetres(one.diameter_m)),
                    one.runs.to_string(),
                    numbers::estimate(&one.dry_k),
                    numbers::interval(&one.dry_k),
                    String::new(),
                    one.dry_k.why_none.clone().unwrap_or_default(),
                ]
            }));
        }
    }
    let level = interval_header(told);
    page.table(
        &[
            "particle",
            "D / mm",
            "runs",
            "k / (m/s)^(−1/5)",
            &level,
            "residual sd",
            "verdict",
        ],
        &rows,
    );
    for dry in &told.findings.dry {
        if let Some(test) = &dry.heterogeneity {
            page.paragraph(&format!(
                "{}: one k for all diameters, F({}, {}) = {}, p {}.",
                dry.particle,
                test.df_between,
                test.df_within,
                numbers::significant(test.f, 3),
                equals(test.p)
            ));
        }
    }
}

fn diameters(dry: &crate::findings::dry::Dry) -> Vec<f64> {
    dry.by_diameter.iter().map(|one| one.diameter_m).collect()
}

fn equals(p: f64) -> String {
    let text = numbers::probability(p);
    if text.starts_with("below") {
        text
    } else {
        format!("= {text}")
    }
}

pub(super) fn series(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.series.is_empty() {
        return;
    }
    page.heading("Wet series");
    let offset = match told.scene.model.dry_speed {
        DrySpeed::Reference(_) => String::new(),
        DrySpeed::Impact => {
            " α is quoted at the reference dry speed; each run's own enters as a known offset.".to_owned()
        }
    };
    page.paragraph(&format!(
        "e = √(α + β/v), one law a series; the threshold is the speed −β/α below which it gives no rebound.{offset}"
    ));
    let (bands, names) = (bands(told), figures::Names::of(told.scene));
    for name in estimated(told) {
        page.figure(
            &names.speed(&name),
            &format!("{name}: e_n against v"),
            &format!("{name}: restitution against impact speed at one film ratio. Points are means of repeated speeds with their standard errors, curves the fits of this section and the dry law (as figs. 2a and 2c of Müller & Huang 2016). Stuck runs are hollow marks at e = 0, those of one series above another's.{bands}"),
        );
    }
    let rows: Vec<Vec<String>> = findings
        .series
        .iter()
        .map(|row| {
            vec![
                row.particle.clone(),
                row.liquid.clone(),
                numbers::short(millimetres(row.diameter_m)),
                numbers::significant(micrometres(row.film_m), 3),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.alpha),
                numbers::estimate(&row.beta),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.threshold_speed_m_s),
                numbers::optional(row.residual_sd, 2),
                told_verdict(&row.verdict),
            ]
        })
        .collect();
    page.table(
        &[
            "particle",
            "liquid",
            "D / mm",
            "δ / µm",
            "rebounds (stuck)",
            "α",
            "β / (m/s)",
            "e_inf",
            "threshold / (m/s)",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
}

/// What the bands in a figure are; nothing where there are none.
fn bands(told: Told) -> &'static str {
    match told.posterior {
        Some(_) => {
            " Shaded: 90 % bands of the posterior over the speeds of the runs, dark for the mean restitution (often no \
             wider than a line), light for a single run."
        }
        None => "",
    }
}

pub(super) fn bias_cells(row: &Scaling) -> [String; 2] {
    row.bias.map_or([NONE.to_owned(), NONE.to_owned()], |bias| {
        [
            numbers::shift(bias.e_inf, row.e_inf.se),
            numbers::shift(bias.st_c, row.st_c.se),
        ]
    })
}

pub(super) fn scaling(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.scaling.is_empty() {
        return;
    }
    page.heading("Scaling with the Stokes number");
    page.paragraph(
        "The linear law is e = e_inf (1 − St_c/St). Here both laws are fitted over all film ratios; \
         p is the probability, by an F test against one law at each film ratio, of so large a difference by chance. \
         Bias is what the linear law gets wrong when fitted to the noise-free square root at the same runs.",
    );
    let (bands, names) = (bands(told), figures::Names::of(told.scene));
    for name in estimated(told) {
        page.figure(
            &names.stokes(&name),
            &format!("{name}: e_n against 1/St"),
            &format!(
                "{name}: restitution against 1/St at one film ratio, with both laws fitted to it (as figs. 2b and 2d). Stuck runs are hollow marks at e = 0.{bands}"
            ),
        );
        page.figure(
            &names.film_ratios(&name),
            &format!("{name}: every film ratio"),
            &format!("{name}: restitution against 1/St at every film ratio, with both laws fitted over all of them (as fig. 3)."),
        );
    }
    let rows: Vec<Vec<String>> = findings
        .scaling
        .iter()
        .filter(|row| row.film_ratio.is_none())
        .map(|row| {
            let mut cells = vec![
                row.particle.clone(),
                law_name(row.law),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                numbers::optional(row.correlation, 2),
            ];
            cells.extend(bias_cells(row));
            cells.extend([
                numbers::optional(row.residual_sd, 2),
                row.one_for_all
                    .map_or(NONE.to_owned(), |test| numbers::probability(test.p)),
                told_verdict(&row.verdict),
            ]);
            cells
        })
        .collect();
    page.table(
        &[
            "particle",
            "law",
            "rebounds (stuck)",
            "e_inf",
            "St_c",
            "corr",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "p",
            "verdict",
        ],
        &rows,
    );
}

pub(super) fn film(page: &mut Page, told: Told) {
    let rows: Vec<Vec<String>> = told
        .findings
        .scaling
        .iter()
        .filter_map(|row| {
            let mut cells = vec![
                row.particle.clone(),
                numbers::short(row.film_ratio?),
                law_name(row.law),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                numbers::optional(row.correlation, 2),
            ];
            cells.extend(bias_cells(row));
            cells.extend([numbers::optional(row.residual_sd, 2), told_verdict(&row.verdict)]);
            Some(cells)
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    page.heading("Film thickness");
    page.paragraph(
        "Both laws fitted directly at each film ratio, the square root as e = e_inf √(1 − 2 St_c/St). Their bias is what \
         they get wrong without any noise: the linear law against the square root; the square root, which takes liquids \
         of different density ratio as one, against the energy balance.",
    );
    page.figure(
        figures::FILM,
        "e_inf and St_c",
        "e_inf and St_c against the film ratio by both laws; bars are standard errors (as fig. 4).",
    );
    page.table(
        &[
            "particle",
            "δ/D",
            "law",
            "rebounds (stuck)",
            "e_inf",
            "St_c",
            "corr",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
    if let Some(text) = of_speed(told) {
        page.paragraph(&text);
    }
}

pub(super) fn energy(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.energy.is_empty() {
        return;
    }
    page.heading("Energy");
    page.paragraph(
        "(e_dry² − e_inf²)/ρ̃ is what the liquid's inertia takes, over the density ratio; eq. Eint2 (stepwise) and \
         eq. Eint1 (cap) are the paper's predictions for it. St_c e_inf² = 2 L gives δc = ε exp(L), \
         with its interval made on the logarithm.",
    );
    page.figure(
        figures::ENERGY,
        "energy balance",
        "Inertial loss over density ratio with both predictions, and St_c e_inf², against the film ratio by the square-root law; bars are standard errors (as fig. 5).",
    );
    let rows: Vec<Vec<String>> = findings
        .energy
        .iter()
        .map(|row| {
            vec![
                row.particle.clone(),
                numbers::short(row.film_ratio),
                law_name(row.law),
                numbers::significant(row.density_ratio, 3),
                numbers::estimate(&row.loss_over_density_ratio),
                numbers::significant(row.stepwise, 3),
                numbers::optional(row.cap, 3),
                numbers::estimate(&row.st_c_e_inf2),
                numbers::estimate_scaled(&row.delta_c_m, micrometres),
                numbers::interval_scaled(&row.delta_c_m, micrometres),
            ]
        })
        .collect();
    let level = interval_header(told);
    page.table(
        &[
            "particle",
            "δ/D",
            "law",
            "ρ̃",
            "(e_dry² − e_inf²)/ρ̃",
            "stepwise",
            "cap",
            "St_c e_inf²",
            "δc / µm",
            &level,
        ],
        &rows,
    );
}
