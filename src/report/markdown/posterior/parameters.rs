//! Writes the parameters with their priors: what was believed, what the runs made of it, which go together, what was held.

use super::super::super::quantities::{mean_and_sd, unit_in_brackets};
use super::super::super::{figures, numbers, ReportInput};
use super::super::page::Page;
use super::super::table::ReportTable;
use super::cells::{self, rhat, SampledParameter};
use crate::findings::posterior::{HeldParameter, Posterior};
use crate::physics::Quantity;
use crate::scene::Prior;

/// A posterior narrower than this beside its prior is the runs' word alone.
const RUNS_DECIDE: f64 = 0.1;
/// A posterior wider than this beside its prior is mostly the prior.
const PRIOR_DECIDES: f64 = 0.9;
/// Correlations beyond this are worth a word.
const STRONG: f64 = 0.5;

/// The table of parameters with what stands below it, and the pair plot.
pub(super) fn parameters(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection(
        "Parameters",
        "Means and sds have the digits that their Monte Carlo errors leave. sd ratio: posterior sd over prior sd; shift: \
         posterior mean less prior median, in prior sd; both on the logarithm where the prior is lognormal. ESS: the number of \
         independent draws that the draws are worth, for the centre (bulk) and for the 5 % and 95 % points (tail).",
    );
    let rows = cells::parameters(input, posterior);
    let table = ReportTable::of(&rows)
        .column("parameter", |one| &one.label)
        .column("name in files", |one| format!("`{}`", one.found.name))
        .column("unit", |one| unit_in_brackets(one.prior.unit))
        .column("mean", |one| numbers::by_mcse(one.found.mean, one.found.mcse_mean))
        .column("sd", |one| numbers::by_mcse(one.found.sd, one.found.mcse_sd))
        .column("prior", |one| &one.prior.density)
        .column("bounds", |one| match one.prior.upper {
            Some(upper) => format!("{} to {}", bound(one.prior.lower), bound(upper)),
            None if one.prior.lower == f64::NEG_INFINITY => "none".to_owned(),
            None => format!("above {}", bound(one.prior.lower)),
        })
        .column("sd ratio", |one| numbers::optional(one.prior.sd_ratio, 2))
        .column("shift", |one| one.shift().map(numbers::signed))
        .column("R-hat", |one| rhat(one.found.rhat))
        .column("ESS bulk", |one| effective(one.found.ess_bulk))
        .column("ESS tail", |one| effective(one.found.ess_tail));
    page.table(&table);
    for one in &rows {
        if let Some(why) = &one.found.why_none {
            page.paragraph(&format!("{}: {why}.", one.label));
        }
    }
    if let Some(text) = deciding(&rows) {
        page.paragraph(&text);
    }
    let of_k = if rows.iter().any(|one| one.is_dry_k) {
        "; that of k keeps e_dry above zero at every speed in use, since e_dry² would grow again beyond"
    } else {
        ""
    };
    page.paragraph(&format!(
        "Priors are written as in a scene: {}. Each ends at its bounds{of_k}. Where they come from: {}.",
        families(posterior),
        sources(&rows)
    ));
    left_out(page, &posterior.findings.left_out);
    lengths(page, posterior);
    correlations(page, posterior, &rows);
}

fn effective(ess: Option<f64>) -> String {
    ess.map_or(numbers::NONE.to_owned(), |ess| format!("{ess:.0}"))
}

/// Which parameters the priors make what they are; nothing where the runs decide all, as the sd ratios of the table say.
fn deciding(rows: &[SampledParameter]) -> Option<String> {
    let not_by_runs = rows
        .iter()
        .filter_map(|one| Some(format!("{}: {}", one.label, who_decides(one)?)));
    let not_by_runs: Vec<String> = not_by_runs.collect();
    (!not_by_runs.is_empty()).then(|| format!("{}. The runs decide the others.", not_by_runs.join("; ")))
}

/// What makes a parameter what it is, where that is not the runs alone.
fn who_decides(one: &SampledParameter) -> Option<&'static str> {
    let moved = one.shift().is_some_and(|shift| shift.abs() > 1.0);
    if one.prior.runs_alone.is_some_and(|alone| alone.contradicts_prior()) {
        return Some("the runs contradict the prior");
    }
    match one.prior.sd_ratio? {
        ratio if ratio < RUNS_DECIDE => None,
        ratio if ratio > PRIOR_DECIDES && !moved => Some("the prior decides"),
        ratio if ratio > PRIOR_DECIDES => Some("the runs move it, without narrowing it"),
        _ => Some("runs and prior together"),
    }
}

/// Where the priors come from, each source with its parameters.
fn sources(rows: &[SampledParameter]) -> String {
    let mut sources: Vec<(&str, Vec<&str>)> = vec![];
    for one in rows {
        match sources.iter_mut().find(|(source, _)| *source == one.prior.source) {
            Some((_, labels)) => labels.push(&one.label),
            None => sources.push((one.prior.source, vec![&one.label])),
        }
    }
    let texts = sources
        .iter()
        .map(|(source, labels)| format!("for {}, {source}", labels.join(" and ")));
    texts.collect::<Vec<_>>().join("; ")
}

