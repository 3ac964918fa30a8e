//! Runs Levenberg–Marquardt as an argmin solver; the only file that knows argmin.
//!
//! Moré's damping of scaled columns with Nielsen's update, Transtrum and Sethna's geodesic
//! acceleration, and undamped Gauss–Newton steps at the end, where the sum of squares is flat
//! to rounding while the parameters still move in their eighth digit.

use argmin::core::{Error, Executor, IterState, Problem, Solver, TerminationReason, TerminationStatus, KV};
use nalgebra::{DMatrix, DVector};

use super::linearised::{Damped, Linearised};
use super::{OutOfDomain, ResidualProblem, Stop};

/// Outer iterations of one attempt.
const MAX_ITERATIONS: u64 = 1000;
/// Dampings tried before an iteration is given up.
const MAX_DAMPINGS: usize = 40;
/// Damping of the first step, in units of the squared yardsticks.
const FIRST_DAMPING: f64 = 1e-3;
/// Below this relative offset an undamped step is tried first.
const UNDAMPED_BELOW: f64 = 0.1;
/// An undamped step is kept only if it leaves at most this part of what was removable.
const UNDAMPED_GAIN: f64 = 0.7;
/// Relative offset at which nothing is left to gain: a 1e-9th of a standard error.
const TIGHT: f64 = 1e-9;
/// Relative offset which still counts as converged when rounding forbids any further step.
const LOOSE: f64 = 1e-5;
/// Longest acceleration, as a part of the step, that is believed.
const MAX_ACCELERATION: f64 = 0.75;
/// Where along the step the curvature is measured.
const CURVATURE_PROBE: f64 = 0.1;

/// How the parameters are measured when a step is damped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Yardstick {
    /// By the longest column met so far (Moré): cautious, remembers steep ground.
    Longest,
    /// By the column as it is here: forgets, and so leaves flat ground again.
    Current,
}

/// How one attempt ended.
pub(super) struct Attempt {
    /// The last point; `None` if the model is undefined at the start.
    pub(super) end: Option<Linearised>,
    pub(super) stop: Stop,
    pub(super) evaluations: usize,
}

/// Runs one attempt from `start` by argmin's executor.
pub(super) fn attempt<P: ResidualProblem>(problem: &P, start: &[f64], yardstick: Yardstick) -> Attempt {
    let solver = LevenbergMarquardt::new(problem.runs(), problem.parameters(), yardstick);
    let start = DVector::from_column_slice(start);
    let run = Executor::new(Model(problem), solver)
        .configure(|state| state.param(start).max_iters(MAX_ITERATIONS))
        .ctrlc(false)
        .timer(false)
        .run();
    match run {
        Ok(mut result) => Attempt {
            end: result.solver.here.take(),
            stop: result.solver.stop.unwrap_or(Stop::MaxIterations),
            evaluations: result.problem.counts.values().map(|&c| c as usize).sum(),
        },
        // The solver itself returns no error; argmin has none left to give.
        Err(_) => Attempt {
            end: None,
            stop: Stop::OutOfDomain,
            evaluations: 0,
        },
    }
}

type State = IterState<DVector<f64>, (), (), (), (), f64>;

/// The problem as argmin carries and counts it.
struct Model<'a, P>(&'a P);

struct LevenbergMarquardt {
    yardstick: Yardstick,
    /// Where the solver stands.
    here: Option<Linearised>,
    residuals: DVector<f64>,
    trial: DVector<f64>,
    work: DVector<f64>,
    yardsticks: DVector<f64>,
    damping: f64,
    growth: f64,
    /// Undamped steps wait until the relative offset falls below this.
    undamped_below: f64,
    stop: Option<Stop>,
}

/// What a proposed step led to.
enum Step {
    Taken,
    Refused,
}

impl LevenbergMarquardt {
    fn new(runs: usize, parameters: usize, yardstick: Yardstick) -> Self {
        Self {
            yardstick,
            here: None,
            residuals: DVector::zeros(runs),
            trial: DVector::zeros(runs),
            work: DVector::zeros(runs),
            yardsticks: DVector::zeros(parameters),
            damping: FIRST_DAMPING,
            growth: 2.0,
            undamped_below: UNDAMPED_BELOW,
            stop: None,
        }
    }

