//! Weighs runs by the measurement errors of their speed and restitution: least squares by effective variance.
//!
//! About a law m(v) the residual e − m(v) of a run scatters by τ² = u² + s_v² (m/v + m′)², primes in v, since e = v_r/v
//! shares the error of v (correlated errors of v and v_r take 2 ρ u s_v (m/v + m′) off; see [`crate::runs::RunError`]), and by an intrinsic σ² besides. The weights are
//! 1/(σ² + τ²), with τ at the fit's own slopes and σ² ≥ 0 such that the weighted squares equal the degrees of freedom; σ
//! is 0 where the errors alone explain more than the scatter, and they are then not shrunk, and where it is held at 0. A run
//! without an error is taken to err like the median of those that carry one: it never has an infinite weight.
//!
//! A run whose error of v may take it to where nothing rebounds is left out: there the law is no straight line.
//!
//! Errors of v also bias a fit, to second order in s_v ([`SpeedResponse::second_order_bias`]); what that moves is taken
//! off.
//!
//! Source: effective variance after Orear, Am. J. Phys. 50, 912 (1982); the covariance of e and v and the second order
//! are ours.

use nalgebra::{DMatrix, DVector};

use super::law::SpeedResponse;
use super::least_squares::{fit_weighted, Fit, OutOfDomain, ResidualProblem, Stop};
use crate::distributions::chi_squared_tail;
use crate::roots::root_between;

/// Measurement errors of the runs of a fit, one number a run in every column; 0 where a run carries none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ErrorColumns {
    /// s_v/v, standard deviation of the speed as a share of it
    pub relative_speed_sd: Vec<f64>,
    /// u, standard deviation of the restitution beyond its share of the speed's
    pub restitution_sd: Vec<f64>,
    /// ρ, the correlation of the errors of v and v_r; empty for none
    pub speed_correlation: Vec<f64>,
    /// v o′ and v² o″ of a known offset o in the law, primes in v; empty for none
    pub offset_slopes: Vec<[f64; 2]>,
    /// whether nothing else scatters the restitutions: σ is held at 0
    pub are_all: bool,
}

impl ErrorColumns {
    /// Those of some runs, in their order.
    pub fn of_runs(&self, runs: &[usize]) -> ErrorColumns {
        fn of<T: Copy>(column: &[T], runs: &[usize]) -> Vec<T> {
            runs.iter().filter_map(|run| column.get(*run)).copied().collect()
        }
        ErrorColumns {
            relative_speed_sd: of(&self.relative_speed_sd, runs),
            restitution_sd: of(&self.restitution_sd, runs),
            speed_correlation: of(&self.speed_correlation, runs),
            offset_slopes: of(&self.offset_slopes, runs),
            are_all: self.are_all,
        }
    }
}

/// Takes the restitution of a run with its derivatives in the speed; and for each parameter in which it has a slope J, its
/// place, J and v J′.
pub type RunInSpeed<'h> = &'h mut dyn FnMut(SpeedResponse, &[(usize, [f64; 2])]);

/// A least-squares problem whose residuals depend on measured speeds.
pub trait SpeedDependent: ResidualProblem {
    /// Hands on every run at `b` and at its speed.
    ///
    /// Residuals after those of the runs are prior knowledge of a parameter, in its standard errors. Fails as
    /// [`ResidualProblem::residuals`] does.
    fn each_in_speed(&self, b: &[f64], errors: &ErrorColumns, hand_on: RunInSpeed) -> Result<(), OutOfDomain>;

    /// The restitutions with their derivatives in the speed.
    fn responses(&self, b: &[f64], errors: &ErrorColumns) -> Result<Vec<SpeedResponse>, OutOfDomain> {
        let mut all = vec![];
        self.each_in_speed(b, errors, &mut |response, _| all.push(response))?;
        Ok(all)
    }

    /// Degrees of freedom that the residuals after those of the runs have by themselves.
    fn own_freedom(&self) -> usize {
        0
    }

