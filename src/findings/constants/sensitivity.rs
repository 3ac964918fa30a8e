//! Holds the sensitivity of a result to the constants, and names the result.

use schemars::JsonSchema;
use serde::Serialize;

use crate::findings::places::EstimatePlace;
use crate::findings::remarks::described;
use crate::physics::Quantity;

/// How the energy balance is named as the fit behind a result.
pub(super) const BALANCE: &str = "balance";

/// How one result moves with the constants.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Sensitivity {
    /// the name of a shared parameter, `delta_c_m`, `e_inf` or `st_c`
    pub result: String,
    /// what it is of
    #[serde(flatten)]
    pub of: EstimatePlace,
    /// `balance`: over all rebounds; `sqrt`: the square-root law of the film ratio
    pub fit: &'static str,
    /// its value
    pub value: f64,
    /// its statistical standard error, by least squares; `None` where the curvature of the fit forbids one
    pub se: Option<f64>,
    /// the constants that move it; any other moves it by less than 5e-6 of its own share
    pub by: Vec<Elasticity>,
    /// √Σ (value · elasticity · rel_sd)² over the constants whose uncertainty is given; `None` where none is
    pub constants_sd: Option<f64>,
    /// √(se² + constants_sd²); `None` without either
    pub combined: Option<f64>,
}

impl Sensitivity {
    /// Whether it is of the energy balance.
    pub fn is_of_balance(&self) -> bool {
        self.fit == BALANCE
    }

    /// Its name in a table, with the fit that it is of.
    pub fn label(&self) -> String {
        let fit = match self.is_of_balance() {
            true => "energy balance",
            false => "square root",
        };
        self.named(self.of.film_ratio.map(|_| fit))
    }

    /// Its name in a sentence, whichever fit it is of.
    pub fn subject(&self) -> String {
        self.named(None)
    }

    fn named(&self, fit: Option<&str>) -> String {
        let own = described(&self.result, [Quantity::DeltaC, Quantity::EInf, Quantity::StC]);
        let name = own.map_or(self.result.as_str(), |own| own.symbol);
        match self.of.words(fit).as_str() {
            "" => name.to_owned(),
            of => format!("{name} ({of})"),
        }
    }
}

/// Elasticity of a result in one constant.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Elasticity {
    /// `viscosity`, `liquid_density`, `particle_density`, `roughness` or `film`: all of a kind by one factor;
    /// `viscosity[AK10]` and the like: one alone; `film_offset`: all films by one length, in units of their mean;
    /// `speed`: all speeds by one factor
    pub constant: String,
    /// d ln(result)/d ln(constant), to five decimals
    pub elasticity: f64,
    /// sd of the constant over its value, as the scene gives it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rel_sd: Option<f64>,
}
