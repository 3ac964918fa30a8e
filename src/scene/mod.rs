//! Holds what was kept fixed: particles, liquids, choices of method; read from a scene file and checked.
//!
//! | file | job |
//! |---|---|
//! | `names.rs`, `expect.rs` | which names and numbers a scene may hold |
//! | `keys.rs` | what is to be said of a key: name, unit, what it takes, default, and by `keys.txt` meaning and example |
//! | `run_columns.rs` | the columns a table of runs can have |
//! | `unknown_keys.rs` | finds the keys of a table that nothing reads |
//! | `document.rs` | keeps the text and gathers the problems found in it |
//! | `table/` | reads TOML tables with units in the keys, and names what it cannot use |
//! | `prior.rs` | the densities a prior may have, their slopes, quantiles and draws |
//! | `trial.rs` | tries a prior where sampling will go |
//! | `materials.rs` | the particles and the liquids |
//! | `choices/` | the model, prior, sampler and bootstrap tables |
//! | `table_file.rs` | names a table of runs: its file, and the sheet of a workbook |
//! | `naming.rs` | what a table calls its columns and its words, and what it leaves unsaid |
//! | `plan.rs` | the truth and design tables of a simulation |
//! | `published.rs` | numbers from the literature |
//! | `data.rs` | which tables hold the runs, and which of their runs are used |
//! | `contents.rs` | a [`Scene`]: everything that does not change from run to run |
//! | `read.rs` | turns a scene file into one |
//! | `guide.rs` | tells every key, as Markdown and as plain text |
//! | `overwriting.rs` | recognises scenes and their runs, which must not be written over |

mod choices;
mod contents;
mod data;
mod document;
mod expect;
mod guide;
mod keys;
mod materials;
mod names;
mod naming;
mod overwriting;
mod plan;
mod prior;
mod published;
mod read;
mod run_columns;
mod table;
mod table_file;
mod trial;
mod unknown_keys;

pub(crate) use choices::{log_normal, SceneParameter, NOISE, NU, SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET};
pub use choices::{
    Bootstrap, DryKOf, IntervalMethod, LikelihoodFamily, ModelChoices, NoiseOn, PriorChoice, ResamplingScheme, Sampler,
    Sticking, MOST_KEPT,
};
pub use contents::Scene;
pub use data::{Data, Screens};
pub use expect::LARGEST_FILM_RATIO;
pub(crate) use guide::wrapped;
pub use guide::{guide, markdown, plain};
pub use keys::{KeyGuide, Section, Without};
pub use materials::{Liquid, Particle};
pub(crate) use names::already_given;
pub use names::{closest, letters_apart, name_expected, name_is_allowed, DRY, FILL_IN, MISSING, NAME_RULE};
pub use naming::{Constant, ConstantValue, HeightsOf, HeightsTo, HiddenRows, Naming};
pub use overwriting::why_not_overwritten;
pub use plan::{Design, KOfDiameter, NoiseShape, Truth};
pub use prior::Prior;
pub use published::{Published, WetLaw};
pub use read::{parse, read};
pub use run_columns::RunColumn;
pub use table_file::TableFile;
pub(crate) use trial::within;