    /// Squares that the residuals after those of the runs leave by themselves.
    fn own_squares(&self) -> f64 {
        0.0
    }
}

/// How measurement errors entered a fit.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct ErrorSummary {
    /// runs that carry an error above 0; the others are taken to err like the median of these
    pub runs_with_errors: usize,
    /// runs left out, since their error of v may take them to where nothing rebounds
    pub runs_left_out: usize,
    /// σ, what the restitutions scatter by beyond their measurement errors; 0 where these explain more than the scatter
    pub intrinsic_sd: f64,
    /// squares of the residuals over their measurement errors', a degree of freedom: above 1 these do not explain the scatter
    pub reduced_chi_squared: f64,
    /// those degrees of freedom, of the runs that were not left out
    pub degrees_of_freedom: usize,
    /// probability of squares as large by chance, if nothing but the errors scatters the runs
    pub p: Option<f64>,
}

/// How the runs of a fit were weighed by their measurement errors.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorWeights {
    /// the errors
    pub errors: ErrorColumns,
    /// σ² + τ² of each run; infinite where it is left out
    pub variance: Vec<f64>,
    /// Σ r²/(σ² + τ²), at the minimum
    pub squares: f64,
    /// how they entered
    pub summary: ErrorSummary,
    /// second-order bias of the parameters by errors of v, taken off
    pub bias: Vec<f64>,
}

/// Roots of the weights 1/variance over the largest, and the variance that has it.
fn roots(variance: &[f64]) -> (Vec<f64>, f64) {
    let least = variance.iter().copied().fold(f64::INFINITY, f64::min);
    (variance.iter().map(|v| (least / v).sqrt()).collect(), least)
}

/// Weighted squares of a law fitted with these variances of all its residuals; infinite where it has no fit.
pub fn chi_squared<P: ResidualProblem>(problem: &P, variance: &[f64], start: &[f64]) -> f64 {
    let (roots, least) = roots(variance);
    fit_weighted(problem, &roots, start).residual_sum_of_squares / least
}

/// Bound on the rounds of weights and fits; each brings both nearer by orders of magnitude.
pub(super) const MOST_ROUNDS: usize = 60;

/// Change of a parameter, in its standard errors, after which the weights have settled.
const SETTLED: f64 = 1e-10;

/// An error whose square is below this share of the median counts as none.
const NO_ERROR: f64 = 1e-6;

/// Standard deviations of the speed within which a run whose e² would vanish is left out.
const NEAR: f64 = 3.0;

/// Fits a problem again from its unweighted fit, with the runs weighed by their errors. `excluding` gives the problem
/// without the domain of some runs, whose residuals then have no weight.
///
/// The residual sum of squares and the residual sd that come back are those of the plain residuals, the covariance is
/// (JᵀWJ)⁻¹ with the weights' own scale. `None` beside the fit as it was where no run has an error or the law is undefined;
/// beside a fit that gives the reason, where one has no covariance or its weights do not settle.
pub fn reweight<P: SpeedDependent>(
    errors: &ErrorColumns,
    unweighted: Fit,
    excluding: impl Fn(Vec<bool>) -> P,
) -> (Fit, Option<ErrorWeights>) {
    match settle(errors, &unweighted, excluding) {
        Ok((fit, weights)) => (fit, Some(weights)),
        Err(unsettled) => (unsettled.map_or(unweighted, |fit| *fit), None),
    }
}

