//! Reads the table of the model: the terms of the energy balance, the noise on a run, and what stuck runs are.

use super::parameters::{SceneParameter, ASYMMETRY, NU};
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::{DrySpeed, Form, Inertia, Viscous};
use crate::scene::expect::ABOVE_ZERO;
use crate::scene::materials::{Liquid, Particle};
use crate::scene::table::values::{number_or, one_of, some_of, switch, Takes};
use crate::scene::table::SceneTable;
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

    /// Whether noise is other than normal or acts on the energy, too: then no few runs have the sums of all.
    pub fn has_own_noise(&self) -> bool {
        self.likelihood != LikelihoodFamily::Normal || self.noise == NoiseOn::Both
    }

    /// Whether every run has to be kept: for its noise, or as forms of the inertial loss are compared run by run.
    pub fn needs_every_run(&self) -> bool {
        self.has_own_noise() || self.inertia_is_open()
    }
}

/// Distribution of the noise on a restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LikelihoodFamily {
    /// normal
    Normal,
    /// Student-t with estimated degrees of freedom
    Student,
    /// two exponentials of different slope
    AsymmetricLaplace,
}

impl LikelihoodFamily {
    /// Every one with its word in scenes.
    pub const NAMED: [(&'static str, LikelihoodFamily); 3] = [
        ("normal", LikelihoodFamily::Normal),
        ("student", LikelihoodFamily::Student),
        ("asymmetric_laplace", LikelihoodFamily::AsymmetricLaplace),
    ];

    /// The parameter of its shape; `None` of the normal, which has none.
    pub(crate) fn shape(self) -> Option<SceneParameter> {
        match self {
            LikelihoodFamily::Normal => None,
            LikelihoodFamily::Student => Some(NU),
            LikelihoodFamily::AsymmetricLaplace => Some(ASYMMETRY),
        }
    }

    /// Why it may not stand beside this, over which each run is integrated, as a message ends; `None` where it may: where its
    /// density has no kink.
    pub fn refused_beside(self, what: &str) -> Option<String> {
        let is_refused = self == LikelihoodFamily::AsymmetricLaplace;
        is_refused.then(|| format!("expected normal or student beside {what}, which are not integrated over a kink"))
    }

    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        LikelihoodFamily::NAMED[self as usize].0
    }
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
    /// on the restitution; on the energy kept, too, where runs barely rebound and a main number depends on it
    Auto,
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

/// What is taken for the speed at which e_dry enters; none is each run's own.
pub fn dry_speeds() -> Takes<Option<f64>> {
    number_or(ABOVE_ZERO, "impact").of(Dimension::Speed)
}

/// What is taken for the form of the viscous loss.
pub fn viscous_forms() -> Takes<Viscous> {
    one_of(Viscous::NAMED.map(|form| (form.name(), form)))
}

/// What is taken for the terms of the energy balance.
pub fn some_terms() -> Takes<Option<Vec<Term>>> {
    some_of(Term::LISTED.map(|term| (term.name(), term)), "auto")
}

pub fn model(table: &SceneTable, particles: &[Particle], liquids: &[Liquid]) -> ModelChoices {
    let forms = Inertia::ALL.map(|form| (form.name(), Some(form)));
    let forms: Vec<_> = forms.into_iter().chain([("auto", None)]).collect();
    let noise = one_of([
        ("auto", NoiseOn::Auto),
        ("restitution", NoiseOn::Restitution),
        ("both", NoiseOn::Both),
    ]);
    let dry_k = one_of([("particle", DryKOf::Particle), ("diameter", DryKOf::Diameter)]);
    let sticking = one_of([
        ("censored", Sticking::Censored),
        ("truncated", Sticking::Truncated),
        ("excluded", Sticking::Excluded),
    ]);
    let choices = ModelChoices {
        dry_speed: dry_speed(table.read_or("dry_speed", dry_speeds(), Some(REFERENCE_SPEED))),
        inertia: table.read_or("inertia", one_of(forms), None),
        viscous: checked_viscous(
            table,
            table.read_or("viscous", viscous_forms(), Viscous::Constant),
            particles,
        ),
        terms: checked_terms(table, table.read_or("terms", some_terms(), None), liquids),
        likelihood: table.read_or("likelihood", one_of(LikelihoodFamily::NAMED), LikelihoodFamily::Normal),
        noise: table.read_or("noise", noise, NoiseOn::Auto),
        series_offsets: table.read_or("series_offsets", switch(), false),
        dry_k: table.read_or("dry_k", dry_k, DryKOf::Particle),
        sticking: table.read_or("sticking", sticking, Sticking::Censored),
    };
    let energy = "noise on the energy kept (noise = \"both\")";
    let refused = choices.likelihood.refused_beside(energy);
    if let Some(expected) = refused.filter(|_| choices.noise == NoiseOn::Both) {
        table.refuse_key("likelihood", expected);
    }
    table.finish();
    choices
}

/// The speed at which e_dry enters; none is each run's own.
pub fn dry_speed(given: Option<f64>) -> DrySpeed {
    given.map_or(DrySpeed::Impact, DrySpeed::Reference)
}

/// The form of the viscous loss; lubrication over the whole film wants the roughness of every particle.
pub fn checked_viscous(table: &SceneTable, form: Viscous, particles: &[Particle]) -> Viscous {
    let without = |particle: &&Particle| form.reads_roughness() && particle.roughness.is_none();
    if let Some(Particle { name, .. }) = particles.iter().find(without) {
        let needs = format!("{} needs the roughness", form.name());
        table.refuse_key("viscous", format!("{needs}: expected [particles.{name}] roughness_um"));
    }
    form
}

/// The terms a table names; a bridge wants the surface tension of every liquid.
pub fn checked_terms(table: &SceneTable, terms: Option<Vec<Term>>, liquids: &[Liquid]) -> Option<Vec<Term>> {
    let has_bridge = terms.as_ref().is_some_and(|terms| terms.contains(&Term::Bridge));
    let without = |liquid: &&Liquid| has_bridge && liquid.surface_tension.is_none();
    if let Some(Liquid { name, .. }) = liquids.iter().find(without) {
        let needs = "bridge needs the surface tension";
        table.refuse_key(
            "terms",
            format!("{needs}: expected [liquids.{name}] surface_tension_mN_m"),
        );
    }
    terms
}
