//! Finds how results move with a constant.

use super::constant::{Constant, MaterialsInUse};
use super::linearised::{LinearisedBalance, MovedBalance};
use super::sample::RunSample;
use crate::findings::dry::FittedDry;
use crate::findings::scaling::square_root_of;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// A result whose sensitivity is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Output {
    /// a parameter of the energy balance
    Parameter(usize),
    /// δc of a particle, from the energy balance
    CriticalSeparation(usize),
    /// a quantity of a place, from the energy balance
    Derived(usize, Quantity),
    /// e_inf or St_c of a film group, by its square-root law
    SquareRoot(usize, Quantity),
}

/// What a sensitivity analysis of some results rests on.
pub(super) struct SensitivityAnalysis<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sample: &'a RunSample,
    pub(super) dry: &'a [FittedDry],
    pub(super) in_use: &'a MaterialsInUse,
    pub(super) outputs: &'a [Output],
    /// the energy balance at the fit; `None` without one
    pub(super) balance: Option<LinearisedBalance<'a>>,
}

impl SensitivityAnalysis<'_> {
    /// d ln(result)/d ln(constant) of every output, by central differences; NaN where a fit gives no number.
    pub(super) fn elasticities(&self, constant: Constant, step: f64) -> Vec<f64> {
        let sides = [-step, step].map(|share| self.in_use.perturbed(self.scene, &self.sample.runs, constant, share));
        let settings = sides.each_ref().map(|(scene, runs)| (scene, &**runs));
        let balances = self.balance.as_ref().and_then(|balance| balance.at(settings));
        let [less, more] = [0, 1].map(|side| {
            let (scene, runs) = settings[side];
            let balance = balances.as_ref().map(|balances| &balances[side]);
            self.results(scene, balance, &self.square_roots(scene, runs))
        });
        // a power law has no other error than rounding in logarithms
        let slope = |(more, less): (&f64, &f64)| (more / less).ln() / (2.0 * step);
        more.iter().zip(&less).map(slope).collect()
    }

    /// e_inf and St_c by the square-root law, of the film groups that are among the outputs.
    fn square_roots(&self, scene: &Scene, runs: &Runs) -> Vec<Option<[f64; 2]>> {
        let is_output = |group: usize| {
            let of_group = |output: &Output| matches!(output, Output::SquareRoot(wanted, _) if *wanted == group);
            self.outputs.iter().any(of_group)
        };
        let square_root = |index: usize| {
            let group = runs.film_groups.get(index).filter(|_| is_output(index))?;
            let series: &[Series] = &runs.series[group.series.clone()];
            square_root_of(scene, runs, self.dry, group.sphere, series)
        };
        (0..runs.film_groups.len()).map(square_root).collect()
    }

    fn results(&self, scene: &Scene, balance: Option<&MovedBalance>, square_roots: &[Option<[f64; 2]>]) -> Vec<f64> {
        let result = |output: &Output| -> Option<f64> {
            match *output {
                Output::Parameter(index) => balance?.parameters.get(index).copied(),
                Output::CriticalSeparation(particle) => {
                    let at = Place {
                        roughness: scene.particles[particle].roughness,
                        ..Place::NONE
                    };
                    let l = *balance?.parameters.first()?;
                    Some(Quantity::DeltaC.value(&at, &Wetted::of_balance(f64::NAN, l)))
                }
                Output::Derived(place, quantity) => Some(balance?.at_places.get(place)?.as_ref()?.value(quantity)),
                Output::SquareRoot(group, quantity) => {
                    let [e_inf, st_c] = square_roots[group]?;
                    Some(if quantity == Quantity::StC { st_c } else { e_inf })
                }
            }
        };
        self.outputs
            .iter()
            .map(|output| result(output).unwrap_or(f64::NAN))
            .collect()
    }
}
