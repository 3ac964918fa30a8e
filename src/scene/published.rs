//! Holds numbers from the literature that are set beside ours.

use serde::{Serialize, Serializer};

use crate::physics::Quantity;

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
