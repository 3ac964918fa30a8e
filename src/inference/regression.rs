//! Fits a law to runs by least squares, with its sensitivity to errors of the speed and to a known offset.
//!
//! The caller gives no starting values: they come from a straight line.

use nalgebra::DMatrix;
use pulp::Arch;

use super::effective_variance::{
    chi_squared, reweight, ErrorColumns, ErrorWeights, SpeedDependent, SpeedDerivatives, WeightedProblem,
};
use super::kernel::{self, Sample};
use super::law::{Law, Response};
use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem};
use crate::lanes::sums;
use crate::scene::WetLaw;

/// A law and the runs it is fitted to, one number a run in every column.
#[derive(Debug, Clone, Copy)]
pub struct Regression<'a> {
    /// the law
    pub law: Law,
    /// abscissae
    pub x: &'a [f64],
    /// known offsets; empty for none
    pub offset: &'a [f64],
    /// restitutions
    pub restitution: &'a [f64],
    /// how many runs each stands for; empty where that is itself
    pub counts: &'a [f64],
}

impl<'a> Regression<'a> {
    /// A law without offset.
    pub fn new(law: Law, x: &'a [f64], restitution: &'a [f64]) -> Regression<'a> {
        Regression {
            law,
            x,
            offset: &[],
            restitution,
            counts: &[],
        }
    }

    /// Fits the law with all runs weighing the same.
    pub fn fit(&self) -> Fit {
        let (problem, parameters) = (self.problem(vec![]), self.law.parameters());
        if self.counts.is_empty() {
            return fit(&problem, &self.start()[..parameters]);
        }
        let roots: Vec<f64> = self.counts.iter().map(|count| count.sqrt()).collect();
        let weighted = WeightedProblem {
            problem: &problem,
            roots: &roots,
        };
        fit(&weighted, &self.start_by_counts()[..parameters]).of_runs(self.counts.iter().sum())
    }

    /// Fits the law, the runs weighed by their measurement errors if there are any; x must move with the speed as the
    /// law's does.
    pub fn fit_with_errors(&self, errors: Option<&ErrorColumns>) -> (Fit, Option<ErrorWeights>) {
        match errors {
            Some(errors) => reweight(errors, self.fit(), |excluded| self.problem(excluded)),
            None => (self.fit(), None),
        }
    }

    fn problem(&self, excluded: Vec<bool>) -> RegressionProblem<'a> {
        RegressionProblem {
            regression: *self,
            excluded,
        }
    }

    /// Weighted squares of the law fitted with these variances of the runs, infinite for those left out, from a start.
    pub fn chi_squared(&self, variance: &[f64], start: &[f64]) -> f64 {
        let problem = self.problem(variance.iter().map(|variance| variance.is_infinite()).collect());
        chi_squared(&problem, variance, start)
    }

    /// Restitution that the law gives each run; 0 where it is undefined.
    pub fn fitted(&self, parameters: [f64; 2]) -> Vec<f64> {
        let runs = 0..self.x.len();
        runs.map(|run| self.law.restitution(parameters, self.x[run], self.offset_of(run)))
            .collect()
    }

    /// The law at a run, with its slopes and bends.
    pub fn response(&self, parameters: [f64; 2], run: usize) -> Response {
        self.law.response(self.predictor(parameters, run))
    }

    fn predictor(&self, parameters: [f64; 2], run: usize) -> f64 {
        self.law.predictor(parameters, self.x[run], self.offset_of(run))
    }

    fn offset_of(&self, run: usize) -> f64 {
        self.offset.get(run).copied().unwrap_or(0.0)
    }

    /// The error of v, as a share of it common to all runs, that would bias the second parameter of a fit by a tenth of
    /// its standard error; the bias grows with the square of that share.
    ///
    /// `offset_slopes` are v o′ and v² o″ of each run, empty for none; `variance` is that of each residual, empty where
    /// all have the fit's own. `None` where the fit has no covariance or such an error no bias.
    pub fn speed_error_that_matters(&self, fitted: &Fit, offset_slopes: &[[f64; 2]], variance: &[f64]) -> Option<f64> {
        let covariance = fitted.covariance.as_ref()?;
        let parameters = pair(&fitted.parameters);
        let mut pull = [0.0; 2];
        for (run, weight) in self.weights(fitted, variance)? {
            let predictor = self.predictor(parameters, run);
            if !self.law.is_defined(predictor) {
                return None;
            }
            let offset_slopes = offset_slopes.get(run).copied().unwrap_or_default();
            let at = self.law.in_speed(parameters, self.x[run], predictor, offset_slopes);
            for (j, pull) in pull.iter_mut().enumerate() {
                *pull += weight * at.response.second_order_bias(at.jacobian[j], at.jacobian_slope[j]);
            }
        }
        let bias = covariance[(1, 0)] * pull[0] + covariance[(1, 1)] * pull[1];
        let share = (0.1 * fitted.se(1)? / bias.abs()).sqrt();
        share.is_finite().then_some(share)
    }

    /// Slopes of both fitted parameters in a number that shifts every run's offset.
    ///
    /// `offset_slope` is d(offset)/d(that number) for each run. First order: −(JᵀWJ)⁻¹ JᵀW ∂e, with (JᵀWJ)⁻¹ taken from
    /// the covariance; `variance` is that of each residual, empty where all have the fit's own. `None` where the fit has
    /// no covariance.
    pub fn offset_sensitivity(&self, fitted: &Fit, offset_slope: &[f64], variance: &[f64]) -> Option<[f64; 2]> {
        let covariance = fitted.covariance.as_ref()?;
        let parameters = pair(&fitted.parameters);
        let mut projected = [0.0; 2];
        for (run, weight) in self.weights(fitted, variance)? {
            let predictor = self.predictor(parameters, run);
            if !self.law.is_defined(predictor) {
                return None;
            }
            let slope = self.law.response(predictor).slope;
            for (projected, c) in projected.iter_mut().zip(self.law.design(self.x[run])) {
                *projected += weight * slope * slope * c * offset_slope[run];
            }
        }
        Some([0, 1].map(|j| -(covariance[(j, 0)] * projected[0] + covariance[(j, 1)] * projected[1])))
    }

    /// The runs that are not left out, each with the inverse of its residual's variance.
    fn weights<'f>(
        &'f self,
        fitted: &Fit,
        variance: &'f [f64],
    ) -> Option<impl Iterator<Item = (usize, f64)> + use<'a, 'f>> {
        let (common, counts) = (fitted.residual_sd? * fitted.residual_sd?, self.counts);
        let of_run = move |run: usize| 1.0 / variance.get(run).copied().unwrap_or(common);
        let runs = (0..self.x.len()).map(move |run| (run, of_run(run) * counts.get(run).copied().unwrap_or(1.0)));
        Some(runs.filter(|(_, weight)| *weight != 0.0))
    }

    /// The same as [`Self::start`] where runs stand for several.
    fn start_by_counts(&self) -> [f64; 2] {
        let Regression {
            law, x, offset, counts, ..
        } = *self;
        let sample = Sample {
            offset,
            ..Sample::new(x, self.restitution, counts)
        };
        let found = match law {
            Law::Dry(_) => kernel::dry(&sample),
            Law::Wet(WetLaw::Linear) => kernel::linear(&sample),
            Law::Wet(WetLaw::Sqrt) => {
                let squares = |run: usize| self.restitution[run].powi(2);
                let left: Vec<f64> = (0..x.len()).map(|run| squares(run) - self.offset_of(run)).collect();
                kernel::linear(&Sample::new(x, &left, counts)).and_then(|fitted| {
                    let [alpha, fall] = fitted;
                    let all: f64 = counts.iter().sum();
                    let mean =
                        |of: &dyn Fn(usize) -> f64| (0..x.len()).map(|run| counts[run] * of(run)).sum::<f64>() / all;
                    let centre = mean(&|run| x[run]);
                    let line = Line {
                        centre,
                        mean: alpha - fall * centre,
                        slope: -fall,
                    };
                    let start = self.flattened(&line, START_MARGIN * mean(&squares));
                    kernel::square_root(&sample, start).or(Ok(start))
                })
            }
        };
        found.unwrap_or_default()
    }

    /// Parameters near the minimum, inside the domain of the law at every run.
    fn start(&self) -> [f64; 2] {
        match self.law {
            Law::Dry(_) => {
                let squares: f64 = self.x.iter().map(|x| x * x).sum();
                let products: f64 = self.x.iter().zip(self.restitution).map(|(x, e)| x * (1.0 - e)).sum();
                [if squares > 0.0 { products / squares } else { 0.0 }, 0.0]
            }
            Law::Wet(WetLaw::Linear) => {
                let line = Line::through(self.x, [self.restitution; 2], |[e, _]| e);
                [line.mean - line.slope * line.centre, -line.slope]
            }
            Law::Wet(WetLaw::Sqrt) => Arch::new().dispatch(|| match self.offset {
                [] => self.start_of_square_root::<false>(self.x),
                offset => self.start_of_square_root::<true>(offset),
            }),
        }
    }

    /// The minimum where Newton's method finds it from the line through e², or else that line, flattened about its mean
    /// until no run lies below a margin; the offset is o, or any column where there is none.
    #[inline(always)] // in the widest registers
    fn start_of_square_root<const OFFSET: bool>(&self, o: &[f64]) -> [f64; 2] {
        let known = known::<OFFSET>;
        let (x, e) = (self.x, self.restitution);
        let line = Line::through(x, [e, o], |[e, o]| e * e - known(o));
        let mean_square = if OFFSET {
            e.iter().map(|e| e * e).sum::<f64>() / x.len().max(1) as f64
        } else {
            line.mean
        };
        let floor = START_MARGIN * mean_square;
        let kept = |x: f64, o: f64| line.mean + line.slope * (x - line.centre) + known(o);
        let [low] = sums([x, o], |[x, o]| [f64::from(u8::from(kept(x, o) < floor))]);
        let start = if low > 0.0 {
            self.flattened(&line, floor)
        } else {
            [line.mean - line.slope * line.centre, line.slope]
        };
        let settled = self.newton::<OFFSET>(o, start);
        settled.unwrap_or_else(|| self.square_root_from(start).unwrap_or(start))
    }

    /// A line through e², flattened about its mean until it lies nowhere below a floor.
    fn flattened(&self, line: &Line, floor: f64) -> [f64; 2] {
        let mut flatten: f64 = 1.0;
        for (run, x) in self.x.iter().enumerate() {
            let offset = self.offset_of(run);
            let (kept, flat) = (line.mean + line.slope * (x - line.centre) + offset, line.mean + offset);
            if kept < floor && flat > floor {
                flatten = flatten.min((flat - floor) / (flat - kept));
            }
        }
        let slope = line.slope * flatten;
        [line.mean - slope * line.centre, slope]
    }

    /// The square root's minimum by steps of Newton's method that stay inside the domain, from a start there: where a run lies
    /// near its edge a fit from farther away takes hundreds of steps along it. `None` where it does not settle.
    fn square_root_from(&self, start: [f64; 2]) -> Option<[f64; 2]> {
        let weights = vec![1.0; self.x.len()];
        let sample = Sample {
            offset: self.offset,
            ..Sample::new(self.x, self.restitution, &weights)
        };
        kernel::square_root(&sample, start).ok()
    }

    /// The square root's minimum by whole steps of Newton's method from a start near it, a few of them: less than a
    /// single step of the fit takes, which judges it then. `None` where they do not settle or leave the domain.
    #[inline(always)] // in the registers of the start
    fn newton<const OFFSET: bool>(&self, o: &[f64], start: [f64; 2]) -> Option<[f64; 2]> {
        let law = Law::SQUARE_ROOT;
        let [mut alpha, mut beta] = start;
        for _ in 0..NEWTON_STEPS {
            let [g0, g1, h0, h1, h2] = sums([self.x, o, self.restitution], |[x, o, e]| {
                // outside the domain a NaN, and the sums with it
                let Response { value, slope, bend } = law.response(law.predictor([alpha, beta], x, known::<OFFSET>(o)));
                let gradient = (value - e) * slope;
                let bend = slope * slope + (value - e) * bend;
                [gradient, gradient * x, bend, bend * x, bend * x * x]
            });
            if !(h0 > 0.0 && h0 * h2 - h1 * h1 > NEWTON_SINGULAR * h0 * h2) {
                return None;
            }
            let [da, db] = law.solve([h0, h1, h2], [g0, g1]);
            (alpha, beta) = (alpha - da, beta - db);
            if da.abs() <= NEWTON_SETTLED * alpha.abs() && db.abs() <= NEWTON_SETTLED * beta.abs() {
                return Some([alpha, beta]);
            }
        }
        None
    }
}

