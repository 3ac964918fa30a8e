//! Estimates k of each particle, or of each of its diameters, from its dry runs, and whether one k serves all diameters.

use schemars::JsonSchema;
use serde::Serialize;

use super::estimate::{Estimate, Quoting};
use super::fit_columns::{error_columns, FitColumns, OwnDrySpeed};
use super::fit_verdict::{one_against, uncertain, why_stopped, OwnLaw, Verdict};
use crate::distributions::normal_quantile;
use crate::inference::effective_variance::{ErrorSummary, ErrorWeights};
use crate::inference::lack_of_fit::{lack_of_fit, LackOfFit, LawRow};
use crate::inference::law::Law;
use crate::inference::least_squares::Fit;
use crate::inference::nested::FTest;
use crate::inference::regression::Regression;
use crate::model::parameters::ParameterKind;
use crate::physics::dry::{Order, DRY_K};
use crate::physics::{DrySpeed, Quantity};
use crate::runs::{sphere_label, sphere_words, DryGroup, Runs};
use crate::scene::Scene;

/// k of one particle, or of one diameter of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Dry {
    /// name of the particle
    pub particle: String,
    /// D, m, where each diameter has a k of its own
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// index into [`Runs::spheres`]
    #[serde(skip)]
    pub sphere: usize,
    /// dry runs used
    pub runs: usize,
    /// dry runs with no rebound, left out
    pub stuck: usize,
    /// k over all its diameters, (m/s)^(-1/5)
    #[serde(skip)]
    pub dry_k: Estimate,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// how measurement errors entered; `None` where no run carries one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<ErrorSummary>,
    /// k of each diameter
    pub by_diameter: Vec<DryOfDiameter>,
    /// one k for all diameters against one k each; `None` with a single diameter
    pub heterogeneity: Option<FTest>,
    /// the law, with a k for each diameter, against its own runs; `None` where these cannot test it
    pub lack_of_fit: Option<LackOfFit>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether k may be quoted
    pub verdict: Verdict,
    /// k and its standard error, where it may be used
    #[serde(skip)]
    pub usable: Option<(f64, f64)>,
    /// spread of the restitutions that its runs are weighed by: that of all diameters of the particle
    #[serde(skip)]
    weighing_sd: Option<f64>,
    /// weights of its runs, where they carry measurement errors
    #[serde(skip)]
    pub error_weights: Option<ErrorWeights>,
}

/// k of one particle at one diameter.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DryOfDiameter {
    /// D, m
    pub diameter_m: f64,
    /// dry runs used
    pub runs: usize,
    /// k, (m/s)^(-1/5)
    #[serde(skip)]
    pub dry_k: Estimate,
}

impl Dry {
    /// The k that other runs or diameters would have, in its standard errors from this one; the largest distance.
    fn largest_shift(&self, shifts: impl Iterator<Item = f64>) -> Option<f64> {
        let se = self.dry_k.se.filter(|se| *se > 0.0)?;
        shifts.map(|shift| shift.abs() / se).reduce(f64::max)
    }

    /// How far the law's misfit moves k between slow and fast runs, in its standard errors.
    pub fn shift_by_speed(&self) -> Option<f64> {
        self.largest_shift(self.lack_of_fit.iter().flat_map(|found| found.shifts))
    }

    /// How far k of a diameter lies from k of all, in its standard errors.
    pub fn shift_by_diameter(&self) -> Option<f64> {
        let k = self.dry_k.value?;
        let own = self.by_diameter.iter().filter_map(|own| own.dry_k.value);
        self.largest_shift(own.map(|own| own - k))
    }

    /// Its words in a text: `PTFE`, `PTFE of 4.762 mm`.
    pub fn words(&self) -> String {
        sphere_words(&self.particle, self.diameter_m)
    }

    /// Variance of each of so many rows of rebounds about the law, in their order; infinite where one was left out.
    pub(super) fn variances(&self, rows: usize) -> impl Iterator<Item = f64> + '_ {
        let of_all = self.weighing_sd.map_or(f64::NAN, |sd| sd * sd);
        let own = self.error_weights.as_ref().map(|weights| &weights.variance);
        (0..rows).map(move |run| own.map_or(of_all, |own| own[run]))
    }
}