    /// Moves to `next`, whose residuals are in `trial`.
    fn move_to(&mut self, next: Linearised) {
        std::mem::swap(&mut self.residuals, &mut self.trial);
        for (y, &length) in self.yardsticks.iter_mut().zip(next.lengths.iter()) {
            *y = match self.yardstick {
                Yardstick::Longest => y.max(length),
                Yardstick::Current => length,
            };
            if *y == 0.0 {
                *y = 1.0;
            }
        }
        self.here = Some(next);
    }

    /// Tries the undamped step: it is judged by the slope left, not by the sum of squares,
    /// which no longer feels steps below 1e-8.
    fn undamped_step<P: ResidualProblem>(
        &mut self,
        problem: &mut Problem<Model<P>>,
        here: &Linearised,
    ) -> Result<Step, Error> {
        let Some(step) = here.gauss_newton_step() else {
            return Ok(Step::Refused);
        };
        let there = &here.parameters + step;
        let Some(sum) = residuals_at(problem, &there, &mut self.trial)? else {
            return Ok(Step::Refused);
        };
        if sum > here.residual_sum_of_squares * (1.0 + UNDAMPED_BELOW) && !here.at_rounding() {
            return Ok(Step::Refused);
        }
        let Some(next) = linearise_at(problem, there, &self.trial, &mut self.work)? else {
            return Ok(Step::Refused);
        };
        if next.removable.norm() > UNDAMPED_GAIN * here.removable.norm() {
            return Ok(Step::Refused);
        }
        self.move_to(next);
        Ok(Step::Taken)
    }

    /// Tries dampings, each greater than the last, until one lowers the sum of squares.
    fn damped_step<P: ResidualProblem>(
        &mut self,
        problem: &mut Problem<Model<P>>,
        here: &Linearised,
    ) -> Result<Step, Error> {
        let Some(damped) = Damped::new(here, &self.yardsticks) else {
            return Ok(Step::Refused);
        };
        let mut left_domain = false;
        for _ in 0..MAX_DAMPINGS {
            let Some(velocity) = damped.step(&here.removable, self.damping) else {
                break;
            };
            let Some(change) = damped.apply(&velocity) else {
                break;
            };
            let expected = change.norm_squared() + 2.0 * self.damping * velocity.norm_squared();
            let bent = self.accelerate(problem, here, &damped, &velocity, &change)?;
            if let Some(scaled) = bent {
                let there = &here.parameters + scaled.component_div(&self.yardsticks);
                if there == here.parameters {
                    break;
                }
                match residuals_at(problem, &there, &mut self.trial)? {
                    None => left_domain = true,
                    Some(sum) => {
                        let gain = (here.residual_sum_of_squares - sum) / expected;
                        if gain > 1e-4 {
                            match linearise_at(problem, there, &self.trial, &mut self.work)? {
                                None => left_domain = true,
                                Some(next) => {
                                    let ease = 1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3);
                                    self.damping *= ease.max(1.0 / 3.0);
                                    self.growth = 2.0;
                                    self.move_to(next);
                                    return Ok(Step::Taken);
                                }
                            }
                        }
                    }
                }
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
        if left_domain {
            self.stop = Some(Stop::OutOfDomain);
        }
        Ok(Step::Refused)
    }

    /// Bends the step along the curvature measured on its way; `None` if it is bent so far
    /// that the step reaches beyond what the slopes here can tell.
    fn accelerate<P: ResidualProblem>(
        &mut self,
        problem: &mut Problem<Model<P>>,
        here: &Linearised,
        damped: &Damped,
        velocity: &DVector<f64>,
        change: &DVector<f64>,
    ) -> Result<Option<DVector<f64>>, Error> {
        let h = CURVATURE_PROBE;
        let probe = &here.parameters + velocity.component_div(&self.yardsticks) * h;
        if residuals_at(problem, &probe, &mut self.work)?.is_none() {
            return Ok(Some(velocity.clone()));
        }
        self.work -= &self.residuals;
        let curvature = (here.project(&mut self.work) / h - change) * (2.0 / h);
        let Some(acceleration) = damped.step(&curvature, self.damping) else {
            return Ok(None);
        };
        if acceleration.norm() > MAX_ACCELERATION * velocity.norm() {
            return Ok(None);
        }
        Ok(Some(velocity + acceleration * 0.5))
    }
}

impl<P: ResidualProblem> Solver<Model<'_, P>, State> for LevenbergMarquardt {
    fn name(&self) -> &str {
        "Levenberg–Marquardt"
    }

