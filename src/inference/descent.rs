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
    /// whether a step would lower it by little more, or by nothing beside its rounding
    pub converged: bool,
}

/// Descends from a start until the slopes promise a fall of at most `small`; `None` where the start has no sums.
pub fn descend(start: &[f64], small: f64, sums_at: impl Fn(&[f64]) -> Option<Sums>) -> Option<Descent> {
    const STEPS: usize = 100;
    const FIRST_DAMPING: f64 = 1e-6;
    const MOST_DAMPING: f64 = 1e8;
    /// share of the squares that their own rounding hides
    const ROUNDING: f64 = 1e-12;
    let mut here = sums_at(start)?;
    let began = here.squares;
    let mut point = start.to_vec();
    let mut damping = FIRST_DAMPING;
    let mut converged = false;
    // what the slopes say it falls by, at most
    let mut promised = f64::INFINITY;
    for _ in 0..STEPS {
        let mut damped = here.information.clone();
        damped.set_diagonal(&(here.information.diagonal() * (1.0 + damping)));
        let Some(step) = damped.cholesky().map(|root| root.solve(&here.gradient)) else {
            break;
        };
        if damping <= 1.0 {
            promised = step.dot(&here.gradient);
        }
        if promised <= small {
            converged = true;
            break;
        }
        let trial: Vec<f64> = point.iter().zip(step.iter()).map(|(b, step)| b - step).collect();
        match sums_at(&trial) {
            Some(there) if there.squares < here.squares => {
                (point, here) = (trial, there);
                damping = (0.1 * damping).max(FIRST_DAMPING);
            }
            _ if damping > MOST_DAMPING => {
                converged = promised <= ROUNDING * here.squares;
                break;
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// (x − 1)² + 1 with a slope that is so many times its own.
    fn end(times: f64, small: f64) -> Descent {
        let sums_at = |point: &[f64]| {
            let mut sums = Sums::new(1);
            sums.add(point[0] - 1.0, &[(0, times)]);
            sums.add(1.0, &[]);
            Some(sums)
        };
        descend(&[5.0], small, sums_at).expect("finite")
    }

    #[test]
    fn it_says_whether_it_ended_at_a_minimum() {
        let least = end(1.0, 1e-12);
        assert!(least.converged && (least.point[0] - 1.0).abs() < 1e-6);
        // nothing is small enough, but no step lowers the squares beyond their rounding
        assert!(end(1.0, -1.0).converged);
        // uphill by the slopes
        assert!(!end(-1.0, 1e-12).converged);
    }
}