/// The name of a k in files: `dry_k[PTFE]`, `dry_k[PTFE,4.762]`.
pub fn name_of_k(particle: &str, diameter: Option<f64>) -> String {
    format!("{}[{}]", DRY_K.name, sphere_label(particle, diameter))
}

/// k of every sphere that has dry runs, in their order.
pub fn fit_dry_laws(scene: &Scene, runs: &Runs) -> Vec<Dry> {
    let spheres = (0..runs.spheres.len()).filter_map(|sphere| {
        let groups: Vec<&DryGroup> = runs.dry_of(sphere).iter().collect();
        (!groups.is_empty()).then(|| of_sphere(scene, runs, sphere, &groups))
    });
    let mut fits: Vec<Dry> = spheres.collect();
    for of_particle in fits.chunk_by_mut(|a, b| runs.spheres[a.sphere].particle == runs.spheres[b.sphere].particle) {
        if of_particle.len() > 1 {
            let sd = pooled_sd(of_particle);
            of_particle.iter_mut().for_each(|fitted| fitted.weighing_sd = sd);
        }
    }
    fits
}

/// Spread of the restitutions about some laws of one parameter each. Each diameter has its k, but what scatters them is
/// one; a few runs alone say too little of it, and intervals with weights from them would be too short.
fn pooled_sd(fits: &[Dry]) -> Option<f64> {
    let known = || {
        fits.iter()
            .filter_map(|fitted| Some((fitted.residual_sd?, (fitted.runs - 1) as f64)))
    };
    let freedom: f64 = known().map(|(_, freedom)| freedom).sum();
    let squares: f64 = known().map(|(sd, freedom)| freedom * sd * sd).sum();
    (freedom > 0.0).then(|| (squares / freedom).sqrt())
}

/// That of one sphere, out of all in their order.
pub fn fit_of_sphere(dry: &[Dry], sphere: usize) -> Option<&Dry> {
    let place = dry.binary_search_by_key(&sphere, |fitted| fitted.sphere).ok()?;
    dry.get(place)
}

/// The dry speed of a sphere's own runs; `None` unless the scene asks for it and the sphere has a usable k.
pub(super) fn own_dry_speed(scene: &Scene, dry: &[Dry], sphere: usize) -> Option<OwnDrySpeed> {
    if scene.model.dry_speed != DrySpeed::Impact {
        return None;
    }
    let (dry_k, dry_k_se) = fit_of_sphere(dry, sphere)?.usable?;
    Some(OwnDrySpeed {
        dry_k,
        dry_k_se,
        order: scene.model.form().dry,
    })
}

fn of_sphere(scene: &Scene, runs: &Runs, index: usize, groups: &[&DryGroup]) -> Dry {
    let quoting = Quoting::of(scene);
    let order = scene.model.form().dry;
    let law = Law::Dry(order);
    let errors_of = |groups: &[&DryGroup]| {
        let ranges = groups.iter().map(|group| group.rebounds.clone());
        error_columns(scene, runs, ParameterKind::SigmaDry, ranges, None)
    };
    let all = groups.iter().flat_map(|group| group.rebounds.clone());
    let columns = FitColumns::of(runs, all, |run| law.abscissa(runs.impact_speed[run]), None);
    let regression = columns.regression(law);
    let (fit, error_weights) = regression.fit_with_errors(errors_of(groups).as_ref());
    let fastest = columns.speeds.iter().copied().fold(0.0, f64::max);
    let stuck = groups.iter().map(|group| runs.measured(group.stuck.clone())).sum();
    let verdict = dry_verdict(&fit, order, fastest, stuck);
    let mut first = 0;
    let mut of_group = |group: &DryGroup| {
        let range = group.rebounds.clone();
        first += range.len();
        Regression {
            counts: runs.counts(range.clone()),
            ..Regression::new(law, &columns.x[first - range.len()..first], &runs.restitution[range])
        }
    };
    let own_law = |group: &&DryGroup| OwnLaw::new(of_group(group), errors_of(&[group]).as_ref());
    let separate: Vec<OwnLaw> = groups.iter().map(own_law).collect();
    let (expected, sticks_at) = (regression.fitted(&fit), scene.data.smallest_restitution);
    let heterogeneity = one_against(1, &expected, sticks_at, &separate, |variance, _| {
        regression.chi_squared(&variance, &fit.parameters)
    });
    let dry_k = estimate(&fit, quoting);
    let sphere = runs.spheres[index];
    Dry {
        usable: dry_k.pair().filter(|_| verdict.passed),
        weighing_sd: fit.residual_sd,
        particle: scene.particles[sphere.particle].name.clone(),
        diameter_m: sphere.diameter,
        sphere: index,
        runs: groups.iter().map(|group| runs.measured(group.rebounds.clone())).sum(),
        stuck,
        dry_k,
        residual_sd: fit.residual_sd,
        measurement_errors: error_weights.as_ref().map(|weights| weights.summary),
        by_diameter: separate
            .iter()
            .zip(groups)
            .map(|(own, group)| DryOfDiameter {
                diameter_m: group.diameter,
                runs: runs.measured(group.rebounds.clone()),
                dry_k: estimate(&own.fit, quoting),
            })
            .collect(),
        heterogeneity,
        lack_of_fit: {
            let some = runs.sample();
            lack_of_fit(&rows_of(some, order, some.dry_of(index), &separate))
        },
        stop: fit.stop.as_str(),
        verdict,
        error_weights,
    }
}

