//! Reads the truth and the design of a simulation.

use super::choices::{
    checked_terms, checked_viscous, dry_speed, model, LikelihoodFamily, ModelChoices, NoiseParameter, DRY_SPEED_TAKES,
    SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET, TERMS_TAKES, VISCOUS_TAKES,
};
use super::expect::{Expect, ABOVE_ZERO, FILM_RATIO, FINITE, NOT_NEGATIVE, SHARE};
use super::keys::{Key, Section};
use super::materials::{Liquid, Particle};
use super::naming::SceneNames;
use super::table::{
    read_nothing, Count, Inner, Number, NumberOr, Numbers, NumbersByParticle, OneOf, SceneTable, SomeOf, Texts,
    MOST_COUNTED,
};
use crate::physics::balance::Balance;
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::DRY_K;
use crate::physics::form::Term;
use crate::physics::loss::Film;
use crate::physics::numbers::same_diameter;
use crate::physics::quantity::Wetted;
use crate::physics::{numbers, Coefficient, DrySpeed, Form, Inertia, Parameters, Quantity, Viscous};
use crate::units::Dimension;

/// The parameters simulated runs are drawn from. What a file leaves out is missed only when runs are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// k of each of the scene's particles at every diameter; absent where the table names none
    pub dry_k: Vec<Option<f64>>,
    /// k of each of the scene's particles by diameter; empty where the table names none
    pub dry_k_by_diameter: Vec<Vec<KOfDiameter>>,
    /// the parameters that particles share, in the order of [`Coefficient::ALL`]
    pub shared: [Option<f64>; Coefficient::COUNT],
    /// form of the inertial loss
    pub inertia: Inertia,
    /// form of the viscous loss where it is held
    pub viscous: Viscous,
    /// the speed at which e_dry enters
    pub dry_speed: DrySpeed,
    /// sd of the noise on a dry restitution
    pub sigma_dry: Option<f64>,
    /// sd of the noise on a wet restitution
    pub sigma_wet: Option<f64>,
    /// sd of the noise on the energy a wet run keeps; absent: none
    pub sigma_energy: Option<f64>,
    /// sd of the offset of the energy kept that the wet runs of a series share; absent: none
    pub sigma_series: Option<f64>,
    /// shape of the noise's family
    pub shape: Option<f64>,
    /// shape of the noise on wet runs
    pub noise: NoiseShape,
    /// the terms the truth holds; absent: the inertial and the viscous loss
    pub terms: Option<Vec<Term>>,
}

/// k of a particle at one diameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KOfDiameter {
    /// D, m
    pub diameter: f64,
    /// k, (m/s)^(-1/5)
    pub dry_k: f64,
}

impl Truth {
    /// k of a particle at a diameter, m; `None` where the table names none.
    pub fn k(&self, particle: usize, diameter: f64) -> Option<f64> {
        let mut each = self.dry_k_by_diameter[particle].iter();
        let own = each.find(|own| same_diameter(own.diameter, diameter));
        own.map(|own| own.dry_k).or(self.dry_k[particle])
    }

    /// The value of a parameter that particles share.
    pub fn value(&self, coefficient: Coefficient) -> Option<f64> {
        self.shared[coefficient as usize]
    }

    /// The value of a parameter that particles share, or of δc/ε that follows from one; `None` where the truth does not name
    /// it.
    pub fn of_quantity(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Shared(coefficient) => self.value(coefficient).filter(|_| self.form().has(coefficient)),
            Quantity::DeltaCOverRoughness => self
                .of_quantity(Quantity::Shared(Coefficient::LubricationLog))
                .map(f64::exp),
            _ => None,
        }
    }

    /// What holds at infinite speed of a sphere of this k at a film, with e_dry at a reference speed; `None` where the truth
    /// lacks a number, or where its viscous loss belongs to a diameter.
    pub fn wetted(&self, dry_k: f64, film: Film, reference_speed: f64) -> Option<Wetted<f64>> {
        let form = self.form();
        let complete = form.coefficients().all(|coefficient| self.value(coefficient).is_some());
        if form.viscous.tells_diameters_apart() || !complete {
            return None;
        }
        let parameters = Parameters {
            dry_k,
            shared: Coefficients::first_of(&self.shared.map(|value| value.unwrap_or(f64::NAN))),
        };
        let balance = Balance::new(form, film, &parameters);
        Some(Wetted::of_balance(
            balance.e_inf(reference_speed),
            balance.lost.over_stokes,
        ))
    }

    /// The form of the truth's energy balance.
    pub fn form(&self) -> Form {
        let usual = Form {
            viscous: self.viscous,
            ..Form::new(self.inertia, self.dry_speed)
        };
        self.terms.as_deref().map_or(usual, |terms| usual.with_terms(terms))
    }
}

