//! Reads the table of the model: the terms of the energy balance, the noise on a run, and what stuck runs are.

use crate::physics::dry::Order;
use crate::physics::impact::{DrySpeed, Form};
use crate::physics::inertia::Inertia;
use crate::scene::expect::ABOVE_ZERO;
use crate::scene::materials::Liquid;
use crate::scene::table::Table;
use crate::units::Dimension;

/// What the model holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelChoices {
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// the inertial form; absent: to be chosen by comparison
    pub inertia: Option<Inertia>,
    /// the terms to hold; absent: as the runs require
    pub terms: Option<Vec<Term>>,
    /// distribution of the noise on a restitution
    pub likelihood: Likelihood,
    /// what is made of stuck runs
    pub sticking: Sticking,
    /// where the scatter of wet runs acts
    pub noise: NoiseOn,
}

/// Speed at which e_inf and St_c are quoted unless the scene names another, m/s (upper end of the paper's dry runs).
pub const DEFAULT_DRY_SPEED: f64 = 2.0;

/// A term of the energy balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// C ρ̃ g(δ̃)
    Inertia,
    /// 4 L/St
    Viscous,
    /// κ/v²
    Bridge,
    /// (3/5) k² v^(2/5)
    DrySecondOrder,
}

impl Term {
    /// Every term a scene can name.
    pub const ALL: [Term; 4] = [Term::Inertia, Term::Viscous, Term::Bridge, Term::DrySecondOrder];

    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Term::Inertia => "inertia",
            Term::Viscous => "viscous",
            Term::Bridge => "bridge",
            Term::DrySecondOrder => "dry_second_order",
        }
    }
}

/// The terms an energy balance holds.
pub fn terms_of(form: Form) -> Vec<Term> {
    let holds = |term: &Term| match term {
        Term::Inertia => form.inertia != Inertia::None,
        Term::Viscous => form.viscous,
        Term::Bridge => form.bridge,
        Term::DrySecondOrder => form.dry == Order::Second,
    };
    Term::ALL.into_iter().filter(holds).collect()
}

/// The energy balance that holds exactly these terms; without a list, the inertial and the viscous loss.
pub fn form_of(inertia: Inertia, dry_speed: DrySpeed, terms: Option<&[Term]>) -> Form {
    let usual = Form::new(inertia, dry_speed);
    let Some(terms) = terms else {
        return usual;
    };
    let has = |term| terms.contains(&term);
    Form {
        inertia: if has(Term::Inertia) { inertia } else { Inertia::None },
        viscous: has(Term::Viscous),
        bridge: has(Term::Bridge),
        dry: if has(Term::DrySecondOrder) {
            Order::Second
        } else {
            Order::First
        },
        ..usual
    }
}

impl ModelChoices {
    /// The energy balance to start from: what the scene's terms name, with the form of inertia that stands where the
    /// scene leaves it open.
    pub fn form(&self) -> Form {
        form_of(
            self.inertia.unwrap_or(Inertia::Stepwise),
            self.dry_speed,
            self.terms.as_deref(),
        )
    }

    /// Whether the form of the inertial loss is to be found by comparison.
    pub fn inertia_is_open(&self) -> bool {
        self.inertia.is_none() && self.form().inertia != Inertia::None
    }
}

/// Distribution of the noise on a restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Likelihood {
    /// normal
    Normal,
    /// Student-t with estimated degrees of freedom
    Student,
}

/// Where the scatter of wet runs acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseOn {
    /// on the restitution alone
    Restitution,
    /// on the energy kept, too
    Both,
}

/// What is made of stuck runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sticking {
    /// they are data: the restitution fell below the limit
    Censored,
    /// they were not logged
    Truncated,
    /// they are left out
    Excluded,
}

pub(in crate::scene) fn model(root: &Table, liquids: &[Liquid]) -> ModelChoices {
    let mut choices = ModelChoices {
        dry_speed: DrySpeed::Reference(DEFAULT_DRY_SPEED),
        inertia: Some(Inertia::Stepwise),
        terms: None,
        likelihood: Likelihood::Normal,
        sticking: Sticking::Censored,
        noise: NoiseOn::Restitution,
    };
    let Some(table) = root.table("model") else {
        return choices;
    };
    let impact = ("impact", DrySpeed::Impact);
    if let Some(speed) = table.quantity_or_word("dry_speed", Dimension::Speed, ABOVE_ZERO, impact, DrySpeed::Reference)
    {
        choices.dry_speed = speed;
    }
    let mut forms: Vec<_> = Inertia::ALL.map(|form| (form.name(), Some(form))).to_vec();
    forms.push(("auto", None));
    if let Some(form) = table.choice("inertia", &forms) {
        choices.inertia = form;
    }
    choices.terms = terms(&table, liquids);
    let likelihoods = [("normal", Likelihood::Normal), ("student", Likelihood::Student)];
    if let Some(likelihood) = table.choice("likelihood", &likelihoods) {
        choices.likelihood = likelihood;
    }
    let stickings = [
        ("censored", Sticking::Censored),
        ("truncated", Sticking::Truncated),
        ("excluded", Sticking::Excluded),
    ];
    if let Some(sticking) = table.choice("sticking", &stickings) {
        choices.sticking = sticking;
    }
    let noises = [("restitution", NoiseOn::Restitution), ("both", NoiseOn::Both)];
    if let Some(noise) = table.choice("noise", &noises) {
        choices.noise = noise;
    }
    table.finish();
    choices
}

/// The terms a table names; absent: as the runs require. A bridge wants the surface tension of every liquid.
pub(in crate::scene) fn terms(table: &Table, liquids: &[Liquid]) -> Option<Vec<Term>> {
    let words = Term::ALL.map(|term| (term.name(), term));
    let terms = table.words_or("terms", "auto", &words).flatten()?;
    let without = liquids.iter().find(|liquid| liquid.surface_tension.is_none());
    if let Some(liquid) = without.filter(|_| terms.contains(&Term::Bridge)) {
        let expected = format!(
            "bridge needs the surface tension: expected [liquids.{}] surface_tension_mN_m",
            liquid.name
        );
        table.refuse("terms", table.at("terms"), None, expected);
    }
    Some(terms)
}
