//! Moves the energy balance with the constants, from its linearisation at the fit.

use nalgebra::{DMatrix, DVector};

use super::sample::RunSample;
use crate::findings::balance::{at_place, problem_of, spheres_with_known_k, EnergyBalance, RefitStart, WetPlaceValues};
use crate::findings::dry::FittedDry;
use crate::findings::places::WetPlace;
use crate::inference::effective_variance::WeightedProblem;
use crate::inference::joint::{Joint, JointFit};
use crate::inference::least_squares::ResidualProblem;
use crate::runs::Runs;
use crate::scene::Scene;

/// The balance as it stands at the fit, its form and the weights of the runs kept: with J the weighted slopes, QR = J.
pub(super) struct LinearisedBalance<'h> {
    fit: &'h RefitStart,
    dry: &'h [FittedDry],
    known: Vec<usize>,
    /// the spread that weighs dry runs against the wet ones of the sample
    spread: f64,
    /// roots of the runs' weights; empty where they carry no errors
    roots: Vec<f64>,
    /// Q
    basis: DMatrix<f64>,
    /// R
    triangle: DMatrix<f64>,
}

/// A balance at changed constants.
pub(super) struct MovedBalance {
    /// the parameters, in the order of `EnergyBalance::parameters`
    pub(super) parameters: Vec<f64>,
    /// what it says of each place; `None` of one whose sphere is not in it
    pub(super) at_places: Vec<Option<WetPlaceValues>>,
}

impl<'h> LinearisedBalance<'h> {
    /// Some of the wet rebounds stand for all, which the dry ones are weighed down to; `None` where the model is undefined.
    pub(super) fn new(
        scene: &Scene,
        runs: &Runs,
        sample: &RunSample,
        dry: &'h [FittedDry],
        balance: &'h EnergyBalance,
    ) -> Option<Self> {
        let fit = &balance.refit_start;
        let known = spheres_with_known_k(runs, dry);
        let wet = runs.series.iter().filter(|series| known.contains(&series.sphere));
        let places = wet.flat_map(|series| 0..series.rebounds.len());
        let sampled = places.zip(&fit.roots).filter(|(place, _)| sample.holds(*place));
        let mut linearised = LinearisedBalance {
            fit,
            dry,
            spread: fit.spread * sample.share.sqrt(),
            roots: sampled.map(|(_, root)| *root).collect(),
            known,
            basis: DMatrix::zeros(0, 0),
            triangle: DMatrix::zeros(0, 0),
        };
        let problem = linearised.problem(scene, &sample.runs);
        let weighted = linearised.weighted(&problem);
        let mut jacobian = DMatrix::zeros(weighted.runs(), weighted.parameters());
        weighted.jacobian(&fit.point, &mut jacobian).ok()?;
        (linearised.basis, linearised.triangle) = jacobian.qr().unpack();
        Some(linearised)
    }

    fn problem<'r>(&self, scene: &Scene, runs: &'r Runs) -> JointFit<'r> {
        let joint = Joint::new(scene, runs, self.fit.form, &self.known, &self.known);
        problem_of(joint, self.dry, self.spread)
    }

    fn weighted<'p, 'r>(&'p self, problem: &'p JointFit<'r>) -> WeightedProblem<'p, JointFit<'r>> {
        WeightedProblem {
            problem,
            roots: &self.roots,
        }
    }

    /// The balance at two scenes and their runs that lie as far on either side: with Δe what the second does to the
    /// restitutions beyond the first, the parameters differ by −(JᵀJ)⁻¹JᵀΔe = −R⁻¹QᵀΔe.
    pub(super) fn at(&self, settings: [(&Scene, &Runs); 2]) -> Option<[MovedBalance; 2]> {
        let problems = settings.map(|(scene, runs)| self.problem(scene, runs));
        let residuals = |problem: &JointFit| {
            let mut residuals = DVector::zeros(problem.runs());
            let found = self
                .weighted(problem)
                .residuals(&self.fit.point, residuals.as_mut_slice());
            found.ok().map(|()| residuals)
        };
        let effect = residuals(&problems[1])? - residuals(&problems[0])?;
        let apart = self.triangle.solve_upper_triangular(&self.basis.tr_mul(&effect))?;
        let moved = |side: usize, share: f64| {
            let (joint, (scene, runs)) = (&problems[side].joint, settings[side]);
            let there = self.fit.point.iter().zip(&apart);
            let parameters: Vec<f64> = there.map(|(value, apart)| value + share * apart).collect();
            let places = WetPlace::all(runs, joint.form);
            MovedBalance {
                at_places: places
                    .iter()
                    .map(|place| at_place(scene, joint, &parameters, place))
                    .collect(),
                parameters,
            }
        };
        Some([moved(0, 0.5), moved(1, -0.5)])
    }
}
