//! Writes whether new runs would look like the ones made, and which form of the law predicts best.

use super::super::super::numbers::{self, NONE};
use super::super::super::ReportInput;
use super::super::cells::diameter;
use super::super::page::Page;
use super::super::table::ReportTable;
use super::cells::rhat;
use crate::findings::compare::ComparedModel;
use crate::findings::posterior::Posterior;
use crate::findings::remarks::LOO_KHAT;
use crate::physics::Viscous;
use crate::remark::Line;

/// Bands, groups and the number stuck.
pub(super) fn predictive(page: &mut Page, posterior: &Posterior) {
    let found = &posterior.findings.predictive;
    page.subheading("Predictive check");
    let bands: Vec<String> = found
        .bands
        .iter()
        .map(|band| {
            format!(
                "the {:.0} % band holds {:.1} %",
                100.0 * band.level,
                100.0 * band.coverage
            )
        })
        .collect();
    page.paragraph(&format!(
        "New runs are drawn from the posterior at the settings of the runs made{}. Of these {} runs {}; a stuck run counts with \
         the share of its probability that the band holds.",
        if posterior.findings.series_offsets.is_empty() {
            ""
        } else {
            ", with the offsets of their series"
        },
        found.bands.first().map_or(0, |band| band.runs),
        bands.join(", ")
    ));
    if found.stuck.is_empty() {
        return;
    }
    page.paragraph(
        "Series whose number of stuck runs was in doubt; p is the probability of a number at least as far out.",
    );
    let table = ReportTable::of(&found.stuck)
        .column("particle", |row| &row.particle)
        .column("liquid", |row| &row.liquid)
        .column("D / mm", |row| diameter(row.diameter_m))
        .column("δ/D", |row| numbers::short(row.film_ratio))
        .column("runs", |row| row.runs)
        .column("stuck", |row| row.observed)
        .column("expected", |row| format!("{:.1}", row.expected))
        .column("p", |row| numbers::probability(row.p));
    page.table(&table);
}

/// Leave-one-out of every form of the law; nothing where they were not compared.
pub(super) fn forms(page: &mut Page, input: ReportInput) {
    let Some(models) = &input.findings.compare else {
        return;
    };
    page.subheading("Other forms of the law");
    let line = input.findings.checks().find(|check| check.code == LOO_KHAT.code);
    let line = line.map_or(NONE.to_owned(), |check| {
        numbers::significant(check.line.map_or(f64::NAN, Line::threshold), 2)
    });
    let has_roughness = input.scene.why_no_roughness(input.runs.wet_particles()).is_none();
    let unusual = Viscous::NAMED.iter().skip(1);
    let unusual = unusual.filter(|form| has_roughness || !form.reads_roughness());
    let unusual: Vec<String> = unusual
        .map(|form| format!("`+{}`: {}", form.name(), form.words()))
        .collect();
    let of_viscous = match unusual.as_slice() {
        [] => String::new(),
        some => format!(
            ", and this scene's with each other form of the viscous loss ({})",
            some.join(", ")
        ),
    };
    page.paragraph(&format!(
        "Each form of inertia with each dry speed (`/2`: e_dry at 2 m/s; `/impact`: at the run's own speed){of_viscous} by \
         PSIS-LOO: elpd is the log density of each run as predicted from the others, summed; the difference to the best form \
         has the standard error of the differences run by run. Other forms than this scene's are judged by draws of a \
         Student's t about their mode, weighed and resampled, or by trajectories. Up to eight runs with k-hat above the line \
         ({line} for the scene's own draws) are left out by draws made without them; where there are more, the elpd is rough."
    ));
    if input.scene.model.series_offsets {
        page.paragraph(
            "A series is left out as a whole, its offset integrated out, since the other runs of it would tell that: elpd is the \
             log density of each series and each dry run as predicted from the others, and what is told of runs here is of \
             these. A form that misfits from series to series pays by a wider σ_series.",
        );
    }
    page.table(&table(models));
}

fn table(models: &[ComparedModel]) -> ReportTable<&ComparedModel> {
    ReportTable::of(models)
        .column("form", |model| {
            if model.own {
                format!("**{}**, this scene's", model.model)
            } else {
                model.model.clone()
            }
        })
        .column("elpd ± se", |model| match model.se {
            Some(se) => numbers::with_se(model.elpd_loo, se),
            None => numbers::significant(model.elpd_loo, 4),
        })
        .column("difference ± se", |model| match model.delta_se {
            // the best differs from itself by nothing
            _ if model.delta == 0.0 => "0".to_owned(),
            Some(se) => numbers::with_se(model.delta, se),
            None => numbers::significant(model.delta, 3),
        })
        .column("p_loo", |model| numbers::significant(model.p_loo, 2))
        .column("largest k-hat", |model| numbers::optional(model.khat_max, 2))
        .column("runs above", |model| model.khat_high)
        .column("Monte Carlo error", |model| numbers::optional(model.delta_mcse, 1))
        .column("draws", drawn)
}

/// How many draws a form was judged by, and of what kind they are.
fn drawn(model: &ComparedModel) -> String {
    if model.weighed {
        return format!("{} weighed", model.draws);
    }
    let divergences = match model.divergences {
        0 => String::new(),
        some => format!(", {some} divergences"),
    };
    format!("{}, R-hat {}{divergences}", model.draws, rhat(model.rhat))
}
