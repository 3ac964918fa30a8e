//! Reads parameters off the fitted laws, with normal uncertainties, where the laws give them.

use super::results::Marginal;
use crate::findings::dry::FittedDry;
use crate::findings::energy::Energy;
use crate::findings::scaling::FittedScaling;
use crate::inference::law::Law;
use crate::model::parameters::{ModelParameters, ParameterKind};
use crate::physics::inertia::Inertia;
use crate::scene::WetLaw;

/// Φ⁻¹(0.95).
const NORMAL_95: f64 = 1.644_853_626_951_472_2;

/// The fits of least squares that parameters are read from.
pub(super) struct TradeLaws<'f> {
    pub dry: &'f [FittedDry],
    pub scaling: &'f [FittedScaling],
    pub energy: &'f [Energy],
}

/// What one law gives of each parameter: L = St_c e_inf²/2 and C = (e_dry² − e_inf²)/(ρ̃ g), each the mean over particles
/// and film ratios weighted by its standard errors, k by the dry fit, spreads by the residuals.
///
/// A form of inertia with a film scale has no such C: `None`.
pub(super) fn by_law(
    law: WetLaw,
    parameters: &ModelParameters,
    inertia: Inertia,
    fits: &TradeLaws,
) -> Vec<Option<Marginal>> {
    let of = |kind: ParameterKind| match kind {
        ParameterKind::DryK(sphere) => {
            let fitted = fits.dry.iter().find(|dry| dry.sphere == sphere)?;
            fitted.usable.map(normal)
        }
        ParameterKind::LUBRICATION_LOG => {
            let groups = fits.scaling.iter().filter(|one| one.law == law);
            weighted(groups.filter_map(|one| {
                one.scaling
                    .film_ratio
                    .and(one.scaling.lubrication_log.value_and_scale())
            }))
        }
        ParameterKind::INERTIAL_PREFACTOR if !inertia.has_film_scale() && inertia != Inertia::None => {
            let groups = fits.energy.iter().filter(|one| one.law == law);
            weighted(groups.filter_map(|one| {
                let (loss, se) = one.loss_over_density_ratio.value_and_scale()?;
                let shape = inertia.shape(one.film_ratio, 1.0);
                Some((loss / shape, se / shape))
            }))
        }
        ParameterKind::Shared(_) | ParameterKind::LubricationTrend | ParameterKind::InertialTrend => None,
        ParameterKind::SigmaDry => spread(1, fits.dry.iter().map(|one| (one.dry.residual_sd, one.dry.runs))),
        // least squares has one spread, and normal noise
        ParameterKind::SigmaEnergy | ParameterKind::SigmaSeries | ParameterKind::Nu => None,
        ParameterKind::SigmaWet => {
            let groups = fits.scaling.iter().filter(|one| one.law == law);
            let each = groups.filter(|one| one.scaling.film_ratio.is_some());
            let each = each.map(|one| (one.scaling.residual_sd, one.scaling.runs));
            spread(Law::Wet(law).parameters(), each)
        }
    };
    parameters.sampled.iter().map(|parameter| of(parameter.kind)).collect()
}

fn normal((mean, sd): (f64, f64)) -> Marginal {
    Marginal {
        mean,
        sd,
        q05: mean - NORMAL_95 * sd,
        q95: mean + NORMAL_95 * sd,
    }
}

/// Mean by inverse squares of the standard errors.
fn weighted(pairs: impl Iterator<Item = (f64, f64)>) -> Option<Marginal> {
    let (mut weights, mut sum) = (0.0, 0.0);
    for (value, se) in pairs {
        let weight = 1.0 / (se * se);
        weights += weight;
        sum += weight * value;
    }
    (weights > 0.0).then(|| normal((sum / weights, (1.0 / weights).sqrt())))
}

/// One spread from the residual sds and runs of fits of so many parameters each; its own uncertainty is that of a normal
/// sample, σ/√(2ν).
fn spread(parameters: usize, fits: impl Iterator<Item = (Option<f64>, usize)>) -> Option<Marginal> {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for (sd, runs) in fits {
        if let Some(sd) = sd {
            let left = runs.saturating_sub(parameters) as f64;
            squares += left * sd * sd;
            freedom += left;
        }
    }
    let sigma = (squares / freedom).sqrt();
    (freedom > 0.0).then(|| normal((sigma, sigma / (2.0 * freedom).sqrt())))
}
