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

/// A problem with the count of its evaluations. (argmin's own count, a hash map, takes a tenth of a small
/// fit.)
pub(super) struct Model<'a, P> {
    problem: &'a P,
    pub(super) evaluations: usize,
    /// Whether any point was outside the domain.
    pub(super) met_edge: bool,
}

impl<'a, P> Model<'a, P> {
    pub(super) fn new(problem: &'a P) -> Self {
        Self {
            problem,
            evaluations: 0,
            met_edge: false,
        }
    }
}

/// The state of one attempt.
pub(super) struct LevenbergMarquardt {
    variant: Variant,
    /// The current point.
    pub(super) current: Option<Linearised>,
    /// its relative offset
    offset: f64,
    residuals: DVector<f64>,
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

/// A step of the scaled parameters, before acceleration.
struct Proposal {
    velocity: DVector<f64>,
    /// first-order change of the residuals it makes, in the plane of the slopes
    change: DVector<f64>,
}

/// What a proposed step led to.
enum Step {
    Taken,
    Refused,
}

impl LevenbergMarquardt {
    pub(super) fn new(runs: usize, parameters: usize, variant: Variant) -> Self {
        Self {
            variant,
            current: None,
            offset: f64::INFINITY,
            residuals: DVector::zeros(runs),
            trial: DVector::zeros(runs),
            work: DVector::zeros(runs),
            yardsticks: DVector::zeros(parameters),
            damping: FIRST_DAMPING,
            growth: 2.0,
            refused_at: f64::INFINITY,
            at_edge: None,
            stop: None,
        }
    }

    /// Begins at `start`; stopped at once if the model is undefined or nothing is left to gain there.
    pub(super) fn begin<P: ResidualProblem>(&mut self, model: &mut Model<P>, start: DVector<f64>) {
        let sum = residuals_at(model, &start, &mut self.trial);
        match sum.and_then(|_| linearise_at(model, start, &self.trial, &mut self.work)) {
            Some(first) => self.move_to(first),
            None => self.stop = Some(Stop::OutOfDomain),
        }
    }

