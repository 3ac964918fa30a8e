//! Weighs runs by what their speed and restitution are measured to err by: least squares by effective variance.
//!
//! About a law m(v) the residual e − m(v) of a run scatters by τ² = u² + s_v² (m/v + m′)², primes in v, since e = v_r/v
//! shares the error of v (see [`crate::runs::MeasurementErrors`]), and by an intrinsic σ² besides. The weights are
//! 1/(σ² + τ²), with τ at the fit's own slopes and σ² ≥ 0 such that the weighted squares equal the degrees of freedom; σ
//! is 0 where the errors alone explain more than the scatter, and they are then not shrunk. A run without an error is
//! taken to err like the median of those that carry one: it never has an infinite weight.
//!
//! A run whose error of v may take it to where nothing rebounds is left out: there the law is no straight line.
//!
//! Errors of v also bias a fit, to second order in s_v: with J the slopes in the parameters, E[r J] is
//! s_v² (J (m/v² − m″/2) − J′ (m/v + m′)), and what that moves is taken off.
//!
//! Source: effective variance after Orear, Am. J. Phys. 50, 912 (1982); the covariance of e and v and the second order
//! are ours.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{fit, Fit, OutOfDomain, ResidualProblem, Stop};

/// What the runs of a fit err by; one number a run in every column.
#[derive(Debug, Clone, Copy)]
pub struct Erring<'a> {
    /// v, m/s
    pub speed: &'a [f64],
    /// s_v, m/s
    pub impact_speed_sd: &'a [f64],
    /// u, what e errs by beyond its share of v
    pub restitution_sd: &'a [f64],
    /// first and second derivative of a known offset of e² in v; empty for none
    pub offset_slopes: &'a [[f64; 2]],
}

/// A law and its derivatives in the speed, one a run.
#[derive(Debug)]
pub struct InSpeed {
    /// m
    pub value: Vec<f64>,
    /// m′
    pub slope: Vec<f64>,
    /// m″
    pub bend: Vec<f64>,
    /// J, a row a run
    pub jacobian: DMatrix<f64>,
    /// J′
    pub jacobian_slope: DMatrix<f64>,
}

impl InSpeed {
    /// Room for some runs.
    pub fn zeros(runs: usize, parameters: usize) -> InSpeed {
        InSpeed {
            value: vec![0.0; runs],
            slope: vec![0.0; runs],
            bend: vec![0.0; runs],
            jacobian: DMatrix::zeros(runs, parameters),
            jacobian_slope: DMatrix::zeros(runs, parameters),
        }
    }

    /// What the residual of a run errs by for a unit error of v: m/v + m′.
    fn pull(&self, run: usize, speed: f64) -> f64 {
        self.value[run] / speed + self.slope[run]
    }

    /// E[r J] of a run for a unit variance of v.
    fn bias(&self, run: usize, speed: f64, j: usize) -> f64 {
        let mean = self.value[run] / (speed * speed) - 0.5 * self.bend[run];
        self.jacobian[(run, j)] * mean - self.jacobian_slope[(run, j)] * self.pull(run, speed)
    }
}

/// A law whose runs may err in speed.
pub trait OfSpeed: ResidualProblem {
    /// The law at `b` and at the speeds of the runs, with its derivatives.
    ///
    /// Residuals after those of the runs are something known of a parameter, in its standard errors. Fails as
    /// [`ResidualProblem::residuals`] does.
    fn in_speed(&self, b: &[f64], erring: &Erring) -> Result<InSpeed, OutOfDomain>;

    /// Degrees of freedom that the residuals after those of the runs have by themselves.
    fn own_freedom(&self) -> usize {
        0
    }

    /// Squares that the residuals after those of the runs leave by themselves.
    fn own_squares(&self) -> f64 {
        0.0
    }
}

/// How the runs of a fit were weighed.
#[derive(Debug, Clone, PartialEq)]
pub struct Weighing {
    /// σ² + τ² of each run; infinite where it is left out
    pub variance: Vec<f64>,
    /// Σ r²/(σ² + τ²), at the minimum
    pub squares: f64,
    /// σ, what the restitutions scatter by beyond their measurement errors
    pub intrinsic_sd: f64,
    /// weighted squares over the degrees of freedom with σ = 0: above 1 the errors do not explain the scatter
    pub reduced_chi_squared: f64,
    /// runs that carry an error above 0
    pub erring: usize,
    /// runs without weight, since their error of v may take them to where nothing rebounds
    pub left_out: usize,
    /// second-order bias of the parameters by errors of v, taken off
    pub bias: Vec<f64>,
}

