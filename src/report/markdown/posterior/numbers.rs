//! Writes the parameters, what follows from them, how far the runs moved them from the priors, and which go together.

use super::super::super::quantities::{five_to_ninety_five, label, mean_and_sd};
use super::super::super::{figures, numbers, ReportInput};
use super::super::cells::diameter;
use super::super::page::Page;
use super::super::table::ReportTable;
use super::cells::{self, rhat, SampledParameter};
use crate::findings::posterior::derived::{DerivedDraws, WetSetting};
use crate::findings::posterior::{Posterior, QuantitySummary};
use crate::physics::{Inertia, Quantity};

/// A posterior narrower than this beside its prior is the runs' word alone.
const RUNS_DECIDE: f64 = 0.1;
/// A posterior wider than this beside its prior is mostly the prior.
const PRIOR_DECIDES: f64 = 0.9;
/// Correlations beyond this are worth a word.
const STRONG: f64 = 0.5;

/// The table of parameters, and the pair plot.
pub(super) fn parameters(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection(
        "Parameters",
        "What the runs and the priors together say of each parameter.",
    );
    page.paragraph(
        "Each number is printed to the last digit worth more than its own Monte Carlo standard error, one digit at least \
         (the 50 % point to that of the mean). sd is the spread of the posterior; ESS is how many independent draws the draws are worth, for \
         the centre (bulk) and for the 5 % and 95 % points (tail).",
    );
    let rows = cells::parameters(input, posterior);
    let table = ReportTable::of(&rows)
        .column("parameter", |one| &one.label)
        .column("mean", |one| numbers::by_mcse(one.found.mean, one.found.mcse_mean))
        .column("sd", |one| numbers::by_mcse(one.found.sd, one.found.mcse_sd))
        .column("5 %", |one| numbers::by_mcse(one.found.q05, one.found.mcse_q05))
        .column("50 %", |one| numbers::by_mcse(one.found.median, one.found.mcse_mean))
        .column("95 %", |one| numbers::by_mcse(one.found.q95, one.found.mcse_q95))
        .column("R-hat", |one| rhat(one.found.rhat))
        .column("ESS bulk", |one| effective(one.found.ess_bulk))
        .column("ESS tail", |one| effective(one.found.ess_tail));
    page.table(&table);
    for one in &rows {
        if let Some(why) = &one.found.why_none {
            page.paragraph(&format!("{}: {why}.", one.label));
        }
    }
}

fn effective(ess: Option<f64>) -> String {
    ess.map_or(numbers::NONE.to_owned(), |ess| format!("{ess:.0}"))
}

/// δc, then e_inf, St_c and the Stokes number of no rebound, one row a setting.
pub(super) fn derived(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    let both = posterior.derived.iter().zip(&posterior.findings.derived);
    let all: Vec<Following> = both.map(|(derived, found)| Following { derived, found }).collect();
    if all.is_empty() {
        return;
    }
    page.subsection(
        "What follows from them",
        "Every quantity that the parameters determine. ± is one standard deviation of the posterior about its mean.",
    );
    let lengths = lengths(&all);
    if !lengths.is_empty() {
        page.table(&lengths);
        if let Some(why) = input.scene.why_no_roughness(input.runs.wet_particles()) {
            page.paragraph(&format!("δc = ε exp(L) is missing where ε is: {why}."));
        }
    }
    let speed = numbers::short(input.scene.model.dry_speed.reference());
    page.paragraph(&format!(
        "At each particle, liquid{} e_inf with e_dry at {speed} m/s, St_c = 2 L/e_inf², and 2 St_c, \
         below which nothing rebounds.",
        if of_diameters(posterior) {
            ", film ratio and diameter:"
        } else {
            " and film ratio:"
        }
    ));
    let settings = settings(&all, posterior);
    page.table(&of_settings(&settings, input, posterior));
    let worst = |of: fn(&QuantitySummary) -> Option<f64>, worse: fn(f64, f64) -> f64| {
        all.iter().filter_map(|one| of(one.found)).reduce(worse)
    };
    page.paragraph(&format!(
        "Among these the largest R-hat is {}, the fewest effective draws {} (bulk) and {} (tail).",
        rhat(worst(|q| q.rhat, f64::max)),
        effective(worst(|q| q.ess_bulk, f64::min)),
        effective(worst(|q| q.ess_tail, f64::min))
    ));
}

/// What follows from the parameters, with what is found of it.
#[derive(Clone, Copy)]
struct Following<'a> {
    derived: &'a DerivedDraws,
    found: &'a QuantitySummary,
}

impl Following<'_> {
    fn is(&self, quantity: Quantity) -> bool {
        self.derived.quantity == quantity.describe().name
    }
}

/// δc/ε, and δc of each particle.
fn lengths<'a>(all: &[Following<'a>]) -> ReportTable<Following<'a>> {
    let quantity = |one: Following| match one.derived.label {
        Some(_) => Quantity::DeltaC,
        None => Quantity::DeltaCOverRoughness,
    };
    ReportTable::of(all.iter().filter(|one| one.derived.setting.is_none()).copied())
        .column("quantity", |one| match &one.derived.label {
            Some(particle) => format!("{}, {particle}", label(quantity(one))),
            None => format!("{} = exp(L)", label(quantity(one))),
        })
        .column("mean ± sd", |one| mean_and_sd(quantity(one), one.found))
        .column("5 % to 95 %", |one| five_to_ninety_five(quantity(one), one.found))
}

