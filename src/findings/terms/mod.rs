//! Sizes each term of the energy balance: by how many standard errors leaving it out would move a parameter.
//!
//! With J the slopes of the restitutions in the parameters of the model without the term, W the inverse variances, and Δe
//! what the term does to each restitution, b = (JᵀWJ)⁻¹JᵀWΔe is the bias that leaving it out gives, and max |b_j|/se_j its
//! size. Below 0.25 a 95 % interval still covers 94 %. What the priors say is in JᵀWJ, too, so that a direction the runs
//! cannot see has a standard error.

mod size;

use self::size::term_sizes;
pub use self::size::{SizedTerm, LINE};
use super::balance::{self, EnergyBalance};
use super::remarks::{self, COMPARE_DRY_SPEEDS};
use super::scaling::Scaling;
use super::wet_fit::FitSetup;
use crate::physics::form::Term;
use crate::physics::Form;
use crate::remark::{Level, Remark};
use crate::rounding::with_se;

/// Fits the energy balance, sizes its terms, and with `terms = "auto"` leaves out what is too small to matter.
///
/// What comes back is the form to hold, its balance, and the terms with the sizes they have in it; a term that was left
/// out keeps the size it was left out for.
pub(super) fn choose_terms(setup: FitSetup, scaling: &[Scaling]) -> (Form, Option<EnergyBalance>, Vec<SizedTerm>) {
    let scene = setup.scene;
    let mut form = scene.model.form();
    let open = scene.model.inertia_is_open();
    let mut left_out: Vec<SizedTerm> = vec![];
    loop {
        let is_open = open && Term::Inertia.is_held(form);
        let balance = balance::fit_balance(setup, scaling, form, is_open);
        let mut terms = term_sizes(setup, scaling, form, balance.as_ref());
        let may_go = |sized: &&SizedTerm| {
            let optional = matches!(sized.term, Term::Inertia | Term::Viscous) && sized.term.is_held(form);
            optional && sized.size.is_some_and(|size| size < LINE)
        };
        let size = |sized: &SizedTerm| sized.size.unwrap_or(f64::NAN);
        let smallest = terms.iter().filter(may_go).min_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(smallest) = smallest.filter(|_| scene.model.terms.is_none()) else {
            for gone in left_out {
                terms.retain(|sized| sized.term != gone.term);
                terms.insert(0, gone);
            }
            terms.sort_by_key(|sized| Term::ALL.iter().position(|term| *term == sized.term));
            return (form, balance, terms);
        };
        left_out.push(SizedTerm {
            held: false,
            chosen_by: "auto",
            ..smallest.clone()
        });
        form = smallest.term.toggled(form);
    }
}

/// Whether a term wants a second look: one that matters and is not held.
pub(super) fn term_notice(sized: &SizedTerm) -> Option<Remark> {
    let size = sized.size.filter(|size| *size >= LINE && !sized.held)?;
    let name = sized.term.in_words();
    let digits = if size < 10.0 { 2 } else { 0 };
    let moved = sized.moves.as_deref();
    let far = format!(
        "{} by {size:.digits$} standard errors, a restitution by up to {:.3}",
        moved.map_or("no parameter".to_owned(), remarks::in_symbols),
        sized.largest_effect
    );
    let shown = match (sized.runs_show, sized.runs_show_se) {
        (Some(share), Some(se)) => {
            let share = with_se(share, se);
            format!("; the runs show {share} of its full effect (0: it is absent, 1: it acts in full)")
        }
        _ => String::new(),
    };
    if sized.is_rejected() {
        let text = format!("{name}: not in the model, and the runs speak against it{shown}");
        let told = remarks::TERM_NOT_HELD.notice(1, text).at(Level::Informs);
        return Some(told.then("nothing"));
    }
    let text = format!("{name}: not in the model; if it acts, leaving it out moves {far}{shown}");
    // as many parameters either way: neither can feign a better fit
    let gain = sized.gain_without().map(|gain| -gain);
    let is_shown = |gain: &f64| sized.term == Term::OwnDrySpeed && size >= 1.0 && !remarks::DRY_SPEED.holds(*gain);
    if let Some(gain) = gain.filter(is_shown) {
        return Some(remarks::DRY_SPEED.check(gain, text));
    }
    let told = remarks::TERM_NOT_HELD.notice(1, text);
    Some(match sized.term {
        Term::OwnDrySpeed => told.then(COMPARE_DRY_SPEEDS),
        _ => told,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_term_that_the_runs_reject_is_no_caution_and_a_dry_speed_that_they_show_is_a_check() {
        let left_out = |term: Term, share: f64| {
            let sized = SizedTerm {
                term,
                held: false,
                chosen_by: "default",
                size: Some(15.0),
                moves: Some("dry_k[PTFE]".to_owned()),
                largest_effect: 0.15,
                runs_show: Some(share),
                runs_show_se: Some(0.3),
            };
            term_notice(&sized).expect("it matters")
        };
        let rejected = left_out(Term::DrySecondOrder, 0.02);
        assert!(
            !rejected.cautions() && rejected.text.contains("speak against it; the runs show"),
            "{rejected:?}"
        );
        let open = left_out(Term::DrySecondOrder, 0.47);
        assert!(
            open.cautions() && open.text.contains("leaving it out moves k of PTFE by 15"),
            "{open:?}"
        );
        // a difference of 0.28 is e^3.1 times as likely where it acts
        for (term, share, forbids) in [
            (Term::OwnDrySpeed, 0.78, true),
            (Term::OwnDrySpeed, 0.76, false),
            (Term::DrySecondOrder, 0.9, false),
        ] {
            assert_eq!(left_out(term, share).forbids(), forbids, "{term:?} {share}");
        }
    }
}
