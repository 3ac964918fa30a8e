//! Finds least squares by damped Gauss–Newton steps from sums over rows, never a row a run.

use super::sums::Sums;

/// Where a descent ended.
pub struct Descent {
    /// the point
    pub point: Vec<f64>,
    /// Σ residual² there
    pub squares: f64,
    /// by how much that fell
    pub fell: f64,
    /// whether a step would lower it by little more
    pub converged: bool,
}

/// Descends from a start until the slopes promise a fall of at most `small`; `None` where the start has no sums.
pub fn descend(start: &[f64], small: f64, sums_at: impl Fn(&[f64]) -> Option<Sums>) -> Option<Descent> {
    const STEPS: usize = 100;
    const FIRST_DAMPING: f64 = 1e-6;
    const MOST_DAMPING: f64 = 1e8;
    let mut here = sums_at(start)?;
    let began = here.squares;
    let mut point = start.to_vec();
    let mut damping = FIRST_DAMPING;
    let mut converged = false;
    for _ in 0..STEPS {
        let mut damped = here.information.clone();
        damped.set_diagonal(&(here.information.diagonal() * (1.0 + damping)));
        let Some(step) = damped.cholesky().map(|root| root.solve(&here.gradient)) else {
            break;
        };
        // what the slopes say it falls by, at most
        if step.dot(&here.gradient) <= small && damping <= 1.0 {
            converged = true;
            break;
        }
        let trial: Vec<f64> = point.iter().zip(step.iter()).map(|(b, step)| b - step).collect();
        match sums_at(&trial) {
            Some(there) if there.squares < here.squares => {
                (point, here) = (trial, there);
                damping = (0.1 * damping).max(FIRST_DAMPING);
            }
            _ if damping > MOST_DAMPING => break,
            _ => damping *= 10.0,
        }
    }
    Some(Descent {
        point,
        squares: here.squares,
        fell: began - here.squares,
        converged,
    })
}