/// Shape of the noise on a simulated restitution; each has the truth's sd, or varies about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseShape {
    /// of a family that the model may have, on dry runs as well
    Family(LikelihoodFamily),
    /// one minus an exponential: mean 0, sd 1, a long tail towards low restitutions
    Skewed,
    /// normal, its sd growing with 1/St: sd · (1/2 + 25/St)
    Heteroscedastic,
}

/// The settings simulated runs are made at.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// diameters of each particle, m; empty where the table names none
    pub diameters: Vec<Vec<f64>>,
    /// indices into the scene's liquids
    pub liquids: Vec<usize>,
    /// film ratios of each particle
    pub film_ratios: Vec<Vec<f64>>,
    /// impact speeds of the wet runs, m/s
    pub speeds: Vec<f64>,
    /// impact speeds of the dry runs, m/s
    pub dry_speeds: Vec<f64>,
    /// sd of the logarithm of the wet runs' own films about that of their setting; absent: the film of the setting
    pub film_rel_sd: Option<f64>,
    /// the same of the runs' own impact speeds, dry runs' too
    pub impact_speed_rel_sd: Option<f64>,
    /// runs at each setting
    pub repeats: u64,
}

const TRUE_DRY_K: Key<Inner> = Key::new(
    DRY_K.name,
    Inner("a table of particles, each with a number of 0 or more or a table by diameter in mm"),
)
.means("k of each particle")
.example("{ PTFE = 0.183, PE = { \"3.175\" = 0.12, \"4.762\" = 0.13 } }")
.optional(WANTED);

/// What is to be said of a parameter of the truth that has no default.
const WANTED: &str = "a simulation that needs it is refused";

/// The key of a parameter that particles share.
fn shared(coefficient: Coefficient) -> Key<Number> {
    let own = coefficient.describe();
    Key::new(own.name, Number(if own.must_be_positive { ABOVE_ZERO } else { FINITE }))
        .means(own.meaning)
        .example(own.example)
        .optional(WANTED)
}

/// The key of a parameter of the noise.
const fn noise(own: &NoiseParameter, expect: Expect, absent: &'static str) -> Key<Number> {
    Key::new(own.name, Number(expect))
        .means(own.meaning)
        .example(own.example)
        .optional(absent)
}

const TRUE_SIGMA_DRY: Key<Number> = noise(&SIGMA_DRY, NOT_NEGATIVE, WANTED);
const TRUE_SIGMA_WET: Key<Number> = noise(&SIGMA_WET, NOT_NEGATIVE, WANTED);
const TRUE_SIGMA_ENERGY: Key<Number> = noise(&SIGMA_ENERGY, NOT_NEGATIVE, "none");
const TRUE_SIGMA_SERIES: Key<Number> = noise(&SIGMA_SERIES, NOT_NEGATIVE, "none");

/// The keys of the shapes of the families, each with its family.
fn shapes() -> impl Iterator<Item = (LikelihoodFamily, Key<Number>)> {
    LikelihoodFamily::NAMED.into_iter().filter_map(|(_, family)| {
        let own = family.shape()?;
        let expect = if own.least < 0.0 { FINITE } else { ABOVE_ZERO };
        Some((family, noise(&own, expect, WANTED)))
    })
}

const NOISE: Key<OneOf<NoiseShape>, NoiseShape> = Key::new(
    "noise",
    OneOf::of(|| {
        let families = LikelihoodFamily::NAMED.map(|(name, family)| (name, NoiseShape::Family(family)));
        let others = [
            ("skewed", NoiseShape::Skewed),
            ("heteroscedastic", NoiseShape::Heteroscedastic),
        ];
        families.into_iter().chain(others).collect()
    }),
)
.means("shape of the noise")
.example("\"skewed\"")
.defaults_to(NoiseShape::Family(LikelihoodFamily::Normal));

/// What holds without a key that [model] has, too.
const AS_THE_MODEL: &str = "as in [model]";

