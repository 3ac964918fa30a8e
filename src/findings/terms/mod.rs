//! Sizes each term of the energy balance: by how many standard errors leaving it out would move a parameter.
//!
//! With J the slopes of the restitutions in the parameters of the model without the term, W the inverse variances, and Δe
//! what the term does to each restitution, b = (JᵀWJ)⁻¹JᵀWΔe is the bias that leaving it out gives, and max |b_j|/se_j its
//! size. Below 0.25 a 95 % interval still covers 94 %. What the priors say is in JᵀWJ, too, so that a direction the runs
//! cannot see has a standard error.

mod size;

use serde::Serialize;

use self::size::size;
use super::balance::{self, EnergyBalance};
use super::dry::FittedDry;
use super::estimate::Quoting;
use super::scaling::FittedScaling;
use crate::model::parameters::Kind;
use crate::notice::Notice;
use crate::physics::dry::Order;
use crate::physics::impact::{DrySpeed, Form};
use crate::physics::inertia::Inertia;
use crate::runs::Runs;
use crate::scene::{Scene, DEFAULT_DRY_SPEED};

/// Size from which a term matters: 95 % intervals of a model without it then cover less than 94 %.
pub const LINE: f64 = 0.25;

/// A term, its size, and what was decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizedTerm {
    /// inertia, viscous, own_dry_speed, bridge or dry_second_order
    pub term: &'static str,
    /// whether the model holds it
    pub held: bool,
    /// scene (named there), auto (decided by the size) or default
    pub chosen_by: &'static str,
    /// largest bias of a parameter that leaving it out gives, in its standard errors; `None` without a spread of the runs
    pub size: Option<f64>,
    /// the parameter that has it
    pub moves: Option<String>,
    /// largest change of a restitution
    pub largest_effect: f64,
    /// factor by which holding it widens the standard error of another parameter at most; `None` if not held, or if it
    /// has no parameter
    pub widens: Option<f64>,
}

impl SizedTerm {
    /// What the term is called in a text.
    pub fn in_words(&self) -> &'static str {
        match self.term {
            "inertia" => "inertia of the liquid",
            "viscous" => "viscous loss",
            "own_dry_speed" => "e_dry at the run's own speed",
            "bridge" => "rupture of the bridge",
            "dry_second_order" => "second order of the dry law",
            other => other,
        }
    }
}

/// What a model may hold beyond k.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Term {
    Inertia,
    Viscous,
    OwnDrySpeed,
    Bridge,
    DrySecondOrder,
}

impl Term {
    const ALL: [Term; 5] = [
        Term::Inertia,
        Term::Viscous,
        Term::OwnDrySpeed,
        Term::Bridge,
        Term::DrySecondOrder,
    ];

    fn name(self) -> &'static str {
        match self {
            Term::Inertia => "inertia",
            Term::Viscous => "viscous",
            Term::OwnDrySpeed => "own_dry_speed",
            Term::Bridge => "bridge",
            Term::DrySecondOrder => "dry_second_order",
        }
    }

    fn is_held(self, form: Form) -> bool {
        match self {
            Term::Inertia => form.inertia != Inertia::None,
            Term::Viscous => form.viscous,
            Term::OwnDrySpeed => form.dry_speed == DrySpeed::Impact,
            Term::Bridge => form.bridge,
            Term::DrySecondOrder => form.dry == Order::Second,
        }
    }

    /// The form with this term held where it was not, and left out where it was.
    fn toggled(self, form: Form) -> Form {
        let held = self.is_held(form);
        match self {
            Term::Inertia => Form {
                inertia: if held { Inertia::None } else { Inertia::Stepwise },
                ..form
            },
            Term::Viscous => Form { viscous: !held, ..form },
            Term::OwnDrySpeed => Form {
                dry_speed: if held {
                    DrySpeed::Reference(DEFAULT_DRY_SPEED)
                } else {
                    DrySpeed::Impact
                },
                ..form
            },
            Term::Bridge => Form { bridge: !held, ..form },
            Term::DrySecondOrder => Form {
                dry: if held { Order::First } else { Order::Second },
                ..form
            },
        }
    }

    /// Whether a slot of a full vector of parameters is this term's own.
    fn owns(self, slot: usize) -> bool {
        match self {
            Term::Inertia => slot == Kind::InertialPrefactor.slot() || slot == Kind::FilmScale.slot(),
            Term::Viscous => slot == Kind::LubricationLog.slot(),
            Term::OwnDrySpeed | Term::Bridge | Term::DrySecondOrder => false,
        }
    }
}

