//! Reads parameters off the fitted laws, with their standard errors, where the laws give them.

use serde::Serialize;

use crate::findings::scaling::{self, Scaling};
use crate::findings::{dry, FitSetup};
use crate::inference::law::Law;
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::physics::{Inertia, Quantity};
use crate::runs::Runs;
use crate::scene::{Scene, WetLaw};

/// Where a parameter lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Marginal {
    /// mean
    pub mean: f64,
    /// standard deviation
    pub sd: f64,
}

/// What one law gives of each parameter: L = St_c e_inf²/2 and C = (e_dry² − e_inf²)/(ρ̃ g), each the mean over particles
/// and film ratios weighted by its standard errors, k by the dry fit, spreads by the residuals.
///
/// A form of inertia with a film scale has no such C: `None`.
pub(super) fn marginals(
    law: WetLaw,
    scene: &Scene,
    runs: &Runs,
    parameters: &ModelParameters,
    inertia: Inertia,
) -> Vec<Option<Marginal>> {
    let dry = dry::fit_dry_laws(scene, runs);
    let setup = FitSetup { scene, runs, dry: &dry };
    let scaling = scaling::fit_scaling(setup);
    let groups = || scaling.iter().filter(|one| one.law == law && one.film_ratio.is_some());
    let l = |one: &Scaling| {
        let (twice, se) = one.estimates[Quantity::StCEInf2].value_and_scale()?;
        Some((0.5 * twice, 0.5 * se))
    };
    let of = |kind: ParameterKind| match kind {
        ParameterKind::DryK(sphere) => dry::fit_of_sphere(&dry, sphere)?.usable,
        ParameterKind::LUBRICATION_LOG => weighted(groups().filter_map(l)),
        ParameterKind::INERTIAL_PREFACTOR if !inertia.has_film_scale() && inertia != Inertia::None => {
            weighted(groups().filter_map(|one| {
                let (loss, se) = one.estimates[Quantity::InertialLoss].value_and_scale()?;
                let shape = inertia.shape(one.film_ratio?, 1.0);
                Some((loss / shape, se / shape))
            }))
        }
        ParameterKind::Shared(_) | ParameterKind::LubricationTrend | ParameterKind::InertialTrend => None,
        ParameterKind::SigmaDry => spread(1, dry.iter().map(|one| (one.residual_sd, one.runs))),
        // least squares has one spread, and normal noise
        ParameterKind::SigmaEnergy | ParameterKind::SigmaSeries | ParameterKind::Shape(_) => None,
        ParameterKind::SigmaWet => {
            let each = groups().map(|one| (one.residual_sd, one.runs));
            spread(Law::Wet(law).parameters(), each)
        }
    };
    let each = parameters.sampled.iter().map(|parameter| of(parameter.kind));
    each.map(|found| found.map(|(mean, sd)| Marginal { mean, sd }))
        .collect()
}

/// Mean by inverse squares of the standard errors.
fn weighted(pairs: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let (mut weights, mut sum) = (0.0, 0.0);
    for (value, se) in pairs {
        let weight = 1.0 / (se * se);
        weights += weight;
        sum += weight * value;
    }
    (weights > 0.0).then(|| (sum / weights, (1.0 / weights).sqrt()))
}

/// One spread from the residual sds and runs of fits of so many parameters each; its own uncertainty is that of a normal
/// sample, σ/√(2ν).
fn spread(parameters: usize, fits: impl Iterator<Item = (Option<f64>, usize)>) -> Option<(f64, f64)> {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for (sd, runs) in fits {
        if let Some(sd) = sd {
            let left = runs.saturating_sub(parameters) as f64;
            squares += left * sd * sd;
            freedom += left;
        }
    }
    let sigma = (squares / freedom).sqrt();
    (freedom > 0.0).then(|| (sigma, sigma / (2.0 * freedom).sqrt()))
}
