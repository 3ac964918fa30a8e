//! Reads numbers from the literature that are set beside ours.

use serde::Serialize;

use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE};
use super::keys::{Key, Section};
use super::table::{read_nothing, Number, OneOf, SceneTable, Text};
use crate::physics::Quantity;

/// One of the two laws of the wet restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WetLaw {
    /// e = e_inf (1 − St_c/St)
    Linear,
    /// e = √(e_inf² − 4 L/St)
    Sqrt,
}

impl WetLaw {
    /// The word files use.
    pub fn name(self) -> &'static str {
        match self {
            WetLaw::Linear => "linear",
            WetLaw::Sqrt => "sqrt",
        }
    }
}

/// A number from the literature.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// what it is: e_inf or St_c of one law, or k of the dry law
    pub quantity: Quantity,
    /// index into [`super::Scene::particles`]
    pub particle: usize,
    /// the film ratio it holds for; absent: all of them
    pub film_ratio: Option<f64>,
    /// the law it was fitted with; absent for k
    pub law: Option<WetLaw>,
    /// its value
    pub value: f64,
    /// its standard error
    pub se: f64,
    /// where it stands
    pub source: String,
}

const QUANTITY: Key<OneOf<Quantity>> = Key::new("quantity", OneOf::of(quantities))
    .means("what it is")
    .example("\"e_inf\"");

/// What the literature gives numbers for.
fn quantities() -> Vec<(&'static str, Quantity)> {
    let all = [Quantity::EInf, Quantity::StC, Quantity::DryK];
    all.map(|quantity| (quantity.describe().name, quantity)).to_vec()
}

const PARTICLE: Key<Text> = Key::new("particle", Text)
    .means("the particle it is of, a name in [particles]")
    .example("\"PTFE\"");

const OF_FILM_RATIO: Key<Number> = Key::new("film_ratio", Number(FILM_RATIO))
    .means("the film ratio it holds for")
    .example("0.06")
    .optional("all of them");

const LAW: Key<OneOf<WetLaw>> = Key::new(
    "law",
    OneOf::of(|| [WetLaw::Linear, WetLaw::Sqrt].map(|law| (law.name(), law)).to_vec()),
)
.means("the law it was fitted with; not of dry_k")
.example("\"linear\"")
.optional("linear");

const VALUE: Key<Number> = Key::new("value", Number(FINITE)).means("its value").example("0.718");

const SE: Key<Number> = Key::new("se", Number(ABOVE_ZERO))
    .means("its standard error")
    .example("0.004");

const SOURCE: Key<Text> = Key::new("source", Text)
    .means("where it stands")
    .example("\"Müller & Huang 2016, fig. 2\"");

/// What is to be said of a table of a number from the literature.
pub(super) fn guide() -> Section {
    let about = "A number from the literature, to set beside ours; one table for each";
    let (_, keys) = read_nothing(|table| published(table, &[]));
    Section::new("[[published]]", about, keys)
}

/// Reads a number from the literature.
pub(super) fn published(table: &SceneTable, particles: &[&str]) -> Option<Published> {
    let quantity = table.read(&QUANTITY);
    let name = table.read(&PARTICLE);
    let particle = name.as_deref().and_then(|name| {
        let index = particles.iter().position(|particle| *particle == name);
        if index.is_none() {
            let (names, at) = (particles.iter().copied(), table.at(PARTICLE.base));
            table.refuse_name(PARTICLE.base, (name, at), "a name in [particles]", names);
        }
        index
    });
    let film_ratio = table.read(&OF_FILM_RATIO);
    let law = table.read(&LAW);
    let value = table.read(&VALUE);
    let se = table.read(&SE);
    let source = table.read(&SOURCE);
    table.finish();
    let quantity = quantity?;
    Some(Published {
        quantity,
        particle: particle?,
        film_ratio,
        law: (quantity != Quantity::DryK).then(|| law.unwrap_or(WetLaw::Linear)),
        value: value?,
        se: se?,
        source: source?,
    })
}
