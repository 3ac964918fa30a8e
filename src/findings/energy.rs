//! Estimates where the energy went: the inertial loss over the density ratio, St_c·e_inf² and δc, by both laws.

use serde::Serialize;

use super::dry::{self, FittedDry};
use super::estimate::{Estimate, Quoting, Scale};
use super::scaling::FittedScaling;
use crate::physics::inertia::Inertia;
use crate::physics::viscous::critical_separation;
use crate::runs::{Runs, Series};
use crate::scene::{Scene, WetLaw};

/// The energy balance of one particle at one film ratio, by one law.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Energy {
    /// name of the particle
    pub particle: String,
    /// film ratio
    pub film_ratio: f64,
    /// `linear` or `sqrt`
    pub law: &'static str,
    /// ρ̃, mean over the rebounds used
    pub density_ratio: f64,
    /// (e_dry² − e_inf²)/ρ̃ at the reference dry speed
    pub loss_over_density_ratio: Estimate,
    /// eq. Eint2 at this film ratio
    pub stepwise: f64,
    /// eq. Eint1 at this film ratio; `None` beyond 0.39, where it falls
    pub cap: Option<f64>,
    /// St_c e_inf² = 2 L
    pub st_c_e_inf2: Estimate,
    /// δc = ε exp(L), m
    pub delta_c_m: Estimate,
}

/// The energy table, in the order of the scaling table.
pub fn find(scene: &Scene, runs: &Runs, dry: &[FittedDry], scaling: &[FittedScaling], quoting: Quoting) -> Vec<Energy> {
    scaling
        .iter()
        .filter_map(|fitted| {
            let film_ratio = fitted.scaling.film_ratio?;
            Some(of_group(scene, runs, dry, fitted, film_ratio, quoting))
        })
        .collect()
}

fn of_group(
    scene: &Scene,
    runs: &Runs,
    dry: &[FittedDry],
    fitted: &FittedScaling,
    film_ratio: f64,
    quoting: Quoting,
) -> Energy {
    let particle = &scene.particles[fitted.particle];
    let series = &runs.series[fitted.series.clone()];
    let density_ratio = density_ratio(scene, fitted.particle, series);
    let cap = Inertia::Cap;
    let lubrication_log = &fitted.scaling.lubrication_log;
    let scaled = |factor: f64| match (lubrication_log.pair(), lubrication_log.value) {
        (Some((l, se)), _) => quoting.with_se(
            factor * l,
            factor * se,
            fitted.uncertain.degrees_of_freedom,
            Scale::Plain,
        ),
        (None, value) => quoting.without_se(value.map(|l| factor * l), why(lubrication_log)),
    };
    let delta_c = |l: f64| critical_separation(particle.roughness, l);
    let delta_c_m = match (lubrication_log.pair(), lubrication_log.value) {
        (Some((l, se)), _) => quoting.with_se(
            delta_c(l),
            delta_c(l) * se,
            fitted.uncertain.degrees_of_freedom,
            Scale::Log,
        ),
        (None, value) => quoting.without_se(value.map(delta_c), why(lubrication_log)),
    };
    Energy {
        particle: particle.name.clone(),
        film_ratio,
        law: fitted.law.name(),
        density_ratio,
        loss_over_density_ratio: loss(scene, dry, fitted, density_ratio, quoting),
        stepwise: Inertia::Stepwise.shape(film_ratio, 1.0),
        cap: (film_ratio <= cap.valid_to()).then(|| cap.shape(film_ratio, 1.0)),
        st_c_e_inf2: scaled(2.0),
        delta_c_m,
    }
}

fn why(estimate: &Estimate) -> String {
    estimate.why_none.clone().unwrap_or_default()
}

/// ρ̃ of some series of one particle, weighted by their rebounds; by the series where none rebounded.
pub(super) fn density_ratio(scene: &Scene, particle: usize, series: &[Series]) -> f64 {
    let density = scene.particles[particle].density;
    let ratio = |one: &Series| scene.liquids[one.liquid].density / density;
    let rebounds: usize = series.iter().map(|s| s.rebounds.len()).sum();
    if rebounds == 0 {
        return series.iter().map(ratio).sum::<f64>() / series.len() as f64;
    }
    series.iter().map(|s| s.rebounds.len() as f64 * ratio(s)).sum::<f64>() / rebounds as f64
}

/// (e_dry² − e_inf²)/ρ̃ with the uncertainties of k and of the fit, and what they share.
fn loss(scene: &Scene, dry: &[FittedDry], fitted: &FittedScaling, density_ratio: f64, quoting: Quoting) -> Estimate {
    let usable = dry::of(dry, fitted.particle).and_then(|dry| dry.usable);
    let Some((k, k_se)) = usable else {
        return quoting.none("the particle has no usable dry runs, so e_dry is not known");
    };
    let Some(e_inf) = fitted.scaling.e_inf.value else {
        return quoting.none(why(&fitted.scaling.e_inf));
    };
    let v = scene.model.dry_speed.reference();
    let law = scene.model.form().dry;
    let e_dry = law.restitution(k, v);
    if e_dry <= 0.0 {
        return quoting.none("e_dry is not positive at the reference speed");
    }
    let value = (e_dry * e_dry - e_inf * e_inf) / density_ratio;
    // e_inf² is α of the square root, the square of the intercept of the line
    let slope = match fitted.law {
        WetLaw::Sqrt => 1.0,
        WetLaw::Linear => 2.0 * e_inf,
    };
    let k_slope = 2.0 * e_dry * law.slope_dry_k(k, v);
    let covariance = match &fitted.uncertain.covariance {
        Ok(covariance) => covariance,
        Err(why) => return quoting.without_se(Some(value), why.clone()),
    };
    let with_k = fitted.shift_by_dry_k[0] * k_se * k_se;
    let variance =
        k_slope * k_slope * k_se * k_se + slope * slope * covariance[(0, 0)] - 2.0 * k_slope * slope * with_k;
    if variance <= 0.0 || !variance.is_finite() {
        return quoting.without_se(Some(value), "its standard error is not a positive number");
    }
    let se = variance.sqrt() / density_ratio;
    quoting.with_se(value, se, fitted.uncertain.degrees_of_freedom, Scale::Plain)
}
