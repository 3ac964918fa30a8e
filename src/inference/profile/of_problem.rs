//! Profiles a function of the parameters of any least-squares problem, by fits that are drawn to values of it.
//!
//! The least of squares + w (q(b) − c)² has, among all points with its own value of q, the least squares, so that whatever c
//! and w are, it lies on the profile.

use nalgebra::{DMatrix, DVector};

use super::{limit, Limits, ProfilePoint, AGREES};
use crate::distributions::student_t_quantile;
use crate::inference::descent::{descend, Descent};
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::least_squares::Fit;
use crate::inference::sums::Sums;

/// A function of the parameters, and its slopes in them.
pub type WithSlopes = (f64, Vec<f64>);

/// The first parameter as such a function.
pub fn first_parameter(b: &[f64]) -> Option<WithSlopes> {
    let mut slopes = vec![0.0; b.len()];
    *slopes.first_mut()? = 1.0;
    Some((b[0], slopes))
}

/// Where the squares of a fitted problem have risen by no more than t²s².
#[derive(Debug, Clone)]
pub struct Region {
    /// where the squares are least
    pub minimum: Vec<f64>,
    /// covariance of the parameters
    pub covariance: DMatrix<f64>,
    /// s², the variance of a residual of weight 1
    pub variance: f64,
    /// how many standard errors a limit lies off, were everything straight
    pub t: f64,
}

impl Region {
    /// That of a fit, its runs weighed by their measurement errors if there are any, at the level of an interval; `None`
    /// where it did not converge or has no covariance.
    pub fn of(fit: &Fit, errors: Option<&ErrorWeights>, level: f64) -> Option<Region> {
        Some(Region {
            minimum: fit.parameters.clone(),
            covariance: fit.covariance.clone().ok().filter(|_| fit.converged())?,
            variance: match errors {
                Some(_) => 1.0,
                None => fit.residual_sd?.powi(2),
            },
            t: student_t_quantile(0.5 + 0.5 * level, fit.degrees_of_freedom as f64)?,
        })
    }

    /// t²s².
    pub fn rise(&self) -> f64 {
        self.t * self.t * self.variance
    }

    /// The standard error of a quantity with these slopes at the minimum, and the step of the parameters that goes with it;
    /// `None` where it is not a positive number.
    pub fn along(&self, slopes: &DVector<f64>) -> Option<(f64, DVector<f64>)> {
        let step = &self.covariance * slopes;
        let se = slopes.dot(&step).sqrt();
        (se > 0.0 && se.is_finite()).then(|| (se, step / se))
    }

    /// The parameters to one side at the end of the region, by the slopes at the minimum.
    pub fn moved(&self, step: &DVector<f64>, side: f64) -> Vec<f64> {
        let both = self.minimum.iter().zip(step.iter());
        both.map(|(b, step)| b + side * self.t * step).collect()
    }
}

/// The squares of a problem at some parameters, with their sums; `None` outside the domain.
type Squares<'s> = Box<dyn Fn(&[f64]) -> Option<Sums> + Sync + 's>;

/// A fitted problem about its minimum.
pub struct ProblemProfile<'s> {
    squares: Squares<'s>,
    region: Region,
    /// the squares at the minimum
    least: f64,
}

impl<'s> ProblemProfile<'s> {
    /// `squares` are those of the residuals at some parameters, with the sums of residuals times slopes and of slopes times
    /// slopes; `None` outside the domain, and so of the whole where that is at the minimum.
    pub fn new(squares: impl Fn(&[f64]) -> Option<Sums> + Sync + 's, region: Region) -> Option<ProblemProfile<'s>> {
        let least = squares(&region.minimum)?.squares;
        Some(ProblemProfile {
            squares: Box::new(squares),
            region,
            least,
        })
    }

    /// Whether the delta method's limits of a function of the parameters are as good, or it has none.
    pub fn is_straight(&self, quantity: impl Fn(&[f64]) -> Option<WithSlopes>) -> bool {
        let about = AboutMinimum::new(self, quantity);
        about.is_none_or(|about| SIDES.iter().all(|side| about.is_straight_to(*side)))
    }

    /// The limits of a function of the parameters; `None` where it has no standard error.
    pub fn limits(&self, quantity: impl Fn(&[f64]) -> Option<WithSlopes>) -> Option<Limits> {
        let about = AboutMinimum::new(self, quantity)?;
        let [lo, hi] = SIDES.map(|side| about.limit(side));
        Some(Limits { lo, hi })
    }
}

/// Below the estimate and above it.
const SIDES: [f64; 2] = [-1.0, 1.0];

/// A quantity about the minimum of a problem.
struct AboutMinimum<'p, Q> {
    problem: &'p ProblemProfile<'p>,
    quantity: Q,
    /// of the quantity at the minimum
    value: f64,
    /// its standard error, and the step of the parameters along it
    se: f64,
    step: DVector<f64>,
}

