//! Reads the table of the model: the terms of the energy balance, the noise on a run, and what stuck runs are.

use super::noise::{NoiseParameter, ASYMMETRY, NU};
use crate::physics::dry::REFERENCE_SPEED;
use crate::physics::form::Term;
use crate::physics::{DrySpeed, Form, Inertia, Viscous};
use crate::scene::expect::ABOVE_ZERO;
use crate::scene::keys::{Key, Section};
use crate::scene::materials::{Liquid, Particle};
use crate::scene::table::{read_nothing, NumberOr, OneOf, SceneTable, SomeOf, Switch};
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
    pub(crate) fn shape(self) -> Option<NoiseParameter> {
        match self {
            LikelihoodFamily::Normal => None,
            LikelihoodFamily::Student => Some(NU),
            LikelihoodFamily::AsymmetricLaplace => Some(ASYMMETRY),
        }
    }

    /// Why it may not stand beside this, over which each run is integrated, as a message ends; `None` where it may: where its
    /// density has no kink.
    pub fn refused_beside(self, hidden: HiddenOfRun) -> Option<String> {
        let what = match hidden {
            HiddenOfRun::NoiseOnEnergy => "noise on the energy kept (noise = \"both\")",
            HiddenOfRun::TrueSpeed => "errors of the impact speeds",
        };
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

/// What is hidden of a run, over which its density is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HiddenOfRun {
    /// what noise adds to the energy kept
    NoiseOnEnergy,
    /// the impact speed, where its measurement errs
    TrueSpeed,
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

const DRY_SPEED: Key<NumberOr, Option<f64>> = Key::of("dry_speed", Dimension::Speed, DRY_SPEED_TAKES)
    .means("impact speed at which e_dry enters; \"impact\": each run's own, e_inf and St_c then still at the default")
    .example("\"impact\"")
    .defaults_to(Some(REFERENCE_SPEED));
pub const DRY_SPEED_TAKES: NumberOr = NumberOr(ABOVE_ZERO, "impact");

const INERTIA: Key<OneOf<Option<Inertia>>, Option<Inertia>> = Key::new(
    "inertia",
    OneOf::of(|| {
        let forms = Inertia::ALL.map(|form| (form.name(), Some(form)));
        forms.into_iter().chain([("auto", None)]).collect()
    }),
)
.means("form of the inertial loss; auto: as the runs require, by comparison")
.example("\"saturating\"")
.defaults_to(None);

const VISCOUS: Key<OneOf<Viscous>, Viscous> = Key::new("viscous", VISCOUS_TAKES)
    .means("form of the viscous loss: one L, or L of each film, without δc")
    .example("\"film\"")
    .defaults_to(Viscous::Constant);
pub const VISCOUS_TAKES: OneOf<Viscous> = OneOf::of(|| Viscous::NAMED.map(|form| (form.name(), form)).to_vec());

const TERMS: Key<SomeOf<Term>, Option<Vec<Term>>> = Key::new("terms", TERMS_TAKES)
    .means("terms of the energy balance; auto: inertia and viscous, unless the runs do not require one")
    .example("[\"inertia\", \"viscous\", \"bridge\"]")
    .defaults_to(None);
pub const TERMS_TAKES: SomeOf<Term> = SomeOf {
    words: || Term::LISTED.map(|term| (term.name(), term)).to_vec(),
    instead: "auto",
};

const LIKELIHOOD: Key<OneOf<LikelihoodFamily>, LikelihoodFamily> =
    Key::new("likelihood", OneOf::of(|| LikelihoodFamily::NAMED.to_vec()))
        .means(
            "distribution of the noise; student: with outliers; asymmetric_laplace: two exponentials, one to each side",
        )
        .example("\"student\"")
        .defaults_to(LikelihoodFamily::Normal);

const DRY_K: Key<OneOf<DryKOf>, DryKOf> = Key::new(
    "dry_k",
    OneOf::of(|| vec![("particle", DryKOf::Particle), ("diameter", DryKOf::Diameter)]),
)
.means("what has a k of its own; a fit takes at most 300 k")
.example("\"diameter\"")
.defaults_to(DryKOf::Particle);

const STICKING: Key<OneOf<Sticking>, Sticking> = Key::new(
    "sticking",
    OneOf::of(|| {
        vec![
            ("censored", Sticking::Censored),
            ("truncated", Sticking::Truncated),
            ("excluded", Sticking::Excluded),
        ]
    }),
)
.means("runs that stuck: censored are data, truncated were not logged, excluded are left out")
.example("\"truncated\"")
.defaults_to(Sticking::Censored);

const NOISE_ON: Key<OneOf<NoiseOn>, NoiseOn> = Key::new(
    "noise",
    OneOf::of(|| {
        vec![
            ("auto", NoiseOn::Auto),
            ("restitution", NoiseOn::Restitution),
            ("both", NoiseOn::Both),
        ]
    }),
)
.means("what scatters; both: the energy that a wet run keeps, too; auto: that only where barely rebounding runs ask for it")
.example("\"both\"")
.defaults_to(NoiseOn::Auto);

const SERIES_OFFSETS: Key<Switch, bool> = Key::new("series_offsets", Switch)
    .means("whether every series of runs has an offset of the energy kept")
    .example("true")
    .defaults_to(false);

/// What is to be said of the table of the model.
pub(in crate::scene) fn guide() -> Section {
    let (_, keys) = read_nothing(|table| model(table, &[], &[]));
    Section::new("[model]", "What the model holds", keys).that_may_be_empty()
}

pub fn model(table: &SceneTable, particles: &[Particle], liquids: &[Liquid]) -> ModelChoices {
    let choices = ModelChoices {
        dry_speed: dry_speed(table.read_or(&DRY_SPEED)),
        inertia: table.read_or(&INERTIA),
        viscous: checked_viscous(table, table.read_or(&VISCOUS), particles),
        terms: checked_terms(table, table.read_or(&TERMS), liquids),
        likelihood: table.read_or(&LIKELIHOOD),
        noise: table.read_or(&NOISE_ON),
        series_offsets: table.read_or(&SERIES_OFFSETS),
        dry_k: table.read_or(&DRY_K),
        sticking: table.read_or(&STICKING),
    };
    let refused = choices.likelihood.refused_beside(HiddenOfRun::NoiseOnEnergy);
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
