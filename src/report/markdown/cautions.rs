//! Writes the cautions, what else was noted, the checks, and how to make the report again.

use super::super::ReportInput;
use super::cells::found;
use super::escape::{code, literal};
use super::page::Page;
use super::table::ReportTable;
use crate::findings::by_weight;
use crate::findings::checks::Check;
use crate::findings::notices::IN_TABLES;

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

/// What was found and what to do about it, where there is anything.
fn told(text: &str, next_step: &str) -> String {
    match next_step.strip_prefix("nothing") {
        None => format!("{text}. Next: {next_step}."),
        Some("") => format!("{text}."),
        Some(why) => format!("{text}; {}.", why.trim_start_matches([':', ' '])),
    }
}

/// The notices that move no main number and stand in no table.
pub(super) fn also_noted(page: &mut Page, input: ReportInput) {
    let informing = by_weight(&input.findings.notices)
        .into_iter()
        .filter(|notice| !notice.cautions() && !IN_TABLES.contains(&notice.code));
    let lines: Vec<String> = informing.map(|notice| told(&notice.text, &notice.next_step)).collect();
    if !lines.is_empty() {
        page.section(ALSO_NOTED, "What moves no main number by more than a quarter of its ±.");
        page.list(&lines);
    }
}

/// How many checks hold, and those that do not.
pub(super) fn checks(page: &mut Page, input: ReportInput) {
    let all = &input.findings.verdicts;
    let failed: Vec<&Check> = all.iter().filter(|check| !check.passed).collect();
    page.section(
        "Checks",
        &format!(
            "{} of {} checks hold; `findings.json` has the value and the line of each.",
            all.len() - failed.len(),
            all.len()
        ),
    );
    let (felt, informing): (Vec<&Check>, Vec<&Check>) =
        failed.into_iter().partition(|check| !check.concerns.is_empty());
    let (gating, cautioning): (Vec<&Check>, Vec<&Check>) = felt.into_iter().partition(|check| check.gates);
    let lines: Vec<String> = gating
        .into_iter()
        .map(|check| format!("Not to be quoted: {}. Why this line: {}.", found(check), check.source))
        .collect();
    page.list(&lines);
    for (what, checks) in [
        ("These fail and stand under Cautions", cautioning),
        ("These fail, and no main number rests on them", informing),
    ] {
        if !checks.is_empty() {
            let texts: Vec<String> = checks.into_iter().map(found).collect();
            page.paragraph(&format!("{what}: {}.", texts.join("; ")));
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
