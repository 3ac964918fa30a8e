//! Profiles a function of the parameters of any least-squares problem, by fits that are drawn to values of it.
//!
//! The least of squares + w (q(b) − c)² has, among all points with its own value of q, the least squares: whatever c and w
//! are, it lies on the profile. So c leads along it, and no parameter needs to be solved out.

use nalgebra::{DMatrix, DVector};

use super::{search, Limits, ProfilePoint, AGREES};
use crate::inference::effective_variance::WeightedProblem;
use crate::inference::least_squares::{fit, OutOfDomain, ResidualProblem};

/// A function of the parameters with its slopes in them.
#[derive(Debug, Clone, PartialEq)]
pub struct WithSlopes {
    /// the function
    pub value: f64,
    /// its slopes
    pub slopes: Vec<f64>,
}

/// A fitted problem about its minimum.
pub struct ProblemProfile<'p, P> {
    /// the problem, with the roots of the weights of its residuals; empty for none
    pub weighted: WeightedProblem<'p, P>,
    /// where the squares are least
    pub minimum: &'p [f64],
    /// covariance of the parameters
    pub covariance: &'p DMatrix<f64>,
    /// s², the variance of a residual of weight 1
    pub variance: f64,
}

/// A problem drawn to a value of a function of its parameters, in a residual after its own.
struct Drawn<'p, P, F> {
    problem: &'p P,
    quantity: &'p F,
    target: f64,
    root: f64,
}

impl<P: ResidualProblem, F: Fn(&[f64]) -> Option<WithSlopes>> ResidualProblem for Drawn<'_, P, F> {
    fn parameters(&self) -> usize {
        self.problem.parameters()
    }
    fn runs(&self) -> usize {
        self.problem.runs() + 1
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        let (last, own) = residuals.split_last_mut().ok_or(OutOfDomain)?;
        *last = self.root * ((self.quantity)(b).ok_or(OutOfDomain)?.value - self.target);
        self.problem.residuals(b, own)
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let slopes = (self.quantity)(b).ok_or(OutOfDomain)?.slopes;
        let runs = self.problem.runs();
        let mut own = DMatrix::zeros(runs, slopes.len());
        self.problem.jacobian(b, &mut own)?;
        jacobian.rows_mut(0, runs).copy_from(&own);
        for (j, slope) in slopes.into_iter().enumerate() {
            jacobian[(runs, j)] = self.root * slope;
        }
        Ok(())
    }
    fn scale(&self) -> f64 {
        self.problem.scale()
    }
}

/// The quantity at the minimum, and the way of t standard errors along the slopes there.
struct AlongSlopes {
    value: f64,
    /// standard error of the quantity
    se: f64,
    /// step of the parameters that goes with it
    step: DVector<f64>,
    /// least squares, and by how much they rise to a limit
    least: f64,
    wanted: f64,
}

