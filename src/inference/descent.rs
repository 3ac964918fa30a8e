//! Finds least squares by damped Newton or Gauss–Newton steps from sums over rows, never a row a run; and the mode of a density,
//! of which they are −2 ln p.

use super::sums::Sums;

/// Where a descent ended.
pub struct Descent {
    /// the point
    pub point: Vec<f64>,
    /// the sums there
    pub sums: Sums,
    /// by how much the squares fell
    pub fell: f64,
    /// by how much more they fall at most, as their slopes say
    pub promised: f64,
    /// whether a step would lower them by little more, or by nothing beside their rounding
    pub converged: bool,
}

/// Descends from a start until the slopes promise a fall of at most `small`; `None` where the start has no sums. A point without
/// sums is not gone to, nor one whose squares are no lower.
pub fn descend(start: &[f64], small: f64, mut sums_at: impl FnMut(&[f64]) -> Option<Sums>) -> Option<Descent> {
    const STEPS: usize = 100;
    const FIRST_DAMPING: f64 = 1e-6;
    const MOST_DAMPING: f64 = 1e8;
    /// what a parameter that moves nothing is damped by
    const LEAST: f64 = 1e-6;
    /// share of the squares that their own rounding hides
    const ROUNDING: f64 = 1e-12;
    let mut here = sums_at(start)?;
    let began = here.squares;
    let mut point = start.to_vec();
    let mut damping = FIRST_DAMPING;
    let mut converged = false;
    let mut promised = f64::INFINITY;
    for _ in 0..STEPS {
        let mut damped = here.information.clone();
        // no weaker where the squares bend down than where they bend up
        damped.set_diagonal(&damped.diagonal().map(|own| own + damping * own.abs().max(LEAST)));
        let step = damped.cholesky().map(|root| root.solve(&here.gradient));
        if let Some(step) = step.as_ref().filter(|_| damping <= 1.0) {
            promised = step.dot(&here.gradient);
        }
        if promised <= small {
            converged = true;
            break;
        }
        let lower = step.and_then(|step| {
            let trial: Vec<f64> = point.iter().zip(step.iter()).map(|(b, step)| b - step).collect();
            let there = sums_at(&trial).filter(|there| there.squares < here.squares)?;
            Some((trial, there))
        });
        match lower {
            Some(lower) => {
                (point, here) = lower;
                damping = (0.1 * damping).max(FIRST_DAMPING);
            }
            None if damping > MOST_DAMPING => {
                converged = promised <= ROUNDING * here.squares.abs();
                break;
            }
            None => damping *= 10.0,
        }
    }
    Some(Descent {
        fell: began - here.squares,
        point,
        sums: here,
        promised,
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