/// Weighs and fits in turn until neither changes. Fails where no run has an error or the law is undefined, and with a fit
/// without covariance where this does not come to an end.
fn settle<P: SpeedDependent>(
    errors: &ErrorColumns,
    unweighted: &Fit,
    excluding: impl Fn(Vec<bool>) -> P,
) -> Result<(Fit, ErrorWeights), Option<Box<Fit>>> {
    let any = |sds: &[f64]| sds.iter().any(|sd| *sd > 0.0);
    if !any(&errors.relative_speed_sd) && !any(&errors.restitution_sd) {
        return Err(None);
    }
    let (problem, start, excluded) = exclude_near(errors, unweighted, excluding).ok_or(None)?;
    if start.covariance.is_err() {
        return Err(Some(Box::new(start)));
    }
    let unsettled = |why: &str| {
        Some(Box::new(Fit {
            covariance: Err(why.to_owned()),
            stop: Stop::MaxIterations,
            ..start.clone()
        }))
    };
    let left_out = excluded.iter().filter(|excluded| **excluded).count();
    let determined = problem.parameters() + problem.own_freedom() + left_out;
    let freedom = problem.runs().checked_sub(determined).filter(|df| *df > 0);
    let freedom = freedom.ok_or_else(|| unsettled("too few runs have a speed known well enough"))?;
    let reweighting = WeighedRuns {
        problem: &problem,
        errors,
        excluded: &excluded,
        counts: &[],
        freedom: freedom as f64,
    };
    let mut parameters = start.parameters.clone();
    for _ in 0..MOST_ROUNDS {
        let variances = reweighting.variances_at(&parameters);
        let undefined = |OutOfDomain| unsettled("the law is undefined where its runs would be weighed");
        let variances = variances.map_err(undefined)?.ok_or(None)?;
        let (fitted, squares) = reweighting.fit(&variances.total, &parameters);
        let Ok(covariance) = &fitted.covariance else {
            return Err(Some(Box::new(fitted)));
        };
        let change = |j: usize| (fitted.parameters[j] - parameters[j]).abs() / covariance[(j, j)].sqrt();
        let largest = (0..parameters.len()).map(change).fold(0.0, f64::max);
        if largest <= SETTLED {
            let bias = match reweighting.pull(&parameters, &variances.total) {
                Ok((pull, _)) => (covariance * pull).as_slice().to_vec(),
                Err(OutOfDomain) => vec![0.0; parameters.len()],
            };
            return Ok(reweighting.completed(fitted, squares, variances, bias));
        }
        parameters = fitted.parameters;
    }
    Err(unsettled("the weights by measurement errors did not settle"))
}

/// The problem and its fit without the runs that are too near to no rebound, all else weighing the same; the runs follow
/// the fit and the fit the runs a few times, which mostly settles both.
fn exclude_near<P: SpeedDependent>(
    errors: &ErrorColumns,
    unweighted: &Fit,
    excluding: impl Fn(Vec<bool>) -> P,
) -> Option<(P, Fit, Vec<bool>)> {
    const ROUNDS: usize = 4;
    let mut excluded = vec![false; errors.relative_speed_sd.len()];
    let mut problem = excluding(excluded.clone());
    let mut start = unweighted.clone();
    for _ in 0..ROUNDS {
        let near = too_near(&problem.responses(&start.parameters, errors).ok()?, errors);
        if near == excluded {
            break;
        }
        problem = excluding(near.clone());
        let mut roots: Vec<f64> = near.iter().map(|near| if *near { 0.0 } else { 1.0 }).collect();
        roots.resize(problem.runs(), 1.0);
        start = fit_weighted(&problem, &roots, &start.parameters);
        excluded = near;
    }
    Some((problem, start, excluded))
}

/// The runs whose error of v may take them to where nothing rebounds: about these a law is no straight line, and its slope
/// does not give the error of the residual.
fn too_near(responses: &[SpeedResponse], errors: &ErrorColumns) -> Vec<bool> {
    let runs = responses.iter().zip(&errors.relative_speed_sd);
    // e² falls by 2 m m′ for a unit of v
    runs.map(|(at, sd)| *sd > 0.0 && at.value < 2.0 * NEAR * sd * at.slope.abs())
        .collect()
}

/// The runs of a problem that are weighed by their errors.
pub(super) struct WeighedRuns<'a, P> {
    pub problem: &'a P,
    pub errors: &'a ErrorColumns,
    pub excluded: &'a [bool],
    /// how many runs each stands for; empty where that is itself
    pub counts: &'a [f64],
    /// degrees of freedom of the runs that are not excluded
    pub freedom: f64,
}