/// The known offset of a run; none where its column holds something else.
#[inline(always)]
fn known<const OFFSET: bool>(o: f64) -> f64 {
    if OFFSET {
        o
    } else {
        0.0
    }
}

/// Smallest energy kept at the starting values, as a share of the mean of e²; keeps every run inside the domain.
const START_MARGIN: f64 = 0.05;

/// Newton steps towards the start of a square root,
const NEWTON_STEPS: usize = 6;
/// the relative change of the parameters by the last of them: what it leaves is about its square,
const NEWTON_SETTLED: f64 = 1e-6;
/// and the share of its diagonal's product below which their determinant is left to the fit to judge.
const NEWTON_SINGULAR: f64 = 1e-9;

/// A least-squares line.
struct Line {
    /// mean of the abscissae
    centre: f64,
    /// mean of the ordinates
    mean: f64,
    /// 0 where the abscissae do not vary
    slope: f64,
}

impl Line {
    /// The line through ordinates made of two columns.
    #[inline(always)]
    fn through(x: &[f64], [a, b]: [&[f64]; 2], y: impl Fn([f64; 2]) -> f64) -> Line {
        let runs = x.len().max(1) as f64;
        let [centre, mean] = sums([x, a, b], |[x, a, b]| [x, y([a, b])]).map(|sum| sum / runs);
        let [products, squares] = sums([x, a, b], |[x, a, b]| {
            let apart = x - centre;
            [apart * (y([a, b]) - mean), apart * apart]
        });
        let slope = if squares > 0.0 { products / squares } else { 0.0 };
        Line { centre, mean, slope }
    }
}

