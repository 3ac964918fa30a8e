//! Holds what was kept fixed: particles, liquids, choices of method; read from a scene file and checked.
//!
//! | file | job |
//! |---|---|
//! | `names.rs`, `expect.rs` | which names and numbers a scene may hold |
//! | `asked.rs` | judges the keys nobody asked for |
//! | `document.rs` | keeps the text and gathers the problems found in it |
//! | `table/` | reads TOML tables with units in the keys, and names what it cannot use |
//! | `prior.rs` | the densities a prior may have, their slopes, quantiles and draws |
//! | `trial.rs` | tries a prior where sampling will go |
//! | `materials.rs` | the particles and the liquids |
//! | `choices/` | the model, prior, sampler and bootstrap tables |
//! | `plan.rs` | the truth and design tables of a simulation |
//! | `published.rs` | numbers from the literature |
//! | `contents.rs` | a [`Scene`]: everything that does not change from run to run |
//! | `read.rs` | turns a scene file into one |
//! | `claim.rs` | says whether a file is a scene or holds the runs of one |

mod asked;
mod choices;
mod claim;
mod contents;
mod document;
mod expect;
mod materials;
mod names;
mod plan;
mod prior;
mod published;
mod read;
mod table;
mod trial;

pub(crate) use choices::least;
pub use choices::{
    Bootstrap, IntervalMethod, Likelihood, ModelChoices, NoiseOn, PriorChoice, ResamplingScheme, Sampler, Sticking,
    MOST_KEPT,
};
pub use claim::claim;
pub use contents::{Data, Scene, Screens};
pub use expect::LARGEST_FILM_RATIO;
pub use materials::{Liquid, Particle};
pub use names::{closest, letters_apart, name_expected, name_is_allowed, DRY, MISSING, NAME_RULE};
pub use plan::{Design, DesignSpeeds, Noise, Truth};
pub use prior::Prior;
pub use published::{Published, PublishedQuantity, WetLaw};
pub use read::{parse, read};
pub(crate) use trial::within;