/// Variances of the residuals at some parameters.
pub(super) struct Variances {
    /// τ² of each run; infinite where it is excluded
    of_errors: Vec<f64>,
    runs_with_errors: usize,
    /// σ²
    intrinsic: f64,
    /// squares of the residuals that are prior knowledge
    prior_squares: f64,
    /// σ² + τ² of each run over its count, then 1 for each residual that is prior knowledge
    pub total: Vec<f64>,
}

impl<P: SpeedDependent> WeighedRuns<'_, P> {
    pub fn residuals_at(&self, b: &[f64]) -> Result<Vec<f64>, OutOfDomain> {
        let mut residuals = vec![0.0; self.problem.runs()];
        self.problem.residuals(b, &mut residuals)?;
        let finite = residuals.iter().all(|r| r.is_finite());
        finite.then_some(residuals).ok_or(OutOfDomain)
    }

    fn count(&self, run: usize) -> f64 {
        self.counts.get(run).copied().unwrap_or(1.0)
    }

    /// `None` where no run carries an error there.
    pub fn variances_at(&self, b: &[f64]) -> Result<Option<Variances>, OutOfDomain> {
        let responses = self.problem.responses(b, self.errors)?;
        let residuals = self.residuals_at(b)?;
        let Some((of_errors, runs_with_errors)) = error_variances(&responses, self.errors, self.excluded) else {
            return Ok(None);
        };
        let (of_runs, prior) = residuals.split_at(of_errors.len());
        let prior_squares: f64 = prior.iter().map(|r| r * r).sum();
        let beyond_own = prior_squares - self.problem.own_squares();
        let wanted = (self.freedom - beyond_own).max(1.0);
        let intrinsic = if self.errors.are_all {
            0.0
        } else {
            let squares = of_runs.iter().enumerate().map(|(run, r)| self.count(run) * r * r);
            intrinsic_variance(squares, &of_errors, wanted)
        };
        let of_run = |(run, tau): (usize, &f64)| (intrinsic + tau) / self.count(run);
        let mut total: Vec<f64> = of_errors.iter().enumerate().map(of_run).collect();
        total.resize(residuals.len(), 1.0);
        Ok(Some(Variances {
            of_errors,
            runs_with_errors,
            intrinsic,
            prior_squares,
            total,
        }))
    }

    /// The fit with these variances and its weighted squares; the covariance, if any, has the variances' own scale, which
    /// the scatter must not set again.
    fn fit(&self, variance: &[f64], start: &[f64]) -> (Fit, f64) {
        let (roots, least) = roots(variance);
        let mut fitted = fit_weighted(self.problem, &roots, start);
        let squares = fitted.residual_sum_of_squares / least;
        if let (Ok(covariance), Some(sd)) = (fitted.covariance.as_mut(), fitted.residual_sd) {
            *covariance *= least / (sd * sd);
        }
        (fitted, squares)
    }

    /// Σ w E[r J] and Σ w J Jᵀ of the runs with these variances.
    pub fn pull(&self, b: &[f64], variance: &[f64]) -> Result<(DVector<f64>, DMatrix<f64>), OutOfDomain> {
        let parameters = self.problem.parameters();
        let (mut pull, mut information) = (DVector::zeros(parameters), DMatrix::zeros(parameters, parameters));
        let mut runs = self.errors.relative_speed_sd.iter().zip(variance);
        let add = &mut |response: SpeedResponse, slopes: &[(usize, [f64; 2])]| {
            let Some((sd, variance)) = runs.next() else { return };
            for &(place, [slope, in_speed]) in slopes {
                pull[place] += sd * sd / variance * response.second_order_bias(slope, in_speed);
                for &(other, [of_other, _]) in slopes {
                    information[(place, other)] += slope * of_other / variance;
                }
            }
        };
        self.problem.each_in_speed(b, self.errors, add)?;
        Ok((pull, information))
    }

    /// Takes the bias by errors of v off a fit, unless that leads out of the domain, and completes it.
    fn completed(
        &self,
        mut fitted: Fit,
        squares: f64,
        variances: Variances,
        mut bias: Vec<f64>,
    ) -> (Fit, ErrorWeights) {
        let runs = variances.of_errors.len();
        let corrected: Vec<f64> = fitted.parameters.iter().zip(&bias).map(|(b, bias)| b - bias).collect();
        let residuals = match self.residuals_at(&corrected) {
            Ok(residuals) => {
                fitted.parameters = corrected;
                residuals
            }
            Err(OutOfDomain) => {
                bias.fill(0.0);
                // a fit ends inside the domain
                self.residuals_at(&fitted.parameters).unwrap_or_default()
            }
        };
        let of_runs = || residuals.iter().take(runs);
        let included = of_runs().zip(self.excluded).filter(|(_, excluded)| !**excluded);
        fitted.degrees_of_freedom = self.freedom as usize;
        fitted.residual_sum_of_squares = included.map(|(r, _)| r * r).sum();
        fitted.residual_sd = Some((fitted.residual_sum_of_squares / self.freedom).sqrt());
        // variances of runs left out are infinite
        let chi_squared: f64 = of_runs().zip(&variances.of_errors).map(|(r, tau)| r * r / tau).sum();
        let (reduced, freedom) = (chi_squared / self.freedom, fitted.degrees_of_freedom as f64);
        let summary = ErrorSummary {
            runs_with_errors: variances.runs_with_errors,
            runs_left_out: self.excluded.iter().filter(|excluded| **excluded).count(),
            intrinsic_sd: variances.intrinsic.sqrt(),
            reduced_chi_squared: reduced,
            degrees_of_freedom: fitted.degrees_of_freedom,
            p: chi_squared_tail(reduced * freedom, freedom),
        };
        let weights = ErrorWeights {
            errors: self.errors.clone(),
            squares: squares - variances.prior_squares,
            summary,
            variance: variances.total[..runs].to_vec(),
            bias,
        };
        (fitted, weights)
    }
}