/// The dry runs beside the law of their diameter; none of a diameter whose law did not converge.
fn rows_of(runs: &Runs, order: Order, groups: &[DryGroup], separate: &[OwnLaw]) -> Vec<LawRow> {
    let mut rows = vec![];
    for (index, (group, own)) in groups.iter().zip(separate).enumerate() {
        let OwnLaw { fit, weights, .. } = own;
        let Some(k) = fit.parameters.first().filter(|_| fit.converged()) else {
            continue;
        };
        rows.extend(group.rebounds.clone().enumerate().map(|(place, run)| {
            let speed = runs.impact_speed[run];
            LawRow {
                group: index,
                speed,
                residual: runs.restitution[run] - order.restitution(*k, speed),
                slope: order.slope_dry_k(*k, speed),
                next_power: order.next_power(speed),
                weight: weights.as_ref().map_or(1.0, |weights| 1.0 / weights.variance[place]),
            }
        }));
    }
    rows
}

fn estimate(fit: &Fit, quoting: Quoting) -> Estimate {
    match fit.parameters.first() {
        Some(k) if fit.converged() => quoting.of_function(&uncertain(fit), *k, &[1.0], Quantity::DryK),
        _ => quoting.none(why_stopped(fit)),
    }
}

/// How far leaving out the lowest runs moves a mean of normal ones, in its standard errors.
fn cut_off_bias(rebounds: usize, stuck: usize) -> f64 {
    let share = stuck as f64 / (rebounds + stuck) as f64;
    let z = normal_quantile(share);
    let density = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    density / (1.0 - share) * (rebounds as f64).sqrt()
}

fn dry_verdict(fit: &Fit, order: Order, fastest: f64, stuck: usize) -> Verdict {
    let k = fit.parameters.first().copied().unwrap_or(f64::NAN);
    if !fit.converged() || fit.covariance.is_err() {
        Verdict::failed(why_stopped(fit))
    } else if order.speed_limit(k) <= fastest {
        Verdict::failed(match order {
            Order::First => "the fitted law turns negative inside the range of speeds",
            Order::Second => "the fitted law rises again inside the range of speeds",
        })
    } else if cut_off_bias(fit.degrees_of_freedom + 1, stuck) > 1.0 {
        Verdict::failed(format!(
            "{stuck} dry runs have no rebound: leaving out so many may move k by more than its standard error"
        ))
    } else {
        Verdict::passed("converged")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of a standard normal cut off below: φ(z)/(1 − Φ(z)); at the median 0.7979.
    #[test]
    fn the_bias_of_a_cut_off_is_that_of_a_truncated_normal() {
        assert!((cut_off_bias(100, 100) / (10.0 * 0.797_884_56) - 1.0).abs() < 1e-6);
        assert_eq!(cut_off_bias(100, 0), 0.0);
        assert!(cut_off_bias(30, 1) < 1.0 && cut_off_bias(80, 20) > 3.0);
    }
}
