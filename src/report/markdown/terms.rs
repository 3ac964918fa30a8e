//! Tells which terms the energy balance holds, what each matters, and why it is held or not.

use super::super::numbers::{self, NONE};
use super::super::Told;
use super::page::Page;
use crate::findings::terms::{SizedTerm, LINE};
use crate::physics::form::Term;

/// The section on terms.
pub(super) fn terms(page: &mut Page, told: Told) {
    let terms = &told.findings.terms;
    if terms.is_empty() {
        return;
    }
    page.heading("Terms");
    page.paragraph(&format!(
        "What each term matters for these runs. Its size is the largest bias of another parameter that leaving it out \
         would give, in that parameter's standard errors; below {LINE} a 95 % interval still covers 94 %. Its effect is \
         the largest change of a restitution. Holding a term costs, where it has parameters of its own: the standard \
         error of another becomes wider by the factor given. A term that is not held is sized as if it acted in full."
    ));
    let rows: Vec<Vec<String>> = terms.iter().map(cells).collect();
    page.table(
        &["term", "held", "why", "size", "moves most", "effect on e", "widens by"],
        &rows,
    );
}

fn cells(sized: &SizedTerm) -> Vec<String> {
    vec![
        sized.term.in_words().to_owned(),
        yes(sized.held).to_owned(),
        why(sized),
        sized.size.map_or(NONE.to_owned(), |size| numbers::significant(size, 2)),
        sized.moves.clone().unwrap_or_default(),
        numbers::significant(sized.largest_effect, 2),
        sized.widens.map_or(String::new(), |factor| format!("{factor:.2}")),
    ]
}

fn yes(held: bool) -> &'static str {
    if held {
        "yes"
    } else {
        "no"
    }
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

/// The terms for a terminal, a line each.
pub(super) fn text(terms: &[SizedTerm]) -> String {
    let mut text = String::new();
    for sized in terms {
        let name = sized.term.in_words();
        let held = if sized.held { "held    " } else { "not held" };
        let size = match (sized.size, &sized.moves) {
            (Some(size), Some(moves)) => {
                let size = numbers::significant(size, 2);
                format!("leaving it out moves {moves} by {size} standard errors")
            }
            _ => "no size: the runs leave no spread to measure it by".to_owned(),
        };
        let effect = numbers::significant(sized.largest_effect, 2);
        text.push_str(&format!(
            "  {held}  {name}: {size}, e by up to {effect} ({})\n",
            why(sized)
        ));
    }
    text
}
