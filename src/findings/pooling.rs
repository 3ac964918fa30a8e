//! Measures what pooling liquids of different density ratio does to the square-root law, without any noise.

use super::balance::{at_place, spheres_with_known_k, EnergyBalance};
use super::places::WetPlace;
use super::scaling::{e_inf_and_st_c, Bias, Scaling};
use super::wet_fit::{two, FitSetup, WetRuns};
use crate::inference::joint::Joint;
use crate::inference::least_squares::Stop;
use crate::physics::Quantity;
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
    // of each rebound, by its place among the runs
    let mut exact = vec![0.0; runs.len()];
    for part in joint.wet_parts() {
        joint.each(part, part.rebounds.clone(), point, |row| exact[row.run] = row.model);
    }
    let fitted = |row: &&mut Scaling| row.law == WetLaw::Sqrt && !row.is_withheld;
    for row in scaling.iter_mut().filter(fitted) {
        let mut groups = runs.film_groups_of(row.sphere).iter();
        let group = groups.find(|group| Some(group.film_ratio) == row.film_ratio);
        let place = group.map(|group| WetPlace::of_group(runs, group));
        let Some(at) = place.and_then(|place| at_place(scene, &joint, point, &place)) else {
            continue;
        };
        let both = [Quantity::EInf, Quantity::StC].map(|quantity| at.value(quantity));
        if both.iter().all(|x| x.is_finite()) {
            let series = &runs.series[row.series.clone()];
            let exact = series.iter().flat_map(|one| &exact[one.rebounds.clone()]);
            let exact: Vec<f64> = exact.copied().collect();
            // where the balance keeps no energy, the law is not defined and no run would have rebounded
            let fit = WetRuns::over_stokes(setup, series).refitted(WetLaw::Sqrt, &exact, |run| exact[run] > 0.0);
            row.bias = e_inf_and_st_c(WetLaw::Sqrt, two(&fit)).map(|of_law| Bias::of(of_law, both));
        }
    }
}
