//! Finds how results move with a constant, on as many runs as the answer needs.

use super::constant::{Constant, InUse};
use super::movable::{Movable, Moved};
use crate::findings::balance::EnergyBalance;
use crate::findings::dry::FittedDry;
use crate::findings::scaling::square_root_of;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// A result whose sensitivity is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Aim {
    /// a parameter of the energy balance
    Parameter(usize),
    /// δc of a particle, from the energy balance
    CriticalSeparation(usize),
    /// a quantity of a place, from the energy balance
    Derived(usize, Quantity),
    /// e_inf or St_c of a film group, by its square-root law
    SquareRoot(usize, Quantity),
}

/// Everything that says how results move.
pub(super) struct Setting<'a> {
    scene: &'a Scene,
    sample: &'a Runs,
    dry: &'a [FittedDry],
    in_use: &'a InUse,
    aims: &'a [Aim],
    balance: Option<Movable<'a>>,
}

impl<'a> Setting<'a> {
    /// `share` of the rebounds are in the sample.
    pub(super) fn new(
        scene: &'a Scene,
        (sample, share): (&'a Runs, f64),
        dry: &'a [FittedDry],
        balance: Option<&'a EnergyBalance>,
        in_use: &'a InUse,
        aims: &'a [Aim],
    ) -> Setting<'a> {
        Setting {
            scene,
            sample,
            dry,
            in_use,
            aims,
            balance: balance.and_then(|balance| Movable::new(scene, sample, dry, balance, share)),
        }
    }

    /// d ln(result)/d ln(constant) of every aim, by central differences; NaN where a fit gives no number.
    pub(super) fn elasticities(&self, constant: Constant, step: f64) -> Vec<f64> {
        let sides = [-step, step].map(|share| self.in_use.moved(self.scene, self.sample, constant, share));
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

    /// e_inf and St_c by the square-root law, of the film groups that are asked for.
    fn square_roots(&self, scene: &Scene, runs: &Runs) -> Vec<Option<[f64; 2]>> {
        let asked = |group: usize| {
            let of_group = |aim: &Aim| matches!(aim, Aim::SquareRoot(wanted, _) if *wanted == group);
            self.aims.iter().any(of_group)
        };
        let square_root = |index: usize| {
            let group = runs.film_groups.get(index).filter(|_| asked(index))?;
            let series: &[Series] = &runs.series[group.series.clone()];
            square_root_of(scene, runs, self.dry, group.particle, series)
        };
        (0..runs.film_groups.len()).map(square_root).collect()
    }

    fn results(&self, scene: &Scene, balance: Option<&Moved>, square_roots: &[Option<[f64; 2]>]) -> Vec<f64> {
        let result = |aim: &Aim| -> Option<f64> {
            match *aim {
                Aim::Parameter(index) => balance?.parameters.get(index).copied(),
                Aim::CriticalSeparation(particle) => {
                    let at = Place {
                        roughness: scene.particles[particle].roughness,
                        ..Place::NONE
                    };
                    let l = *balance?.parameters.first()?;
                    Some(Quantity::DeltaC.value(&at, &Wetted::of_balance(f64::NAN, l)))
                }
                Aim::Derived(place, quantity) => Some(balance?.at_places.get(place)?.as_ref()?.value(quantity)),
                Aim::SquareRoot(group, quantity) => {
                    let [e_inf, st_c] = square_roots[group]?;
                    Some(if quantity == Quantity::StC { st_c } else { e_inf })
                }
            }
        };
        self.aims.iter().map(|aim| result(aim).unwrap_or(f64::NAN)).collect()
    }
}

/// The dry rebounds and about `most` of the wet ones, spread over each series, with the share of the latter among all; at
/// least one a series.
pub(super) fn sample(runs: &Runs, most: usize) -> (Runs, f64) {
    /// multiples of this have parts behind the point that fill [0, 1) evenly, and fall in step with no repeat of a
    /// design
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let all: usize = runs.series.iter().map(|series| series.rebounds.len()).sum();
    let share = if all > most { most as f64 / all as f64 } else { 1.0 };
    let picked = |place: usize| (place as f64 * GOLDEN).fract() < share;
    let sample = runs.with_rebounds(picked);
    let kept: usize = sample.series.iter().map(|series| series.rebounds.len()).sum();
    let share = kept as f64 / all.max(1) as f64;
    (sample, share)
}
