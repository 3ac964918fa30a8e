//! Writes what was read: ranges of the runs, and what they can identify.

use super::super::numbers;
use super::super::ReportInput;
use super::cells::list;
use super::page::Page;
use super::table::ReportTable;
use crate::error::{plain, quoted};
use crate::findings::film_groups::FilmGroupWidth;
use crate::findings::identify::{Directions, IdentifiableCombination, Unidentified};
use crate::findings::learnt::capital;
use crate::findings::overview::{Material, Overview};
use crate::findings::remarks::in_symbols;
use crate::units::{micrometres, millimetres};

/// The table of what was read, for the report and the `check` command.
fn materials(materials: &[Material]) -> ReportTable<&Material> {
    let range = |range: Option<[f64; 2]>| range.map(numbers::range);
    ReportTable::of(materials)
        .column("particle", |row| &row.particle)
        .column("liquid", |row| &row.liquid)
        .column("runs", |row| row.runs)
        .column("stuck", |row| row.stuck)
        .column_if_any("D / mm", |row| list(&row.diameters_m, millimetres))
        .column_if_any("δ/D", |row| {
            let ratios = &row.film_ratios;
            (!ratios.is_empty()).then(|| list(ratios, |x| x))
        })
        .column_if_any("δ / µm", |row| range(row.film_m.map(|film| film.map(micrometres))))
        .column("v / (m/s)", |row| numbers::range(row.impact_speed_m_s))
        .column_if_any("St", |row| range(row.stokes))
        .column_if_any("Re", |row| range(row.reynolds))
        .column("e", |row| range(row.restitution))
}

/// The table of film groups, for both as well.
fn film_groups<'g>(groups: impl IntoIterator<Item = &'g FilmGroupWidth>) -> ReportTable<&'g FilmGroupWidth> {
    ReportTable::of(groups)
        .column("particle", |row| &row.particle)
        .column("film ratio", |row| numbers::short(row.film_ratio))
        .column("runs", |row| row.runs)
        .column("5 % to 95 %", |row| numbers::range(row.ends))
        .column("width", |row| numbers::significant(row.width, 2))
        .column("laws at one film ratio", |row| {
            row.why_no_laws
                .as_ref()
                .map_or("yes".to_owned(), |why| format!("no: {why}"))
        })
}

pub(super) fn data(page: &mut Page, input: ReportInput) {
    let counts = &input.findings.counts;
    page.heading("Data");
    let screened: usize = counts.screened.iter().map(|s| s.runs).sum();
    let ranges = match input.runs.series.is_empty() {
        true => "",
        false => " St and Re = ρl δ v/η are ranges over the runs, e over the rebounds.",
    };
    page.paragraph(&format!(
        "{} runs read{}, {screened} screened, {} stuck, {} used by least squares.{ranges}",
        counts.runs,
        from_sheets(&counts.sheets),
        counts.stuck,
        counts.used
    ));
    page.table(&materials(&input.overview.materials));
    let directions = input.findings.identifies.iter();
    for directions in directions.filter(|directions| !directions.unseen.is_empty()) {
        page.paragraph(&seen(directions));
        for unseen in &directions.unseen {
            let lines: Vec<String> = unseen_lines(unseen).iter().map(|line| capital(line)).collect();
            page.paragraph(&format!("* {}.", lines.join(". ")));
        }
    }
}

/// Which sheets of workbooks the runs were read from; nothing of other tables.
fn from_sheets(sheets: &[String]) -> String {
    let quoted: Vec<String> = sheets.iter().map(|sheet| quoted(sheet)).collect();
    match quoted.as_slice() {
        [] => String::new(),
        some => format!(" from {}", some.join(", ")),
    }
}

/// The film groups that no law at one film ratio is fitted to.
pub(super) fn groups(page: &mut Page, input: ReportInput) {
    let all = input.findings.film_groups.iter();
    let without = film_groups(all.filter(|group| group.why_no_laws.is_some()));
    if without.is_empty() {
        return;
    }
    page.section(
        "Film groups",
        "Groups of runs without a film ratio of their own. The width is the distance of the 5 % and 95 % quantiles of their \
         δ/D over its mean; the energy balance and the posterior take each run's own film.",
    );
    page.table(&without);
}

/// What the runs see of the parameters together.
fn seen(directions: &Directions) -> String {
    let least = format!(
        "{} is known least and keeps {} % of its prior sd",
        in_symbols(&directions.least_known),
        numbers::significant(100.0 * directions.spread_left, 2)
    );
    match directions.unseen.as_slice() {
        [] => format!("The runs see every direction of the parameters: {least}."),
        _ => format!("The runs say less than the priors in some directions of the parameters ({least}):"),
    }
}

/// Why a direction is unseen, what is determined instead, and what to add.
fn unseen_lines(unseen: &Unidentified) -> Vec<String> {
    let value = |one: &IdentifiableCombination| format!("{} = {}", one.quantity, numbers::with_se(one.value, one.se));
    let determined: Vec<String> = unseen.determined.iter().map(value).collect();
    let mut lines = vec![unseen.reason.clone()];
    if !determined.is_empty() {
        lines.push(format!("determined instead: {}", determined.join(", ")));
    }
    lines.push(unseen.add.clone());
    lines
}

/// What was read, for a terminal: plain columns.
pub fn overview_text(overview: &Overview) -> String {
    let noun = if overview.runs == 1 { "run" } else { "runs" };
    let title = plain(&overview.title, usize::MAX);
    let sheets = from_sheets(&overview.sheets);
    let mut text = format!("{title}\n{} {noun} read{sheets}", overview.runs);
    for screened in &overview.screened {
        text.push_str(&format!(", {} left out ({})", screened.runs, screened.reason));
    }
    text.push_str("\n\n");
    text.push_str(&materials(&overview.materials).plain());
    if !overview.film_groups.is_empty() {
        text.push_str(
            "\nFilm ratios, with the 5 % and 95 % quantiles of the runs' own and their distance over the mean\n",
        );
        text.push_str(&film_groups(&overview.film_groups).plain());
    }
    if let Some(directions) = &overview.directions {
        text.push_str(&format!("\nWhat these runs can identify\n{}\n", seen(directions)));
        for unseen in &directions.unseen {
            text.push_str(&format!("  no   {}\n", unseen_lines(unseen).join("\n       ")));
        }
    }
    if !overview.terms.is_empty() {
        text.push_str("\nThe terms of the energy balance; size: the bias in standard errors if a term is left out\n");
        text.push_str(&super::terms::table(&overview.terms).plain());
    }
    text
}