/// The same residuals, each times a number of its own; as they are without numbers.
pub struct Weighted<'a, P> {
    /// what is weighed
    pub problem: &'a P,
    /// the root of each residual's weight; empty for none
    pub roots: &'a [f64],
}

impl<P: ResidualProblem> ResidualProblem for Weighted<'_, P> {
    fn parameters(&self) -> usize {
        self.problem.parameters()
    }
    fn runs(&self) -> usize {
        self.problem.runs()
    }
    fn residuals(&self, b: &[f64], residuals: &mut [f64]) -> Result<(), OutOfDomain> {
        self.problem.residuals(b, residuals)?;
        for (residual, root) in residuals.iter_mut().zip(self.roots) {
            *residual *= root;
        }
        Ok(())
    }
    fn jacobian(&self, b: &[f64], jacobian: &mut DMatrix<f64>) -> Result<(), OutOfDomain> {
        self.problem.jacobian(b, jacobian)?;
        if !self.roots.is_empty() {
            for mut column in jacobian.column_iter_mut() {
                for (slope, root) in column.iter_mut().zip(self.roots) {
                    *slope *= root;
                }
            }
        }
        Ok(())
    }
    fn scale(&self) -> f64 {
        self.problem.scale()
    }
}

/// Roots of the weights 1/variance over the largest, and the variance that has it.
pub fn roots(variance: &[f64]) -> (Vec<f64>, f64) {
    let least = variance.iter().copied().fold(f64::INFINITY, f64::min);
    (variance.iter().map(|v| (least / v).sqrt()).collect(), least)
}

/// Weighted squares of a law fitted with these variances of all its residuals; infinite where it has no fit.
pub fn chi_squared<P: ResidualProblem>(problem: &P, variance: &[f64], start: &[f64]) -> f64 {
    let (roots, least) = roots(variance);
    let weighted = Weighted { problem, roots: &roots };
    fit(&weighted, start).residual_sum_of_squares / least
}

/// Bound on the rounds of weights and fits; each brings both nearer by orders of magnitude.
const MOST_ROUNDS: usize = 60;

/// Change of a parameter, in its standard errors, after which the weights have settled.
const SETTLED: f64 = 1e-10;

/// An error whose square is below this share of the median says no more than none.
const NO_ERROR: f64 = 1e-6;

/// Standard deviations of the speed within which a run whose e² would vanish is left out.
const NEAR: f64 = 3.0;

/// The runs whose error of v may take them to where nothing rebounds: about these a law is no straight line, and its slope
/// says nothing of what they err by.
fn too_near(in_speed: &InSpeed, erring: &Erring) -> Vec<bool> {
    let of_run = |(run, sd): (usize, &f64)| {
        // e² falls by 2 m m′ for a unit of v
        *sd > 0.0 && in_speed.value[run] < 2.0 * NEAR * sd * in_speed.slope[run].abs()
    };
    erring.impact_speed_sd.iter().enumerate().map(of_run).collect()
}

/// Fits a law again from its unweighted fit, with the runs weighed by their errors. `leaving_out` gives the law without
/// the domain of some runs, whose residuals then have no weight.
///
/// The residual sum of squares and the residual sd that come back are those of the plain residuals, the covariance is
/// (JᵀWJ)⁻¹ with the weights' own scale. `None` beside the fit as it was where no run has an error or the law is undefined;
/// beside one that says why, where a fit has no covariance or its weights do not settle.
pub fn weigh<P: OfSpeed>(erring: &Erring, plain: Fit, leaving_out: impl Fn(Vec<bool>) -> P) -> (Fit, Option<Weighing>) {
    match settle(erring, &plain, leaving_out) {
        Ok(Some((fit, weighing))) => (fit, Some(weighing)),
        Ok(None) => (plain, None),
        Err(unsettled) => (*unsettled, None),
    }
}

