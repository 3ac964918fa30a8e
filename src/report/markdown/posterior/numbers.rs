//! Tells the parameters, what follows from them, how far the runs moved them from the priors, and which go together.

use super::super::super::numbers::{self, NONE};
use super::super::super::{figures, Told};
use super::super::page::Page;
use super::cells::{label, rhat};
use crate::findings::posterior::derived::WetSetting;
use crate::findings::posterior::{Posterior, QuantitySummary};
use crate::physics::inertia::Inertia;
use crate::units::micrometres;

/// A posterior narrower than this beside its prior is the runs' word alone.
const RUNS_DECIDE: f64 = 0.1;
/// A posterior wider than this beside its prior is mostly the prior.
const PRIOR_DECIDES: f64 = 0.9;
/// Correlations beyond this are worth a word.
const STRONG: f64 = 0.5;

/// The table of parameters, and the pair plot.
pub(super) fn parameters(page: &mut Page, posterior: &Posterior) {
    page.subheading("Parameters");
    page.paragraph(
        "Each number is printed to the last digit worth more than its own Monte Carlo standard error, one digit at least \
         (the 50 % point to that of the mean). sd is the spread of the posterior; ESS is how many independent draws the draws are worth, for \
         the centre (bulk) and for the 5 % and 95 % points (tail).",
    );
    let rows: Vec<Vec<String>> = posterior
        .findings
        .parameters
        .iter()
        .map(|q| {
            let mut cells = vec![
                label(q),
                numbers::by_mcse(q.mean, q.mcse_mean),
                numbers::by_mcse(q.sd, q.mcse_sd),
                numbers::by_mcse(q.q05, q.mcse_q05),
                numbers::by_mcse(q.median, q.mcse_mean),
                numbers::by_mcse(q.q95, q.mcse_q95),
                rhat(q.rhat),
            ];
            cells.extend([q.ess_bulk, q.ess_tail].map(effective));
            cells
        })
        .collect();
    let header = [
        "parameter",
        "mean",
        "sd",
        "5 %",
        "50 %",
        "95 %",
        "R-hat",
        "ESS bulk",
        "ESS tail",
    ];
    page.table(&header, &rows);
    for q in posterior.findings.parameters.iter() {
        if let Some(why) = &q.why_none {
            page.paragraph(&format!("{}: {why}.", label(q)));
        }
    }
}

fn effective(ess: Option<f64>) -> String {
    ess.map_or(NONE.to_owned(), |ess| format!("{ess:.0}"))
}

/// δc, then e_inf, St_c and the Stokes number of no rebound, one row a setting.
pub(super) fn derived(page: &mut Page, told: Told, posterior: &Posterior) {
    let both: Vec<(&QuantitySummary, Option<&WetSetting>)> = posterior
        .findings
        .derived
        .iter()
        .zip(posterior.derived.iter().map(|derived| derived.setting.as_ref()))
        .collect();
    if both.is_empty() {
        return;
    }
    page.subheading("What follows from them");
    let lengths = both.iter().filter(|(_, setting)| setting.is_none());
    let rows: Vec<Vec<String>> = lengths
        .map(|(q, _)| {
            let particle = q.name.split_once('[').map(|(_, rest)| rest.trim_end_matches(']'));
            let (name, scale): (String, fn(f64) -> f64) = match particle {
                Some(particle) => (format!("δc / µm, {particle}"), micrometres),
                None => ("δc/ε = exp(L)".to_owned(), |x| x),
            };
            vec![
                name,
                numbers::mean_and_sd(q, scale),
                numbers::five_to_ninety_five(q, scale),
            ]
        })
        .collect();
    page.paragraph("± is one standard deviation of the posterior about its mean.");
    page.table(&["quantity", "mean ± sd", "5 % to 95 %"], &rows);
    let speed = numbers::short(told.scene.model.dry_speed.reference());
    page.paragraph(&format!(
        "At each particle, liquid and film ratio: e_inf with e_dry at {speed} m/s, St_c = 2 L/e_inf², and 2 St_c, \
         below which nothing rebounds."
    ));
    let of = |quantity: &str, wanted: &WetSetting| {
        let start = format!("{quantity}[");
        let mine = |(q, setting): &&(&QuantitySummary, Option<&WetSetting>)| {
            *setting == Some(wanted) && q.name.starts_with(&start)
        };
        both.iter().find(mine).map(|(q, _)| *q)
    };
    let mut rows: Vec<Vec<String>> = vec![];
    for (e_inf, setting) in both.iter().filter(|(q, _)| q.name.starts_with("e_inf[")) {
        let Some(setting) = setting else { continue };
        let mut row = vec![
            told.scene.particles[setting.particle].name.clone(),
            told.scene.liquids[setting.liquid].name.clone(),
            numbers::short(setting.film_ratio),
        ];
        if posterior.findings.inertia == Inertia::None.name() {
            // neither liquid nor film enters
            row[1..].fill("all".to_owned());
            if rows.last().is_some_and(|last| last[0] == row[0]) {
                continue;
            }
        }
        for q in [Some(*e_inf), of("st_c", setting)] {
            row.push(q.map_or(NONE.to_owned(), |q| numbers::mean_and_sd(q, |x| x)));
            row.push(q.map_or(NONE.to_owned(), |q| numbers::five_to_ninety_five(q, |x| x)));
        }
        let no_rebound = of("st_no_rebound", setting);
        row.push(no_rebound.map_or(NONE.to_owned(), |q| numbers::mean_and_sd(q, |x| x)));
        if let Some(why) = &e_inf.why_none {
            row[3] = format!("none: {why}");
        }
        rows.push(row);
    }
    let header = [
        "particle",
        "liquid",
        "δ/D",
        "e_inf ± sd",
        "5 % to 95 %",
        "St_c ± sd",
        "5 % to 95 %",
        "2 St_c ± sd",
    ];
    page.table(&header, &rows);
    let worst = |of: fn(&QuantitySummary) -> Option<f64>, pick: fn(f64, f64) -> f64| {
        both.iter().filter_map(|(q, _)| of(q)).reduce(pick)
    };
    page.paragraph(&format!(
        "Among these the largest R-hat is {}, the fewest effective draws {} (bulk) and {} (tail).",
        rhat(worst(|q| q.rhat, f64::max)),
        effective(worst(|q| q.ess_bulk, f64::min)),
        effective(worst(|q| q.ess_tail, f64::min))
    ));
}

