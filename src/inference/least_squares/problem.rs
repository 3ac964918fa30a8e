//! Describes what a problem brings to be fitted, and why its fit may stop.

use nalgebra::DMatrix;

/// Marks a point where the model is undefined: recoverable, the step is shortened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the model is undefined at these parameters")]
pub struct OutOfDomain;

/// A curve with n residuals in p parameters that is to be fitted.
pub trait ResidualProblem {
    /// Number of parameters p.
    fn parameters(&self) -> usize;

    /// Number of residuals n, one a run.
    fn runs(&self) -> usize;

    /// Writes the residuals (model − observed) at `b` into `residuals`, of length n.
    ///
    /// Fails with [`OutOfDomain`] where the model is undefined; a residual that is not finite
    /// counts as the same.
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain>;

    /// Writes ∂ residual_i / ∂ b_j into `jacobian`, n × p, which arrives filled with zeros.
    ///
    /// Fails as [`ResidualProblem::residuals`] does.
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain>;

    /// Typical size of the observed values, below whose rounding error a residual is no scatter.
    ///
    /// The largest share of any one parameter in the model (rms of b_j ∂/∂b_j) is taken where it
    /// is larger, so most problems need not give it; one whose model has a large constant part should.
    fn scale(&self) -> f64 {
        0.0
    }
}

/// Why a fit stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// At a minimum, to rounding.
    Converged,
    /// Out of steps, or no step lowered the sum of squares, away from a minimum.
    MaxIterations,
    /// The runs do not determine the parameters.
    Degenerate,
    /// Held at the edge of the model's domain, or started outside it.
    OutOfDomain,
}

impl Stop {
    /// The reason as it is written in files: `converged`, `max_iterations`, `degenerate` or
    /// `out_of_domain`.
    pub fn as_str(self) -> &'static str {
        match self {
            Stop::Converged => "converged",
            Stop::MaxIterations => "max_iterations",
            Stop::Degenerate => "degenerate",
            Stop::OutOfDomain => "out_of_domain",
        }
    }
}
