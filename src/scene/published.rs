//! Reads numbers from the literature that are set beside ours.

use serde::{Serialize, Serializer};

use super::expect::{ABOVE_ZERO, FILM_RATIO, FINITE};
use super::keys::{guides, Key, Optional, Required, Section};
use super::table::{Located, Number, OneOf, SceneTable, Text};
use crate::physics::Quantity;
use crate::units::Dimension;

/// One of the two laws of the wet restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

impl Serialize for WetLaw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A quantity the literature gives a number for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PublishedQuantity {
    /// e_inf of one law
    EInf,
    /// St_c of one law
    StC,
    /// k of the dry law
    DryK,
}

impl PublishedQuantity {
    /// What it is of a fit.
    pub fn of_fit(self) -> Quantity {
        match self {
            PublishedQuantity::EInf => Quantity::EInf,
            PublishedQuantity::StC => Quantity::StC,
            PublishedQuantity::DryK => Quantity::DryK,
        }
    }

    /// The word a scene file uses.
    pub fn name(self) -> &'static str {
        self.of_fit().describe().name
    }
}

/// A number from the literature.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// what it is
    pub quantity: PublishedQuantity,
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

const QUANTITY: Key<OneOf<PublishedQuantity>, Required> = Key {
    base: "quantity",
    takes: OneOf(|| {
        let all = [PublishedQuantity::EInf, PublishedQuantity::StC, PublishedQuantity::DryK];
        all.map(|quantity| (quantity.name(), quantity)).to_vec()
    }),
    absent: Required,
    meaning: "what it is",
    example: "\"e_inf\"",
};

const PARTICLE: Key<Text, Required> = Key {
    base: "particle",
    takes: Text,
    absent: Required,
    meaning: "the particle it is of, a name in [particles]",
    example: "\"PTFE\"",
};

const OF_FILM_RATIO: Key<Number, Optional> = Key {
    base: "film_ratio",
    takes: Number(Dimension::One, FILM_RATIO),
    absent: Optional("all of them"),
    meaning: "the film ratio it holds for",
    example: "0.06",
};

const LAW: Key<OneOf<WetLaw>, Optional> = Key {
    base: "law",
    takes: OneOf(|| [WetLaw::Linear, WetLaw::Sqrt].map(|law| (law.name(), law)).to_vec()),
    absent: Optional("linear"),
    meaning: "the law it was fitted with; not of dry_k",
    example: "\"linear\"",
};

const VALUE: Key<Number, Required> = Key {
    base: "value",
    takes: Number(Dimension::One, FINITE),
    absent: Required,
    meaning: "its value",
    example: "0.718",
};

const SE: Key<Number, Required> = Key {
    base: "se",
    takes: Number(Dimension::One, ABOVE_ZERO),
    absent: Required,
    meaning: "its standard error",
    example: "0.004",
};

const SOURCE: Key<Text, Required> = Key {
    base: "source",
    takes: Text,
    absent: Required,
    meaning: "where it stands",
    example: "\"Müller & Huang 2016, fig. 2\"",
};

/// What is to be said of a table of a number from the literature.
pub(super) fn guide() -> Section {
    Section {
        head: "[[published]]",
        may_be_empty: false,
        about: "A number from the literature, to set beside ours; one table for each".to_owned(),
        keys: guides(&[&QUANTITY, &PARTICLE, &OF_FILM_RATIO, &LAW, &VALUE, &SE, &SOURCE]),
    }
}

/// Reads a number from the literature.
pub(super) fn published(table: &SceneTable, particles: &[&str]) -> Option<Published> {
    let quantity = table.read(&QUANTITY);
    let name = table.read(&PARTICLE);
    let particle = name.as_deref().and_then(|name| {
        let index = particles.iter().position(|particle| *particle == name);
        if index.is_none() {
            let names = particles.iter().copied();
            let name = Located {
                value: name,
                at: table.at(PARTICLE.base),
            };
            table.refuse_name(PARTICLE.base, &name, "a name in [particles]", names);
        }
        index
    });
    let law = table.read(&LAW);
    let film_ratio = table.read(&OF_FILM_RATIO);
    let value = table.read(&VALUE);
    let se = table.read(&SE);
    let source = table.read(&SOURCE);
    table.finish();
    let quantity = quantity?;
    Some(Published {
        quantity,
        particle: particle?,
        film_ratio,
        law: (quantity != PublishedQuantity::DryK).then(|| law.unwrap_or(WetLaw::Linear)),
        value: value?,
        se: se?,
        source: source?,
    })
}
