//! Reads the tables that choose a method: model, priors, sampler, bootstrap.

use super::expect::{ABOVE_ZERO, INSIDE_ONE, NOT_NEGATIVE};
use super::table::Table;
use super::Liquid;
use crate::error::quoted;
use crate::physics::dry::Order;
use crate::physics::impact::{DrySpeed, Form};
use crate::physics::inertia::Inertia;
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

/// A prior density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prior {
    /// median, sd of the log
    LogNormal(f64, f64),
    /// scale
    HalfNormal(f64),
    /// mean, sd
    Normal(f64, f64),
    /// shape, rate
    Gamma(f64, f64),
    /// lower, upper end
    Uniform(f64, f64),
    /// degrees of freedom, location, scale
    StudentT(f64, f64, f64),
    /// held at a value
    Fixed(f64),
}

/// A prior the scene sets for one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorChoice {
    /// the parameter's name
    pub parameter: &'static str,
    /// index into the scene's particles, for a prior of one particle
    pub particle: Option<usize>,
    /// the density
    pub prior: Prior,
}

/// How a posterior is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampler {
    /// chains
    pub chains: u64,
    /// draws a chain spends adapting
    pub warmup: u64,
    /// draws a chain keeps
    pub draws: u64,
}

/// How intervals are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// replicates
    pub replicates: u64,
    /// what is resampled
    pub scheme: ResamplingScheme,
    /// the interval to quote; absent: the default
    pub interval: Option<IntervalMethod>,
    /// probability an interval is made for
    pub level: f64,
}

/// What a bootstrap resamples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResamplingScheme {
    /// runs
    Cases,
    /// residuals of the fit
    Residuals,
    /// new noise about the fit
    Parametric,
    /// whole series
    Series,
}

impl ResamplingScheme {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            ResamplingScheme::Cases => "cases",
            ResamplingScheme::Residuals => "residuals",
            ResamplingScheme::Parametric => "parametric",
            ResamplingScheme::Series => "series",
        }
    }
}

/// How an interval is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalMethod {
    /// bias-corrected and accelerated
    Bca,
    /// percentiles of the replicates
    Percentile,
    /// studentized
    Studentized,
    /// estimate ± t · se
    Delta,
}

impl IntervalMethod {
    /// Its word in a scene.
    pub fn name(self) -> &'static str {
        match self {
            IntervalMethod::Bca => "bca",
            IntervalMethod::Percentile => "percentile",
            IntervalMethod::Studentized => "studentized",
            IntervalMethod::Delta => "delta",
        }
    }
}

/// Parameters a prior can be set for.
const PARAMETERS: [&str; 8] = [
    "dry_k",
    "lubrication_log",
    "inertial_prefactor",
    "film_scale",
    "sigma_dry",
    "sigma_wet",
    "sigma_energy",
    "nu",
];

