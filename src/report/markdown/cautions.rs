//! Writes the cautions, what else was noted, the checks, and how to make the report again.

use super::super::ReportInput;
use super::cells::found;
use super::escape::{code, literal};
use super::page::Page;
use super::table::ReportTable;
use crate::findings::remarks::{in_order, IN_TABLES};
use crate::remark::{Level, Remark};

/// The heading over what bears on the main numbers.
pub(in crate::report) const CAUTIONS: &str = "Cautions";

/// The heading over notices that do not.
const ALSO_NOTED: &str = "Also noted";

pub(super) fn cautions(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading(CAUTIONS);
    let cautions = findings.cautions();
    let cautions: Vec<String> = cautions.iter().map(|one| told(one)).collect();
    page.list(&cautions);
    if cautions.is_empty() {
        page.paragraph("None.");
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

/// The notices that move no main number and stand in no table.
pub(super) fn also_noted(page: &mut Page, input: ReportInput) {
    let informing = in_order(&input.findings.remarks).into_iter();
    let informing = informing.filter(|own| own.informs() && own.line.is_none() && !IN_TABLES.contains(&own.code));
    let lines: Vec<String> = informing.map(told).collect();
    if !lines.is_empty() {
        page.section(ALSO_NOTED, "What moves no main number by more than a quarter of its ±.");
        page.list(&lines);
    }
}

/// How many checks hold, and those that do not.
pub(super) fn checks(page: &mut Page, input: ReportInput) {
    let failed = || input.findings.checks().filter(|check| !check.passed);
    let all = input.findings.checks().count();
    page.section(
        "Checks",
        &format!(
            "{} of {all} checks hold; `findings.json` has the value and the line of each.",
            all - failed().count()
        ),
    );
    // what was found stands under the verdict, or under Cautions
    let forbidding = failed().filter(|check| check.forbids());
    let lines = forbidding.map(|check| {
        format!(
            "Not to be quoted: {}. Why this line: {}.",
            code(check.code),
            check.source
        )
    });
    page.list(&lines.collect::<Vec<String>>());
    let of = |level: Level| failed().filter(move |check| check.level == level);
    let cautioning: Vec<String> = of(Level::Cautions).map(|check| code(check.code)).collect();
    let informing: Vec<String> = of(Level::Informs).map(found).collect();
    for (what, which) in [
        ("These fail and stand under Cautions", cautioning),
        ("These fail, and no main number rests on them", informing),
    ] {
        if !which.is_empty() {
            page.paragraph(&format!("{what}: {}.", which.join("; ")));
        }
    }
}

pub(super) fn reproduce(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading("How to reproduce");
    let names = input.scene.data.runs.iter().filter_map(|runs| runs.path.file_name());
    let names: Vec<String> = names.map(|name| literal(&name.to_string_lossy())).collect();
    let runs = names.join(", ");
    page.paragraph(&format!(
        "{}, wetcor {}. Full precision, every interval and every reason stand in `findings.json`.",
        code(input.command),
        findings.wetcor
    ));
    let files = [("scene", &findings.scene_sha256), (&runs, &findings.data_sha256)];
    let table = ReportTable::of(files)
        .column("input", |(name, _)| name)
        .column("SHA-256", |(_, hash)| hash);
    page.table(&table);
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