/// The law and its fit without the runs that are too near, all else weighing the same; the runs follow the fit and the fit
/// the runs a few times, which mostly settles both.
fn without_near<P: OfSpeed>(
    erring: &Erring,
    plain: &Fit,
    leaving_out: impl Fn(Vec<bool>) -> P,
) -> Option<(P, Fit, Vec<bool>)> {
    const ROUNDS: usize = 4;
    let mut out = vec![false; erring.speed.len()];
    let mut problem = leaving_out(out.clone());
    let mut start = plain.clone();
    for _ in 0..ROUNDS {
        let near = too_near(&problem.in_speed(&start.parameters, erring).ok()?, erring);
        if near == out {
            break;
        }
        problem = leaving_out(near.clone());
        let mut roots = vec![1.0; problem.runs()];
        for (root, out) in roots.iter_mut().zip(&near) {
            *root = if *out { 0.0 } else { 1.0 };
        }
        let weighted = Weighted {
            problem: &problem,
            roots: &roots,
        };
        start = fit(&weighted, &start.parameters);
        out = near;
    }
    Some((problem, start, out))
}

fn settle<P: OfSpeed>(
    erring: &Erring,
    plain: &Fit,
    leaving_out: impl Fn(Vec<bool>) -> P,
) -> Result<Option<(Fit, Weighing)>, Box<Fit>> {
    let has_errors = |sds: &[f64]| sds.iter().any(|sd| *sd > 0.0);
    if !has_errors(erring.impact_speed_sd) && !has_errors(erring.restitution_sd) {
        return Ok(None);
    }
    let Some((problem, start, out)) = without_near(erring, plain, leaving_out) else {
        return Ok(None);
    };
    let unsettled = |why: &str| {
        Box::new(Fit {
            covariance: None,
            stop: Stop::MaxIterations,
            why_no_covariance: Some(why.to_owned()),
            ..start.clone()
        })
    };
    if start.covariance.is_none() {
        return Err(Box::new(start));
    }
    let runs = erring.speed.len();
    let left_out = out.iter().filter(|out| **out).count();
    let determined = problem.parameters() + problem.own_freedom() + left_out;
    let Some(freedom) = problem.runs().checked_sub(determined).filter(|df| *df > 0) else {
        return Err(unsettled("too few runs have a speed known well enough"));
    };
    let mut parameters = start.parameters.clone();
    let mut residuals = vec![0.0; problem.runs()];
    let mut at = |b: &[f64]| -> Result<Vec<f64>, OutOfDomain> {
        problem.residuals(b, &mut residuals)?;
        let finite = residuals.iter().all(|r| r.is_finite());
        finite.then(|| residuals.clone()).ok_or(OutOfDomain)
    };
    for _ in 0..MOST_ROUNDS {
        let (Ok(in_speed), Ok(residuals)) = (problem.in_speed(&parameters, erring), at(&parameters)) else {
            return Err(unsettled("the law is undefined where its runs would be weighed"));
        };
        let Some((errors, count)) = errors_of(&in_speed, erring, &out) else {
            return Ok(None);
        };
        let known = residuals[runs..].iter().map(|r| r * r).sum::<f64>() - problem.own_squares();
        let wanted = (freedom as f64 - known).max(1.0);
        let intrinsic = intrinsic_variance(&residuals[..runs], &errors, wanted);
        let mut variance: Vec<f64> = errors.iter().map(|tau| intrinsic + tau).collect();
        variance.resize(problem.runs(), 1.0);
        let (roots, least) = roots(&variance);
        let weighted = Weighted {
            problem: &problem,
            roots: &roots,
        };
        let mut fitted = fit(&weighted, &parameters);
        let squares = fitted.residual_sum_of_squares / least;
        let (Some(covariance), Some(sd)) = (fitted.covariance.as_mut(), fitted.residual_sd) else {
            return Err(Box::new(fitted));
        };
        // the weights have a scale of their own, which the scatter must not set again
        *covariance *= least / (sd * sd);
        let moved = |j: usize| (fitted.parameters[j] - parameters[j]).abs() / covariance[(j, j)].sqrt();
        let largest = (0..parameters.len()).map(moved).fold(0.0, f64::max);
        parameters.clone_from(&fitted.parameters);
        if largest > SETTLED {
            continue;
        }
        let bias = bias(&in_speed, erring, &variance, covariance);
        let corrected: Vec<f64> = parameters.iter().zip(&bias).map(|(b, bias)| b - bias).collect();
        let (residuals, bias) = match at(&corrected) {
            Ok(residuals) => (residuals, bias),
            Err(OutOfDomain) => (residuals, vec![0.0; parameters.len()]),
        };
        fitted.parameters = parameters.iter().zip(&bias).map(|(b, bias)| b - bias).collect();
        // variances of runs left out are infinite
        let over = |variance: &[f64]| residuals.iter().zip(variance).map(|(r, v)| r * r / v).sum::<f64>();
        let plain = residuals[..runs].iter().zip(&out).filter(|(_, out)| !**out);
        fitted.degrees_of_freedom = freedom;
        fitted.residual_sum_of_squares = plain.map(|(r, _)| r * r).sum();
        fitted.residual_sd = Some((fitted.residual_sum_of_squares / freedom as f64).sqrt());
        let weighing = Weighing {
            squares: squares - known - problem.own_squares(),
            intrinsic_sd: intrinsic.sqrt(),
            reduced_chi_squared: over(&errors) / freedom as f64,
            erring: count,
            left_out,
            variance: variance[..runs].to_vec(),
            bias,
        };
        return Ok(Some((fitted, weighing)));
    }
    Err(unsettled("the weights by measurement errors did not settle"))
}

