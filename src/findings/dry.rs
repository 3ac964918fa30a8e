//! Estimates k of each particle from its dry runs, and whether one k serves all diameters.

use serde::Serialize;

use super::estimate::{Estimate, Quoting, Scale};
use super::judge::{spread, uncertain, why_stopped};
use super::Verdict;
use crate::inference::laws::fit_dry;
use crate::inference::least_squares::{Fit, Stop};
use crate::inference::nested::{one_law_for_all, FTest, Spread};
use crate::physics::dry::speed_limit;
use crate::runs::{DryGroup, Runs};
use crate::scene::Scene;

/// k of one particle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dry {
    /// name of the particle
    pub particle: String,
    /// dry runs used
    pub runs: usize,
    /// dry runs with no rebound, left out
    pub stuck: usize,
    /// k over all diameters, (m/s)^(-1/5)
    pub dry_k: Estimate,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// k of each diameter
    pub by_diameter: Vec<DryOfDiameter>,
    /// one k for all diameters against one k each; `None` with a single diameter
    pub heterogeneity: Option<FTest>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether k may be quoted
    pub verdict: Verdict,
}

/// k of one particle at one diameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DryOfDiameter {
    /// D, m
    pub diameter_m: f64,
    /// dry runs used
    pub runs: usize,
    /// k, (m/s)^(-1/5)
    pub dry_k: Estimate,
}

/// A dry estimate with what later steps need of it.
#[derive(Debug)]
pub struct FittedDry {
    /// index into the scene's particles
    pub particle: usize,
    /// k and its standard error, where it may be used
    pub usable: Option<(f64, f64)>,
    /// what is told
    pub dry: Dry,
}

/// k of every particle that has dry runs, in the scene's order.
pub fn find(scene: &Scene, runs: &Runs, quoting: Quoting) -> Vec<FittedDry> {
    (0..scene.particles.len())
        .filter_map(|particle| {
            let groups: Vec<&DryGroup> = runs.dry.iter().filter(|group| group.particle == particle).collect();
            (!groups.is_empty()).then(|| of_particle(scene, runs, particle, &groups, quoting))
        })
        .collect()
}

fn of_particle(scene: &Scene, runs: &Runs, particle: usize, groups: &[&DryGroup], quoting: Quoting) -> FittedDry {
    let gather = |column: &[f64]| -> Vec<f64> {
        let slices = groups.iter().map(|group| &column[group.rebounds.clone()]);
        slices.flatten().copied().collect()
    };
    let (speeds, restitutions) = (gather(&runs.impact_speed), gather(&runs.restitution));
    let fit = fit_dry(&speeds, &restitutions);
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    let verdict = judge(&fit, fastest);
    let separate: Vec<(f64, Fit)> = groups
        .iter()
        .map(|group| {
            let range = group.rebounds.clone();
            let fit = fit_dry(&runs.impact_speed[range.clone()], &runs.restitution[range]);
            (group.diameter, fit)
        })
        .collect();
    let spreads: Vec<Spread> = separate.iter().map(|(_, fit)| spread(fit)).collect();
    let heterogeneity = one_law_for_all(spread(&fit), &spreads);
    let dry_k = estimate(&fit, quoting);
    FittedDry {
        particle,
        usable: dry_k.pair().filter(|_| verdict.passed),
        dry: Dry {
            particle: scene.particles[particle].name.clone(),
            runs: restitutions.len(),
            stuck: groups.iter().map(|group| group.stuck.len()).sum(),
            dry_k,
            residual_sd: fit.residual_sd,
            by_diameter: separate
                .iter()
                .zip(groups)
                .map(|((diameter, fit), group)| DryOfDiameter {
                    diameter_m: *diameter,
                    runs: group.rebounds.len(),
                    dry_k: estimate(fit, quoting),
                })
                .collect(),
            heterogeneity,
            stop: fit.stop.as_str(),
            verdict,
        },
    }
}

fn estimate(fit: &Fit, quoting: Quoting) -> Estimate {
    match fit.parameters.first() {
        Some(k) if fit.stop == Stop::Converged => quoting.of(&uncertain(fit), *k, &[1.0], Scale::Plain),
        _ => quoting.none(why_stopped(fit)),
    }
}

fn judge(fit: &Fit, fastest: f64) -> Verdict {
    let k = fit.parameters.first().copied().unwrap_or(f64::NAN);
    if fit.stop != Stop::Converged {
        Verdict::failed(why_stopped(fit))
    } else if let (None, Some(why)) = (&fit.covariance, &fit.why_no_covariance) {
        Verdict::failed(why.clone())
    } else if speed_limit(k) <= fastest {
        Verdict::failed("the fitted law turns negative inside the range of speeds")
    } else {
        Verdict::passed("converged")
    }
}
