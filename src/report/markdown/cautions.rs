//! Tells what wants a second look, and how to make the report again.

use super::super::{numbers, Told};
use super::escape::{code, literal};
use super::page::Page;
use super::posterior;

pub(super) fn cautions(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("Cautions");
    let told_of = findings.notices.iter();
    let notices: Vec<String> = told_of
        .map(|notice| format!("{}. Next: {}.", notice.text, notice.next_step))
        .collect();
    page.list(&notices);
    let rows: Vec<Vec<String>> = findings
        .verdicts
        .iter()
        .filter(|check| !check.passed || check.gates && !posterior::tells(told, check))
        .map(|check| {
            let outcome = match (check.passed, check.gates) {
                (true, _) => "holds",
                (false, true) => "fails: not to be quoted",
                (false, false) => "fails",
            };
            // some texts end with it
            let beside = !check.passed && !check.text.ends_with(check.advice);
            let text = if beside {
                format!("{}. Next: {}.", check.text, check.advice)
            } else {
                check.text.clone()
            };
            vec![
                text,
                numbers::optional(check.value, 3),
                numbers::significant(check.threshold, 3),
                outcome.to_owned(),
                check.source.to_owned(),
            ]
        })
        .collect();
    page.table(&["check", "value", "line", "outcome", "why this line"], &rows);
    if told.posterior.is_some() {
        page.paragraph("The posterior's own checks that hold stand in its section.");
    }
}

pub(super) fn reproduce(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("How to reproduce");
    let runs = told.scene.data.runs.file_name();
    let runs = runs.map_or(String::new(), |name| literal(&name.to_string_lossy()));
    let every_row = told
        .posterior
        .is_some_and(|posterior| posterior.sampled.compression.is_none());
    let rows = if every_row { " --exact-rows" } else { "" };
    page.paragraph(&format!(
        "{}, wetcor {}. Full precision, further intervals and every reason stand in `findings.json`.",
        code(&format!(
            "wetcor fit {}/scene.toml --seed {}{rows}",
            findings.scene, findings.seed
        )),
        findings.wetcor
    ));
    page.table(
        &["input", "SHA-256"],
        &[
            vec!["scene".to_owned(), findings.scene_sha256.clone()],
            vec![runs, findings.data_sha256.clone()],
        ],
    );
}
