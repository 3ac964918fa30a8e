//! Holds one series of the square-root law, for the bench and for the peer beside it.

use nalgebra::DMatrix;
use wetcor::inference::least_squares::{OutOfDomain, ResidualProblem};

/// Runs of one series under e = √(α + β / v), slopes in closed form.
pub struct SqrtLaw {
    /// 1 / impact speed, s/m.
    pub inverse_speeds: Vec<f64>,
    /// Observed coefficients of restitution.
    pub restitutions: Vec<f64>,
}

impl ResidualProblem for SqrtLaw {
    fn parameters(&self) -> usize {
        2
    }

    fn runs(&self) -> usize {
        self.restitutions.len()
    }

    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        let runs = self.inverse_speeds.iter().zip(&self.restitutions);
        for (residual, (u, e)) in residuals.iter_mut().zip(runs) {
            let square = b[0] + b[1] * u;
            if square <= 0.0 {
                return Err(OutOfDomain);
            }
            *residual = square.sqrt() - e;
        }
        Ok(())
    }

    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let (alpha, beta) = jacobian.as_mut_slice().split_at_mut(self.inverse_speeds.len());
        for ((alpha, beta), u) in alpha.iter_mut().zip(beta).zip(&self.inverse_speeds) {
            *alpha = 0.5 / (b[0] + b[1] * u).sqrt();
            *beta = *alpha * u;
        }
        Ok(())
    }

    fn scale(&self) -> f64 {
        1.0
    }
}