/// Fits the energy balance, sizes its terms, and with `terms = "auto"` leaves out what is too small to matter.
///
/// What comes back is the form to hold, its balance, and the terms with the sizes they have in it; a term that was left
/// out keeps the size it was left out for.
pub(super) fn settle(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    scaling: &mut [FittedScaling],
    quoting: Quoting,
) -> (Form, Option<EnergyBalance>, Vec<SizedTerm>) {
    let mut form = scene.model.form();
    let open = scene.model.inertia_is_open();
    let mut left_out: Vec<SizedTerm> = vec![];
    loop {
        let is_open = open && form.inertia != Inertia::None;
        let balance = balance::find(scene, runs, dry, scaling, (form, is_open), quoting);
        let mut terms = size(scene, runs, dry, scaling, (form, balance.as_ref()));
        let smallest = Term::ALL
            .into_iter()
            .zip(&terms)
            .filter(|(term, _)| matches!(term, Term::Inertia | Term::Viscous) && term.is_held(form))
            .filter_map(|(term, sized)| Some((term, sized.size.filter(|size| *size < LINE)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|_| scene.model.terms.is_none());
        let Some((term, _)) = smallest else {
            for gone in left_out {
                terms.retain(|sized| sized.term != gone.term);
                terms.insert(0, gone);
            }
            terms.sort_by_key(|sized| Term::ALL.iter().position(|term| term.name() == sized.term));
            return (form, balance, terms);
        };
        form = term.toggled(form);
        let gone = terms.into_iter().find(|sized| sized.term == term.name());
        left_out.extend(gone.map(|sized| SizedTerm {
            held: false,
            chosen_by: "auto",
            widens: None,
            ..sized
        }));
    }
}

/// What of the terms wants a second look: one that matters and is not held, one that is held by name and does not, one
/// that was left out.
pub(super) fn notices(terms: &[SizedTerm]) -> Vec<Notice> {
    let of = |sized: &SizedTerm| {
        let (size, effect) = (sized.size?, sized.largest_effect);
        let moves = sized.moves.as_deref().unwrap_or("no parameter");
        let name = sized.in_words();
        let digits = if size < 10.0 { 2 } else { 0 };
        let far = format!("{moves} by {size:.digits$} standard errors, a restitution by up to {effect:.3}");
        Some(match (sized.held, size >= LINE, sized.chosen_by) {
            (false, true, _) => Notice::new(
                "term_not_held",
                1,
                format!("{name}: not in the model; if it acts, leaving it out moves {far}"),
                if sized.term == "own_dry_speed" {
                    "compare the forms: dry_speed_m_s = \"impact\" holds it"
                } else {
                    "name it in [model] terms to hold it"
                },
            ),
            (false, false, "auto") => Notice::new(
                "term_left_out",
                1,
                format!("{name}: left out, since that moves {far}: less than {LINE}"),
                "name it in [model] terms to hold it",
            ),
            (true, false, "scene") if sized.term != "own_dry_speed" => Notice::new(
                "term_too_small",
                1,
                format!(
                    "{name}: held as the scene asks; leaving it out moves {far}, holding it makes another standard error {:.2} times as wide",
                    sized.widens.unwrap_or(1.0)
                ),
                "terms = \"auto\" would decide by the size",
            ),
            _ => return None,
        })
    };
    terms.iter().filter_map(of).collect()
}
