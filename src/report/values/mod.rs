//! Gathers what the templates of the report read: the findings as `findings.json` has them, and what follows from them.
//!
//! | file | job |
//! |---|---|
//! | `main_numbers.rs` | the main numbers with their labels, and what simulated runs were drawn from |
//! | `fits.rs` | the rows of the fits by least squares, as far as they are told |
//! | `posterior.rs` | the model in words, the sampled parameters beside their priors, the offsets of series |

mod fits;
mod main_numbers;
mod posterior;

use minijinja::value::merge_maps;
use minijinja::{context, Value};

use super::template::{serialized, with};
use super::{figures, ReportInput};
use crate::findings::dry::fit_of_sphere;
use crate::findings::estimates::EstimateRow;
use crate::findings::overview::{list_materials, Overview};
use crate::findings::remarks::{in_order, IN_TABLES, SINGLE_RUN};
use crate::findings::terms::{self, SizedTerm};
use crate::findings::Findings;
use crate::physics::loss::Loss;
use crate::physics::DrySpeed;
use crate::remark::{Level, Line, Remark};
use crate::rounding;
use crate::scene::{DryKOf, LikelihoodFamily, NoiseOn, Sticking, WetLaw};

/// Everything that a template of the report may name.
pub(super) fn of_report(input: ReportInput) -> Value {
    let (scene, findings) = (input.scene, input.findings);
    let model = &scene.model;
    let form = &findings.form;
    let spheres = figures::file_names(scene, input.runs).into_iter().enumerate();
    let spheres = spheres.filter(|(sphere, _)| is_estimated(input, *sphere));
    let spheres = spheres.map(|(sphere, [speed_figure, stokes_figure])| {
        context! { words => input.runs.spheres[sphere].words(scene), speed_figure, stokes_figure }
    });
    let tables = scene.data.runs.iter().filter_map(|runs| runs.path.file_name());
    let told_apart = form.viscous.tells_diameters_apart();
    let general = context! {
        title => scene.title.as_str(),
        source => scene.source.as_deref(),
        command => input.command,
        tables => tables.map(|name| name.to_string_lossy().into_owned()).collect::<Vec<_>>(),
        interval => format!("{} % interval", rounding::short(100.0 * scene.bootstrap.level)),
        simulated => scene.truth.is_some(),
        posterior => input.posterior.is_some(),
        series_offsets => model.series_offsets,
        normal => model.likelihood == LikelihoodFamily::Normal,
        both => model.noise == NoiseOn::Both,
        sticking => match model.sticking {
            Sticking::Censored => "censored",
            Sticking::Truncated => "truncated",
            Sticking::Excluded => "excluded",
        },
        k_of_diameters => model.dry_k == DryKOf::Diameter,
        own_dry_speed => model.dry_speed == DrySpeed::Impact,
        reference_speed => model.dry_speed.reference(),
        smallest => scene.data.smallest_restitution,
        laws => context! { sqrt => "square root", linear => WetLaw::Linear.name() },
        form => context! {
            dry => form.dry.formula("v"),
            wet => (!input.runs.series.is_empty()).then(|| form.formula("δ/D")),
            viscous => Loss::definition(&form.viscous, "δ/D"),
            tells_diameters_apart => told_apart,
        },
        spheres => spheres.collect::<Vec<_>>(),
        film_figure => figures::FILM,
        energy_figure => figures::ENERGY,
        pairs_figure => figures::PAIRS,
        residuals_figure => figures::RESIDUALS,
        findings => serialized(findings),
        terms => findings.terms.iter().map(sized).collect::<Vec<_>>(),
        term_line => terms::LINE,
        materials => serialized(list_materials(scene, input.runs)),
    };
    let all = [
        general,
        remarks(findings),
        main_numbers::values(input),
        fits::values(input),
        posterior::values(input),
    ];
    merge_maps(all)
}

/// What the overview of `check` reads.
pub(super) fn of_overview(overview: &Overview) -> Value {
    context! {
        title => crate::error::plain(&overview.title, usize::MAX),
        overview => serialized(overview),
        materials => serialized(&overview.materials),
        terms => overview.terms.iter().map(sized).collect::<Vec<_>>(),
        term_line => terms::LINE,
    }
}

