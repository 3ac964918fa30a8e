//! Holds the end of a fit, with the reasons why it may have no standard errors.

use nalgebra::DMatrix;

use super::problem::Stop;
use crate::rounding::counted;

/// The end of a least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The parameters where the fit ended; the start, if it could not begin.
    pub parameters: Vec<f64>,
    /// Σ residual² there; infinite if the model is undefined at the start.
    pub residual_sum_of_squares: f64,
    /// Standard deviation of the residuals, √(sum of squares / degrees of freedom); `None`
    /// without degrees of freedom or sum of squares.
    pub residual_sd: Option<f64>,
    /// Runs less parameters; 0 where there are fewer runs than parameters.
    pub degrees_of_freedom: usize,
    /// Covariance of the parameters, p × p: residual_sd² (JᵀJ)⁻¹, computed without forming JᵀJ; or why there is none.
    pub covariance: Result<DMatrix<f64>, String>,
    /// Why the fit stopped.
    pub stop: Stop,
    /// Condition number of the slopes in columns of unit length; infinite if singular.
    pub condition: f64,
}

impl Fit {
    /// Standard error of parameter `j`; `None` without a covariance or such a parameter.
    pub fn se(&self, j: usize) -> Option<f64> {
        let covariance = self.covariance.as_ref().ok()?;
        covariance.get((j, j)).map(|variance| variance.sqrt())
    }

    /// Whether the fit ended at a minimum.
    pub fn converged(&self) -> bool {
        self.stop == Stop::Converged
    }

    /// The same fit where those it was made to stand for so many runs, and were weighed by how many each: these tell what scatters.
    pub fn of_runs(self, runs: f64) -> Fit {
        let freedom = (runs.round() as usize).saturating_sub(self.parameters.len());
        if self.residual_sd.is_none_or(|was| was <= 0.0) || freedom == 0 {
            return self;
        }
        let squares = self.residual_sum_of_squares;
        self.with_spread(squares, freedom)
    }

    /// The same fit with the spread that so many squares and degrees of freedom tell, where it had one.
    pub(in crate::inference) fn with_spread(self, squares: f64, freedom: usize) -> Fit {
        let sd = (squares / freedom as f64).sqrt();
        let over = self.residual_sd.map_or(1.0, |was| (sd / was).powi(2));
        Fit {
            covariance: self.covariance.map(|covariance| covariance * over),
            residual_sd: Some(sd),
            residual_sum_of_squares: squares,
            degrees_of_freedom: freedom,
            ..self
        }
    }

    /// A fit that could not begin, since there are fewer runs than parameters they alone determine.
    pub fn without_enough_runs(start: &[f64], runs: usize, parameters: usize) -> Fit {
        let why = format!(
            "{} cannot determine {}",
            counted(runs, "run"),
            counted(parameters, "parameter")
        );
        Fit::not_begun(start, Stop::Degenerate, why)
    }

    pub(super) fn not_begun(start: &[f64], stop: Stop, why: String) -> Fit {
        Fit {
            parameters: start.to_vec(),
            residual_sum_of_squares: f64::INFINITY,
            residual_sd: None,
            degrees_of_freedom: 0,
            covariance: Err(why),
            stop,
            condition: f64::INFINITY,
        }
    }
}

/// Why so many parameters of as many runs have no standard errors.
pub fn no_scatter_left(parameters: usize) -> String {
    format!("as many parameters as runs ({parameters}): no run is left to show the scatter")
}