pub(super) fn model(root: &Table, liquids: &[Liquid]) -> ModelChoices {
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
pub(super) fn terms(table: &Table, liquids: &[Liquid]) -> Option<Vec<Term>> {
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

/// Remembers which keys the scene sets that no stage reads yet.
fn note_unused(name: &str, table: &Table, keys: &[&str], unused: &mut Vec<String>) {
    for key in keys.iter().filter(|key| table.has(key)) {
        unused.push(format!("{name}.{key}"));
    }
}

pub(super) fn priors(
    root: &Table,
    particles: &[&str],
    likelihood: Likelihood,
    unused: &mut Vec<String>,
) -> Vec<PriorChoice> {
    let Some(table) = root.table("priors") else {
        return vec![];
    };
    let mut choices = vec![];
    for parameter in PARAMETERS {
        let Some(inner) = table.table(parameter) else {
            continue;
        };
        if let Some(name) = particles.iter().find(|name| inner.has(name)) {
            let expected = format!("expected the key in quotes: \"{parameter}.{name}\"");
            table.refuse(
                parameter,
                inner.at(name),
                Some(quoted(&format!("{parameter}.{name}"))),
                expected,
            );
            continue;
        }
        if let Some(prior) = prior(parameter, &inner) {
            choices.push(PriorChoice {
                parameter,
                particle: None,
                prior,
            });
        }
    }
    for (particle, name) in particles.iter().enumerate() {
        if let Some(prior) = table
            .table(&format!("dry_k.{name}"))
            .and_then(|inner| prior("dry_k", &inner))
        {
            choices.push(PriorChoice {
                parameter: "dry_k",
                particle: Some(particle),
                prior,
            });
        }
    }
    table.finish();
    if likelihood == Likelihood::Normal {
        note_unused("priors", &table, &["nu"], unused);
    }
    choices
}

fn prior(parameter: &str, table: &Table) -> Option<Prior> {
    let at = table.at("");
    let names = [
        "lognormal",
        "half_normal",
        "normal",
        "gamma",
        "uniform",
        "student_t",
        "fixed",
    ];
    let given: Vec<_> = names.into_iter().filter(|name| table.has(name)).collect();
    let refuse = |key: &str, expected: &str| {
        table.refuse(key, table.at(key), None, format!("expected {expected}"));
        None
    };
    let pair = |key: &str| table.numbers(key, 2).map(|x| (x[0], x[1]));
    let prior = match given.as_slice() {
        ["lognormal"] => match pair("lognormal")? {
            (median, sd) if median > 0.0 && sd > 0.0 => Some(Prior::LogNormal(median, sd)),
            _ => refuse("lognormal", "[median, sd of the log], both above 0"),
        },
        ["half_normal"] => table.number("half_normal", ABOVE_ZERO).map(Prior::HalfNormal),
        ["normal"] => match pair("normal")? {
            (mean, sd) if sd > 0.0 => Some(Prior::Normal(mean, sd)),
            _ => refuse("normal", "[mean, sd] with sd above 0"),
        },
        ["gamma"] => match pair("gamma")? {
            (shape, rate) if shape > 0.0 && rate > 0.0 => Some(Prior::Gamma(shape, rate)),
            _ => refuse("gamma", "[shape, rate], both above 0"),
        },
        ["uniform"] => match pair("uniform")? {
            (lo, hi) if lo < hi => Some(Prior::Uniform(lo, hi)),
            _ => refuse("uniform", "[lo, hi] with lo below hi"),
        },
        ["student_t"] => match table.numbers("student_t", 3)?.as_slice() {
            &[df, loc, scale] if df > 0.0 && scale > 0.0 => Some(Prior::StudentT(df, loc, scale)),
            _ => refuse("student_t", "[df, loc, scale] with df and scale above 0"),
        },
        // every parameter is positive; without inertia is the one with its prefactor at zero
        ["fixed"] if parameter == "inertial_prefactor" => table.number("fixed", NOT_NEGATIVE).map(Prior::Fixed),
        ["fixed"] => table.number("fixed", ABOVE_ZERO).map(Prior::Fixed),
        _ => {
            table.refuse("", at, None, format!("expected one prior out of {}", names.join(", ")));
            return None;
        }
    };
    table.finish();
    prior
}

/// More chains, or more draws a chain, than any memory holds beside the runs.
const MOST_CHAINS: u64 = 1000;
const MOST_DRAWS: u64 = 1_000_000;

pub(super) fn sampler(root: &Table) -> Sampler {
    let mut sampler = Sampler {
        chains: 4,
        warmup: 1000,
        draws: 1000,
    };
    if let Some(table) = root.table("sampler") {
        let count = |key: &str, most: u64| table.count_to(key, 1, most);
        sampler.chains = count("chains", MOST_CHAINS).unwrap_or(sampler.chains);
        sampler.warmup = count("warmup", MOST_DRAWS).unwrap_or(sampler.warmup);
        sampler.draws = count("draws", MOST_DRAWS).unwrap_or(sampler.draws);
        table.finish();
    }
    sampler
}

pub(super) fn bootstrap(root: &Table, unused: &mut Vec<String>) -> Bootstrap {
    let mut bootstrap = Bootstrap {
        replicates: 10_000,
        scheme: ResamplingScheme::Cases,
        interval: None,
        level: 0.95,
    };
    let Some(table) = root.table("bootstrap") else {
        return bootstrap;
    };
    let schemes = [
        ResamplingScheme::Cases,
        ResamplingScheme::Residuals,
        ResamplingScheme::Parametric,
        ResamplingScheme::Series,
    ]
    .map(|scheme| (scheme.name(), scheme));
    let methods = [
        IntervalMethod::Bca,
        IntervalMethod::Percentile,
        IntervalMethod::Studentized,
        IntervalMethod::Delta,
    ]
    .map(|method| (method.name(), method));
    bootstrap.replicates = table.count("replicates", 1).unwrap_or(bootstrap.replicates);
    bootstrap.scheme = table.choice("scheme", &schemes).unwrap_or(bootstrap.scheme);
    bootstrap.interval = table.choice("interval", &methods);
    bootstrap.level = table.number("level", INSIDE_ONE).unwrap_or(bootstrap.level);
    table.finish();
    note_unused("bootstrap", &table, &["replicates", "scheme"], unused);
    if bootstrap.interval.is_some_and(|method| method != IntervalMethod::Delta) {
        unused.push("bootstrap.interval".to_owned());
    }
    bootstrap
}