const TRUE_INERTIA: Key<OneOf<Inertia>> = Key::new(
    "inertia",
    OneOf::of(|| Inertia::ALL.map(|form| (form.name(), form)).to_vec()),
)
.means("form of the inertial loss")
.example("\"saturating\"")
.optional("as in [model], there stepwise where it is open");

const TRUE_VISCOUS: Key<OneOf<Viscous>> = Key::new("viscous", VISCOUS_TAKES)
    .means("form of the viscous loss")
    .example("\"film\"")
    .optional(AS_THE_MODEL);

const TRUE_DRY_SPEED: Key<NumberOr> = Key::of("dry_speed", Dimension::Speed, DRY_SPEED_TAKES)
    .means("impact speed at which e_dry enters")
    .example("\"impact\"")
    .optional(AS_THE_MODEL);

const TRUE_TERMS: Key<SomeOf<Term>> = Key::new("terms", TERMS_TAKES)
    .means("terms that the truth holds")
    .example("[\"inertia\", \"viscous\", \"bridge\"]")
    .optional("inertia and viscous");

const DIAMETER: Key<NumbersByParticle> = Key::of("diameter", Dimension::Length, NumbersByParticle(ABOVE_ZERO))
    .means("diameters of each particle")
    .example("{ PTFE = [3.175, 4.762] }")
    .optional(WANTED);

const FILM_RATIOS: Key<NumbersByParticle> = Key::new("film_ratio", NumbersByParticle(FILM_RATIO))
    .means("film ratios of each particle")
    .example("[0.03, 0.06]")
    .optional(WANTED);

const LIQUIDS: Key<Texts> = Key::new("liquids", Texts)
    .means("liquids, names in [liquids]")
    .example("[\"AK10\"]")
    .optional("every run is dry");

const HEIGHT: Key<Numbers> = Key::of("height", Dimension::Length, Numbers(ABOVE_ZERO))
    .means("heights that wet runs fall from, v = √(2 g h)")
    .example("[30, 50, 100, 150]")
    .optional("impact_speed says it");

const IMPACT_SPEED: Key<Numbers> = Key::of("impact_speed", Dimension::Speed, Numbers(ABOVE_ZERO))
    .means("impact speeds of the wet runs")
    .example("[0.5, 1.0, 2.0]")
    .optional("height says it");

const DRY_IMPACT_SPEED: Key<Numbers> = Key::of("dry_impact_speed", Dimension::Speed, Numbers(ABOVE_ZERO))
    .means("impact speeds of the dry runs")
    .example("[0.5, 1.0, 2.0]")
    .optional("no run is dry");

const FILM_REL_SD: Key<Number> = Key::new("film_rel_sd", Number(SHARE))
    .means("gives every wet run a film of its own: sd of its logarithm about that of the setting")
    .example("0.02")
    .optional("every film is that of its setting");

const IMPACT_SPEED_REL_SD: Key<Number> = Key::new("impact_speed_rel_sd", Number(SHARE))
    .means("gives every run an impact speed of its own, in the same way")
    .example("0.05")
    .optional("every speed is that of its setting");

const REPEATS: Key<Count, u64> = Key::new("repeats", Count(1, MOST_COUNTED))
    .means("runs at each setting")
    .example("5")
    .defaults_to(1);

/// What is to be said of the tables of a simulation.
pub(super) fn guide() -> [Section; 2] {
    let (usual, _) = read_nothing(|table| model(table, &[], &[]));
    let (_, of_truth) = read_nothing(|table| truth(table, &[], (&[], &[]), &usual));
    let (_, of_design) = read_nothing(|table| design(table, &SceneNames::default()));
    let about = "The parameters that simulated runs are drawn from; of a fit only the report reads them";
    [
        Section::new("[truth]", about, of_truth),
        Section::new("[design]", "The settings that simulated runs are made at", of_design),
    ]
}

