//! Holds what was kept fixed: particles, liquids, choices of method; read from a scene file and checked.
//!
//! | file | job |
//! |---|---|
//! | `names.rs`, `expect.rs` | which names and numbers a scene may hold |
//! | `asked.rs` | judges the keys nobody asked for |
//! | `document.rs` | keeps the text and gathers the problems found in it |
//! | `table/` | reads TOML tables with units in the keys, and names what it cannot use |
//! | `read.rs` | turns a scene file into a [`Scene`] |
//! | `choices/` | the model, prior, sampler and bootstrap tables |
//! | `plan.rs` | the truth and design tables of a simulation |
//! | `claim.rs` | says whether a file is a scene or holds the runs of one |
//! | `prior.rs` | the densities a prior may have, their slopes, quantiles and draws |
//! | `trial.rs` | tries a prior where sampling will go |

mod asked;
mod choices;
mod claim;
mod document;
mod expect;
mod names;
mod plan;
mod prior;
mod read;
mod table;
mod trial;

pub(crate) use choices::least;
pub use choices::{
    form_of, terms_of, Bootstrap, IntervalMethod, Likelihood, ModelChoices, NoiseOn, PriorChoice, ResamplingScheme,
    Sampler, Sticking, Term, DEFAULT_DRY_SPEED, MOST_KEPT,
};
pub use claim::claim;
pub use names::{closest, letters_apart, name_expected, name_is_allowed, NAME_RULE};
pub use plan::{Design, DesignSpeeds, Noise, Truth};
pub use prior::Prior;
pub use read::{parse, read};
pub(crate) use trial::within;

use std::path::PathBuf;

/// How a table of runs marks a run without liquid.
pub const DRY: &str = "dry";

/// How a table of runs marks a missing cell, besides leaving it empty.
pub const MISSING: &str = "NA";

/// Film ratio above which no inertial form of the paper is valid; thicker films are screened.
pub const LARGEST_FILM_RATIO: f64 = 0.5;

/// A scene: everything that does not change from run to run. SI inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// the scene file, as the user named it
    pub file: PathBuf,
    /// name of the folder the scene file lies in
    pub name: String,
    /// title of the report
    pub title: String,
    /// where the runs come from, in words
    pub source: Option<String>,
    /// SHA-256 of the scene file
    pub sha256: String,
    /// which runs, and which of them are used
    pub data: Data,
    /// the particles, in the order of the file
    pub particles: Vec<Particle>,
    /// the liquids, in the order of the file
    pub liquids: Vec<Liquid>,
    /// what the model holds
    pub model: ModelChoices,
    /// priors the scene sets; every other one keeps its default
    pub priors: Vec<PriorChoice>,
    /// how a posterior is sampled
    pub sampler: Sampler,
    /// how intervals are made
    pub bootstrap: Bootstrap,
    /// numbers from the literature to set beside ours
    pub published: Vec<Published>,
    /// the truth of a simulation
    pub truth: Option<Truth>,
    /// the design of a simulation
    pub design: Option<Design>,
    /// keys the scene sets that no stage of this version reads, as `table.key`
    pub unused: Vec<String>,
}

/// Which runs, and which of them are used.
#[derive(Debug, Clone, PartialEq)]
pub struct Data {
    /// the table of runs
    pub runs: PathBuf,
    /// a restitution at or below this counts as stuck
    pub smallest_restitution: f64,
    /// where runs carry no film ratio: sorted δ/D is split at larger gaps
    pub film_ratio_gap: f64,
    /// sd of an error of the film thickness that all runs share, m; absent: the films are taken as exact
    pub film_sd: Option<f64>,
    /// which runs are left out
    pub screens: Screens,
}

/// Limits outside which a run is left out and counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screens {
    /// thinnest film, m
    pub min_film: Option<f64>,
    /// largest film ratio δ/D; never above [`LARGEST_FILM_RATIO`]
    pub max_film_ratio: f64,
    /// slowest impact, m/s
    pub min_impact_speed: Option<f64>,
    /// fastest impact, m/s
    pub max_impact_speed: Option<f64>,
}

/// A kind of particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    /// its name in the runs
    pub name: String,
    /// ρp, kg/m³
    pub density: f64,
    /// sd of ρp over ρp; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// ε, m
    pub roughness: f64,
    /// sd of ε over ε; absent: taken as exact
    pub roughness_rel_sd: Option<f64>,
}

/// A liquid.
#[derive(Debug, Clone, PartialEq)]
pub struct Liquid {
    /// its name in the runs
    pub name: String,
    /// ρl, kg/m³
    pub density: f64,
    /// sd of ρl over ρl; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// η, Pa s
    pub viscosity: f64,
    /// sd of η over η; absent: taken as exact
    pub viscosity_rel_sd: Option<f64>,
    /// γ, N/m
    pub surface_tension: Option<f64>,
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
    /// The word a scene file uses.
    pub fn name(self) -> &'static str {
        match self {
            PublishedQuantity::EInf => "e_inf",
            PublishedQuantity::StC => "st_c",
            PublishedQuantity::DryK => "dry_k",
        }
    }
}

/// One of the two laws of the wet restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// e = e_inf (1 − St_c/St)
    Linear,
    /// e = √(e_inf² − 4 L/St)
    Sqrt,
}

impl Law {
    /// The word files use.
    pub fn name(self) -> &'static str {
        match self {
            Law::Linear => "linear",
            Law::Sqrt => "sqrt",
        }
    }
}

/// A number from the literature.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// what it is
    pub quantity: PublishedQuantity,
    /// index into [`Scene::particles`]
    pub particle: usize,
    /// the film ratio it holds for; absent: all of them
    pub film_ratio: Option<f64>,
    /// the law it was fitted with; absent for k
    pub law: Option<Law>,
    /// its value
    pub value: f64,
    /// its standard error
    pub se: f64,
    /// where it stands
    pub source: String,
}
