//! Gives every estimate its bootstrap interval, beside the delta method's.
//!
//! | file | job |
//! |---|---|
//! | `resampling.rs` | what is resampled, and how |
//! | `affordable.rs` | how many replicates are held at once |
//! | `columns.rs` | lays the runs of all fits out in strata |
//! | `tell.rs` | turns replicates into intervals |
//! | `cautions.rs` | which intervals want a second look |

mod affordable;
mod cautions;
mod columns;
mod resampling;
mod tell;

pub use affordable::MOST_HELD;
pub use cautions::{COVERAGE_OF_EIGHT, FEW_RUNS};
pub use resampling::{Estimates, Joint, Resampling};

use std::ops::Range;

use rayon::prelude::*;

use super::dry::FittedDry;
use super::estimate::Estimate;
use super::shown;
use crate::inference::bootstrap::jackknife::leave_one_out;
use crate::inference::bootstrap::kernel::WeightedFit;
use crate::inference::bootstrap::{replicate, Plan, RunWeights, Target};
use crate::inference::effective_variance::ErrorWeights;
use crate::notice::Notice;
use crate::physics::viscous::critical_separation;
use crate::runs::Runs;
use crate::scene::{IntervalMethod, ResamplingScheme, Scene, WetLaw};
use affordable::{affordable, fewer};
use columns::Columns;
use tell::{Quantity, Task, Told};

/// The interval quoted unless the scene names one; the coverage table supports it.
pub const DEFAULT_INTERVAL: IntervalMethod = IntervalMethod::Percentile;

