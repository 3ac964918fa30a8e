//! Gives what should happen: published formulas of wet impact, each with its slopes and its equation.
//!
//! "eq. stc" and the like are the LaTeX labels of Müller & Huang 2016, *Influence of the liquid film thickness on the
//! coefficient of restitution for wet particles*. Everything is f64 in SI; nothing that a simulation calls allocates.
//!
//! | file | job |
//! |---|---|
//! | [`numbers`] | Stokes and Reynolds number, speed of a fall, which diameters are one |
//! | [`jet`] | a number with its slopes, for formulas that are written once |
//! | [`coefficient`] | the parameters that particles share, and a value of each |
//! | [`loss`] | what a loss states of itself, at one setting |
//! | [`dry`] | the dry law to either order, with k |
//! | [`inertia`], [`viscous`], [`bridge`] | a loss a file: word, formula, parameters with unit and prior, value and slopes |
//! | [`form`] | which terms a balance holds |
//! | [`balance`] | their sum: the energy kept, with slopes |
//! | [`rebound`] | from the energy kept to the restitution; the laws in v and St |
//! | [`quantity`] | what is quoted of a fit: e_inf, St_c, δc …: name, symbol, unit, definition |
//! | [`restitution`] | e(v) of one sphere, liquid and film |

pub mod balance;
pub mod bridge;
pub mod coefficient;
pub mod dry;
pub mod form;
pub mod inertia;
pub mod jet;
pub mod loss;
pub mod numbers;
pub mod quantity;
pub mod rebound;
pub mod restitution;
pub mod viscous;

pub use balance::kept_energy;
pub use coefficient::{Coefficient, Parameters};
pub use dry::Order;
pub use form::{DrySpeed, Form};
pub use inertia::Inertia;
pub use loss::Setting;
pub use quantity::Quantity;
pub use restitution::{LawNumbers, Plateau, Restitution};
pub use viscous::Viscous;

#[cfg(test)]
mod tests;