    fn init(&mut self, problem: &mut Problem<Model<'_, P>>, mut state: State) -> Result<(State, Option<KV>), Error> {
        let start = state.take_param().unwrap_or_default();
        let sum = residuals_at(problem, &start, &mut self.trial)?;
        let first = match sum {
            Some(_) => linearise_at(problem, start.clone(), &self.trial, &mut self.work)?,
            None => None,
        };
        match first {
            Some(first) => self.move_to(first),
            None => self.stop = Some(Stop::OutOfDomain),
        }
        Ok((state.param(start), None))
    }

    fn next_iter(&mut self, problem: &mut Problem<Model<'_, P>>, state: State) -> Result<(State, Option<KV>), Error> {
        let Some(here) = self.here.take() else {
            return Ok((state, None));
        };
        let offset = here.relative_offset();
        let mut step = Step::Refused;
        if offset <= TIGHT {
            self.stop = Some(Stop::Converged);
        } else {
            if offset < self.undamped_below {
                step = self.undamped_step(problem, &here)?;
                if matches!(step, Step::Refused) {
                    self.undamped_below = 0.1 * offset;
                }
            }
            let settled = here.at_rounding() || offset <= 1e-8;
            if matches!(step, Step::Refused) && !settled {
                step = self.damped_step(problem, &here)?;
            }
            if matches!(step, Step::Refused) {
                self.stop = Some(match self.stop {
                    _ if settled || offset <= LOOSE => Stop::Converged,
                    Some(stop) => stop,
                    None => Stop::MaxIterations,
                });
            }
        }
        if self.here.is_none() {
            self.here = Some(here);
        }
        let Some(here) = self.here.as_ref() else {
            return Ok((state, None));
        };
        let sum = here.residual_sum_of_squares;
        let parameters = here.parameters.clone();
        Ok((state.param(parameters).cost(sum), None))
    }

    fn terminate(&mut self, _state: &State) -> TerminationStatus {
        match self.stop {
            None => TerminationStatus::NotTerminated,
            Some(Stop::Converged) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            Some(stop) => TerminationStatus::Terminated(TerminationReason::SolverExit(stop.as_str().to_owned())),
        }
    }
}

/// Sum of squares at `parameters`, the residuals going into `out`; `None` outside the domain,
/// which a residual that is not a finite number counts as.
fn residuals_at<P: ResidualProblem>(
    problem: &mut Problem<Model<P>>,
    parameters: &DVector<f64>,
    out: &mut DVector<f64>,
) -> Result<Option<f64>, Error> {
    if !parameters.iter().all(|b| b.is_finite()) {
        return Ok(None);
    }
    problem.problem("residuals", |model| {
        let inside = model.0.residuals(parameters.as_slice(), out.as_mut_slice());
        let sum = out.norm_squared();
        Ok((inside.is_ok() && sum.is_finite()).then_some(sum))
    })
}

/// The triangle at `parameters`, whose `residuals` are known; `None` outside the domain.
fn linearise_at<P: ResidualProblem>(
    problem: &mut Problem<Model<P>>,
    parameters: DVector<f64>,
    residuals: &DVector<f64>,
    work: &mut DVector<f64>,
) -> Result<Option<Linearised>, Error> {
    problem.problem("slopes", |model| {
        let mut jacobian = DMatrix::zeros(model.0.runs(), model.0.parameters());
        let inside: Result<(), OutOfDomain> = model.0.jacobian(parameters.as_slice(), &mut jacobian);
        if inside.is_err() {
            return Ok(None);
        }
        Ok(Linearised::new(parameters, residuals, jacobian, work, model.0.scale()))
    })
}