/// τ² of each run, that of runs without an error by the median of the others and infinite where it is left out, and how
/// many carry one; `None` where none does.
fn errors_of(in_speed: &InSpeed, erring: &Erring, out: &[bool]) -> Option<(Vec<f64>, usize)> {
    let of_run = |run: usize| {
        let of_speed = erring.impact_speed_sd[run] * in_speed.pull(run, erring.speed[run]);
        let own = erring.restitution_sd[run];
        own * own + of_speed * of_speed
    };
    let mut errors: Vec<f64> = (0..erring.speed.len())
        .map(|run| if out[run] { f64::INFINITY } else { of_run(run) })
        .collect();
    let mut given: Vec<f64> = errors
        .iter()
        .copied()
        .filter(|tau| *tau > 0.0 && tau.is_finite())
        .collect();
    let middle = given.len() / 2;
    if given.is_empty() {
        return None;
    }
    let (_, median, _) = given.select_nth_unstable_by(middle, f64::total_cmp);
    let median = *median;
    let mut count = 0;
    for tau in &mut errors {
        if *tau > NO_ERROR * median {
            count += usize::from(tau.is_finite());
        } else {
            *tau = median;
        }
    }
    Some((errors, count))
}

/// σ² ≥ 0 at which Σ r²/(σ² + τ²) is as wanted; 0 where it is less already.
fn intrinsic_variance(residuals: &[f64], errors: &[f64], wanted: f64) -> f64 {
    const MOST_STEPS: usize = 100;
    let runs = || residuals.iter().map(|r| r * r).zip(errors);
    // left of the root: one run alone has as much there
    let mut sigma2 = runs().map(|(square, tau)| square / wanted - tau).fold(0.0, f64::max);
    for _ in 0..MOST_STEPS {
        let (mut sum, mut slope) = (0.0, 0.0);
        for (square, tau) in runs() {
            // 0 of a run left out
            let share = square / (sigma2 + tau);
            sum += share;
            slope += share / (sigma2 + tau);
        }
        if sum <= wanted {
            break;
        }
        // Newton's step for the inverse of the sum, which is nearly straight and concave: never beyond the root
        let step = sum * (sum / wanted - 1.0) / slope;
        sigma2 += step;
        if step <= f64::EPSILON * sigma2 {
            break;
        }
    }
    sigma2
}

/// (JᵀWJ)⁻¹ Σ w E[r J].
fn bias(in_speed: &InSpeed, erring: &Erring, variance: &[f64], covariance: &DMatrix<f64>) -> Vec<f64> {
    let pull = DVector::from_fn(covariance.ncols(), |j, _| {
        let runs = erring.speed.iter().zip(erring.impact_speed_sd).enumerate();
        runs.map(|(run, (v, sd))| sd * sd / variance[run] * in_speed.bias(run, *v, j))
            .sum()
    });
    (covariance * pull).as_slice().to_vec()
}