/// Bootstraps every estimate that has a fit, and quotes the interval the scene names.
///
/// Of the other intervals only the delta method's are kept, unless `keep_all`.
/// `done` is told of replicates as they are finished.
pub fn complete(
    scene: &Scene,
    runs: &Runs,
    estimates: Estimates,
    seed: u64,
    keep_all: bool,
    done: &(dyn Fn(usize) + Sync),
) -> (Resampling, Vec<Notice>) {
    let Estimates {
        dry,
        series,
        scaling,
        energy,
    } = estimates;
    let fits = dry.len() + series.len() + scaling.len();
    let plan = Plan {
        replicates: affordable(scene.bootstrap.replicates, fits),
        scheme: scene.bootstrap.scheme,
        seed,
    };
    let method = scene.bootstrap.interval.unwrap_or(DEFAULT_INTERVAL);
    let columns = Columns::new(scene, runs, dry);
    let wet = runs.dry.len();
    let own_dry = |fitted: &FittedDry| {
        let first = runs.dry.partition_point(|group| group.particle < fitted.particle);
        let groups = runs.dry_of(fitted.particle).len();
        (groups > 0).then_some(first..first + groups)
    };
    let run_weights = |error_weights: &Option<ErrorWeights>, places: Range<usize>| {
        let mut weights = columns.run_weights(error_weights.as_ref(), places)?;
        if matches!(plan.scheme, ResamplingScheme::Residuals | ResamplingScheme::Parametric) {
            // noise about the law at the speeds as they were read: nothing errs in speed
            weights.bias = [0.0; 2];
        }
        Some(weights)
    };
    let weights_dry: Vec<Option<RunWeights>> = dry
        .iter()
        .map(|fitted| run_weights(&fitted.error_weights, own_dry(fitted)?))
        .collect();
    let weights_series: Vec<Option<RunWeights>> = series
        .iter()
        .enumerate()
        .map(|(index, fit)| run_weights(&fit.error_weights, wet + index..wet + index + 1))
        .collect();
    let weights_scaling: Vec<Option<RunWeights>> = scaling
        .iter()
        .map(|fitted| {
            run_weights(
                &fitted.error_weights,
                wet + fitted.series.start..wet + fitted.series.end,
            )
        })
        .collect();
    let mut targets: Vec<Target> = vec![];
    let mut add = |target| {
        targets.push(target);
        targets.len() - 1
    };
    let order = scene.model.form().dry;
    let dry_targets: Vec<Option<usize>> = dry
        .iter()
        .zip(&weights_dry)
        .map(|(fitted, weights)| {
            let k = fitted.dry.dry_k.value?;
            Some(add(columns.dry(own_dry(fitted)?, k, order, weights.as_ref())))
        })
        .collect();
    let series_targets: Vec<Option<usize>> = series
        .iter()
        .zip(&weights_series)
        .enumerate()
        .map(|(index, (fit, weights))| {
            let fitted = [fit.alpha.value?, fit.beta.value?];
            let strata = wet + index..wet + index + 1;
            Some(add(columns.wet(columns.over_speed(), strata, fitted, weights.as_ref())))
        })
        .collect();
    let scaling_targets: Vec<Option<usize>> = scaling
        .iter()
        .zip(&weights_scaling)
        .map(|(fitted, weights)| {
            let strata = wet + fitted.series.start..wet + fitted.series.end;
            let all = columns.over_stokes(fitted.law);
            Some(add(columns.wet(all, strata, fitted.parameters?, weights.as_ref())))
        })
        .collect();
    let replicated = Told {
        plan,
        method,
        keep_all,
        fits: replicate(&columns.pool, &targets, plan, done),
        without: targets
            .par_iter()
            .map(|target| leave_one_out(&columns.pool, target, plan.scheme))
            .collect(),
        fitted: targets.iter().map(|target| target.fitted).collect(),
        to_spare: targets
            .iter()
            .map(|target| {
                target
                    .regression
                    .x
                    .len()
                    .saturating_sub(target.regression.law.parameters())
            })
            .collect(),
        drawn: targets
            .iter()
            .map(|target| plan.scheme != ResamplingScheme::Series || target.series.len() > 1)
            .collect(),
    };
    let dry_of = |particle: usize| {
        let place = dry.binary_search_by_key(&particle, |fitted| fitted.particle).ok()?;
        dry_targets[place]
    };
    let dry_of_particle: Vec<Option<usize>> = (0..scene.particles.len()).map(dry_of).collect();
    let mut tasks: Vec<Task> = vec![];
    for (fitted, target) in dry.iter_mut().zip(&dry_targets) {
        let Some(target) = *target else { continue };
        let quantity: Quantity = Box::new(|[k, _], _| k);
        tasks.push(Task {
            estimate: &mut fitted.dry.dry_k,
            target,
            dry: None,
            quantity,
        });
    }
    for (fit, target) in series.iter_mut().zip(&series_targets) {
        let Some(target) = *target else { continue };
        // the threshold speed keeps its delta interval: near β = 0 its replicates have no mean
        let quantities: [(&mut Estimate, Quantity); 3] = [
            (&mut fit.alpha, Box::new(|[alpha, _], _| alpha)),
            (&mut fit.beta, Box::new(|[_, beta], _| beta)),
            (&mut fit.e_inf, Box::new(|[alpha, _], _| alpha.sqrt())),
        ];
        for (estimate, quantity) in quantities {
            tasks.push(Task {
                estimate,
                target,
                dry: None,
                quantity,
            });
        }
    }
    // the energy table follows the film ratios of the scaling table
    let of_ratio = scaling
        .iter()
        .zip(&scaling_targets)
        .filter(|(fitted, _)| fitted.scaling.film_ratio.is_some());
    let energy_targets: Vec<(Option<usize>, usize, WetLaw)> = of_ratio
        .map(|(fitted, target)| (*target, fitted.particle, fitted.law))
        .collect();
    for (fitted, target) in scaling.iter_mut().zip(&scaling_targets) {
        let Some(target) = *target else { continue };
        let law = fitted.law;
        let row = &mut fitted.scaling;
        let mut quantities: Vec<(&mut Estimate, Quantity)> = vec![
            (&mut row.e_inf, Box::new(move |p, _| e_inf(law, p))),
            (&mut row.st_c, Box::new(move |p, _| st_c(law, p))),
            (&mut row.lubrication_log, Box::new(move |p, _| lubrication_log(law, p))),
        ];
        if let Some(twice) = &mut row.st_no_rebound {
            quantities.push((twice, Box::new(move |p, _| 2.0 * st_c(law, p))));
        }
        for (estimate, quantity) in quantities {
            tasks.push(Task {
                estimate,
                target,
                dry: None,
                quantity,
            });
        }
    }
    let reference = scene.model.dry_speed.reference();
    for (row, (target, particle, law)) in energy.iter_mut().zip(energy_targets) {
        let Some(target) = target else { continue };
        let roughness = scene.particles[particle].roughness;
        let density_ratio = row.density_ratio;
        let loss = move |p: [f64; 2], k: f64| {
            let e_dry = order.restitution(k, reference);
            (e_dry * e_dry - e_inf(law, p).powi(2)) / density_ratio
        };
        let quantities: [(&mut Estimate, Option<usize>, Quantity); 3] = [
            (
                &mut row.loss_over_density_ratio,
                dry_of_particle[particle],
                Box::new(loss),
            ),
            (
                &mut row.st_c_e_inf2,
                None,
                Box::new(move |p, _| 2.0 * lubrication_log(law, p)),
            ),
            (
                &mut row.delta_c_m,
                None,
                Box::new(move |p, _| critical_separation(roughness, lubrication_log(law, p))),
            ),
        ];
        for (estimate, dry, quantity) in quantities {
            tasks.push(Task {
                estimate,
                target,
                dry,
                quantity,
            });
        }
    }
    tasks.into_par_iter().for_each(|task| replicated.tell(task));
    let shown: Vec<Option<f64>> = (0..scene.particles.len())
        .map(|particle| shown::film_ratio(scene, runs, particle))
        .collect();
    let joint = scaling.iter().zip(&scaling_targets).filter_map(|(fitted, target)| {
        let row = &fitted.scaling;
        let drawn = match row.film_ratio {
            Some(_) => row.film_ratio == shown[fitted.particle],
            None => row.verdict.passed,
        };
        let fits = replicated.fits.of(target.filter(|_| drawn)?);
        let pair = |fit: WeightedFit| [e_inf(fitted.law, fit.parameters), st_c(fitted.law, fit.parameters)];
        Some(Joint {
            particle: fitted.particle,
            film_ratio: row.film_ratio,
            law: fitted.law,
            pairs: fits.map(pair).collect(),
        })
    });
    let resampling = Resampling {
        scheme: plan.scheme.name(),
        interval: method.name(),
        replicates: plan.replicates,
        strata: columns.pool.strata.len(),
        single_run_strata: columns.pool.single_runs(),
        joint: joint.collect(),
    };
    let estimates = Estimates {
        dry,
        series,
        scaling,
        energy,
    };
    let mut notices = cautions::notices(runs, &resampling, &estimates);
    notices.extend(fewer(scene.bootstrap.replicates, plan.replicates, fits));
    (resampling, notices)
}

fn where_it_falls([alpha, beta]: [f64; 2], value: f64) -> f64 {
    if alpha > 0.0 && beta < 0.0 {
        value
    } else {
        f64::NAN
    }
}

fn e_inf(law: WetLaw, [a, _]: [f64; 2]) -> f64 {
    match law {
        WetLaw::Sqrt => a.sqrt(),
        WetLaw::Linear if a > 0.0 => a,
        WetLaw::Linear => f64::NAN,
    }
}

fn st_c(law: WetLaw, p: [f64; 2]) -> f64 {
    match law {
        WetLaw::Sqrt => where_it_falls(p, -p[1] / (2.0 * p[0])),
        WetLaw::Linear => where_it_falls([p[0], -p[1]], p[1] / p[0]),
    }
}

fn lubrication_log(law: WetLaw, p: [f64; 2]) -> f64 {
    match law {
        WetLaw::Sqrt => where_it_falls(p, -p[1] / 4.0),
        WetLaw::Linear => where_it_falls([p[0], -p[1]], 0.5 * p[0] * p[1]),
    }
}
