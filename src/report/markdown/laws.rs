//! Writes the dry law, the wet series, the scaling with St, the film thickness and the energy.

use super::super::figures;
use super::super::numbers;
use super::super::ReportInput;
use super::cells::{
    diameter, estimated, interval_header, is_told, law_name, list, rebounds_and_stuck, why_not_usable, NOT_USABLE,
};
use super::errors::of_speed;
use super::page::Page;
use super::table::ReportTable;
use crate::distributions::normal_quantile;
use crate::findings::dry::{Dry, DryOfDiameter};
use crate::findings::energy::Energy;
use crate::findings::estimate::Estimate;
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;
use crate::inference::lack_of_fit::Alternative;
use crate::inference::nested::FTest;
use crate::physics::{DrySpeed, Inertia, Quantity};
use crate::rounding::by_number;
use crate::runs::{sphere_words, Sphere};
use crate::scene::{DryKOf, LikelihoodFamily, WetLaw};
use crate::units::{micrometres, millimetres};

/// Over the number of rebounds, and of the runs that stuck.
const REBOUNDS: &str = "rebounds (stuck)";

pub(super) fn dry(page: &mut Page, input: ReportInput) {
    if input.findings.dry.is_empty() {
        return;
    }
    page.section("Dry law", "k of each particle from its dry runs alone.");
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
        .estimate_and_interval(Quantity::DryK, |row| (true, row.dry_k()), &interval_header(input))
        .column("residual sd", |row| match row.diameter {
            None => numbers::optional(row.dry.residual_sd, 2),
            Some(_) => String::new(),
        })
        .column_if_any(NOT_USABLE, |row| match row.diameter {
            None => why_not_usable(&row.dry.verdict),
            Some(one) => one.dry_k.why_none.as_deref().unwrap_or_default(),
        });
    page.table(&table);
    let of_diameters = input.findings.dry.iter().filter_map(|dry| {
        let test = dry.heterogeneity.as_ref()?;
        Some(format!("{}: {}", dry.words(), f_test(test)))
    });
    let of_speeds = input.findings.dry.iter().filter_map(|dry| {
        let found = dry.lack_of_fit.as_ref()?;
        let against = against(found.against);
        Some(format!("{} against {against}: {}", dry.particle, f_test(&found.test)))
    });
    for (what, tests) in [
        ("One k for all diameters", of_diameters.collect::<Vec<_>>()),
        (
            "Lack of fit of the law, with a k for each diameter",
            of_speeds.collect(),
        ),
    ] {
        if !tests.is_empty() {
            page.paragraph(&format!("{what}. {}.", tests.join("; ")));
        }
    }
}

fn f_test(test: &FTest) -> String {
    format!(
        "F({}, {}) = {}, p {}",
        test.df_between,
        test.df_within,
        numbers::significant(test.f, 3),
        equals(test.p)
    )
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
    page.heading("Wet series");
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
    let of_one_film = || findings.series.iter().filter(|one| !one.is_withheld);
    let failed: Vec<&SeriesFit> = of_one_film().filter(|one| !one.verdict.passed).collect();
    let all = of_one_film().count();
    let passed = all - failed.len();
    let have = by_number(passed, "has", "have");
    page.paragraph(&format!(
        "{passed} of {all} series of one film ratio {have} a law of their own, e = √(α + β/v), in `findings.json`.{offset} The law of every pair, \
         {of_all}, stands in [laws.csv](laws.csv).{}",
        if failed.is_empty() { "" } else { " The others:" }
    ));
    if !failed.is_empty() {
        page.table(&without_law(failed));
    }
    for sphere in estimated(input) {
        against_speed(page, input, sphere);
    }
}

/// The series without a usable law, each with the reason.
fn without_law(failed: Vec<&SeriesFit>) -> ReportTable<&SeriesFit> {
    ReportTable::of(failed)
        .column("particle", |row| &row.particle)
        .column("liquid", |row| &row.liquid)
        .column("D / mm", |row| diameter(row.diameter_m))
        .column("δ / µm", |row| numbers::significant(micrometres(row.film_m), 3))
        .column(REBOUNDS, |row| rebounds_and_stuck(row.runs, row.stuck))
        .column(NOT_USABLE, |row| why_not_usable(&row.verdict))
}

