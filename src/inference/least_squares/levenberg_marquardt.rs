//! Iterates by the method of Levenberg and Marquardt, from point to point until nothing is left to gain.
//!
//! Damped by Moré's scaling and Nielsen's update, bent by Transtrum and Sethna's geodesic
//! acceleration; at the end undamped, or Newton's, as there the sum of squares is flat to rounding
//! while the parameters still move in their eighth digit.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector};

use super::linearised::{Damped, Linearised};
use super::problem::{ResidualProblem, Stop};

/// Dampings tried before an iteration is given up.
const MAX_DAMPINGS: usize = 40;
/// Damping of the first step, in units of the squared yardsticks.
const FIRST_DAMPING: f64 = 1e-3;
/// Below this relative offset an undamped step is tried first,
const UNDAMPED_BELOW: f64 = 1.0;
/// and below this share of the model's values, which decides where there is no scatter.
const UNDAMPED_BELOW_SHARE: f64 = 1e-4;
/// An undamped step is kept only if it leaves at most this part of what was removable.
const UNDAMPED_GAIN: f64 = 0.7;
/// Newton's step is tried where the undamped one is refused and the scatter, as a part of the
/// model's values, is enough to measure a curvature by,
const NEWTON_SCATTER: f64 = 1e-8;
/// which is done this part of a standard error away.
const NEWTON_PROBE: f64 = 1e-4;
/// Relative offset at which nothing is left to gain: a 1e-9th of a standard error.
const TIGHT: f64 = 1e-9;
/// Relative offset which still counts as converged when rounding forbids any further step.
const LOOSE: f64 = 1e-5;
/// Longest acceleration, as a part of the step, that is believed.
const MAX_ACCELERATION: f64 = 0.75;
/// Where along the step the curvature is measured.
const CURVATURE_PROBE: f64 = 0.1;

/// Once a step has led out of the domain, so many iterations
const EDGE_PATIENCE: usize = 30;
/// must lower the sum of squares by this part: an attempt that creeps along the edge has no minimum to come to, and with
/// a million runs would take minutes to find that out.
const EDGE_GAIN: f64 = 1e-3;

/// Variants of the method, by how they scale the parameters and bound a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variant {
    /// Scales each parameter by its longest column so far (Moré).
    LargestScale,
    /// Scales it by its column at the current point, and so leaves flat ground again.
    CurrentScale,
    /// As `LargestScale` without acceleration, but shortens a step that would go more than half the
    /// way to the edge of the domain. Damping it instead turns it, for slopes that are nearly
    /// alike, straight towards the edge, where they may be so steep that no step leads away again.
    ShortenedSteps,
}

/// A problem with the weights of its residuals.
pub(super) struct Model<'a, P> {
    problem: &'a P,
    /// The root of each residual's weight; empty where all weigh the same.
    roots: &'a [f64],
    /// Whether any point was outside the domain.
    pub(super) met_edge: bool,
}

impl<'a, P: ResidualProblem> Model<'a, P> {
    pub(super) fn new(problem: &'a P, roots: &'a [f64]) -> Self {
        Self {
            problem,
            roots,
            met_edge: false,
        }
    }

    /// Sum of squares at `parameters`, the residuals going into `out`; `None` outside the domain,
    /// which a residual that is not a finite number counts as.
    pub(super) fn residuals(&mut self, parameters: &DVector<f64>, out: &mut DVector<f64>) -> Option<f64> {
        if !parameters.iter().all(|b| b.is_finite()) {
            return None;
        }
        let inside = self.problem.residuals(parameters.as_slice(), out.as_mut_slice());
        out.iter_mut()
            .zip(self.roots)
            .for_each(|(residual, root)| *residual *= root);
        let sum = out.norm_squared();
        let found = Some(sum).filter(|sum| inside.is_ok() && sum.is_finite());
        self.met_edge |= found.is_none();
        found
    }

    /// The triangle at `parameters`, whose `residuals` are known; `None` outside the domain.
    fn linearise(
        &mut self,
        parameters: DVector<f64>,
        residuals: &DVector<f64>,
        work: &mut DVector<f64>,
    ) -> Option<Linearised> {
        let mut jacobian = DMatrix::zeros(self.problem.runs(), self.problem.parameters());
        self.problem.jacobian(parameters.as_slice(), &mut jacobian).ok()?;
        for mut column in jacobian.column_iter_mut() {
            column
                .iter_mut()
                .zip(self.roots)
                .for_each(|(slope, root)| *slope *= root);
        }
        Linearised::new(parameters, residuals, jacobian, work, self.problem.scale())
    }
}

