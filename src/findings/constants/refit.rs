//! Refits the energy balance at constants changed by a little, by one step from its minimum.

use crate::findings::balance::{
    at_place, error_columns, problem_of, spheres_with_known_k, EnergyBalance, RefitStart, WetPlaceValues,
};
use crate::findings::dry::FittedDry;
use crate::findings::places::WetPlace;
use crate::inference::effective_variance::{reweight, roots, WeightedProblem};
use crate::inference::joint::{refit, Joint, JointFit};
use crate::inference::least_squares::Minimum;
use crate::runs::Runs;
use crate::scene::Scene;

/// The minimum of the balance of some of the runs, from which it is refitted at changed constants.
pub(super) struct BalanceMinimum<'h> {
    refit_start: &'h RefitStart,
    dry: &'h [FittedDry],
    known: Vec<usize>,
    /// the spread that weighs dry runs against these wet ones
    spread: f64,
    /// roots of the runs' weights; empty where they carry no errors
    roots: Vec<f64>,
    minimum: Minimum,
}

/// A balance refitted at changed constants.
pub(super) struct RefittedBalance {
    /// the parameters, in the order of `EnergyBalance::parameters`
    pub(super) parameters: Vec<f64>,
    /// what it says of each place; `None` of one whose sphere is not in it
    pub(super) at_places: Vec<Option<WetPlaceValues>>,
}

impl<'h> BalanceMinimum<'h> {
    /// Fits the balance again from where it ended, its form and the weight of the dry runs kept; `share` of the wet
    /// rebounds are among these runs, which the dry ones are weighed down to. `None` unless that converges on a minimum
    /// with standard errors.
    pub(super) fn new(
        scene: &Scene,
        runs: &Runs,
        dry: &'h [FittedDry],
        balance: &'h EnergyBalance,
        share: f64,
    ) -> Option<Self> {
        let refit_start = &balance.refit_start;
        let known = spheres_with_known_k(runs, dry);
        let joint = Joint::new(scene, runs, refit_start.form, &known, &known);
        let mut spread = refit_start.spread * share.sqrt();
        let mut problem = problem_of(joint, dry, spread);
        let mut fit = refit(&problem, &[], &refit_start.point);
        let mut of_runs = vec![];
        if let Some(errors) = error_columns(scene, &problem.joint) {
            let in_errors = problem_of(problem.joint.clone(), dry, share.sqrt());
            let weighed = reweight(&errors, fit.clone(), |_| in_errors.clone());
            if let Some(weighing) = weighed.1 {
                let mut variance = weighing.variance;
                variance.resize(variance.len() + in_errors.dry_roots.len(), 1.0);
                of_runs = roots(&variance).0;
                fit = refit(&in_errors, &of_runs, &refit_start.point);
                spread = share.sqrt();
                problem = in_errors;
            }
        }
        let weighted = WeightedProblem {
            problem: &problem,
            roots: &of_runs,
        };
        let minimum = Minimum::new(&weighted, &fit)?;
        Some(BalanceMinimum {
            refit_start,
            dry,
            known,
            spread,
            roots: of_runs,
            minimum,
        })
    }

    /// The balance refitted at two scenes and their runs that lie as far on either side: of the first, of the second.
    pub(super) fn refit_at(&self, settings: [(&Scene, &Runs); 2]) -> Option<[RefittedBalance; 2]> {
        let [first, second] = settings.map(|(scene, runs)| {
            let joint = Joint::new(scene, runs, self.refit_start.form, &self.known, &self.known);
            problem_of(joint, self.dry, self.spread)
        });
        let weighted = [&first, &second].map(|problem| WeightedProblem {
            problem,
            roots: &self.roots,
        });
        let [of_first, of_second] = self.minimum.of_neighbours(&weighted[0], &weighted[1])?;
        Some([
            at_point(settings[0].0, &first, of_first),
            at_point(settings[1].0, &second, of_second),
        ])
    }
}

fn at_point(scene: &Scene, problem: &JointFit, parameters: Vec<f64>) -> RefittedBalance {
    let joint = &problem.joint;
    let places = WetPlace::all(joint.runs, joint.form);
    let at_places = places.iter().map(|place| at_place(scene, joint, &parameters, place));
    RefittedBalance {
        at_places: at_places.collect(),
        parameters,
    }
}
