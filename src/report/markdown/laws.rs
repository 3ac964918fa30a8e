//! Writes the dry law, the wet series, the scaling with St, the film thickness and the energy.

use super::super::figures;
use super::super::ReportInput;
use super::super::{numbers, quantities};
use super::cells::{diameter, estimated, interval_header, law_name, list, rebounds_and_stuck, usable};
use super::errors::of_speed;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::dry::{Dry, DryOfDiameter};
use crate::findings::estimate::Estimate;
use crate::findings::scaling::Scaling;
use crate::inference::lack_of_fit::Alternative;
use crate::physics::{DrySpeed, Inertia, Quantity};
use crate::runs::{sphere_words, Sphere};
use crate::scene::{DryKOf, WetLaw};
use crate::units::{micrometres, millimetres};

/// Over the number of rebounds, and of the runs that stuck.
const REBOUNDS: &str = "rebounds (stuck)";

pub(super) fn dry(page: &mut Page, input: ReportInput) {
    if input.findings.dry.is_empty() {
        return;
    }
    page.section(
        "Dry law",
        "k of each particle by its dry runs alone, and whether one k serves at every diameter and speed.",
    );
    let rows = input.findings.dry.iter().flat_map(|dry| {
        let several = dry.by_diameter.iter().filter(|_| dry.by_diameter.len() > 1);
        let each = several.map(|one| DryTableRow {
            dry,
            diameter: Some(one),
        });
        std::iter::once(DryTableRow { dry, diameter: None }).chain(each)
    });
    let table = ReportTable::of(rows)
        .column("particle", |row| &row.dry.particle)
        .column("D / mm", |row| match (row.diameter, row.dry.by_diameter.as_slice()) {
            (Some(one), _) => diameter(one.diameter_m),
            (None, [_, _, ..]) => "all".to_owned(),
            (None, few) => list(&few.iter().map(|one| one.diameter_m).collect::<Vec<_>>(), millimetres),
        })
        .column("runs", |row| row.diameter.map_or(row.dry.runs, |one| one.runs))
        .estimate_and_interval(Quantity::DryK, |row| row.dry_k(), &interval_header(input))
        .column("residual sd", |row| match row.diameter {
            None => numbers::optional(row.dry.residual_sd, 2),
            Some(_) => String::new(),
        })
        .column("verdict", |row| match row.diameter {
            None => usable(&row.dry.verdict),
            Some(one) => one.dry_k.why_none.clone().unwrap_or_default(),
        });
    page.table(&table);
    for dry in &input.findings.dry {
        if let Some(test) = &dry.heterogeneity {
            page.paragraph(&format!(
                "{}: one k for all diameters, F({}, {}) = {}, p {}.",
                dry.words(),
                test.df_between,
                test.df_within,
                numbers::significant(test.f, 3),
                equals(test.p)
            ));
        }
        if let Some(found) = &dry.lack_of_fit {
            let test = &found.test;
            page.paragraph(&format!(
                "{}: the law, with a k for each diameter, against {}, F({}, {}) = {}, p {}.",
                dry.particle,
                against(found.against),
                test.df_between,
                test.df_within,
                numbers::significant(test.f, 3),
                equals(test.p)
            ));
        }
    }
}

/// The dry law of a particle, over all diameters or of one.
#[derive(Clone, Copy)]
struct DryTableRow<'a> {
    dry: &'a Dry,
    diameter: Option<&'a DryOfDiameter>,
}

impl<'a> DryTableRow<'a> {
    fn dry_k(self) -> &'a Estimate {
        self.diameter.map_or(&self.dry.dry_k, |one| &one.dry_k)
    }
}

/// What a dry law is held against, in words.
fn against(alternative: Alternative) -> &'static str {
    match alternative {
        Alternative::RepeatedSpeeds => "the scatter of runs at each speed",
        Alternative::NextPower => "a law with one more power of v",
    }
}

fn equals(p: f64) -> String {
    let text = numbers::probability(p);
    if text.starts_with("below") {
        text
    } else {
        format!("= {text}")
    }
}

pub(super) fn series(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.series.is_empty() {
        return;
    }
    page.section("Wet series", "α, β and the threshold of each series by itself.");
    let offset = match input.scene.model.dry_speed {
        DrySpeed::Reference(_) => String::new(),
        DrySpeed::Impact => {
            " α is quoted at the reference dry speed; each run's own enters as a known offset.".to_owned()
        }
    };
    let of_all = match input.posterior {
        Some(_) => "as the posterior of all runs at once has it",
        None => "in SI",
    };
    page.paragraph(&format!(
        "e = √(α + β/v), one law a series; the threshold is the speed −β/α below which it gives no rebound.{offset} For a \
         simulation code the law of every pair, {of_all}, stands in [laws.csv](laws.csv)."
    ));
    for sphere in estimated(input) {
        against_speed(page, input, sphere);
    }
    let table = ReportTable::of(&findings.series)
        .column("particle", |row| &row.particle)
        .column("liquid", |row| &row.liquid)
        .column("D / mm", |row| diameter(row.diameter_m))
        .column("δ / µm", |row| numbers::significant(micrometres(row.film_m), 3))
        .column(REBOUNDS, |row| rebounds_and_stuck(row.runs, row.stuck))
        .estimate_if(Quantity::Alpha, |row| (row.verdict.passed, &row.alpha))
        .estimate_if(Quantity::Beta, |row| (row.verdict.passed, &row.beta))
        .estimate_if(Quantity::EInf, |row| (row.verdict.passed, &row.e_inf))
        .column("threshold / (m/s)", |row| {
            quantities::estimate_if(row.verdict.passed, Quantity::ThresholdSpeed, &row.threshold_speed_m_s)
        })
        .column("residual sd", |row| numbers::optional(row.residual_sd, 2))
        .column("verdict", |row| usable(&row.verdict));
    page.table(&table);
}

