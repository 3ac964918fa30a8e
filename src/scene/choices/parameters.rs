//! Lists the parameters that a scene may give a prior or a true value.

use crate::physics::coefficient::{LogNormal, Parameter};
use crate::physics::dry::DRY_K;
use crate::physics::Coefficient;
use crate::scene::prior::Prior;

/// A parameter that a scene may name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SceneParameter {
    /// its word in scenes and files
    pub name: &'static str,
    /// the letter of the formulas
    pub symbol: &'static str,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// a value it may well have
    pub example: &'static str,
    /// its unit
    pub unit: &'static str,
    /// what is believed of it before any run
    pub prior: Prior,
    /// why
    pub reason: &'static str,
    /// what it lies above
    pub least: f64,
    /// whether it may be held at 0: a loss that is none, or a spread where measurement errors scatter the runs
    pub may_be_zero: bool,
}

impl SceneParameter {
    /// One of the physics, which is positive.
    pub fn of_physics(own: &Parameter) -> SceneParameter {
        SceneParameter {
            name: own.name,
            symbol: own.symbol,
            meaning: own.meaning,
            example: own.example,
            unit: own.unit,
            prior: log_normal(own.prior),
            reason: own.prior.reason,
            least: 0.0,
            may_be_zero: own.may_be_zero,
        }
    }
}

/// A belief of the physics as a prior.
pub(crate) fn log_normal(belief: LogNormal) -> Prior {
    Prior::LogNormal(belief.median, belief.ln_sd)
}

/// Every one: k, those that particles share, and those of the noise.
pub(in crate::scene) fn parameters() -> impl Iterator<Item = SceneParameter> {
    let shared = Coefficient::ALL.map(|coefficient| *coefficient.describe());
    let physical = std::iter::once(DRY_K).chain(shared);
    physical.map(|own| SceneParameter::of_physics(&own)).chain(NOISE)
}

/// Spread of the dry restitutions.
pub(crate) const SIGMA_DRY: SceneParameter = SceneParameter {
    name: "sigma_dry",
    symbol: "σ_dry",
    meaning: "sd of the dry restitutions about their law",
    example: "0.01",
    unit: "1",
    prior: Prior::HalfNormal(0.1),
    reason: "default: a spread of restitutions above 0.2 would be no measurement",
    least: 0.0,
    may_be_zero: true,
};

/// Spread of the wet restitutions.
pub(crate) const SIGMA_WET: SceneParameter = SceneParameter {
    name: "sigma_wet",
    symbol: "σ_wet",
    meaning: "sd of the wet restitutions about their law",
    example: "0.02",
    ..SIGMA_DRY
};

/// Spread of the energy a wet run keeps.
pub(crate) const SIGMA_ENERGY: SceneParameter = SceneParameter {
    name: "sigma_energy",
    symbol: "σ_r",
    meaning: "sd of the energy a wet run keeps",
    example: "0.02",
    reason: "default: a spread of the energy kept above 0.2 would be no measurement",
    may_be_zero: false,
    ..SIGMA_DRY
};

/// Spread of the offsets of series.
pub(crate) const SIGMA_SERIES: SceneParameter = SceneParameter {
    name: "sigma_series",
    symbol: "σ_series",
    meaning: "sd of the offsets of the energy kept that the wet runs of a series share",
    example: "0.01",
    prior: Prior::HalfNormal(0.03),
    reason: "default: series whose energy kept differs by more than 0.06 would be no repeats of one law",
    ..SIGMA_ENERGY
};

/// Degrees of freedom of Student's noise; noise of two or fewer has no variance.
pub(crate) const NU: SceneParameter = SceneParameter {
    name: "nu",
    symbol: "ν",
    meaning: "degrees of freedom of the noise of Student's t",
    example: "4.0",
    unit: "1",
    prior: Prior::Gamma(2.0, 0.1),
    reason:
        "default: Juárez & Steel 2010, from a few outliers to as good as normal; above 2, where there is a variance",
    least: 2.0,
    may_be_zero: false,
};

/// Asymmetry of Laplace's noise.
pub(crate) const ASYMMETRY: SceneParameter = SceneParameter {
    name: "asymmetry",
    symbol: "η",
    meaning: "ln of how many times as far the noise of asymmetric_laplace reaches above as below",
    example: "-0.5",
    unit: "1",
    prior: Prior::Normal(0.0, 1.0),
    reason: "default: of either sign; tails that differ by more than a factor of seven are past belief",
    least: f64::NEG_INFINITY,
    may_be_zero: true,
};

/// Every one of the noise.
pub(crate) const NOISE: [SceneParameter; 6] = [SIGMA_DRY, SIGMA_WET, SIGMA_ENERGY, SIGMA_SERIES, NU, ASYMMETRY];
