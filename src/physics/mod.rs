//! Gives what should happen: published formulas of wet impact, each with its slopes and its equation.
//!
//! "eq. stc" and the like are the LaTeX labels of Müller & Huang 2016, *Influence of the liquid film thickness on the
//! coefficient of restitution for wet particles*. Everything is f64 in SI; nothing here allocates.

pub mod bridge;
pub mod dry;
pub mod impact;
pub mod inertia;
pub mod numbers;
pub mod rebound;
pub mod restitution;
pub mod viscous;