/// Restitution against speed.
fn against_speed(page: &mut Page, input: ReportInput, sphere: Sphere) {
    let (label, name) = (sphere.label(input.scene), sphere.words(input.scene));
    page.figure(
        &figures::Names::of(input.scene, input.runs).speed(&label),
        &format!("{name}: e_n against v"),
        &format!("{name}: restitution against impact speed at one film ratio. Points are means of repeated speeds with their standard errors, curves the square-root law of each series and the dry law (as figs. 2a and 2c of Müller & Huang 2016). Stuck runs are hollow marks at e = 0.{}", bands(input)),
    );
}

/// e_inf and St_c against the film ratio.
fn against_film(page: &mut Page, input: ReportInput) {
    let curves = match input.posterior {
        Some(_) => {
            " Curves: the posterior's means, at the mean density ratio of all runs; the points take the liquids of a film ratio \
             as one, and where these differ in density they lie off the curve by the bias that Film thickness has."
        }
        None => "",
    };
    let drawn = |law: WetLaw| {
        let mut rows = input.findings.scaling.iter();
        rows.any(|row| row.law == law && row.film_ratio.is_some() && row.verdict.passed)
    };
    let laws = if drawn(WetLaw::Linear) {
        "by the square-root law and, hollow, the linear law"
    } else {
        "by the square-root law"
    };
    page.figure(
        figures::FILM,
        "e_inf and St_c",
        &format!("e_inf and St_c against the film ratio {laws}, with their standard errors (as fig. 4).{curves}"),
    );
}

/// The two figures that stand beside the main numbers.
pub(super) fn first_figures(page: &mut Page, input: ReportInput) {
    if let Some(sphere) = estimated(input).into_iter().next() {
        against_speed(page, input, sphere);
    }
    against_film(page, input);
}

/// What the bands in a figure are; nothing where there are none.
fn bands(input: ReportInput) -> String {
    if input.posterior.is_none() {
        return String::new();
    }
    let text =
        " Shaded: 90 % bands of the posterior over the speeds of the runs, dark for the mean restitution (often no \
         wider than a line), light for a single run";
    let text = if input.scene.model.series_offsets {
        format!("{text}, both of a new series, whose offset nothing tells")
    } else {
        text.to_owned()
    };
    let noise = input.findings.noise.as_ref();
    match noise.and_then(|noise| noise.growth.as_ref()?.of_wet_runs()) {
        Some(growth) => format!(
            "{text}, which takes one spread where that of the runs grows with {} by a factor of {:.1} (see Noise): too wide \
             at one end, too narrow at the other.",
            growth.with.words(),
            growth.factor
        ),
        None => format!("{text}."),
    }
}

/// Both laws of some fits: over all film ratios, or each at its own.
fn scaling_table<'a>(rows: impl Iterator<Item = &'a Scaling>, over_all: bool) -> ReportTable<&'a Scaling> {
    let mut table = ReportTable::of(rows).column("particle", Scaling::words);
    if !over_all {
        table = table.column("δ/D", |row| row.film_ratio.map(numbers::short));
    }
    table = table
        .column("law", |row| law_name(row.law))
        .column(REBOUNDS, |row| rebounds_and_stuck(row.runs, row.stuck))
        .estimate_if(Quantity::EInf, |row| (row.verdict.passed, &row.e_inf))
        .estimate_if(Quantity::StC, |row| (row.verdict.passed, &row.st_c))
        .column("corr", |row| numbers::optional(row.correlation, 2))
        .column("bias of e_inf", |row| {
            row.bias.map(|bias| numbers::shift(bias.e_inf, row.e_inf.se))
        })
        .column("bias of St_c", |row| {
            row.bias.map(|bias| numbers::shift(bias.st_c, row.st_c.se))
        })
        .column("residual sd", |row| numbers::optional(row.residual_sd, 2));
    if over_all {
        table = table.column("p", |row| row.one_for_all.map(|test| numbers::probability(test.p)));
    }
    table.column("verdict", |row| usable(&row.verdict))
}