/// δc of each particle.
fn lengths(page: &mut Page, posterior: &Posterior) {
    let both = posterior.derived.iter().zip(&posterior.findings.derived);
    let of_particles = both.filter(|(derived, _)| derived.setting.is_none());
    // particles of one roughness have one
    let mut lengths: Vec<(String, Vec<&str>)> = vec![];
    for (derived, found) in of_particles {
        let (length, Some(particle)) = (mean_and_sd(Quantity::DeltaC, found), derived.label.as_deref()) else {
            continue;
        };
        match lengths.iter_mut().find(|(other, _)| *other == length) {
            Some((_, particles)) => particles.push(particle),
            None => lengths.push((length, vec![particle])),
        }
    }
    let lengths = lengths
        .iter()
        .map(|(length, particles)| format!("{length} µm ({})", particles.join(", ")));
    let lengths: Vec<String> = lengths.collect();
    if !lengths.is_empty() {
        page.paragraph(&format!("δc = ε exp(L) = {}.", lengths.join(", ")));
    }
}

fn bound(x: f64) -> String {
    if x == 0.0 || x.abs() >= 0.01 {
        numbers::short(x)
    } else {
        numbers::significant(x, 3)
    }
}

/// The families in use, each with the meaning of its numbers.
fn families(posterior: &Posterior) -> String {
    let mut used: Vec<&str> = vec![];
    for parameter in &posterior.sampled.parameters.sampled {
        let words = match parameter.prior {
            Prior::LogNormal(..) => "lognormal [median, sd of the logarithm]",
            Prior::HalfNormal(_) => "half_normal scale",
            Prior::Normal(..) => "normal [mean, sd]",
            Prior::Gamma(..) => "gamma [shape, rate]",
            Prior::Uniform(..) => "uniform [lower, upper]",
            Prior::StudentT(..) => "student_t [degrees of freedom, location, scale]",
            // held, not sampled
            Prior::Fixed(_) => continue,
        };
        if !used.contains(&words) {
            used.push(words);
        }
    }
    used.join(", ")
}

fn left_out(page: &mut Page, left_out: &[HeldParameter]) {
    if left_out.is_empty() {
        return;
    }
    page.paragraph("Not sampled:");
    let table = ReportTable::of(left_out)
        .column("parameter", |left| format!("`{}`", left.name))
        .column("held at", |left| {
            left.value
                .map_or("not read".to_owned(), |value| numbers::significant(value, 4))
        })
        .column("why", |left| &left.reason);
    page.table(&table);
    if let Some(text) = held(left_out) {
        page.paragraph(&text);
    }
}

/// What the posterior takes as known; nothing where all that it reads was sampled.
pub(in super::super) fn held(left_out: &[HeldParameter]) -> Option<String> {
    let held: Vec<String> = left_out
        .iter()
        .filter_map(|left| Some(format!("{} at {}", left.name, numbers::significant(left.value?, 3))))
        .collect();
    (!held.is_empty()).then(|| {
        format!(
            "The posterior holds {}: what is not known of that is not in its ±.",
            held.join(" and ")
        )
    })
}

/// Pairs of parameters the runs do not tell well apart, and the pair plot.
fn correlations(page: &mut Page, posterior: &Posterior, parameters: &[SampledParameter]) {
    let found = &posterior.findings;
    let mut pairs = vec![];
    for (i, row) in found.correlation.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if correlation.abs() > STRONG {
                let names = [j, i].map(|place| parameters[place].label.as_str());
                pairs.push((*correlation, names));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let correlated: Vec<String> = pairs
        .iter()
        .map(|(correlation, [a, b])| format!("{a} with {b} ({})", numbers::signed(*correlation)))
        .collect();
    page.paragraph(&if correlated.is_empty() {
        format!("No two parameters are correlated beyond {STRONG}.")
    } else {
        format!("Correlated beyond {STRONG}: {}.", correlated.join("; "))
    });
    page.figure(
        figures::PAIRS,
        "pairs of parameters",
        &format!(
            "Draws of each pair of parameters, thinned; on the diagonal the posterior as a histogram with the prior \
             density as a line.{}{}",
            without_panel(posterior),
            if found.divergences > 0 {
                " Hollow marks are draws whose trajectory diverged."
            } else {
                ""
            }
        ),
    );
}

/// How many parameters have no place in the figure of pairs; nothing where all have.
fn without_panel(posterior: &Posterior) -> String {
    match posterior.sampled.values.len() {
        all if all > figures::MOST_PAIRED => format!(
            " Shown are {} of the {all} parameters, those of all runs before the k of each particle; the tables have all.",
            figures::MOST_PAIRED
        ),
        _ => String::new(),
    }
}