pub(super) fn truth(
    table: &SceneTable,
    names: &[&str],
    (particles, liquids): (&[Particle], &[Liquid]),
    model: &ModelChoices,
) -> Truth {
    let (dry_k, dry_k_by_diameter) = true_k(table, names);
    let shared = Coefficient::ALL.map(|coefficient| table.read(&shared(coefficient)));
    let inertia = table.read(&TRUE_INERTIA).or(model.inertia);
    let viscous = table.read(&TRUE_VISCOUS);
    let viscous = viscous.map(|form| checked_viscous(table, form, particles));
    let terms = table.read(&TRUE_TERMS).flatten();
    let mut truth = Truth {
        dry_k,
        dry_k_by_diameter,
        shared,
        inertia: inertia.unwrap_or(Inertia::DEFAULT),
        viscous: viscous.unwrap_or(model.viscous),
        dry_speed: table.read(&TRUE_DRY_SPEED).map_or(model.dry_speed, dry_speed),
        sigma_dry: table.read(&TRUE_SIGMA_DRY),
        sigma_wet: table.read(&TRUE_SIGMA_WET),
        sigma_energy: table.read(&TRUE_SIGMA_ENERGY),
        sigma_series: table.read(&TRUE_SIGMA_SERIES),
        noise: table.read_or(&NOISE),
        shape: None,
        terms: checked_terms(table, terms, liquids),
    };
    for (family, key) in shapes() {
        let value = table.read(&key);
        if truth.noise == NoiseShape::Family(family) {
            truth.shape = value;
        }
    }
    table.finish();
    truth
}

/// k of each particle, as [`Truth`] has it: one for every diameter, or where the file has a table of them by diameter, each
/// of these.
fn true_k(table: &SceneTable, particles: &[&str]) -> (Vec<Option<f64>>, Vec<Vec<KOfDiameter>>) {
    let (mut of_all, mut of_each) = (vec![None; particles.len()], vec![vec![]; particles.len()]);
    let Some(by_particle) = table.inner_table(&TRUE_DRY_K) else {
        return (of_all, of_each);
    };
    for (particle, name) in particles.iter().enumerate() {
        if !by_particle.holds_table(name) {
            of_all[particle] = by_particle.number(name, NOT_NEGATIVE);
        } else if let Some(table) = by_particle.table(name) {
            of_each[particle] = by_diameter(&table);
        }
    }
    by_particle.finish();
    (of_all, of_each)
}

/// The k of a table whose keys are diameters in mm.
fn by_diameter(table: &SceneTable) -> Vec<KOfDiameter> {
    let mut all: Vec<KOfDiameter> = vec![];
    for key in table.keys() {
        let in_mm = key.parse::<f64>().ok().filter(|mm| (ABOVE_ZERO.holds)(*mm));
        // without quotes TOML takes the point of 4.762 for a table in a table
        let in_quotes = !table.holds_table(&key);
        let Some(diameter) = in_mm.filter(|_| in_quotes).map(|mm| Dimension::Length.usual_to_si(mm)) else {
            let expected = "expected diameters in mm, in quotes: { \"4.762\" = 0.18 }";
            table.refuse_key(&key, expected);
            continue;
        };
        let dry_k = table.number(&key, NOT_NEGATIVE);
        if all.iter().any(|other| same_diameter(other.diameter, diameter)) {
            let expected = "expected diameters that differ by more than 0.1 %";
            table.refuse(&key, table.at(&key), None, expected);
        }
        all.extend(dry_k.map(|dry_k| KOfDiameter { diameter, dry_k }));
    }
    table.finish();
    all
}

pub(super) fn design(table: &SceneTable, names: &SceneNames) -> Design {
    let diameters = table.by_particle(&DIAMETER, &names.particles);
    let mut used = vec![];
    for (name, at) in table.read(&LIQUIDS).unwrap_or_default() {
        match names.liquids.iter().position(|liquid| *liquid == name) {
            Some(liquid) => used.push(liquid),
            None => {
                let names = names.liquids.iter().copied();
                table.refuse_name(LIQUIDS.base, (&name, at), "a name in [liquids]", names);
            }
        }
    }
    let film_ratios = table.by_particle(&FILM_RATIOS, &names.particles);
    let heights = table.read(&HEIGHT);
    let speeds = table.read(&IMPACT_SPEED);
    if heights.is_some() && speeds.is_some() {
        let at = table.at("");
        table.refuse("", at, None, "expected either drop heights or impact speeds, not both");
    }
    let fallen = heights.map(|hs| hs.into_iter().map(numbers::free_fall_speed).collect());
    let design = Design {
        diameters,
        liquids: used,
        film_ratios,
        speeds: fallen.or(speeds).unwrap_or_default(),
        dry_speeds: table.read(&DRY_IMPACT_SPEED).unwrap_or_default(),
        film_rel_sd: table.read(&FILM_REL_SD),
        impact_speed_rel_sd: table.read(&IMPACT_SPEED_REL_SD),
        repeats: table.read_or(&REPEATS),
    };
    table.finish();
    design
}