/// How far each parameter moved from its prior.
pub(super) fn beside_the_prior(page: &mut Page, posterior: &Posterior) {
    page.subheading("Prior against posterior");
    page.paragraph(&format!(
        "Shift: posterior mean minus prior median, in prior sd. sd ratio: posterior sd over prior sd; below {RUNS_DECIDE} \
         the runs decide, above {PRIOR_DECIDES} they narrow nothing."
    ));
    let rows: Vec<Vec<String>> = posterior
        .findings
        .parameters
        .iter()
        .filter_map(|q| {
            let prior = q.prior.as_ref()?;
            let shift = q.mean.zip(prior.sd).map(|(mean, sd)| (mean - prior.median) / sd);
            let moved = shift.is_some_and(|shift| shift.abs() > 1.0);
            let said = match prior.sd_ratio {
                None => "the prior has no sd",
                Some(ratio) if ratio < RUNS_DECIDE => "the runs decide",
                Some(ratio) if ratio > PRIOR_DECIDES && !moved => "the prior decides",
                Some(ratio) if ratio > PRIOR_DECIDES => "the runs move it, without narrowing it",
                Some(_) => "runs and prior together",
            };
            Some(vec![
                label(q),
                numbers::significant(prior.median, 3),
                numbers::optional(prior.sd, 3),
                numbers::mean_and_sd(q, |x| x),
                shift.map_or(NONE.to_owned(), numbers::signed),
                numbers::optional(prior.sd_ratio, 2),
                said.to_owned(),
            ])
        })
        .collect();
    let header = [
        "parameter",
        "prior median",
        "prior sd",
        "posterior mean ± sd",
        "shift",
        "sd ratio",
        "who decides",
    ];
    page.table(&header, &rows);
    page.figure(
        figures::PRIORS,
        "prior against posterior",
        "Prior (line) and posterior (shaded) of each parameter over the range of the prior, each over its own maximum.",
    );
}

/// Pairs of parameters the runs do not tell well apart, and the pair plot.
pub(super) fn correlations(page: &mut Page, posterior: &Posterior) {
    let found = &posterior.findings;
    let mut pairs = vec![];
    for (i, row) in found.correlation.iter().enumerate() {
        for (j, correlation) in row.iter().enumerate().take(i) {
            if correlation.abs() > STRONG {
                let names = [j, i].map(|place| label(&found.parameters[place]));
                pairs.push((*correlation, names));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let told: Vec<String> = pairs
        .iter()
        .map(|(correlation, [a, b])| format!("{a} with {b} ({})", numbers::signed(*correlation)))
        .collect();
    page.paragraph(&if told.is_empty() {
        format!("No two parameters are correlated beyond {STRONG}.")
    } else {
        format!(
            "Correlated beyond {STRONG}: {}. What the runs say of one of such a pair holds only together with the other.",
            told.join("; ")
        )
    });
    page.figure(
        figures::PAIRS,
        "pairs of parameters",
        &format!(
            "Draws of each pair of parameters, thinned; on the diagonal the posterior as a histogram with the prior \
             density as a line.{}",
            if found.divergences > 0 {
                " Hollow marks are draws whose trajectory diverged."
            } else {
                ""
            }
        ),
    );
}