/// τ² of each run, that of runs without an error by the median of the others and infinite where it is excluded, and how
/// many carry one; `None` where none does.
fn error_variances(responses: &[SpeedResponse], errors: &ErrorColumns, excluded: &[bool]) -> Option<(Vec<f64>, usize)> {
    let of_run = |run: usize| {
        let of_speed = errors.relative_speed_sd[run] * responses[run].error_slope();
        let own = errors.restitution_sd[run];
        let correlation = errors.speed_correlation.get(run).copied().unwrap_or(0.0);
        own * own + of_speed * of_speed - 2.0 * correlation * own * of_speed
    };
    let mut variances: Vec<f64> = (0..excluded.len())
        .map(|run| if excluded[run] { f64::INFINITY } else { of_run(run) })
        .collect();
    let mut given: Vec<f64> = variances
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
    for tau in &mut variances {
        if *tau > NO_ERROR * median {
            count += usize::from(tau.is_finite());
        } else {
            *tau = median;
        }
    }
    Some((variances, count))
}

/// σ² ≥ 0 at which Σ r²/(σ² + τ²) is as wanted; 0 where it is less already.
fn intrinsic_variance(squares: impl Iterator<Item = f64> + Clone, errors: &[f64], wanted: f64) -> f64 {
    let runs = || squares.clone().zip(errors);
    // where one run alone has as much, and where all have without an error of their own
    let least = runs().map(|(square, tau)| square / wanted - tau).fold(0.0, f64::max);
    let included = runs().filter(|(_, tau)| tau.is_finite());
    let most = included.map(|(square, _)| square / wanted).sum();
    let beyond = |sigma2: f64| runs().map(|(square, tau)| square / (sigma2 + tau)).sum::<f64>() - wanted;
    root_between([least, most], beyond).unwrap_or(least)
}
