//! Writes whether the main numbers may be quoted, and what was learnt.

use super::super::ReportInput;
use super::cells::found;
use super::escape::literal;
use super::page::Page;
use crate::findings::learnt::capital;
use crate::findings::remarks::{in_symbols, SINGLE_RUN};
use crate::findings::Findings;
use crate::remark::Remark;

/// Whether the main numbers may be quoted, and what carries them.
pub(super) fn opening(page: &mut Page, input: ReportInput) {
    let (lead, checks) = verdict(input.findings, in_symbols);
    page.paragraph(&format!("**Verdict: {}.**{}", lead, cautions_line(input.findings)));
    page.list(&checks);
    if let Some(carried) = carried(input.findings) {
        let next = literal(&carried.next_step);
        page.paragraph(&format!("**{}.** Next: {next}.", literal(&capital(&carried.text))));
    }
    if let Some(source) = &input.scene.source {
        page.paragraph(&format!("Runs: {}", literal(source)));
    }
}

/// What the runs tell of the law, a sentence each.
pub(super) fn learnt(page: &mut Page, input: ReportInput) {
    let main = &input.findings.main;
    if main.learnt.is_empty() {
        return;
    }
    page.heading("What the runs tell");
    if !main.verdict.passed {
        page.paragraph("What they would tell, if these numbers could be quoted:");
    }
    let sentences: Vec<String> = main.learnt.iter().map(|sentence| literal(sentence)).collect();
    page.list(&sentences);
}

/// Whether the main numbers may be quoted; where not, each check that forbids it, with what to do. `named` is what a parameter
/// is called beside it.
pub(super) fn verdict(findings: &Findings, named: fn(&str) -> String) -> (String, Vec<String>) {
    if findings.main.verdict.passed {
        let open: Vec<String> = undetermined(findings).into_iter().map(named).collect();
        let except = match open.len() {
            0 => String::new(),
            _ => format!(", except {}, which these runs do not determine", open.join(", ")),
        };
        return (format!("the main numbers may be quoted{except}"), vec![]);
    }
    let failed = findings.checks().filter(|check| check.forbids());
    let checks: Vec<String> = failed
        .map(|check| format!("{}. Next: {}.", found(check), check.next_step))
        .collect();
    let failed = if checks.len() == 1 { "one check" } else { "these checks" };
    (format!("not to be quoted; {failed} failed"), checks)
}

/// Which single runs carry a main number; `None` where none does.
pub(super) fn carried(findings: &Findings) -> Option<&Remark> {
    findings.notices().find(|notice| notice.code == SINGLE_RUN.code)
}

/// The main parameters that the runs do not tell, or not apart from others; δc/ε is exp(L), and goes with it.
fn undetermined(findings: &Findings) -> Vec<&str> {
    let unseen = findings.identifies.iter().flat_map(|directions| &directions.unseen);
    let unseen: Vec<&String> = unseen.flat_map(|one| &one.parameters).collect();
    let names = findings.main.parameters.iter().map(|own| own.name.as_str());
    let source = |name: &str| name.replace("delta_c_over_roughness", "lubrication_log");
    names.filter(|name| unseen.contains(&&source(name))).collect()
}

/// How many cautions there are, with a blank before it; nothing where there is none.
pub(super) fn cautions_line(findings: &Findings) -> String {
    match findings.cautions().len() {
        0 => String::new(),
        1 => " One caution stands under Cautions.".to_owned(),
        n => format!(" {n} cautions stand under Cautions."),
    }
}
