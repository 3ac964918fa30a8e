//! Writes the report as markdown: verdict and main numbers first, then what they rest on.

mod bootstrap;
mod cautions;
mod cells;
mod constants;
mod errors;
pub(super) mod escape;
mod laws;
mod main_numbers;
mod noise;
pub(super) mod page;
mod posterior;
mod runs;
mod terms;

pub use main_numbers::summary;
pub use runs::overview_text;

use super::Told;
use crate::findings::verdicts::quotable;
use crate::findings::Findings;
use escape::literal;
use page::Page;

/// The whole report; `figures` are the names of those that were drawn.
pub fn report(told: Told, figures: &[&str]) -> String {
    let mut page = Page::titled(&literal(&told.scene.title), figures);
    page.paragraph(&verdict_line(told.findings));
    if let Some(source) = &told.scene.source {
        page.paragraph(&format!("Runs: {}", literal(source)));
    }
    main_numbers::main_numbers(&mut page, told);
    main_numbers::published(&mut page, told);
    runs::data(&mut page, told);
    terms::terms(&mut page, told);
    laws::dry(&mut page, told);
    laws::series(&mut page, told);
    laws::scaling(&mut page, told);
    laws::film(&mut page, told);
    laws::energy(&mut page, told);
    errors::errors(&mut page, told);
    noise::noise(&mut page, told);
    constants::constants(&mut page, told);
    bootstrap::bootstrap(&mut page, told);
    posterior::posterior(&mut page, told);
    cautions::cautions(&mut page, told);
    cautions::reproduce(&mut page, told);
    let mut text = page.text.trim_end().to_owned();
    text.push('\n');
    text
}

/// The first line: whether the main numbers may be quoted.
pub fn verdict_line(findings: &Findings) -> String {
    let failed: Vec<&str> = findings
        .verdicts
        .iter()
        .filter(|check| check.gates && !check.passed)
        .map(|check| check.text.as_str())
        .collect();
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
    if quotable(&findings.verdicts) {
        format!("**Verdict: the main numbers may be quoted.**{see}")
    } else {
        format!("**Verdict: not to be quoted: {}.**{see}", failed.join("; "))
    }
}
