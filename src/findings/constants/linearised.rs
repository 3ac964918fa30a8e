//! Moves the energy balance with the constants, from its linearisation at the fit.
//!
//! With g(b, c) the slope of half the weighted squares in the parameters b, which is 0 at the fit for every value of a
//! constant c, db/dc = −(∂g/∂b)⁻¹ ∂g/∂c. Both are central differences of g, so that what the model bends by about runs near
//! sticking, where a residual is no small part of e, is in them.

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::findings::balance::{
    at_place, problem_of, spheres_with_known_k, EnergyBalance, FittedPoint, WetPlaceValues,
};
use crate::findings::places::WetPlace;
use crate::findings::wet_fit::FitSetup;
use crate::inference::descent::descend;
use crate::inference::joint::{Joint, JointFit};

/// Share of a parameter, or of its standard error where that is larger, over which g is differenced: the curves this is
/// for turn within 1e-4 of their values, and slopes are known to 1e-16 of theirs.
const APART: f64 = 1e-7;

/// A fall of the squares by this share of them moves no parameter by a noticeable part of its standard error.
const SMALL: f64 = 1e-14;

/// The balance at the fit, its form and the weights of the runs kept.
pub(super) struct LinearisedBalance<'h> {
    fit: &'h FittedPoint,
    /// b
    point: Vec<f64>,
    /// ∂g/∂b
    curvature: Cholesky<f64, Dyn>,
}

/// A balance at changed constants.
pub(super) struct MovedBalance {
    /// the parameters, in the order of `EnergyBalance::parameters`
    pub(super) parameters: Vec<f64>,
    /// what it says of each place; `None` of one whose sphere is not in it
    pub(super) at_places: Vec<Option<WetPlaceValues>>,
}

/// The balance's problem for a scene and its runs, with the weights that the fit ended with.
fn problem<'r>(FitSetup { scene, runs, dry }: FitSetup<'r>, fit: &FittedPoint) -> JointFit<'r> {
    let known = spheres_with_known_k(runs, dry);
    problem_of(Joint::new(scene, runs, fit.form, &known, &known), dry, fit.spread)
}

impl<'h> LinearisedBalance<'h> {
    /// `None` where the squares have no proper minimum, or the search for it does not get there.
    pub(super) fn new(setup: FitSetup, balance: &'h EnergyBalance) -> Option<Self> {
        let fit = &balance.fitted_point;
        let problem = problem(setup, fit);
        // the squares, and g as their gradient
        let sums = |point: &[f64]| problem.sums_at(&fit.roots, point);
        // where the bias by errors of speeds was taken off, the balance is not at its least squares
        let small = SMALL * sums(&fit.point)?.squares;
        let end = descend(&fit.point, small, sums)?;
        let point = end.converged.then_some(end.point)?;
        let column = |(place, value): (usize, &f64)| {
            let error = balance.parameters[place].estimate.value_and_scale();
            let apart = APART * error.map_or(0.0, |(_, scale)| scale).max(value.abs());
            let at = |step: f64| {
                let mut there = point.clone();
                there[place] += step;
                Some(sums(&there)?.gradient)
            };
            Some((at(apart)? - at(-apart)?) / (2.0 * apart))
        };
        let columns: Option<Vec<DVector<f64>>> = point.iter().enumerate().map(column).collect();
        let curvature = DMatrix::from_columns(&columns?);
        Some(LinearisedBalance {
            fit,
            point,
            curvature: Cholesky::new((&curvature + curvature.transpose()) * 0.5)?,
        })
    }

    /// The balance at two scenes and their runs that lie as far on either side; `None` where the model is undefined.
    pub(super) fn at(&self, settings: [FitSetup; 2]) -> Option<[MovedBalance; 2]> {
        let problems = settings.map(|setup| problem(setup, self.fit));
        let [first, second] = problems
            .each_ref()
            .map(|problem| problem.sums_at(&self.fit.roots, &self.point));
        let apart = self.curvature.solve(&(second?.gradient - first?.gradient));
        let moved = |side: usize, share: f64| {
            let (joint, FitSetup { scene, runs, .. }) = (&problems[side].joint, settings[side]);
            let there = self.point.iter().zip(&apart);
            let parameters: Vec<f64> = there.map(|(value, apart)| value + share * apart).collect();
            let places = WetPlace::all(runs, joint.form);
            let there = |place: &WetPlace| at_place(scene, joint, &parameters, place);
            MovedBalance {
                at_places: places.iter().map(there).collect(),
                parameters,
            }
        };
        Some([moved(0, 0.5), moved(1, -0.5)])
    }
}
