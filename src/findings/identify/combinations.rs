//! Finds the combinations of parameters that the runs determine where they do not tell these apart.

use serde::Serialize;

use super::identifiability::Identifiability;
use super::words;
use crate::findings::energy::Energy;
use crate::findings::estimate::Estimate;
use crate::findings::least_squares::LeastSquares;
use crate::findings::scaling::Scaling;
use crate::model::parameters::ParameterKind;
use crate::runs::{rounded_film_ratio, FilmGroup, Runs, Sphere};
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

/// What is determined of the parameters at these places: e_inf where k is among them, the inertial loss where it is not,
/// and only the restitution itself where neither is, or L is among them. Nothing of one parameter by itself.
pub(super) fn find_combinations(
    scene: &Scene,
    runs: &Runs,
    least_squares: LeastSquares,
    identifiability: &Identifiability,
    members: &[usize],
) -> Vec<IdentifiableCombination> {
    let kinds: Vec<ParameterKind> = members.iter().map(|place| identifiability.kinds[*place]).collect();
    let has = |kind: ParameterKind| kinds.contains(&kind);
    let spheres = words::spheres(&kinds);
    // a parameter by itself has no combination, except that C g(δ̃) stands while δ̃0 moves
    if kinds.len() == 1 && !has(ParameterKind::FILM_SCALE) {
        return vec![];
    }
    let found: Vec<IdentifiableCombination> = if has(ParameterKind::LUBRICATION_LOG) {
        vec![]
    } else if spheres.is_empty() {
        inertial_loss(least_squares)
            .or_else(|| loss_of_balance(runs, identifiability))
            .into_iter()
            .collect()
    } else {
        let of = |sphere: &usize| e_inf(scene, least_squares, runs.spheres[*sphere]);
        spheres.iter().filter_map(of).collect()
    };
    if !found.is_empty() {
        return found;
    }
    let all: Vec<usize> = (0..runs.spheres.len()).collect();
    let of = if spheres.is_empty() { &all } else { &spheres };
    of.iter()
        .filter_map(|s| restitution(scene, runs, identifiability, *s))
        .collect()
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
    let rows = rows.map(|row| (&row.loss_over_density_ratio, loss_name(row.film_ratio)));
    // a larger loss says more of C with the same error
    best(rows, |value, se| se / value.abs())
}

/// The same from all runs at once, where dry runs give no e_dry to read it off.
fn loss_of_balance(runs: &Runs, identifiability: &Identifiability) -> Option<IdentifiableCombination> {
    let rebounds = |group: &&FilmGroup| -> usize {
        let series = &runs.series[group.series.clone()];
        series.iter().map(|series| series.rebounds.len()).sum()
    };
    let ratio = runs.film_groups.iter().max_by_key(rebounds)?.film_ratio;
    let found = identifiability.inertial_loss(ratio)?;
    Some(IdentifiableCombination::new(loss_name(ratio), found))
}

fn loss_name(film_ratio: f64) -> String {
    format!("inertial_prefactor·g({})", rounded_film_ratio(film_ratio))
}

/// Restitution of a sphere's series with most rebounds, at its middle speed: what runs tell though they tell no
/// parameter apart.
fn restitution(
    scene: &Scene,
    runs: &Runs,
    identifiability: &Identifiability,
    sphere: usize,
) -> Option<IdentifiableCombination> {
    let all = runs.series.iter().enumerate();
    let own = all.filter(|(_, series)| series.sphere == sphere);
    let (index, series) = own.max_by_key(|(_, series)| series.rebounds.len())?;
    let mut by_speed: Vec<usize> = series.rebounds.clone().collect();
    by_speed.sort_by(|a, b| runs.impact_speed[*a].total_cmp(&runs.impact_speed[*b]));
    let run = *by_speed.get(by_speed.len() / 2)?;
    let found = identifiability.restitution(index, run)?;
    let (sphere, liquid) = (runs.spheres[sphere].label(scene), &scene.liquids[series.liquid].name);
    let st = 1.0 / runs.inverse_stokes(run);
    let ratio = rounded_film_ratio(series.film_ratio);
    let quantity = format!("e[{sphere},{liquid},{ratio}] at St {st:.1}");
    Some(IdentifiableCombination::new(quantity, found))
}