/// Restitution against speed.
fn against_speed(page: &mut Page, input: ReportInput, sphere: Sphere) {
    let (label, name) = (sphere.label(input.scene), sphere.words(input.scene));
    let shown = if input.runs.series.is_empty() {
        "restitution of dry runs against impact speed. Points are means of repeated speeds with their standard errors, the curve the dry law."
    } else {
        "restitution against impact speed at one film ratio. Points are means of repeated speeds with their standard errors, curves the square-root law of each series and the dry law (as figs. 2a and 2c of Müller & Huang 2016). Stuck runs are hollow marks at e = 0."
    };
    page.figure(
        &figures::Names::of(input.scene, input.runs).speed(&label),
        &format!("{name}: e against v"),
        &captioned(input, sphere, &format!("{shown}{}", bands(input))),
    );
}

/// The caption of one sphere's figure, said once where each has such a figure.
fn captioned(input: ReportInput, sphere: Sphere, shown: &str) -> String {
    let name = sphere.words(input.scene);
    match estimated(input).first() {
        Some(first) if *first != sphere => format!("{name}: as for {}.", first.words(input.scene)),
        _ => format!("{name}: {shown}"),
    }
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

/// The laws of some fits that are told: over all film ratios, or each at its own.
fn scaling_table<'i>(input: ReportInput<'i>, over_all: bool) -> ReportTable<&'i Scaling> {
    let (findings, interval) = (input.findings, interval_header(input));
    let told = |row: &&Scaling| is_told(findings, &row.particle, [row.diameter_m, row.film_ratio], row.law);
    let rows = findings
        .scaling
        .iter()
        .filter(|row| row.film_ratio.is_none() == over_all);
    let mut table = ReportTable::of(rows.filter(told)).column("particle", Scaling::words);
    if !over_all {
        table = table.column("δ/D", |row| row.film_ratio.map(numbers::short));
    }
    table = with_laws(table, |row| row.law)
        .column(REBOUNDS, |row| rebounds_and_stuck(row.runs, row.stuck))
        .estimate_and_interval(Quantity::EInf, |row| (row.verdict.passed, &row.e_inf), &interval)
        .estimate_and_interval(Quantity::StC, |row| (row.verdict.passed, &row.st_c), &interval)
        .column_if_any("corr", |row| numbers::optional(row.correlation, 2))
        .column_if_any("bias of e_inf", |row| {
            row.bias.map(|bias| numbers::shift(bias.e_inf, row.e_inf.se))
        })
        .column_if_any("bias of St_c", |row| {
            row.bias.map(|bias| numbers::shift(bias.st_c, row.st_c.se))
        })
        .column("residual sd", |row| numbers::optional(row.residual_sd, 2));
    if over_all {
        table = table.column("p", |row| row.one_for_all.map(|test| numbers::probability(test.p)));
    }
    table.column_if_any(NOT_USABLE, |row| why_not_usable(&row.verdict))
}

/// Adds which law a row is of, where not all are of the square root.
fn with_laws<R: Copy>(table: ReportTable<R>, law: impl Fn(R) -> WetLaw) -> ReportTable<R> {
    if table.rows().iter().all(|row| law(*row) == WetLaw::Sqrt) {
        return table;
    }
    table.column("law", |row| law_name(law(row)))
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
        "e = e_inf √(1 − 2 St_c/St), fitted to each particle over all its film ratios; the linear law, e = e_inf (1 − St_c/St), \
         stands where it describes the runs better. p: an F test against one law at each film ratio.",
    );
    say_of_diameters(page, input);
    let names = figures::Names::of(input.scene, input.runs);
    let shown = format!(
        "restitution against 1/St at one film ratio, with its law where the tables call it usable (as figs. 2b and 2d). Stuck runs are hollow marks at e = 0.{}",
        bands(input)
    );
    for sphere in estimated(input) {
        let (label, name) = (sphere.label(input.scene), sphere.words(input.scene));
        page.figure(
            &names.stokes(&label),
            &format!("{name}: e against 1/St"),
            &captioned(input, sphere, &shown),
        );
    }
    page.table(&scaling_table(input, true));
}

