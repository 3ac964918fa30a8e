//! Writes which terms the energy balance holds, what each matters, and why it is held or not.

use super::super::numbers;
use super::super::ReportInput;
use super::page::Page;
use super::table::ReportTable;
use crate::findings::remarks::in_symbols;
use crate::findings::terms::{SizedTerm, LINE};
use crate::physics::form::Term;

/// The section on terms.
pub(super) fn terms(page: &mut Page, input: ReportInput) {
    let terms = &input.findings.terms;
    if terms.is_empty() {
        return;
    }
    page.section("Terms", &format!(
        "Size: the largest bias of another parameter, in its standard errors, if the term is left out (below {LINE} a 95 % \
         interval still covers 94 %). The runs show: the share ± standard error of its full effect that they show of a term \
         that is not held. Widens by: the factor by which holding the term widens the standard error of another parameter."
    ));
    page.table(&table(terms));
}

/// The terms with their sizes, for the report and the `check` command.
pub(super) fn table(terms: &[SizedTerm]) -> ReportTable<&SizedTerm> {
    ReportTable::of(terms)
        .column("term", |sized| sized.term.in_words())
        .column("held", |sized| if sized.held { "yes" } else { "no" })
        .column("why", why)
        .column("size", |sized| sized.size.map(|size| numbers::significant(size, 2)))
        .column("moves most", |sized| {
            sized.moves.as_deref().map_or(String::new(), in_symbols)
        })
        .column("effect on e", |sized| numbers::significant(sized.largest_effect, 2))
        .column_if_any("the runs show", |sized| {
            let share = sized.runs_show.zip(sized.runs_show_se);
            share.map_or(String::new(), |(share, se)| numbers::with_se(share, se))
        })
        .column_if_any("widens by", |sized| {
            sized.widens.map_or(String::new(), |factor| format!("{factor:.2}"))
        })
}

fn why(sized: &SizedTerm) -> String {
    match (sized.chosen_by, sized.term) {
        ("auto", _) if sized.size.is_none() => "no spread to size it by".to_owned(),
        ("auto", _) if sized.held => format!("size not below {LINE}"),
        ("auto", _) => format!("size below {LINE}"),
        ("default", _) => "enters by name only".to_owned(),
        (_, Term::OwnDrySpeed) => "`dry_speed_m_s`".to_owned(),
        _ => "the scene's `terms`".to_owned(),
    }
}
