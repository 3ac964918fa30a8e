//! Writes the cautions, what else was noted, the checks, and how to make the report again.

use super::super::ReportInput;
use super::cells::check_table;
use super::escape::{code, literal};
use super::page::Page;
use super::posterior;
use super::table::ReportTable;
use crate::findings::by_weight;
use crate::findings::checks::Check;

/// The heading over what bears on the main numbers.
pub(in crate::report) const CAUTIONS: &str = "Cautions";

/// The heading over notices that do not.
const ALSO_NOTED: &str = "Also noted";

pub(super) fn cautions(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading(CAUTIONS);
    let cautions = findings.cautions();
    let cautions: Vec<String> = cautions.iter().map(|one| told(one.text, one.next_step)).collect();
    page.list(&cautions);
    if cautions.is_empty() {
        page.paragraph("None.");
    }
}

/// What was found and what to do about it.
fn told(text: &str, next_step: &str) -> String {
    format!("{text}. Next: {next_step}.")
}

/// The notices that move no main number.
pub(super) fn also_noted(page: &mut Page, input: ReportInput) {
    let informing = by_weight(&input.findings.notices)
        .into_iter()
        .filter(|notice| !notice.cautions());
    let lines: Vec<String> = informing.map(|notice| told(&notice.text, &notice.next_step)).collect();
    if !lines.is_empty() {
        page.section(ALSO_NOTED, "What moves no main number by more than a quarter of its ±.");
        page.list(&lines);
    }
}

/// What must hold before the numbers are quoted, with what does not.
pub(super) fn checks(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.section(
        "Checks",
        "What must hold before the numbers are quoted, and what of other checks fails.",
    );
    let checks = findings.verdicts.iter();
    let checks = checks.filter(|check| !check.passed || check.gates && !posterior::lists(input, check));
    let text = |check: &Check| {
        if check.passed {
            check.text.clone()
        } else {
            told(check.found(), check.advice)
        }
    };
    let outcome = |check: &Check| match check {
        check if check.passed => "holds",
        check if check.gates => "fails: not to be quoted",
        check if check.concerns.is_empty() => "fails; no main number rests on it",
        _ => "fails: a caution",
    };
    page.table(&check_table(checks, 3, text, outcome));
    if input.posterior.is_some() {
        page.paragraph("The posterior's own checks that hold stand in its section.");
    }
}

pub(super) fn reproduce(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading("How to reproduce");
    let names = input.scene.data.runs.iter().filter_map(|runs| runs.path.file_name());
    let names: Vec<String> = names.map(|name| literal(&name.to_string_lossy())).collect();
    let runs = names.join(", ");
    page.paragraph(&format!(
        "{}, wetcor {}. Full precision, further intervals and every reason stand in `findings.json`.",
        code(input.command),
        findings.wetcor
    ));
    let files = [("scene", &findings.scene_sha256), (&runs, &findings.data_sha256)];
    let table = ReportTable::of(files)
        .column("input", |(name, _)| name)
        .column("SHA-256", |(_, hash)| hash);
    page.table(&table);
}