    /// Takes one step, or stops.
    pub(super) fn iterate<P: ResidualProblem>(&mut self, model: &mut Model<P>) {
        let Some(here) = self.current.take() else {
            return;
        };
        let offset = self.offset;
        let mut step = Step::Refused;
        let near = offset < UNDAMPED_BELOW || here.removable_share() < UNDAMPED_BELOW_SHARE;
        if near && offset < 0.1 * self.refused_at {
            step = self.undamped_step(model, &here);
            if matches!(step, Step::Refused) {
                self.refused_at = offset;
                if here.scatter() > NEWTON_SCATTER * here.scale {
                    step = self.newton_step(model, &here);
                }
            }
        }
        let settled = here.at_rounding() || offset <= 1e-8;
        if matches!(step, Step::Refused) && !settled {
            step = self.damped_step(model, &here);
        }
        if matches!(step, Step::Refused) {
            self.stop = Some(match self.stop {
                _ if settled || offset <= LOOSE => Stop::Converged,
                Some(stop) => stop,
                None => Stop::MaxIterations,
            });
        }
        let sum = self.current.get_or_insert(here).residual_sum_of_squares;
        if model.met_edge && self.stop.is_none() {
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
    fn undamped_step<P: ResidualProblem>(&mut self, model: &mut Model<P>, here: &Linearised) -> Step {
        let Some(step) = here.gauss_newton_step() else {
            return Step::Refused;
        };
        self.take_if_flatter(model, here, &here.parameters + step)
    }

    /// Tries Newton's step, for curves so bent that undamped steps overshoot for ever (runs close
    /// to a square root's edge). What the slopes leave out of the curvature is measured by
    /// differences of the gradient.
    fn newton_step<P: ResidualProblem>(&mut self, model: &mut Model<P>, here: &Linearised) -> Step {
        let Some(axes) = here.axes() else {
            return Step::Refused;
        };
        let apart = NEWTON_PROBE * here.scatter();
        let p = here.parameters.len();
        let mut curvature = DMatrix::zeros(p, p);
        for (axis, mut column) in axes.column_iter().zip(curvature.column_iter_mut()) {
            let probe = &here.parameters + axis * apart;
            let Some(_) = residuals_at(model, &probe, &mut self.trial) else {
                return Step::Refused;
            };
            let Some(there) = linearise_at(model, probe, &self.trial, &mut self.work) else {
                return Step::Refused;
            };
            column.copy_from(&((there.gradient_along(&axes) - &here.removable) / apart));
        }
        let symmetric = (&curvature + curvature.transpose()) * 0.5;
        // Without a positive curvature in every direction there is no minimum to step to.
        let Some(root) = Cholesky::new(symmetric) else {
            return Step::Refused;
        };
        let step = axes * root.solve(&here.removable);
        self.take_if_flatter(model, here, &here.parameters - step)
    }

    /// Moves `there` if that leaves clearly less to remove.
    fn take_if_flatter<P: ResidualProblem>(
        &mut self,
        model: &mut Model<P>,
        here: &Linearised,
        there: DVector<f64>,
    ) -> Step {
        let Some(sum) = residuals_at(model, &there, &mut self.trial) else {
            return Step::Refused;
        };
        if sum > here.residual_sum_of_squares * 1.1 && !here.at_rounding() {
            return Step::Refused;
        }
        let Some(next) = linearise_at(model, there, &self.trial, &mut self.work) else {
            return Step::Refused;
        };
        if next.removable.norm() > UNDAMPED_GAIN * here.removable.norm() {
            return Step::Refused;
        }
        self.move_to(next);
        Step::Taken
    }

    /// Tries dampings, each greater than the last, until one lowers the sum of squares.
    fn damped_step<P: ResidualProblem>(&mut self, model: &mut Model<P>, here: &Linearised) -> Step {
        let Some(damped) = Damped::new(here, &self.yardsticks) else {
            return Step::Refused;
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
            let accelerated = self.accelerate(model, here, &damped, Proposal { velocity, change });
            if let Some(scaled) = accelerated {
                let mut step = scaled.component_div(&self.yardsticks);
                let part = match self.variant {
                    Variant::ShortenedSteps => self.part_inside(model, here, &step),
                    _ => 1.0,
                };
                step *= part;
                let expected = expected * part * (2.0 - part);
                let there = &here.parameters + step;
                if there == here.parameters {
                    break;
                }
                match residuals_at(model, &there, &mut self.trial) {
                    None => left_domain = true,
                    Some(sum) => {
                        left_domain = false;
                        let gain = (here.residual_sum_of_squares - sum) / expected;
                        if gain > 1e-4 {
                            match linearise_at(model, there, &self.trial, &mut self.work) {
                                None => left_domain = true,
                                Some(next) => {
                                    let ease = 1.0 - (2.0 * gain.min(1.0) - 1.0).powi(3);
                                    self.damping *= ease.max(1.0 / 3.0);
                                    self.growth = 2.0;
                                    self.move_to(next);
                                    return Step::Taken;
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
        Step::Refused
    }

    /// The part of `step` that goes at most half the way to the edge of the domain, to a half.
    fn part_inside<P: ResidualProblem>(&mut self, model: &mut Model<P>, here: &Linearised, step: &DVector<f64>) -> f64 {
        let mut part = 1.0;
        for _ in 0..MAX_DAMPINGS {
            let beyond = &here.parameters + step * (2.0 * part);
            if residuals_at(model, &beyond, &mut self.work).is_some() {
                break;
            }
            part *= 0.5;
        }
        part
    }

    /// Bends the step along the curvature measured on its way; `None` if it is bent so far
    /// that the step reaches beyond where the slopes here hold.
    fn accelerate<P: ResidualProblem>(
        &mut self,
        model: &mut Model<P>,
        here: &Linearised,
        damped: &Damped,
        Proposal { velocity, change }: Proposal,
    ) -> Option<DVector<f64>> {
        if self.variant == Variant::ShortenedSteps {
            // A step refused as too bent is damped more, and so turned after all.
            return Some(velocity);
        }
        let h = CURVATURE_PROBE;
        let probe = &here.parameters + velocity.component_div(&self.yardsticks) * h;
        if residuals_at(model, &probe, &mut self.work).is_none() {
            return Some(velocity);
        }
        self.work -= &self.residuals;
        let curvature = (here.project(&mut self.work) / h - change) * (2.0 / h);
        let acceleration = damped.step(&curvature, self.damping)?;
        if acceleration.norm() > MAX_ACCELERATION * velocity.norm() {
            return None;
        }
        Some(velocity + acceleration * 0.5)
    }
}

/// Sum of squares at `parameters`, the residuals going into `out`; `None` outside the domain,
/// which a residual that is not a finite number counts as.
fn residuals_at<P: ResidualProblem>(
    model: &mut Model<P>,
    parameters: &DVector<f64>,
    out: &mut DVector<f64>,
) -> Option<f64> {
    if !parameters.iter().all(|b| b.is_finite()) {
        return None;
    }
    model.evaluations += 1;
    let inside = model.problem.residuals(parameters.as_slice(), out.as_mut_slice());
    let sum = out.norm_squared();
    if inside.is_err() || !sum.is_finite() {
        model.met_edge = true;
        return None;
    }
    Some(sum)
}

/// The triangle at `parameters`, whose `residuals` are known; `None` outside the domain.
fn linearise_at<P: ResidualProblem>(
    model: &mut Model<P>,
    parameters: DVector<f64>,
    residuals: &DVector<f64>,
    work: &mut DVector<f64>,
) -> Option<Linearised> {
    model.evaluations += 1;
    let model = model.problem;
    let mut jacobian = DMatrix::zeros(model.runs(), model.parameters());
    if model.jacobian(parameters.as_slice(), &mut jacobian).is_err() {
        return None;
    }
    Linearised::new(parameters, residuals, jacobian, work, model.scale())
}
