//! Reads numbers from the literature that are set beside ours.

use serde::Serialize;

use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE};
use super::table::values::{number, one_of, text};
use super::table::SceneTable;
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

/// Reads a number from the literature.
pub(super) fn published(table: &SceneTable, particles: &[String]) -> Option<Published> {
    let quantities = [Quantity::EInf, Quantity::StC, Quantity::DryK];
    let quantities = quantities.map(|quantity| (quantity.describe().name, quantity));
    let quantity = table.required("quantity", one_of(quantities));
    let name = table.required("particle", text());
    let particle = name.and_then(|name| {
        let at = table.at("particle");
        table.place_of("particle", (&name, at), "a name in [particles]", particles)
    });
    let film_ratio = table.read("film_ratio", number(FILM_RATIO));
    let laws = [WetLaw::Linear, WetLaw::Sqrt].map(|law| (law.name(), law));
    let law = table.read("law", one_of(laws));
    let value = table.required("value", number(FINITE));
    let se = table.required("se", number(ABOVE_ZERO));
    let source = table.required("source", text());
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
