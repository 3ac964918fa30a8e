//! Writes what a report opens with: what was learnt, and whether the main numbers may be quoted.

use super::super::ReportInput;
use super::escape::literal;
use super::page::Page;
use crate::findings::learnt::capital;
use crate::findings::notices::SINGLE_RUN_CODE;
use crate::findings::Findings;
use crate::notice::Notice;

/// What was learnt, and the verdict: first where nothing may be quoted.
pub(super) fn opening(page: &mut Page, input: ReportInput) {
    let main = &input.findings.main;
    let verdict = verdict_line(input.findings);
    if !main.verdict.passed {
        page.paragraph(&verdict);
    }
    if let Some(carried) = carried(input.findings) {
        let next = literal(&carried.next_step);
        page.paragraph(&format!("**{}.** Next: {next}.", literal(&capital(&carried.text))));
    }
    if !main.learnt.is_empty() {
        page.paragraph(if main.verdict.passed {
            "**What was learnt.**"
        } else {
            "What the runs would say, if these numbers could be quoted:"
        });
        let sentences: Vec<String> = main.learnt.iter().map(|sentence| literal(sentence)).collect();
        page.list(&sentences);
    }
    if main.verdict.passed {
        page.paragraph(&verdict);
    }
    if let Some(source) = &input.scene.source {
        page.paragraph(&format!("Runs: {}", literal(source)));
    }
}

/// The line that says whether the main numbers may be quoted.
pub(super) fn verdict_line(findings: &Findings) -> String {
    let see = cautions_line(findings);
    let verdict = &findings.main.verdict;
    if verdict.passed {
        let open = undetermined(findings);
        let except = match open.len() {
            0 => String::new(),
            _ => format!(", except {}, which these runs do not determine", open.join(", ")),
        };
        format!("**Verdict: the main numbers may be quoted{except}.**{see}")
    } else {
        format!("**Verdict: not to be quoted: {}.**{see}", verdict.reason)
    }
}

/// Which single runs carry a main number; `None` where none does.
pub(super) fn carried(findings: &Findings) -> Option<&Notice> {
    findings.notices.iter().find(|notice| notice.code == SINGLE_RUN_CODE)
}

/// The main parameters that the runs do not tell, or not apart from others.
fn undetermined(findings: &Findings) -> Vec<&str> {
    let unseen = findings.identifies.iter().flat_map(|directions| &directions.unseen);
    let unseen: Vec<&String> = unseen.flat_map(|one| &one.parameters).collect();
    let names = findings.main.parameters.iter().map(|own| own.name.as_str());
    names.filter(|name| unseen.iter().any(|one| one == name)).collect()
}

/// How many cautions there are, with a blank before it; nothing where there is none.
pub(super) fn cautions_line(findings: &Findings) -> String {
    match findings.cautions().len() {
        0 => String::new(),
        1 => " One caution stands under Cautions.".to_owned(),
        n => format!(" {n} cautions stand under Cautions."),
    }
}
