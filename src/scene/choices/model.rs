//! Reads the table of the model: the terms of the energy balance, the noise on a run, and what stuck runs are.

use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::{DrySpeed, Form, Inertia, Viscous};
use crate::scene::expect::ABOVE_ZERO;
use crate::scene::materials::Liquid;
use crate::scene::table::{QuantityOrWord, SceneTable};
use crate::units::Dimension;

/// What the model holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelChoices {
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// the inertial form; absent: to be chosen by comparison
    pub inertia: Option<Inertia>,
    /// form of the viscous loss where it is held
    pub viscous: Viscous,
    /// the terms to hold; absent: as the runs require
    pub terms: Option<Vec<Term>>,
    /// distribution of the noise on a restitution
    pub likelihood: LikelihoodFamily,
    /// what has a k of its own
    pub dry_k: DryKOf,
    /// what is made of stuck runs
    pub sticking: Sticking,
    /// where the scatter of wet runs acts
    pub noise: NoiseOn,
    /// whether each series has an offset of r of its own
    pub series_offsets: bool,
}

impl ModelChoices {
    /// The energy balance to start from: what the scene's terms name, with the form of inertia that stands where the
    /// scene leaves it open.
    pub fn form(&self) -> Form {
        let usual = Form {
            viscous: self.viscous,
            ..Form::new(self.inertia.unwrap_or(Inertia::DEFAULT), self.dry_speed)
        };
        self.terms.as_deref().map_or(usual, |terms| usual.with_terms(terms))
    }

    /// Whether the form of the inertial loss is to be found by comparison.
    pub fn inertia_is_open(&self) -> bool {
        self.inertia.is_none() && self.form().inertia != Inertia::None
    }
}

/// Distribution of the noise on a restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LikelihoodFamily {
    /// normal
    Normal,
    /// Student-t with estimated degrees of freedom
    Student,
}

/// What has a k of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DryKOf {
    /// each particle, whatever the diameter
    Particle,
    /// each diameter of each particle
    Diameter,
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

pub fn model(root: &SceneTable, liquids: &[Liquid]) -> ModelChoices {
    let mut choices = ModelChoices {
        dry_speed: DrySpeed::Reference(REFERENCE_SPEED),
        inertia: None,
        viscous: Viscous::Constant,
        terms: None,
        likelihood: LikelihoodFamily::Normal,
        dry_k: DryKOf::Particle,
        sticking: Sticking::Censored,
        noise: NoiseOn::Restitution,
        series_offsets: false,
    };
    let Some(table) = root.table("model") else {
        return choices;
    };
    if let Some(speed) = dry_speed(&table) {
        choices.dry_speed = speed;
    }
    let mut forms: Vec<_> = Inertia::ALL.map(|form| (form.name(), Some(form))).to_vec();
    forms.push(("auto", None));
    if let Some(form) = table.choice("inertia", &forms) {
        choices.inertia = form;
    }
    if let Some(form) = viscous(&table) {
        choices.viscous = form;
    }
    choices.terms = terms(&table, liquids);
    let likelihoods = [
        ("normal", LikelihoodFamily::Normal),
        ("student", LikelihoodFamily::Student),
    ];
    if let Some(likelihood) = table.choice("likelihood", &likelihoods) {
        choices.likelihood = likelihood;
    }
    let of = [("particle", DryKOf::Particle), ("diameter", DryKOf::Diameter)];
    if let Some(of) = table.choice("dry_k", &of) {
        choices.dry_k = of;
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
    if let Some(offsets) = table.boolean("series_offsets") {
        choices.series_offsets = offsets;
    }
    table.finish();
    choices
}

/// The speed at which e_dry enters, where a table names it.
pub fn dry_speed(table: &SceneTable) -> Option<DrySpeed> {
    match table.quantity_or_word("dry_speed", Dimension::Speed, ABOVE_ZERO, "impact")? {
        QuantityOrWord::Quantity(speed) => Some(DrySpeed::Reference(speed)),
        QuantityOrWord::Word => Some(DrySpeed::Impact),
    }
}

/// The form of the viscous loss, where a table names it.
pub fn viscous(table: &SceneTable) -> Option<Viscous> {
    table.choice("viscous", &Viscous::NAMED.map(|form| (form.name(), form)))
}

/// The terms a table names; absent: as the runs require. A bridge wants the surface tension of every liquid.
pub fn terms(table: &SceneTable, liquids: &[Liquid]) -> Option<Vec<Term>> {
    let words = Term::LISTED.map(|term| (term.name(), term));
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