/// The state of one attempt.
pub(super) struct LevenbergMarquardt<'a, P> {
    pub(super) model: Model<'a, P>,
    variant: Variant,
    /// The current point; `None` if the model is undefined at the start.
    pub(super) current: Option<Linearised>,
    /// its relative offset
    offset: f64,
    /// its residuals
    pub(super) residuals: DVector<f64>,
    trial: DVector<f64>,
    work: DVector<f64>,
    yardsticks: DVector<f64>,
    damping: f64,
    growth: f64,
    /// Relative offset at which an undamped step was last refused.
    refused_at: f64,
    /// Iterations since the edge was met or the sum of squares last looked at, and what it was then.
    at_edge: Option<(usize, f64)>,
    /// Why it stopped, once it has.
    pub(super) stop: Option<Stop>,
}

/// Whether a step was taken: `None` where it was refused.
type Taken = Option<()>;

impl<'a, P: ResidualProblem> LevenbergMarquardt<'a, P> {
    pub(super) fn new(model: Model<'a, P>, variant: Variant) -> Self {
        let (of_runs, of_parameters) = (
            DVector::zeros(model.problem.runs()),
            DVector::zeros(model.problem.parameters()),
        );
        Self {
            model,
            variant,
            current: None,
            offset: f64::INFINITY,
            residuals: of_runs.clone(),
            trial: of_runs.clone(),
            work: of_runs,
            yardsticks: of_parameters,
            damping: FIRST_DAMPING,
            growth: 2.0,
            refused_at: f64::INFINITY,
            at_edge: None,
            stop: None,
        }
    }

    /// Begins at `start`; stopped at once if the model is undefined or nothing is left to gain there.
    pub(super) fn begin(&mut self, start: DVector<f64>) {
        match self.linearised(start) {
            Some(first) => self.move_to(first),
            None => self.stop = Some(Stop::OutOfDomain),
        }
    }

    /// The triangle at `parameters`, whose residuals go into `trial`; `None` outside the domain.
    fn linearised(&mut self, parameters: DVector<f64>) -> Option<Linearised> {
        self.model.residuals(&parameters, &mut self.trial)?;
        self.model.linearise(parameters, &self.trial, &mut self.work)
    }

    /// Takes one step, or stops.
    pub(super) fn iterate(&mut self) {
        let Some(here) = self.current.take() else {
            return;
        };
        let offset = self.offset;
        let mut step = None;
        let near = offset < UNDAMPED_BELOW || here.removable_share() < UNDAMPED_BELOW_SHARE;
        if near && offset < 0.1 * self.refused_at {
            step = self.undamped_step(&here);
            if step.is_none() {
                self.refused_at = offset;
                if here.scatter() > NEWTON_SCATTER * here.scale {
                    step = self.newton_step(&here);
                }
            }
        }
        let settled = here.at_rounding() || offset <= 1e-8;
        if step.is_none() && !settled {
            step = self.damped_step(&here);
        }
        if step.is_none() {
            self.stop = Some(match self.stop {
                _ if settled || offset <= LOOSE => Stop::Converged,
                Some(stop) => stop,
                None => Stop::MaxIterations,
            });
        }
        let sum = self.current.get_or_insert(here).residual_sum_of_squares;
        if self.model.met_edge && self.stop.is_none() {
            let (iterations, before) = self.at_edge.unwrap_or((0, sum));
            self.at_edge = match iterations + 1 {
                EDGE_PATIENCE if sum > (1.0 - EDGE_GAIN) * before => {
                    self.stop = Some(Stop::OutOfDomain);
                    None
                }
                EDGE_PATIENCE => Some((0, sum)),
                more => Some((more, before)),
            };
        }
    }

    /// Moves to `next`, whose residuals are in `trial`; stops if nothing is left to gain there.
    fn move_to(&mut self, next: Linearised) {
        std::mem::swap(&mut self.residuals, &mut self.trial);
        for (y, &length) in self.yardsticks.iter_mut().zip(next.lengths.iter()) {
            *y = match self.variant {
                Variant::CurrentScale => length,
                Variant::LargestScale | Variant::ShortenedSteps => y.max(length),
            };
            if *y == 0.0 {
                *y = 1.0;
            }
        }
        self.offset = next.relative_offset();
        if self.offset <= TIGHT {
            self.stop = Some(Stop::Converged);
        }
        self.current = Some(next);
    }

    /// Tries the undamped step: it is judged by the slope left, not by the sum of squares,
    /// which no longer feels steps below 1e-8.
    fn undamped_step(&mut self, here: &Linearised) -> Taken {
        let step = here.gauss_newton_step()?;
        self.take_if_flatter(here, &here.parameters + step)
    }