/// The quantities of a setting.
const OF_SETTING: [Quantity; 3] = [Quantity::EInf, Quantity::StC, Quantity::StNoRebound];

/// A setting with what is found of its quantities, those there are.
struct SettingRow<'a> {
    setting: &'a WetSetting,
    found: [Option<&'a QuantitySummary>; OF_SETTING.len()],
}

/// Every setting; of forms without inertia one a particle, as neither liquid nor film enters.
fn settings<'a>(all: &[Following<'a>], posterior: &Posterior) -> Vec<SettingRow<'a>> {
    let of_e_inf = all.iter().filter(|one| one.is(Quantity::EInf));
    let settings = of_e_inf.filter_map(|one| one.derived.setting.as_ref());
    let mut rows: Vec<SettingRow> = settings
        .map(|setting| {
            let of = |quantity: Quantity| {
                let mine = |one: &&Following| one.derived.setting.as_ref() == Some(setting) && one.is(quantity);
                all.iter().find(mine).map(|one| one.found)
            };
            SettingRow {
                setting,
                found: OF_SETTING.map(of),
            }
        })
        .collect();
    if !reads_film(posterior) {
        rows.dedup_by_key(|row| row.setting.sphere);
    }
    rows
}

/// Whether film or liquid enter e_inf and St_c.
fn reads_film(posterior: &Posterior) -> bool {
    posterior.setup.form.inertia != Inertia::None || tells_diameters_apart(posterior)
}

/// Whether what follows belongs to a diameter, by the form or by k.
fn of_diameters(posterior: &Posterior) -> bool {
    let mut settings = posterior.derived.iter().filter_map(|one| one.setting.as_ref());
    settings.any(|setting| setting.diameter.is_some())
}

/// Whether St_c belongs to a film and a diameter.
fn tells_diameters_apart(posterior: &Posterior) -> bool {
    posterior.setup.form.viscous.tells_diameters_apart()
}

fn of_settings<'a>(
    rows: &'a [SettingRow],
    input: ReportInput,
    posterior: &Posterior,
) -> ReportTable<&'a SettingRow<'a>> {
    let own = |text: String| if reads_film(posterior) { text } else { "all".to_owned() };
    let mut table = ReportTable::of(rows)
        .column("particle", |row| &input.scene.particles[row.setting.particle].name)
        .column("liquid", |row| {
            own(input.scene.liquids[row.setting.liquid].name.clone())
        })
        .column("δ/D", |row| own(numbers::short(row.setting.film_ratio)));
    if of_diameters(posterior) {
        table = table.column("D / mm", |row| row.setting.diameter.map(diameter));
    }
    for (place, quantity) in OF_SETTING.into_iter().enumerate() {
        table = table.column(format!("{} ± sd", label(quantity)), |row| {
            let found = row.found[place]?;
            let why_none = found.why_none.as_ref().filter(|_| quantity == Quantity::EInf);
            Some(why_none.map_or_else(|| mean_and_sd(quantity, found), |why| format!("none: {why}")))
        });
        if quantity != Quantity::StNoRebound {
            table = table.column("5 % to 95 %", |row| {
                row.found[place].map(|found| five_to_ninety_five(quantity, found))
            });
        }
    }
    table
}

/// How far each parameter moved from its prior.
pub(super) fn beside_the_prior(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection(
        "Prior against posterior",
        "How far the runs moved and narrowed each prior.",
    );
    page.paragraph(&format!(
        "Shift: posterior mean minus prior median, in prior sd. sd ratio: posterior sd over prior sd; below {RUNS_DECIDE} \
         the runs decide, above {PRIOR_DECIDES} they narrow nothing. Both on the logarithm where the prior is lognormal."
    ));
    let parameters = cells::parameters(input, posterior);
    let table = ReportTable::of(&parameters)
        .column("parameter", |one| &one.label)
        .column("prior median", |one| numbers::significant(one.prior.median, 3))
        .column("prior sd", |one| numbers::optional(one.prior.sd, 3))
        .column("posterior mean ± sd", |one| numbers::mean_and_sd(one.found, |x| x))
        .column("shift", |one| one.shift().map(numbers::signed))
        .column("sd ratio", |one| numbers::optional(one.prior.sd_ratio, 2))
        .column("who decides", who_decides);
    page.table(&table);
}

/// Whether a parameter is what the runs or what its prior makes it.
fn who_decides(one: &SampledParameter) -> Option<&'static str> {
    let moved = one.shift().is_some_and(|shift| shift.abs() > 1.0);
    if one.prior.runs_alone.is_some_and(|alone| alone.contradicts_prior()) {
        return Some("the runs contradict the prior");
    }
    Some(match one.prior.sd_ratio? {
        ratio if ratio < RUNS_DECIDE => "the runs decide",
        ratio if ratio > PRIOR_DECIDES && !moved => "the prior decides",
        ratio if ratio > PRIOR_DECIDES => "the runs move it, without narrowing it",
        _ => "runs and prior together",
    })
}

/// Pairs of parameters the runs do not tell well apart, and the pair plot.
pub(super) fn correlations(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    let found = &posterior.findings;
    let parameters = cells::parameters(input, posterior);
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
        format!(
            "Correlated beyond {STRONG}: {}. What the runs say of one of such a pair holds only together with the other.",
            correlated.join("; ")
        )
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
