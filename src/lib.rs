//! Infers the parameters of wet-particle impact from a scene and a table of impacts.
//!
//! A sphere falls on a wetted plate; its restitution follows e = √(α + β/v) (Müller & Huang 2016). The data take one
//! way through the modules, and each module uses only what stands above it:
//!
//! | module | question | in → out |
//! |---|---|---|
//! | [`units`], [`error`], [`remark`] | how is it written, why is there no answer, what wants a look | |
//! | `rounding` | how many digits are shown | number → text |
//! | `roots` | where is a function zero | function → number |
//! | `distributions` | how probable is a number | probability → quantile |
//! | `exponential` | what is exp x, several at a time | number → number |
//! | `lanes` | what do terms sum to, several at a time | columns → sums |
//! | `condensing` | which few points stand for many | points → points with counts |
//! | `seed` | which random stream | name → stream |
//! | `encoding` | is it text | bytes → text |
//! | `files` | how much of a file is read | path → bytes |
//! | [`ranks`] | who does which part | pieces of work → all that they give |
//! | `staging`, `interruption` | how is a file written whole or not at all | |
//! | [`physics`] | what should happen | numbers → restitution, with slopes |
//! | `scene` | what was held fixed | file → `Scene`, checked |
//! | `runs` | what was measured | table → `Runs`, screened with reasons |
//! | `recordings` | what the camera saw | frames, positions → runs with errors |
//! | `model` | what we believe | truth → simulated runs |
//! | `inference` | what the data say | runs → fits with covariance |
//! | `findings` | what may be said | fits → estimates with verdicts |
//! | `handoff` | how a simulation code takes it | law → input files |
//! | `report` | how it is told | findings → markdown, figures, JSON |
//! | `study` | what is asked of the whole | simulated scenes → coverage of the intervals |
//!
//! Without the default feature `cli` only [`units`], [`error`], [`remark`] and [`physics`] are built, for a
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
//!     roughness: None,        // m; lubrication over the whole film alone reads it
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
//!
//! # Where such a law is used
//!
//! Every impact of a simulated sphere asks for it. Two equal spheres have twice the Stokes number that one has on a plate at
//! the same relative speed, and with e_dry at one speed e depends on the speed by St alone, so that the plate's law is asked
//! at twice the speed:
//!
//! ```
//! # use wetcor::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Restitution, Setting};
//! # let sphere = Setting {
//! #     density: 2150.0, diameter: 4.762e-3, liquid_density: 930.0, viscosity: 9.3e-3, film: 286e-6,
//! #     surface_tension: None, roughness: None,
//! # };
//! # let parameters = Parameters::new(0.183)
//! #     .with(Coefficient::LubricationLog, 1.85)
//! #     .with(Coefficient::InertialPrefactor, 0.47)
//! #     .with(Coefficient::FilmScale, 0.069);
//! # let e_n = Restitution::new(&sphere, Form::new(Inertia::Saturating, DrySpeed::Reference(2.0)), &parameters);
//! let collide = |[one, other]: [[f64; 3]; 2], normal: [f64; 3]| {
//!     let approach: f64 = (0..3).map(|axis| (one[axis] - other[axis]) * normal[axis]).sum();
//!     let change = 0.5 * (1.0 + e_n.at(2.0 * approach.abs())) * approach;
//!     let moved = |v: [f64; 3], by: f64| [0, 1, 2].map(|axis| v[axis] + by * normal[axis]);
//!     [moved(one, -change), moved(other, change)]
//! };
//! // the law of the sphere above; they meet along x at 0.6 m/s
//! let [one, other] = collide([[0.4, 0.1, 0.0], [-0.2, 0.0, 0.0]], [1.0, 0.0, 0.0]);
//! assert!((one[0] + other[0] - 0.2).abs() < 1e-15 && one[1] == 0.1);
//! let e = (other[0] - one[0]) / 0.6;
//! assert!((e - e_n.at(1.2)).abs() < 1e-12);
//! ```
//!
//! `examples/cooling` lets a gas of 100,000 cool with it by direct simulation Monte Carlo, against Haff's law:
//! `cargo run --release --no-default-features --example cooling -- cooling.svg`.
//!
//! # How to add a term, a quantity, a figure
//!
//! **A term** of the energy balance is a file in `physics/` that implements [`physics::loss::Loss`]: its parameters, each a
//! [`physics::coefficient::Parameter`] with name, symbol, unit and prior; what it takes at a film, with slopes; what no
//! parameter moves; its formula. It enters the sum where [`physics::form::Form`] lists its losses, and has its word in
//! [`physics::form::Term`]. Simulation, least squares, sizes of terms and prediction follow from the sum. The likelihood
//! reads the shape of the inertial loss as a column of the runs, and what the viscous one takes as the same at every film
//! (`model/likelihood/trend.rs`): another loss that reads the film needs a column there, and the tests against the sum fail
//! until it has one:
//!
//! ```
//! use wetcor::physics::loss::{AtFilm, Fixed, Loss, Setting, Share, Slope};
//! use wetcor::physics::{coefficient::Coefficients, Coefficient};
//!
//! /// The viscous loss with an L that is known to be 2 for thick films.
//! struct ThickFilms;
//!
//! impl Loss for ThickFilms {
//!     fn coefficients(&self) -> &'static [Coefficient] {
//!         &[Coefficient::LubricationLog]
//!     }
//!     fn at(&self, film_ratio: f64, values: &Coefficients) -> AtFilm {
//!         let thick = film_ratio > 0.1;
//!         let share = |viscous: f64| Share { inertial: 0.0, viscous };
//!         let slope = Slope {
//!             of: Coefficient::LubricationLog,
//!             share: share(if thick { 0.0 } else { 1.0 }),
//!         };
//!         AtFilm {
//!             share: share(if thick { 2.0 } else { values[Coefficient::LubricationLog] }),
//!             slopes: [Some(slope), None],
//!         }
//!     }
//!     fn fixed(&self, _: &Setting) -> Option<Fixed> {
//!         None
//!     }
//!     fn formula(&self, film: &str) -> Option<String> {
//!         Some(format!("4 L({film})/St"))
//!     }
//!     fn definition(&self, film: &str) -> Option<String> {
//!         Some(format!("L(x) = 2 for {film} > 0.1"))
//!     }
//! }
//!
//! let mut values = Coefficients::default();
//! values[Coefficient::LubricationLog] = 1.85;
//! assert_eq!(ThickFilms.at(0.05, &values).share.viscous, 1.85);
//! ```
//!
//! **A quantity** is an entry of [`physics::quantity::Quantity`] with its name, symbol, unit and definition; estimates,
//! replicates and draws of it are computed from the same line:
//!
//! ```
//! use wetcor::physics::quantity::{Place, Quantity, Wetted};
//!
//! let fitted = Wetted::of_square_root(0.52, -7.7); // e = √(0.52 − 7.7/St)
//! let st_c = Quantity::StC.value(&Place::NONE, &fitted);
//! assert!((st_c - 7.7 / (2.0 * 0.52)).abs() < 1e-12);
//! ```
//!
//! **A figure** is a file in `report/figures/` that makes charts from findings, a line in its `mod.rs`, and the section of
//! the report that shows it.

#[cfg(feature = "cli")]
mod condensing;
#[cfg(feature = "cli")]
mod distributions;
#[cfg(feature = "cli")]
mod encoding;
pub mod error;
mod exponential;
#[cfg(feature = "cli")]
mod files;
#[cfg(feature = "cli")]
pub mod findings;
#[cfg(feature = "cli")]
pub mod handoff;
#[cfg(feature = "cli")]
pub mod inference;
#[cfg(feature = "cli")]
pub mod interruption;
#[cfg(feature = "cli")]
mod lanes;
#[cfg(feature = "cli")]
pub mod model;
pub mod physics;
#[cfg(feature = "cli")]
pub mod ranks;
#[cfg(feature = "cli")]
pub mod recordings;
pub mod remark;
#[cfg(feature = "cli")]
pub mod report;
#[cfg(feature = "cli")]
mod roots;
#[cfg(feature = "cli")]
mod rounding;
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
