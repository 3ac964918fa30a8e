//! Sizes each term of the energy balance: by how many standard errors leaving it out would move a parameter.
//!
//! With J the slopes of the restitutions in the parameters of the model without the term, W the inverse variances, and Δe
//! what the term does to each restitution, b = (JᵀWJ)⁻¹JᵀWΔe is the bias that leaving it out gives, and max |b_j|/se_j its
//! size. Below 0.25 a 95 % interval still covers 94 %. What the priors say is in JᵀWJ, too, so that a direction the runs
//! cannot see has a standard error.

mod size;
mod sized;

use self::size::term_sizes;
pub use self::sized::{SizedTerm, LINE};
use super::balance::{self, BalanceSetup, EnergyBalance};
use super::notices::{self, LeavingOut};
use super::scaling::FittedScaling;
use crate::notice::Notice;
use crate::physics::form::Term;
use crate::physics::Form;

/// Fits the energy balance, sizes its terms, and with `terms = "auto"` leaves out what is too small to matter.
///
/// What comes back is the form to hold, its balance, and the terms with the sizes they have in it; a term that was left
/// out keeps the size it was left out for.
pub(super) fn choose_terms(
    setup: BalanceSetup,
    scaling: &[FittedScaling],
) -> (Form, Option<EnergyBalance>, Vec<SizedTerm>) {
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
        let smallest = terms
            .iter()
            .filter(may_go)
            .min_by(|a, b| a.size.unwrap_or(f64::NAN).total_cmp(&b.size.unwrap_or(f64::NAN)))
            .filter(|_| scene.model.terms.is_none());
        let Some(smallest) = smallest else {
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
            widens: None,
            ..smallest.clone()
        });
        form = smallest.term.toggled(form);
    }
}

/// What of the terms wants a second look: one that matters and is not held, one that is held by name and does not, one
/// that was left out.
pub(super) fn term_notices(terms: &[SizedTerm]) -> Vec<Notice> {
    let of = |sized: &SizedTerm| {
        let out = LeavingOut {
            term: sized.term,
            moves: sized.moves.as_deref(),
            size: sized.size?,
            largest_effect: sized.largest_effect,
            shown: sized.runs_show.zip(sized.runs_show_se),
            gain_without: sized.gain_without(),
        };
        match (sized.held, out.size >= LINE, sized.chosen_by) {
            (false, true, _) => Some(notices::term_not_held(out)),
            (false, false, "auto") => Some(notices::term_left_out(out, LINE)),
            (true, false, "scene") if sized.term != Term::OwnDrySpeed => {
                Some(notices::term_too_small(out, sized.widens.unwrap_or(1.0)))
            }
            _ => None,
        }
    };
    terms.iter().filter_map(of).collect()
}
