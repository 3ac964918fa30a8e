//! Holds a term with its size and what was decided of it.

use serde::Serialize;

use crate::physics::form::Term;

/// Size from which a term matters: 95 % intervals of a model without it then cover less than 94 %.
pub const LINE: f64 = 0.25;

/// A term, its size, and what was decided.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SizedTerm {
    /// which
    pub term: Term,
    /// whether the model holds it
    pub held: bool,
    /// scene (named there), auto (decided by the size) or default
    pub chosen_by: &'static str,
    /// largest bias of a parameter that leaving it out gives, in its standard errors; `None` without a spread of the runs
    pub size: Option<f64>,
    /// the parameter that has it
    pub moves: Option<String>,
    /// largest change of a restitution
    pub largest_effect: f64,
    /// share of its full effect that the runs show: 0 where they show none of it, 1 where all; `None` where it is held or
    /// cannot be told
    pub runs_show: Option<f64>,
    /// standard error of that share
    pub runs_show_se: Option<f64>,
    /// factor by which holding it widens the standard error of another parameter at most; `None` if not held, or if it
    /// has no parameter
    pub widens: Option<f64>,
}

impl SizedTerm {
    /// By how much log density the runs prefer the model without the term to one in which it acts in full; `None` where
    /// they do not tell.
    pub fn gain_without(&self) -> Option<f64> {
        let (share, se) = (self.runs_show?, self.runs_show_se?);
        Some((0.5 - share) / (se * se))
    }
}
