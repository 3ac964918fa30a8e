//! Reads the tables that choose a method: model, priors, sampler, bootstrap.
//!
//! | file | job |
//! |---|---|
//! | `model.rs` | the terms of the energy balance, the noise on a run, what stuck runs are |
//! | `parameters.rs` | the parameters that a scene may name |
//! | `priors.rs` | the priors set for parameters |
//! | `sampler.rs` | how much is sampled |
//! | `bootstrap.rs` | how intervals are made |

mod bootstrap;
mod model;
mod parameters;
mod priors;
mod sampler;

pub use bootstrap::{Bootstrap, IntervalMethod, ResamplingScheme};
pub use model::{DryKOf, LikelihoodFamily, ModelChoices, NoiseOn, Sticking};
pub(crate) use parameters::{log_normal, SceneParameter, NOISE, NU, SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET};
pub use priors::PriorChoice;
pub use sampler::{Sampler, MOST_KEPT};

pub(super) use bootstrap::bootstrap;
pub(super) use model::{checked_terms, checked_viscous, dry_speed, dry_speeds, model, some_terms, viscous_forms};
pub(super) use parameters::parameters;
pub(super) use priors::{guide_to_priors, priors};
pub(super) use sampler::sampler;