pub(super) fn film(page: &mut Page, input: ReportInput) {
    let table = scaling_table(input, false);
    if table.is_empty() {
        return;
    }
    page.section(
        "Film thickness",
        "The same laws at each film ratio. Bias: what the square root, which takes liquids of different density ratio as one, gets \
         wrong without noise against the energy balance; of a linear law, against the square root.",
    );
    if input.posterior.is_some() && input.scene.model.likelihood != LikelihoodFamily::Normal {
        page.paragraph(
            "These laws are fitted by least squares, which outliers move: where the likelihood allows for outliers, the main numbers \
             are the posterior's.",
        );
    }
    against_film(page, input);
    page.table(&table);
    let long = long_intervals(table.rows());
    if !long.is_empty() {
        page.paragraph(&format!(
            "Longer than their ± says, since a few runs decide the law: the intervals of {}.",
            long.join(", ")
        ));
    }
    if let Some(text) = of_speed(input) {
        page.paragraph(&text);
    }
}

/// The estimates of usable laws whose interval is more than twice as long as their ± makes one.
fn long_intervals(laws: &[&Scaling]) -> Vec<String> {
    let is_long = |estimate: &Estimate| {
        let z = normal_quantile(0.5 + 0.5 * estimate.level);
        let both = estimate.se.zip(estimate.interval);
        both.is_some_and(|(se, [lo, hi])| hi - lo > 4.0 * z * se)
    };
    let usable = laws.iter().filter(|law| law.verdict.passed);
    let of_law = |law: &&Scaling| {
        let both = [(Quantity::EInf, &law.e_inf), (Quantity::StC, &law.st_c)].into_iter();
        let at = law
            .film_ratio
            .map_or(String::new(), |ratio| format!(", δ/D = {}", numbers::short(ratio)));
        let words = law.words();
        let long = both.filter(|(_, estimate)| is_long(estimate));
        long.map(|(quantity, _)| format!("{} ({words}{at})", quantity.describe().symbol))
            .collect::<Vec<_>>()
    };
    usable.flat_map(of_law).collect()
}

pub(super) fn energy(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    if findings.energy.is_empty() {
        return;
    }
    page.heading("Energy");
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
        "The liquid's inertia takes (e_dry² − e_inf²)/ρ̃, for which eq. Eint2 (stepwise) and eq. Eint1 (cap) are the paper's \
         predictions. St_c e_inf² = 2 L{two_l}."
    ));
    page.figure(
        figures::ENERGY,
        "energy balance",
        "Inertial loss over density ratio with both predictions, and St_c e_inf², against the film ratio by the square-root law; bars are standard errors (as fig. 5).",
    );
    let told = |row: &&Energy| {
        let place = [row.diameter_m, Some(row.film_ratio)];
        is_told(findings, &row.particle, place, row.law)
    };
    let table = ReportTable::of(findings.energy.iter().filter(told))
        .column("particle", |row| sphere_words(&row.particle, row.diameter_m))
        .column("δ/D", |row| numbers::short(row.film_ratio));
    let table = with_laws(table, |row| row.law)
        .column("ρ̃", |row| numbers::significant(row.density_ratio, 3))
        .estimate(Quantity::InertialLoss, |row| &row.loss_over_density_ratio)
        .column(Inertia::Stepwise.name(), |row| numbers::significant(row.stepwise, 3))
        .column(Inertia::Cap.name(), |row| numbers::optional(row.cap, 3))
        .estimate(Quantity::StCEInf2, |row| &row.st_c_e_inf2);
    let table = match has_delta_c {
        true => table.estimate_and_interval(Quantity::DeltaC, |row| (true, &row.delta_c_m), &interval_header(input)),
        false => table,
    };
    page.table(&table);
}