fn sized(term: &SizedTerm) -> Value {
    with(term, context! { words => term.term.in_words() })
}

/// The verdict, the cautions and the checks.
fn remarks(findings: &Findings) -> Value {
    let failed = || findings.checks().filter(|check| !check.passed);
    let of = |level: Level| failed().filter(move |check| check.level == level);
    let forbidding: Vec<&Remark> = failed().filter(|check| check.forbids()).collect();
    let informing = in_order(&findings.remarks).into_iter();
    let noted = informing.filter(|own| own.informs() && own.line.is_none() && !IN_TABLES.contains(&own.code));
    let carried = findings.notices().find(|notice| notice.code == SINGLE_RUN.code);
    let told_check = |check: &&Remark| context! { found => found(check), next_step => check.next_step.as_str() };
    let all = findings.checks().count();
    context! {
        verdict => context! {
            passed => findings.main.verdict.passed,
            open => undetermined(findings),
            failed => forbidding.iter().map(told_check).collect::<Vec<_>>(),
        },
        carried => carried.map(serialized),
        cautions => findings.cautions().into_iter().map(told).collect::<Vec<_>>(),
        noted => noted.map(told).collect::<Vec<_>>(),
        checks => context! {
            all,
            held => all - failed().count(),
            forbidding => serialized(&forbidding),
            cautioning => of(Level::Cautions).map(|check| check.code).collect::<Vec<_>>(),
            informing => of(Level::Informs).map(found).collect::<Vec<_>>(),
        },
    }
}

/// What was found and what to do about it, where there is anything.
fn told(Remark { text, next_step, .. }: &Remark) -> String {
    // "nothing uses it" is a sentence of its own
    let why = next_step.strip_prefix("nothing").filter(|why| !why.starts_with(' '));
    match why.map(|why| why.trim_start_matches([':', ';', ',', ' '])) {
        None => format!("{text}. Next: {next_step}."),
        Some("") => format!("{text}."),
        Some(why) => format!("{text}; {why}."),
    }
}

/// What a failed check found, with its value where the words do not have it, and the line that it passed.
fn found(check: &Remark) -> String {
    // a count of what failed stands in words
    let line = check.line.filter(|line| ![0.0, 1.0].contains(&line.threshold()));
    let Some((value, line)) = check.value.zip(line) else {
        return check.text.clone();
    };
    let value = rounding::significant(value, 3);
    let value = match check.text.contains(&value) {
        true => String::new(),
        false => value + ", ",
    };
    let side = match line {
        Line::AtMost(_) => "above",
        Line::AtLeast(_) => "below",
    };
    format!("{} ({value}{side} {})", check.text, rounding::short(line.threshold()))
}

/// The main parameters that the runs do not tell, or not apart from others; δc/ε is exp(L), and goes with it.
fn undetermined(findings: &Findings) -> Vec<String> {
    let unseen = findings.identifies.iter().flat_map(|directions| &directions.unseen);
    let unseen: Vec<&String> = unseen.flat_map(|one| &one.parameters).collect();
    let names = findings.main.parameters.iter().map(EstimateRow::name);
    let source = |name: &str| name.replace("delta_c_over_roughness", "lubrication_log");
    names.filter(|name| unseen.contains(&&source(name))).collect()
}

/// Whether a particle, or a diameter of it that has a k of its own, has any estimate.
fn is_estimated(input: ReportInput, sphere: usize) -> bool {
    let mut scaling = input.findings.scaling.iter();
    fit_of_sphere(&input.findings.dry, sphere).is_some() || scaling.any(|row| row.sphere == sphere)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_to_do_is_not_told_as_a_step() {
        let of = |next_step: &str| told(&Remark::new("code", 1, "found", next_step));
        assert_eq!(of("nothing"), "found.");
        for comma in ["nothing: why", "nothing; why", "nothing, why"] {
            assert_eq!(of(comma), "found; why.");
        }
        assert_eq!(of("nothing uses it"), "found. Next: nothing uses it.");
        assert_eq!(of("look"), "found. Next: look.");
    }
}
