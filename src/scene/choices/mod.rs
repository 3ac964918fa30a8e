//! Reads the tables that choose a method: model, priors, sampler, bootstrap.
//!
//! | file | job |
//! |---|---|
//! | `unused.rs` | the keys that nothing reads yet |
//! | `model.rs` | the terms of the energy balance, the noise on a run, what stuck runs are |
//! | `priors.rs` | the priors set for parameters |
//! | `sampler.rs` | how much is sampled |
//! | `bootstrap.rs` | how intervals are made |

mod bootstrap;
mod model;
mod priors;
mod sampler;
mod unused;

pub use bootstrap::{Bootstrap, IntervalMethod, ResamplingScheme};
pub use model::{DryKOf, LikelihoodFamily, ModelChoices, NoiseOn, Sticking};
pub use priors::PriorChoice;
pub(crate) use priors::{least, SIGMA_DRY, SIGMA_WET};
pub use sampler::{Sampler, MOST_KEPT};

pub(super) use bootstrap::bootstrap;
pub(super) use model::{dry_speed, model, terms, viscous};
pub(super) use priors::priors;
pub(super) use sampler::sampler;
