//! Writes the first line of a report: whether the main numbers may be quoted.

use crate::findings::Findings;

/// The first line: whether the main numbers may be quoted.
pub fn verdict_line(findings: &Findings) -> String {
    let cautions = findings
        .verdicts
        .iter()
        .filter(|check| !check.gates && !check.passed)
        .count()
        + findings.notices.len();
    let see = match cautions {
        0 => String::new(),
        1 => " One caution stands at the end.".to_owned(),
        n => format!(" {n} cautions stand at the end."),
    };
    let verdict = &findings.main.verdict;
    if verdict.passed {
        format!("**Verdict: the main numbers may be quoted.**{see}")
    } else {
        format!("**Verdict: not to be quoted: {}.**{see}", verdict.reason)
    }
}
