//! Finds the combinations of parameters that the runs determine where they do not tell these apart.

use serde::Serialize;

use crate::findings::energy::Energy;
use crate::findings::estimate::Estimate;
use crate::findings::least_squares::LeastSquares;
use crate::findings::scaling::Scaling;
use crate::model::parameters::ParameterKind;
use crate::runs::{rounded_film_ratio, Runs, Sphere};
use crate::scene::{Scene, WetLaw};

/// A quantity that the runs determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IdentifiableCombination {
    /// its name: `e_inf[PTFE,0.06]`
    pub quantity: String,
    /// its value
    pub value: f64,
    /// its standard error
    pub se: f64,
}

impl IdentifiableCombination {
    fn new(quantity: String, (value, se): (f64, f64)) -> IdentifiableCombination {
        IdentifiableCombination { quantity, value, se }
    }

    /// `e_inf[PTFE,0.06] = 0.7180 ± 0.0040`, to two digits of the standard error.
    pub fn text(&self) -> String {
        let decimals = (1.0 - self.se.log10().floor()).clamp(0.0, 12.0) as usize;
        format!("{} = {:.decimals$} ± {:.decimals$}", self.quantity, self.value, self.se)
    }
}

/// What is determined of the parameters at these places, by the laws at one film ratio: e_inf where k is among them, the
/// inertial loss where it is not. Nothing of one parameter by itself, and nothing where L is among them.
pub(super) fn find_combinations(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    kinds: &[ParameterKind],
) -> Vec<IdentifiableCombination> {
    let has = |kind: ParameterKind| kinds.contains(&kind);
    // a parameter by itself has no combination, except that C g(δ̃) stands while δ̃0 moves
    let is_alone = kinds.len() == 1 && !has(ParameterKind::FILM_SCALE);
    if is_alone || has(ParameterKind::LUBRICATION_LOG) {
        return vec![];
    }
    let mut spheres = kinds.iter().filter_map(|kind| kind.sphere()).peekable();
    if spheres.peek().is_none() {
        return inertial_loss(least_squares).into_iter().collect();
    }
    let of = |sphere: usize| e_inf(scene, least_squares, runs.spheres[sphere]);
    spheres.filter_map(of).collect()
}

/// The best known of some estimates.
fn best<'e>(
    of: impl Iterator<Item = (&'e Estimate, String)>,
    size: impl Fn(f64, f64) -> f64,
) -> Option<IdentifiableCombination> {
    let known = of.filter_map(|(estimate, quantity)| Some(IdentifiableCombination::new(quantity, estimate.pair()?)));
    known.min_by(|a, b| size(a.value, a.se).total_cmp(&size(b.value, b.se)))
}

/// e_inf of a sphere at the film ratio where it is known best.
fn e_inf(scene: &Scene, least_squares: LeastSquares, sphere: Sphere) -> Option<IdentifiableCombination> {
    let of_sphere = |row: &Scaling| sphere.owns(scene, &row.particle, row.diameter_m);
    let own = |row: &&Scaling| row.law == WetLaw::Sqrt && of_sphere(row) && row.verdict.passed;
    let label = sphere.label(scene);
    let rows = least_squares.scaling.iter().filter(own).filter_map(|row| {
        let ratio = rounded_film_ratio(row.film_ratio?);
        Some((&row.e_inf, format!("e_inf[{label},{ratio}]")))
    });
    best(rows, |_, se| se)
}

/// C g(δ̃) at the film ratio where it is known best.
fn inertial_loss(least_squares: LeastSquares) -> Option<IdentifiableCombination> {
    let own = |row: &&Energy| row.law == WetLaw::Sqrt;
    let rows = least_squares.energy.iter().filter(own);
    let rows = rows.map(|row| {
        let ratio = rounded_film_ratio(row.film_ratio);
        (&row.loss_over_density_ratio, format!("inertial_prefactor·g({ratio})"))
    });
    // a larger loss says more of C with the same error
    best(rows, |value, se| se / value.abs())
}