impl<'p, Q: Fn(&[f64]) -> Option<WithSlopes>> AboutMinimum<'p, Q> {
    fn new(problem: &'p ProblemProfile, quantity: Q) -> Option<AboutMinimum<'p, Q>> {
        let (value, slopes) = quantity(&problem.region.minimum)?;
        let (se, step) = problem.region.along(&DVector::from_vec(slopes))?;
        Some(AboutMinimum {
            problem,
            quantity,
            value,
            se,
            step,
        })
    }

    fn region(&self) -> &Region {
        &self.problem.region
    }

    fn sums_at(&self, point: &[f64]) -> Option<Sums> {
        (self.problem.squares)(point)
    }

    fn point(&self, value: f64, squares: f64) -> ProfilePoint {
        ProfilePoint::new(value, squares - self.problem.least, self.region().rise())
    }

    /// Whether at the end of the region, along the slopes to one side, squares and quantity are what these say.
    fn is_straight_to(&self, side: f64) -> bool {
        let there = self.region().moved(&self.step, side);
        let (Some((found, _)), Some(sums)) = ((self.quantity)(&there), self.sums_at(&there)) else {
            return false;
        };
        let off = (found - self.value) / (side * self.region().t * self.se) - 1.0;
        let distance = self.point(found, sums.squares).distance;
        (distance - 1.0).abs() <= AGREES && off.abs() <= AGREES
    }

    /// The limit on one side, by least squares drawn to one value of the quantity after the other.
    fn limit(&self, side: f64) -> Option<f64> {
        let value = self.value;
        let half_width = self.region().t * self.se;
        let mut last: Option<(Vec<f64>, f64)> = None;
        limit(value, value + side * half_width, |target| {
            let on_side = last.take().filter(|(_, at)| (at - value) * (target - value) > 0.0);
            let ahead = match &on_side {
                Some((near, at)) => {
                    let both = self.region().minimum.iter().zip(near);
                    both.map(|(b, near)| b + (near - b) * (target - value) / (at - value))
                        .collect()
                }
                None => self.region().moved(&self.step, (target - value) / half_width),
            };
            let mut end = self.draw(target, &ahead);
            if on_side.is_none() || !end.as_ref().is_some_and(|end| end.converged) {
                // a run near r = 0 can hold a fit on its own side
                let near = on_side.map_or_else(|| self.region().minimum.clone(), |(near, _)| near);
                let other = self.draw(target, &near);
                let is_lower = |other: &Descent| end.as_ref().is_none_or(|end| other.sums.squares < end.sums.squares);
                if other.as_ref().is_some_and(is_lower) {
                    end = other;
                }
            }
            let end = end?;
            let (found, _) = (self.quantity)(&end.point)?;
            let squares = self.sums_at(&end.point)?.squares;
            last = Some((end.point, found));
            Some(self.point(found, squares))
        })
    }

    /// Least squares with those of a pull to a value of the quantity, much stronger than the squares by the slopes at the
    /// minimum; `None` where they cannot begin.
    fn draw(&self, value: f64, start: &[f64]) -> Option<Descent> {
        /// strength beside the squares' own: a weaker pull leaps over where these bend down, beyond a run near r = 0
        const PULL: f64 = 1e4;
        /// a fall by this share of the rise to a limit moves that by half as much of its half-width
        const SMALL: f64 = 1e-6;
        // it stops short of what it is set to by its share
        let target = value + (value - self.value) / PULL;
        let root = (PULL * self.region().variance).sqrt() / self.se;
        let pulled = |b: &[f64]| {
            let (at, slopes) = (self.quantity)(b)?;
            let mut sums = self.sums_at(b)?;
            let slopes = slopes.iter().enumerate().filter(|(_, slope)| **slope != 0.0);
            let slopes: Vec<(usize, f64)> = slopes.map(|(place, slope)| (place, root * slope)).collect();
            sums.add(root * (at - target), &slopes);
            sums.squares.is_finite().then_some(sums)
        };
        descend(start, SMALL * self.region().rise(), pulled)
    }
}