/// What the St_c of a direct fit is worth where k, or St_c, belongs to a diameter.
fn say_of_diameters(page: &mut Page, input: ReportInput) {
    if input.scene.model.dry_k == DryKOf::Diameter {
        page.paragraph("Each diameter has a k of its own, and so an e_inf and a St_c: these laws take its runs alone.");
    } else if input.findings.form.viscous.tells_diameters_apart() {
        page.paragraph(
            "In this scene's form of the viscous loss St_c belongs to a film and a diameter. These laws take all diameters of \
             their runs as one, so that their St_c is a mean over them; that of each stands under Main numbers.",
        );
    }
}

pub(super) fn scaling(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.scaling.is_empty() {
        return;
    }
    page.section(
        "Scaling with the Stokes number",
        "e_inf and St_c of each particle over all its films, and whether one law serves them.",
    );
    say_of_diameters(page, input);
    page.paragraph(
        "The linear law is e = e_inf (1 − St_c/St). Here both laws are fitted over all film ratios; \
         p is the probability, by an F test against one law at each film ratio, of so large a difference by chance. \
         Bias is what the linear law gets wrong when fitted to the noise-free square root at the same runs.",
    );
    let (bands, names) = (bands(input), figures::Names::of(input.scene, input.runs));
    for sphere in estimated(input) {
        let (label, name) = (sphere.label(input.scene), sphere.words(input.scene));
        page.figure(
            &names.stokes(&label),
            &format!("{name}: e_n against 1/St"),
            &format!(
                "{name}: restitution against 1/St at one film ratio, with the laws fitted to it where the tables call these usable (as figs. 2b and 2d). Stuck runs are hollow marks at e = 0.{bands}"
            ),
        );
    }
    let rows = findings.scaling.iter().filter(|row| row.film_ratio.is_none());
    page.table(&scaling_table(rows, true));
}

pub(super) fn film(page: &mut Page, input: ReportInput) {
    let rows = input.findings.scaling.iter().filter(|row| row.film_ratio.is_some());
    let table = scaling_table(rows, false);
    if table.is_empty() {
        return;
    }
    page.section(
        "Film thickness",
        "e_inf and St_c of each film ratio by the laws alone, to see how they move with the film.",
    );
    say_of_diameters(page, input);
    page.paragraph(
        "Both laws fitted directly at each film ratio, the square root as e = e_inf √(1 − 2 St_c/St). Their bias is what \
         they get wrong without any noise: the linear law against the square root; the square root, which takes liquids \
         of different density ratio as one, against the energy balance.",
    );
    against_film(page, input);
    page.table(&table);
    if let Some(text) = of_speed(input) {
        page.paragraph(&text);
    }
}

pub(super) fn energy(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.energy.is_empty() {
        return;
    }
    page.section(
        "Energy",
        "What the liquid's inertia takes at each film ratio, beside the paper's formulas.",
    );
    let of_form = input.scene.model.viscous.why_no_critical_separation();
    let of_roughness = || {
        let why = input.scene.why_no_roughness(input.runs.wet_particles())?;
        Some(format!("{why}, and so no δc"))
    };
    let why_no_delta_c = of_form.map(str::to_owned).or_else(of_roughness);
    let mut wet = input.runs.wet_particles();
    let some_have_roughness = wet.any(|particle| input.scene.particles[particle].roughness.is_some());
    let has_delta_c = of_form.is_none() && some_have_roughness;
    let mut two_l = String::new();
    if has_delta_c {
        two_l.push_str(" gives δc = ε exp(L), with its interval made on the logarithm");
    }
    if let Some(why) = why_no_delta_c {
        two_l.push_str(&format!("; {why}"));
    }
    page.paragraph(&format!(
        "(e_dry² − e_inf²)/ρ̃ is what the liquid's inertia takes, over the density ratio; eq. Eint2 (stepwise) and \
         eq. Eint1 (cap) are the paper's predictions for it. St_c e_inf² = 2 L{two_l}."
    ));
    page.figure(
        figures::ENERGY,
        "energy balance",
        "Inertial loss over density ratio with both predictions, and St_c e_inf², against the film ratio by the square-root law; bars are standard errors (as fig. 5).",
    );
    let table = ReportTable::of(&findings.energy)
        .column("particle", |row| sphere_words(&row.particle, row.diameter_m))
        .column("δ/D", |row| numbers::short(row.film_ratio))
        .column("law", |row| law_name(row.law))
        .column("ρ̃", |row| numbers::significant(row.density_ratio, 3))
        .estimate(Quantity::InertialLoss, |row| &row.loss_over_density_ratio)
        .column(Inertia::Stepwise.name(), |row| numbers::significant(row.stepwise, 3))
        .column(Inertia::Cap.name(), |row| numbers::optional(row.cap, 3))
        .estimate(Quantity::StCEInf2, |row| &row.st_c_e_inf2);
    let table = match has_delta_c {
        true => table.estimate_and_interval(Quantity::DeltaC, |row| &row.delta_c_m, &interval_header(input)),
        false => table,
    };
    page.table(&table);
}
