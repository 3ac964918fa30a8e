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

    /// What is to be said of it; nothing of the normal.
    pub fn words(self) -> Option<&'static str> {
        match self {
            LikelihoodFamily::Normal => None,
            LikelihoodFamily::Student => Some(
                "Noise has Student's tails: z has a t distribution with ν degrees of freedom, the same for all runs, wet and \
                 dry; F is the probability of less than a number under it. t is stretched so that 68.3 % of it lies within a \
                 spread σ of its mean, as of the normal: its standard deviation is larger. A run far from all others says \
                 little of the other parameters and much of ν.",
            ),
            LikelihoodFamily::AsymmetricLaplace => Some(
                "Noise has an asymmetric Laplace distribution, the same for all runs, wet and dry: its density falls \
                 exponentially on both sides of a kink, above over exp(η) times the distance as below. z has mean 0 and \
                 standard deviation 1; the kink is rounded by a normal share of 0.15 of that. F is the probability of less than a \
                 number under it.",
            ),
        }
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
        table.refuse("likelihood", table.at("likelihood"), None, expected);
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
    let without = particles.iter().find(|particle| particle.roughness.is_none());
    if let Some(particle) = without.filter(|_| form.reads_roughness()) {
        let expected = format!(
            "{} needs the roughness: expected [particles.{}] roughness_um",
            form.name(),
            particle.name
        );
        table.refuse("viscous", table.at("viscous"), None, expected);
    }
    form
}

/// The terms a table names; a bridge wants the surface tension of every liquid.
pub fn checked_terms(table: &SceneTable, terms: Option<Vec<Term>>, liquids: &[Liquid]) -> Option<Vec<Term>> {
    let has_bridge = terms.as_ref().is_some_and(|terms| terms.contains(&Term::Bridge));
    let without = liquids.iter().find(|liquid| liquid.surface_tension.is_none());
    if let Some(liquid) = without.filter(|_| has_bridge) {
        let expected = format!(
            "bridge needs the surface tension: expected [liquids.{}] surface_tension_mN_m",
            liquid.name
        );
        table.refuse("terms", table.at("terms"), None, expected);
    }
    terms
}
