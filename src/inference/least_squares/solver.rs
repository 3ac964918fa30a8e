//! Runs Levenberg–Marquardt as an argmin solver; the only file that uses argmin.

use argmin::core::{Error, Executor, IterState, Problem, Solver, TerminationReason, TerminationStatus, KV};
use nalgebra::DVector;

use super::levenberg_marquardt::{LevenbergMarquardt, Model, Variant};
use super::problem::{ResidualProblem, Stop};

/// Outer iterations of one attempt.
const MAX_ITERATIONS: u64 = 1000;

/// Runs one attempt from `start` to its end, by argmin's executor unless it ends where it begins.
pub(super) fn attempt<'a, P: ResidualProblem>(
    model: Model<'a, P>,
    start: &[f64],
    variant: Variant,
) -> Option<LevenbergMarquardt<'a, P>> {
    let mut solver = LevenbergMarquardt::new(model, variant);
    solver.begin(DVector::from_column_slice(start));
    if solver.stop.is_some() {
        return Some(solver);
    }
    let run = Executor::new((), solver)
        .configure(|state| state.max_iters(MAX_ITERATIONS))
        .ctrlc(false)
        .timer(false)
        .run();
    // the solver returns no error of its own, and argmin has none left to give
    run.ok().map(|result| result.solver)
}

/// argmin's state, which counts the iterations; the solver keeps its own point.
type State = IterState<(), (), (), (), (), f64>;

impl<P: ResidualProblem> Solver<(), State> for LevenbergMarquardt<'_, P> {
    fn name(&self) -> &str {
        "Levenberg–Marquardt"
    }

    fn next_iter(&mut self, _: &mut Problem<()>, state: State) -> Result<(State, Option<KV>), Error> {
        self.iterate();
        Ok((state, None))
    }

    fn terminate(&mut self, _: &State) -> TerminationStatus {
        match self.stop {
            None => TerminationStatus::NotTerminated,
            Some(Stop::Converged) => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            Some(stop) => TerminationStatus::Terminated(TerminationReason::SolverExit(stop.as_str().to_owned())),
        }
    }
}
