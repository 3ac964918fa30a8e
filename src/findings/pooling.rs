//! Measures what pooling liquids of different density ratio does to the square-root law, without any noise.

use super::balance::{at_place, spheres_with_known_k, EnergyBalance};
use super::places::WetPlace;
use super::scaling::{e_inf_and_st_c, Bias, Scaling};
use super::wet_fit::{two, FitSetup, WetRuns};
use crate::inference::joint::{Joint, Part};
use crate::inference::least_squares::Stop;
use crate::physics::Quantity;
use crate::runs::FilmGroup;
use crate::scene::WetLaw;

/// Fits the square-root law to the noise-free balance at the runs of each film ratio.
///
/// Liquids differ in ρ̃, and so in the inertial loss that the law takes as one; what it then gets wrong is its bias, which
/// stays unknown for spheres outside the balance and where that did not converge.
pub(super) fn add_bias(setup: FitSetup, scaling: &mut [Scaling], balance: &EnergyBalance) {
    if balance.stop != Stop::Converged.as_str() {
        return;
    }
    let FitSetup { scene, runs, dry } = setup;
    let known = spheres_with_known_k(runs, dry);
    let (joint, point) = (
        Joint::new(scene, runs, balance.fitted_point.form, &known, &[]),
        &balance.fitted_point.point,
    );
    // in the order of the series
    let parts: Vec<&Part> = joint.wet_parts().collect();
    let fitted = |row: &&mut Scaling| row.law == WetLaw::Sqrt && !row.is_withheld;
    for row in scaling.iter_mut().filter(fitted) {
        let groups = runs.film_groups_of(row.sphere);
        let of_ratio = |film_ratio: f64| {
            // they stand in increasing order
            let place = groups.partition_point(|group| group.film_ratio < film_ratio);
            groups.get(place).filter(|group| group.film_ratio == film_ratio)
        };
        let group = row.film_ratio.and_then(of_ratio);
        let Some((group, at)) = group.and_then(|group| {
            let place = WetPlace::of_group(runs, group);
            Some((group, at_place(scene, &joint, point, &place)?))
        }) else {
            continue;
        };
        let both = [Quantity::EInf, Quantity::StC].map(|quantity| at.value(quantity));
        if both.iter().all(|x| x.is_finite()) {
            let exact = exact_restitutions(&joint, &parts, point, group);
            row.bias = root_of_exact(setup, &exact, group).map(|of_law| Bias::of(of_law, both));
        }
    }
}

/// Noise-free restitutions at the rebounds of a film group.
fn exact_restitutions(joint: &Joint, parts: &[&Part], point: &[f64], group: &FilmGroup) -> Vec<f64> {
    let start = parts.partition_point(|part| part.series < Some(group.series.start));
    let of_group = parts[start..]
        .iter()
        .take_while(|part| part.series < Some(group.series.end));
    let mut exact = vec![];
    for part in of_group {
        joint.each(part, part.rebounds.clone(), point, |row| exact.push(row.model));
    }
    exact
}

/// e_inf and St_c of the square-root law fitted to noise-free restitutions at the rebounds of a film group.
fn root_of_exact(setup: FitSetup, exact: &[f64], group: &FilmGroup) -> Option<[f64; 2]> {
    let series = &setup.runs.series[group.series.clone()];
    let pool = WetRuns::over_stokes(setup, series);
    // where the balance keeps no energy, the law is not defined and no run would have rebounded
    let keeps = |run: usize| exact.get(run).is_some_and(|e| *e > 0.0);
    let fit = pool.refitted(WetLaw::Sqrt, exact, keeps);
    e_inf_and_st_c(WetLaw::Sqrt, two(&fit))
}
