//! Runs Levenberg–Marquardt as an argmin solver; the only file that uses argmin.

use argmin::core::{Error, Executor, IterState, Problem, Solver, TerminationReason, TerminationStatus, KV};
use nalgebra::DVector;

use super::levenberg_marquardt::{LevenbergMarquardt, Model, Variant};
use super::linearised::Linearised;
use super::problem::{ResidualProblem, Stop};

/// Outer iterations of one attempt.
const MAX_ITERATIONS: u64 = 1000;

/// How one attempt ended.
pub(super) struct Attempt {
    /// The last point; `None` if the model is undefined at the start.
    pub(super) end: Option<Linearised>,
    pub(super) stop: Stop,
    pub(super) evaluations: usize,
    /// Whether any step led out of the model's domain.
    pub(super) met_edge: bool,
}

/// Runs one attempt from `start`, by argmin's executor unless it ends where it begins.
pub(super) fn attempt<P: ResidualProblem>(problem: &P, start: &[f64], variant: Variant) -> Attempt {
    let mut solver = LevenbergMarquardt::new(problem.runs(), problem.parameters(), variant);
    let mut model = Model::new(problem);
    solver.begin(&mut model, DVector::from_column_slice(start));
    if solver.stop.is_some() {
        return Attempt::ended(Some(solver), Some(model));
    }
    let run = Executor::new(model, Driven(solver))
        .configure(|state| state.max_iters(MAX_ITERATIONS))
        .ctrlc(false)
        .timer(false)
        .run();
    // The solver returns no error of its own, and argmin has none left to give.
    match run {
        Ok(result) => Attempt::ended(Some(result.solver.0), result.problem.problem),
        Err(_) => Attempt::ended::<P>(None, None),
    }
}

impl Attempt {
    fn ended<P>(solver: Option<LevenbergMarquardt>, model: Option<Model<P>>) -> Attempt {
        Attempt {
            stop: solver
                .as_ref()
                .and_then(|solver| solver.stop)
                .unwrap_or(Stop::MaxIterations),
            end: solver.and_then(|solver| solver.current),
            evaluations: model.as_ref().map_or(0, |model| model.evaluations),
            met_edge: model.is_some_and(|model| model.met_edge),
        }
    }
}

type State = IterState<DVector<f64>, (), (), (), (), f64>;

/// An attempt as argmin drives it.
struct Driven(LevenbergMarquardt);

impl Driven {
    /// argmin's state at the current point.
    fn update(&self, state: State) -> State {
        match &self.0.current {
            Some(here) => state.param(here.parameters.clone()).cost(here.residual_sum_of_squares),
            None => state,
        }
    }
}

impl<P: ResidualProblem> Solver<Model<'_, P>, State> for Driven {
    fn name(&self) -> &str {
        "Levenberg–Marquardt"
    }

    fn init(&mut self, _: &mut Problem<Model<'_, P>>, state: State) -> Result<(State, Option<KV>), Error> {
        Ok((self.update(state), None))
    }

    fn next_iter(&mut self, problem: &mut Problem<Model<'_, P>>, state: State) -> Result<(State, Option<KV>), Error> {
        if let Some(model) = problem.problem.as_mut() {
            self.0.iterate(model);
        }
        Ok((self.update(state), None))
    }

    fn terminate(&mut self, _state: &State) -> TerminationStatus {
        match self.0.stop {
            None => TerminationStatus::NotTerminated,
            Some(Stop::Converged) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            Some(stop) => TerminationStatus::Terminated(TerminationReason::SolverExit(stop.as_str().to_owned())),
        }
    }
}