impl<P: ResidualProblem> ProblemProfile<'_, P> {
    /// The limits of a function of the parameters at t; `None` where the delta method's are the same, or it has none.
    pub fn limits(&self, quantity: impl Fn(&[f64]) -> Option<WithSlopes>, t: f64) -> Option<Limits> {
        let slopes = self.along_slopes(&quantity, t)?;
        let straight = [-1.0, 1.0]
            .into_iter()
            .all(|side| self.is_straight(&quantity, &slopes, side * t));
        (!straight).then(|| self.search(&quantity, &slopes, t))
    }

    fn squares_at(&self, b: &[f64]) -> Option<f64> {
        let mut residuals = vec![0.0; self.weighted.runs()];
        self.weighted.residuals(b, &mut residuals).ok()?;
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        squares.is_finite().then_some(squares)
    }

    fn along_slopes(&self, quantity: &impl Fn(&[f64]) -> Option<WithSlopes>, t: f64) -> Option<AlongSlopes> {
        let at = quantity(self.minimum)?;
        let slopes = DVector::from_vec(at.slopes);
        let step = self.covariance * &slopes;
        let se = slopes.dot(&step).sqrt();
        (se > 0.0 && se.is_finite()).then_some(AlongSlopes {
            value: at.value,
            se,
            step: step / se,
            least: self.squares_at(self.minimum)?,
            wanted: t * t * self.variance,
        })
    }

    /// The parameters so many standard errors of the quantity along the slopes at the fit.
    fn moved(&self, slopes: &AlongSlopes, t: f64) -> Vec<f64> {
        let both = self.minimum.iter().zip(slopes.step.iter());
        both.map(|(b, step)| b + t * step).collect()
    }

    /// Whether t standard errors along the slopes, to either side, squares and quantity are what these say.
    fn is_straight(&self, quantity: &impl Fn(&[f64]) -> Option<WithSlopes>, slopes: &AlongSlopes, t: f64) -> bool {
        let there = self.moved(slopes, t);
        let (Some(found), Some(squares)) = (quantity(&there), self.squares_at(&there)) else {
            return false;
        };
        let off = (found.value - slopes.value) / (t * slopes.se) - 1.0;
        let point = ProfilePoint::new(found.value, squares - slopes.least, slopes.wanted);
        (point.distance - 1.0).abs() <= AGREES && off.abs() <= AGREES
    }

    fn search(&self, quantity: &impl Fn(&[f64]) -> Option<WithSlopes>, slopes: &AlongSlopes, t: f64) -> Limits {
        /// strength of the pull beside the squares' own, by the slopes at the fit
        const PULL: f64 = 100.0;
        let AlongSlopes { value, se, .. } = *slopes;
        let root = (PULL * self.variance).sqrt() / se;
        let mut last: Option<(Vec<f64>, f64)> = None;
        search(value, [value - t * se, value + t * se], |target| {
            let drawn = Drawn {
                problem: &self.weighted,
                quantity,
                // the pull stops short of what it is set to by its share
                target: target + (target - value) / PULL,
                root,
            };
            let on_side = last.take().filter(|(_, at)| (at - value) * (target - value) > 0.0);
            let ahead = match &on_side {
                Some((near, at)) => {
                    let both = self.minimum.iter().zip(near);
                    both.map(|(b, near)| b + (near - b) * (target - value) / (at - value))
                        .collect()
                }
                None => self.moved(slopes, (target - value) / se),
            };
            let mut end = fit(&drawn, &ahead);
            if on_side.is_none() || !end.converged() {
                // a run near r = 0 can hold a fit on its own side
                let near = on_side.map_or_else(|| self.minimum.to_vec(), |(near, _)| near);
                let other = fit(&drawn, &near);
                if other.residual_sum_of_squares < end.residual_sum_of_squares {
                    end = other;
                }
            }
            let found = quantity(&end.parameters)?.value;
            let squares = self.squares_at(&end.parameters)?;
            last = Some((end.parameters, found));
            Some(ProfilePoint::new(found, squares - slopes.least, slopes.wanted))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::rebound::{mean_and_slope, mean_restitution};
    use crate::seed::stream;
    use rand::RngExt;

    /// e = m(a − c g − 4 L x) at two films and some 1/St, with a known beside; or a plane through the same points.
    struct Films {
        plane: bool,
        rows: Vec<[f64; 3]>,
    }

    const A: f64 = 0.624;
    const KNOWN: f64 = 2.0;
    const FILMS: [f64; 2] = [0.0497, 0.0914];

    impl Films {
        /// Runs of which those that rebound are kept.
        fn draw(plane: bool, seed: u64) -> Films {
            let mut rng = stream(seed, "profile of two films", 0);
            let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
            let mut rows = vec![];
            for g in FILMS {
                for x in [1.0 / 20.6, 1.0 / 28.6, 1.0 / 40.4] {
                    rows.extend((0..3).map(|_| [g, x, mean_restitution(A - g - 11.0 * x) + 0.03 * normal()]));
                }
            }
            rows.retain(|row| row[2] > 0.0);
            Films { plane, rows }
        }

        fn least_squares(&self) -> crate::inference::least_squares::Fit {
            fit(self, &[A, 1.0, 2.75])
        }
    }

    impl ResidualProblem for Films {
        fn parameters(&self) -> usize {
            3
        }
        fn runs(&self) -> usize {
            self.rows.len() + 1
        }
        fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
            for (residual, [g, x, e]) in residuals.iter_mut().zip(&self.rows) {
                let kept = b[0] - b[1] * g - 4.0 * b[2] * x;
                *residual = if self.plane { kept } else { mean_restitution(kept) } - e;
            }
            residuals[self.rows.len()] = KNOWN * (b[0] - A);
            Ok(())
        }
        fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
            for (row, [g, x, _]) in self.rows.iter().enumerate() {
                let kept = b[0] - b[1] * g - 4.0 * b[2] * x;
                let slope = if self.plane { 1.0 } else { mean_and_slope(kept).1 };
                for (j, c) in [1.0, -g, -4.0 * x].into_iter().enumerate() {
                    jacobian[(row, j)] = slope * c;
                }
            }
            for j in 0..3 {
                jacobian[(self.rows.len(), j)] = if j == 0 { KNOWN } else { 0.0 };
            }
            Ok(())
        }
    }

    fn l(b: &[f64]) -> Option<WithSlopes> {
        Some(WithSlopes {
            value: b[2],
            slopes: vec![0.0, 0.0, 1.0],
        })
    }

    /// St_c at the thicker film.
    fn st_c(b: &[f64]) -> Option<WithSlopes> {
        let kept = b[0] - b[1] * FILMS[1];
        let value = 2.0 * b[2] / kept;
        (kept > 0.0).then(|| WithSlopes {
            value,
            slopes: vec![-value / kept, value * FILMS[1] / kept, 2.0 / kept],
        })
    }

    fn of<'p>(films: &'p Films, fit: &'p crate::inference::least_squares::Fit) -> ProblemProfile<'p, Films> {
        ProblemProfile {
            weighted: WeightedProblem {
                problem: films,
                roots: &[],
            },
            minimum: &fit.parameters,
            covariance: fit.covariance.as_ref().unwrap(),
            variance: fit.residual_sd.unwrap().powi(2),
        }
    }

    #[test]
    fn of_a_plane_the_limits_are_the_delta_methods() {
        let films = Films::draw(true, 1);
        let fit = films.least_squares();
        let profile = of(&films, &fit);
        assert_eq!(profile.limits(l, 2.1), None);
        let slopes = profile.along_slopes(&l, 2.1).unwrap();
        let [lo, hi] = profile.search(&l, &slopes, 2.1).both().unwrap();
        let half = 2.1 * fit.se(2).unwrap();
        assert!((lo - fit.parameters[2] + half).abs() < 3e-3 * half);
        assert!((hi - fit.parameters[2] - half).abs() < 3e-3 * half);
    }

    /// The least squares over a grid of the other two parameters, at some St_c.
    fn on_a_grid(films: &Films, fitted: &[f64], st_c: f64) -> f64 {
        const STEPS: i32 = 250;
        let mut residuals = vec![0.0; films.runs()];
        let mut least = f64::INFINITY;
        for i in -STEPS..=STEPS {
            for j in -STEPS..=STEPS {
                let a = fitted[0] + 0.15 * f64::from(i) / f64::from(STEPS);
                let c = fitted[1] + 1.5 * f64::from(j) / f64::from(STEPS);
                let b = [a, c, 0.5 * st_c * (a - c * FILMS[1])];
                films.residuals(&b, &mut residuals).unwrap();
                least = residuals.iter().map(|r| r * r).sum::<f64>().min(least);
            }
        }
        least
    }

    #[test]
    fn limits_are_those_of_a_grid() {
        let mut checked = 0;
        for seed in 0..12 {
            let films = Films::draw(false, seed);
            let fit = films.least_squares();
            let Some(limits) = of(&films, &fit).limits(st_c, 2.1) else {
                continue;
            };
            let wanted = 2.1f64.powi(2) * fit.residual_sd.unwrap().powi(2);
            for limit in limits.both().unwrap() {
                // a grid never lies below the least, and 1e-3 of the rise above it
                let rise = (on_a_grid(&films, &fit.parameters, limit) - fit.residual_sum_of_squares) / wanted;
                assert!((0.985..1.03).contains(&rise), "seed {seed}: {limit} {rise}");
                checked += 1;
            }
        }
        assert!(checked >= 8, "{checked}");
    }
}