    /// Tries Newton's step, for curves so bent that undamped steps overshoot for ever (runs close
    /// to a square root's edge). What the slopes leave out of the curvature is measured by
    /// differences of the gradient.
    fn newton_step(&mut self, here: &Linearised) -> Taken {
        let axes = here.axes()?;
        let apart = NEWTON_PROBE * here.scatter();
        let p = here.parameters.len();
        let mut curvature = DMatrix::zeros(p, p);
        for (axis, mut column) in axes.column_iter().zip(curvature.column_iter_mut()) {
            let there = self.linearised(&here.parameters + axis * apart)?;
            column.copy_from(&((there.gradient_along(&axes) - &here.removable) / apart));
        }
        let symmetric = (&curvature + curvature.transpose()) * 0.5;
        // Without a positive curvature in every direction there is no minimum to step to.
        let root = Cholesky::new(symmetric)?;
        let step = axes * root.solve(&here.removable);
        self.take_if_flatter(here, &here.parameters - step)
    }

    /// Moves `there` if that leaves clearly less to remove.
    fn take_if_flatter(&mut self, here: &Linearised, there: DVector<f64>) -> Taken {
        let sum = self.model.residuals(&there, &mut self.trial)?;
        if sum > here.residual_sum_of_squares * 1.1 && !here.at_rounding() {
            return None;
        }
        let next = self.model.linearise(there, &self.trial, &mut self.work)?;
        if next.removable.norm() > UNDAMPED_GAIN * here.removable.norm() {
            return None;
        }
        self.move_to(next);
        Some(())
    }

    /// Tries dampings, each greater than the last, until one lowers the sum of squares.
    fn damped_step(&mut self, here: &Linearised) -> Taken {
        let damped = Damped::new(here, &self.yardsticks)?;
        let mut left_domain = false;
        for _ in 0..MAX_DAMPINGS {
            let velocity = damped.step(&here.removable, self.damping);
            let change = damped.apply(&velocity);
            let expected = change.norm_squared() + 2.0 * self.damping * velocity.norm_squared();
            if let Some(scaled) = self.accelerate(here, &damped, velocity, change) {
                let mut step = scaled.component_div(&self.yardsticks);
                let part = match self.variant {
                    Variant::ShortenedSteps => self.part_inside(here, &step),
                    _ => 1.0,
                };
                step *= part;
                let expected = expected * part * (2.0 - part);
                let there = &here.parameters + step;
                if there == here.parameters {
                    break;
                }
                let sum = self.model.residuals(&there, &mut self.trial);
                let gain = sum.map(|sum| (here.residual_sum_of_squares - sum) / expected);
                left_domain = gain.is_none();
                if let Some(gain) = gain.filter(|gain| *gain > 1e-4) {
                    if let Some(next) = self.model.linearise(there, &self.trial, &mut self.work) {
                        let ease = 1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3);
                        self.damping *= ease.max(1.0 / 3.0);
                        self.growth = 2.0;
                        self.move_to(next);
                        return Some(());
                    }
                    left_domain = true;
                }
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
        }
        if left_domain {
            self.stop = Some(Stop::OutOfDomain);
        }
        None
    }

    /// The part of `step` that goes at most half the way to the edge of the domain, to a half.
    fn part_inside(&mut self, here: &Linearised, step: &DVector<f64>) -> f64 {
        let mut part = 1.0;
        for _ in 0..MAX_DAMPINGS {
            let beyond = &here.parameters + step * (2.0 * part);
            if self.model.residuals(&beyond, &mut self.work).is_some() {
                break;
            }
            part *= 0.5;
        }
        part
    }

    /// Bends a step of the scaled parameters, with the first-order `change` of the residuals it makes in the plane of the
    /// slopes, along the curvature measured on its way; `None` if it is bent so far that the step reaches beyond where the
    /// slopes here hold.
    fn accelerate(
        &mut self,
        here: &Linearised,
        damped: &Damped,
        velocity: DVector<f64>,
        change: DVector<f64>,
    ) -> Option<DVector<f64>> {
        if self.variant == Variant::ShortenedSteps {
            // A step refused as too bent is damped more, and so turned after all.
            return Some(velocity);
        }
        let h = CURVATURE_PROBE;
        let probe = &here.parameters + velocity.component_div(&self.yardsticks) * h;
        if self.model.residuals(&probe, &mut self.work).is_none() {
            return Some(velocity);
        }
        self.work -= &self.residuals;
        let curvature = (here.project(&mut self.work) / h - change) * (2.0 / h);
        let acceleration = damped.step(&curvature, self.damping);
        if acceleration.norm() > MAX_ACCELERATION * velocity.norm() {
            return None;
        }
        Some(velocity + acceleration * 0.5)
    }
}
