//! Writes what wants a second look, and how to make the report again.

use super::super::ReportInput;
use super::cells::check_table;
use super::escape::{code, literal};
use super::page::Page;
use super::posterior;
use super::table::ReportTable;
use crate::findings::checks::Check;

/// The heading over what wants a second look.
pub(in crate::report) const CAUTIONS: &str = "Cautions";

pub(super) fn cautions(page: &mut Page, input: ReportInput) {
    let findings = input.findings;
    page.heading(CAUTIONS);
    let notices: Vec<String> = findings
        .notices
        .iter()
        .map(|notice| format!("{}. Next: {}.", notice.text, notice.next_step))
        .collect();
    page.list(&notices);
    if notices.is_empty() {
        page.paragraph("None but what Checks in the appendix has.");
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
        // some texts end with it
        let beside = !check.passed && !check.text.ends_with(check.advice);
        if beside {
            format!("{}. Next: {}.", check.text, check.advice)
        } else {
            check.text.clone()
        }
    };
    let outcome = |check: &Check| match (check.passed, check.gates) {
        (true, _) => "holds",
        (false, true) => "fails: not to be quoted",
        (false, false) => "fails",
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
