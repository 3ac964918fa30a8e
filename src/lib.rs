//! Infers the parameters of wet-particle impact from a scene and a table of impacts.
//!
//! A sphere falls on a wetted plate; its restitution follows e = √(α + β/v) (Müller & Huang 2016). The data take one
//! way through the modules, and each module uses only what stands above it:
//!
//! | module | question | in → out |
//! |---|---|---|
//! | [`units`], [`error`], [`notice`] | how is it written, why is there no answer, what wants a look | |
//! | `distributions` | how probable is a number | probability → quantile |
//! | `seed` | which random stream | name → stream |
//! | `encoding` | is it text | bytes → text |
//! | `files` | how much of a file is read | path → bytes |
//! | `staging`, `interruption` | how is a file written whole or not at all | |
//! | [`physics`] | what should happen | numbers → restitution, with slopes |
//! | `scene` | what was held fixed | file → `Scene`, checked |
//! | `runs` | what was measured | table → `Runs`, screened with reasons |
//! | `model` | what we believe | truth → simulated runs |
//! | `inference` | what the data say | runs → fits with covariance |
//! | `findings` | what may be said | fits → estimates with verdicts |
//! | `report` | how it is told | findings → markdown, figures, JSON |
//! | `study` | what is asked of the whole | simulated scenes → coverage of the intervals |
//!
//! Without the default feature `cli` only [`units`], [`error`], [`notice`] and [`physics`] are built, for a
//! simulation code to link.
//!
//! # What a sphere does at one speed
//!
//! ```
//! use wetcor::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Restitution, Setting};
//!
//! let sphere = Setting {
//!     density: 2150.0,        // PTFE, kg/m³
//!     diameter: 4.762e-3,     // m
//!     liquid_density: 930.0,  // AK10, kg/m³
//!     viscosity: 9.3e-3,      // Pa s
//!     film: 286e-6,           // m
//!     surface_tension: None,  // N/m; the bridge alone reads it
//! };
//! let parameters = Parameters::new(0.183)
//!     .with(Coefficient::LubricationLog, 1.85)
//!     .with(Coefficient::InertialPrefactor, 0.47)
//!     .with(Coefficient::FilmScale, 0.069);
//! // once for a pair of materials; then a call a collision, without allocation
//! let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
//! let e_n = Restitution::new(&sphere, form, &parameters);
//! assert!(e_n.at(1.2) > 0.65 && e_n.at(1.2) < 0.70);
//! assert_eq!(e_n.at(0.05), 0.0); // too slow to rebound
//! ```

#[cfg(feature = "cli")]
mod distributions;
#[cfg(feature = "cli")]
mod encoding;
pub mod error;
#[cfg(feature = "cli")]
mod files;
#[cfg(feature = "cli")]
pub mod findings;
#[cfg(feature = "cli")]
pub mod inference;
#[cfg(feature = "cli")]
pub mod interruption;
#[cfg(feature = "cli")]
pub mod model;
pub mod notice;
pub mod physics;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
pub mod runs;
#[cfg(feature = "cli")]
pub mod scene;
#[cfg(feature = "cli")]
pub mod seed;
#[cfg(feature = "cli")]
pub mod staging;
#[cfg(feature = "cli")]
pub mod study;
pub mod units;
