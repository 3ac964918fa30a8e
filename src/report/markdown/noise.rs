//! Writes what the scatter of the runs is like, and what the standard errors lack by it.

use super::super::numbers;
use super::super::ReportInput;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::noise::{
    GroupSpread, Noise, NoiseGrowth, Offsets, SpreadTest, StandardErrorRatio, FALSE_ALARM, LINE,
};
use crate::scene::LikelihoodFamily;

pub(super) fn noise(page: &mut Page, input: ReportInput) {
    let Some(noise) = &input.findings.noise else {
        return;
    };
    let has_offsets = input.scene.model.series_offsets;
    page.section(
        "Noise",
        if has_offsets {
            "Least squares takes the runs as independent, with one spread for all dry and one for all wet runs; the posterior \
             gives each series an offset. What was found about the joint fit of dry law and energy balance by least squares:"
        } else {
            "Every interval takes the runs as independent, with one spread for all dry and one for all wet runs. What was \
             found about the joint fit of dry law and energy balance:"
        },
    );
    let mut lines = vec![];
    if input.scene.model.likelihood == LikelihoodFamily::Normal {
        lines.push(outliers(noise));
    }
    lines.extend(noise.spread.as_ref().map(spreads));
    lines.extend(noise.growth.as_ref().and_then(growth));
    let of_offsets = noise.offsets.as_ref();
    lines.extend(of_offsets.map(|own| offsets(own, has_offsets)));
    page.list(&lines);
    let spread = noise
        .spread
        .as_ref()
        .filter(|spread| spread.affected_standard_error().is_some());
    let offsets = of_offsets.filter(|own| own.affected_standard_error().is_some() && !has_offsets);
    if spread.is_some() || offsets.is_some() {
        let all = [
            spread.map(|one| &one.standard_errors),
            offsets.map(|one| &one.standard_errors),
        ];
        table(page, all);
    }
}

fn outliers(noise: &Noise) -> String {
    let runs = noise.runs;
    let line = format!(
        "normal noise takes a run so far in {} % of tables of {runs} runs",
        100.0 * FALSE_ALARM
    );
    match noise.outliers_found {
        0 => format!("Outliers: none ({line})."),
        found => format!("Outliers: {found} ({line}), named under Cautions; left out of the next lines."),
    }
}

fn spreads(spread: &SpreadTest) -> String {
    let of = |group: &GroupSpread| {
        format!(
            "{} ({}, {} runs)",
            numbers::significant(group.sd, 2),
            group.label(),
            group.runs
        )
    };
    format!(
        "Spread: from {} to {}; as unequal by chance with probability {} (Brown–Forsythe).{}",
        of(&spread.narrowest),
        of(&spread.widest),
        numbers::probability(spread.test.p),
        by(spread.affected_standard_error())
    )
}

fn growth(growth: &NoiseGrowth) -> Option<String> {
    let strongest = growth.strongest()?;
    let [from, to] = strongest.ends();
    let tests = growth.tests.len();
    let mut line = format!(
        "Growth: most with {} of the {} runs, by a factor of {} in the sd from {from} to {to}; so much by chance with \
         probability {} (score test on squared residuals, strongest of {tests} over v, 1/St and e).",
        strongest.with.words(),
        strongest.of,
        numbers::significant(strongest.factor, 2),
        numbers::probability(strongest.p)
    );
    for found in growth.found() {
        let [from, to] = found.ends();
        let [slow, fast] = found.band_holds.map(|share| 100.0 * share);
        line.push_str(&format!(
            " A 90 % band of single {} runs would hold about {slow:.0} % of them at {from} and {fast:.0} % at {to}.",
            found.of
        ));
    }
    Some(line)
}

fn offsets(offsets: &Offsets, are_held: bool) -> String {
    let lacking = match are_held {
        true => " The posterior holds them.".to_owned(),
        false => by(offsets.affected_standard_error()),
    };
    format!(
        "Offsets shared by the runs of a series: sd {} in e, {} of the spread of single runs, over {} series; so large by \
         chance with probability {} (F({}, {})).{}",
        numbers::significant(offsets.sd, 2),
        numbers::significant(offsets.share, 2),
        offsets.series,
        numbers::probability(offsets.test.p),
        offsets.test.df_between,
        offsets.test.df_within,
        lacking
    )
}

fn by(lacking: Option<&StandardErrorRatio>) -> String {
    lacking.map_or(String::new(), |lacking| {
        format!(
            " The standard error of {} is too small by a factor of {:.2}.",
            lacking.parameter, lacking.ratio
        )
    })
}

/// What each standard error lacks, where one matters.
fn table(page: &mut Page, all: [Option<&Vec<StandardErrorRatio>>; 2]) {
    page.paragraph(&format!(
        "The standard error that allows for it over the one that does not; above {LINE} a 95 % interval covers less than \
         94 %, below 1 it is wider than it needs to be."
    ));
    let mut names: Vec<&str> = all
        .iter()
        .flatten()
        .flat_map(|one| one.iter())
        .map(|one| one.parameter.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    let ratio = |one: Option<&Vec<StandardErrorRatio>>, name: &str| {
        let found = one?.iter().find(|lacking| lacking.parameter == name);
        found.map(|lacking| format!("{:.2}", lacking.ratio))
    };
    let [spread, offsets] = all;
    let table = ReportTable::of(names)
        .column("parameter", |name| name)
        .column("unequal spreads", |name| ratio(spread, name))
        .column("shared offsets", |name| ratio(offsets, name));
    page.table(&table);
}