/// One or two parameters as two numbers.
fn pair(parameters: &[f64]) -> [f64; 2] {
    [0, 1].map(|j| parameters.get(j).copied().unwrap_or(0.0))
}

/// A regression as a least-squares problem, in which the domain of some runs may not be held.
struct RegressionProblem<'a> {
    regression: Regression<'a>,
    /// runs without weight, which may lie outside the domain; empty for none
    excluded: Vec<bool>,
}

/// Linear predictor that stands for that of an excluded run outside its domain.
const EXCLUDED: f64 = 1e-12;

impl RegressionProblem<'_> {
    /// The linear predictor of a run at its abscissa.
    fn predictor(&self, law: Law, parameters: [f64; 2], run: usize, x: f64) -> Result<f64, OutOfDomain> {
        let predictor = law.predictor(parameters, x, self.regression.offset_of(run));
        if law.is_defined(predictor) {
            Ok(predictor)
        } else if self.excluded.get(run) == Some(&true) {
            Ok(EXCLUDED)
        } else {
            Err(OutOfDomain)
        }
    }

    /// Writes a number of each run into every column, from its linear predictor, abscissa and restitution.
    #[inline(always)] // in the widest registers
    fn write<const N: usize>(
        &self,
        (law, b): (Law, [f64; 2]),
        columns: [&mut [f64]; N],
        of_run: impl Fn(f64, f64, f64) -> [f64; N],
    ) -> Result<(), OutOfDomain> {
        let Regression {
            x, offset, restitution, ..
        } = self.regression;
        match offset {
            [] => self.write_several::<false, N>((law, b), [x, x, restitution], columns, of_run),
            _ => self.write_several::<true, N>((law, b), [x, offset, restitution], columns, of_run),
        }
    }

    /// The same, several runs at once as if all were inside the domain, and again one by one where one is not.
    #[inline(always)]
    fn write_several<const OFFSET: bool, const N: usize>(
        &self,
        (law, b): (Law, [f64; 2]),
        [x, o, e]: [&[f64]; 3],
        mut columns: [&mut [f64]; N],
        of_run: impl Fn(f64, f64, f64) -> [f64; N],
    ) -> Result<(), OutOfDomain> {
        let runs = self.runs();
        let (x, o, e) = (&x[..runs], &o[..runs], &e[..runs]);
        let mut columns = columns.each_mut().map(|column| &mut column[..runs]);
        let mut put = |run: usize, predictor: f64| {
            for (column, number) in columns.iter_mut().zip(of_run(predictor, x[run], e[run])) {
                column[run] = number;
            }
        };
        let mut inside = true;
        for run in 0..runs {
            let predictor = law.predictor(b, x[run], known::<OFFSET>(o[run]));
            inside &= law.is_defined(predictor);
            put(run, predictor);
        }
        if !inside {
            for (run, x) in x.iter().enumerate() {
                put(run, self.predictor(law, b, run, *x)?);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn write_residuals(&self, law: Law, b: [f64; 2], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        self.write((law, b), [residuals], |predictor, _, e| {
            [law.response(predictor).value - e]
        })
    }

    #[inline(always)]
    fn write_jacobian(&self, law: Law, b: [f64; 2], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        let (first, second) = jacobian.as_mut_slice().split_at_mut(self.runs());
        if law.parameters() == 1 {
            self.write((law, b), [first], |predictor, x, _| {
                [law.response(predictor).slope * law.design(x)[0]]
            })
        } else {
            self.write((law, b), [first, second], |predictor, x, _| {
                let slope = law.response(predictor).slope;
                law.design(x).map(|c| slope * c)
            })
        }
    }
}

impl ResidualProblem for RegressionProblem<'_> {
    fn parameters(&self) -> usize {
        self.regression.law.parameters()
    }
    fn runs(&self) -> usize {
        self.regression.restitution.len()
    }
    // the square root, fitted most often, has loops compiled for it alone
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        Arch::new().dispatch(|| match self.regression.law {
            Law::SQUARE_ROOT => self.write_residuals(Law::SQUARE_ROOT, pair(b), residuals),
            law => self.write_residuals(law, pair(b), residuals),
        })
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        Arch::new().dispatch(|| match self.regression.law {
            Law::SQUARE_ROOT => self.write_jacobian(Law::SQUARE_ROOT, pair(b), jacobian),
            law => self.write_jacobian(law, pair(b), jacobian),
        })
    }
}

impl SpeedDependent for RegressionProblem<'_> {
    fn speed_derivatives(&self, b: &[f64], errors: &ErrorColumns) -> Result<SpeedDerivatives, OutOfDomain> {
        let (law, parameters) = (self.regression.law, pair(b));
        let (runs, number) = (self.runs(), self.parameters());
        let mut all = SpeedDerivatives {
            response: Vec::with_capacity(runs),
            jacobian: DMatrix::zeros(runs, number),
            jacobian_slope: DMatrix::zeros(runs, number),
        };
        for (run, x) in self.regression.x.iter().enumerate() {
            let predictor = self.predictor(law, parameters, run, *x)?;
            let offset_slopes = errors.offset_slopes.get(run).copied().unwrap_or_default();
            let at = law.in_speed(parameters, *x, predictor, offset_slopes);
            all.response.push(at.response);
            for j in 0..number {
                all.jacobian[(run, j)] = at.jacobian[j];
                all.jacobian_slope[(run, j)] = at.jacobian_slope[j];
            }
        }
        Ok(all)
    }
}
