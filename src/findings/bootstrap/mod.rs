//! Gives every estimate its bootstrap interval, beside the delta method's.
//!
//! | file | job |
//! |---|---|
//! | `resampling.rs` | what is resampled, and how |
//! | `affordable.rs` | how many replicates are held at once |
//! | `columns.rs` | lays the runs of all fits out in strata |
//! | `replicates.rs` | turns the replicates of a quantity into its interval |
//! | `by_sandwich.rs` | gives the fits of very many runs the intervals that resampling tends to |
//! | `bootstrap_notices.rs` | which intervals want a second look |

mod affordable;
mod bootstrap_notices;
mod by_sandwich;
mod columns;
mod replicates;
mod resampling;

pub use affordable::MOST_HELD;
pub use by_sandwich::MOST_RESAMPLED;
pub use replicates::FEWEST_RUNS;
pub use resampling::{Estimates, JointReplicates, Resampling};

use std::ops::Range;

use rayon::prelude::*;

use super::dry::FittedDry;
use super::estimate::Estimate;
use super::quantities::wetted_of;
use super::scaling::FittedScaling;
use super::{film_ratio, notices};
use crate::inference::bootstrap::kernel::WeightedFit;
use crate::inference::bootstrap::sandwich::{sandwich, sandwich_of_part};
use crate::inference::bootstrap::{Plan, RunWeights, Target};
use crate::inference::effective_variance::ErrorWeights;
use crate::notice::Notice;
use crate::physics::quantity::{Place, Quantity};
use crate::ranks::Shares;
use crate::runs::Runs;
use crate::scene::{IntervalMethod, ResamplingScheme, Scene};
use affordable::{affordable_replicates, fewer_replicates_notice};
use by_sandwich::{FittedBySandwich, Sandwich};
use columns::Columns;
use replicates::{AllReplicates, DrySpeedReference, Formula, ReplicateOrder, ReplicatedLaw, Task};

/// The interval quoted unless the scene names one; the coverage table supports it.
pub const DEFAULT_INTERVAL: IntervalMethod = IntervalMethod::Percentile;

/// Bootstraps every estimate that has a fit, and quotes the interval the scene names.
///
/// Of the other intervals only the delta method's are kept, unless all are asked for.
/// `done` is called with the number of replicates finished.
pub fn add_bootstrap_intervals<S: Shares>(
    scene: &Scene,
    runs: &Runs,
    mut estimates: Estimates,
    options: Options,
    shares: &S,
    done: &(dyn Fn(usize) + Sync),
) -> Result<(Resampling, Vec<Notice>), S::Error> {
    let fits = estimates.dry.len() + estimates.series.len() + estimates.scaling.len();
    let plan = Plan {
        replicates: affordable_replicates(scene.bootstrap.replicates, fits),
        scheme: scene.bootstrap.scheme,
        seed: options.seed,
    };
    let order = ReplicateOrder {
        plan,
        method: scene.bootstrap.interval.unwrap_or(DEFAULT_INTERVAL),
        named: scene.bootstrap.interval.is_some(),
        keep_all: options.keep_all,
        many: runs.sample.is_some() || runs.len() > options.most_resampled && plan.scheme == ResamplingScheme::Cases,
    };
    let many = order.many;
    // what stands for others has their sums, and not the scatter inside a speed
    let some = runs.sample();
    let columns = Columns::new(scene, some, estimates.dry);
    let weights = FitWeights::new(&columns, some, &estimates);
    let (targets, places) = targets(scene, some, &columns, &estimates, &weights);
    let strata = columns.pool.strata.len();
    let single_run_strata = columns.pool.single_runs();
    let sandwiches: Vec<Sandwich> = if runs.sample.is_some() {
        sandwiches_of_sample((&columns, &targets), scene, runs, &estimates)
    } else if many {
        let of_target = |target: &Target| sandwich(&columns.pool, target);
        targets.par_iter().map(of_target).collect()
    } else {
        targets.iter().map(|_| None).collect()
    };
    let mut resampled = vec![];
    for task in tasks(scene, runs, &mut estimates, &places) {
        match FittedBySandwich::of_task(&task, &targets, &sandwiches) {
            Some(fitted) => fitted.add_interval(task, order.method),
            // replicates of a sample are those of fewer runs
            None if runs.sample.is_some() => {}
            None => resampled.push(task),
        }
    }
    let (chosen, replicates) = if many {
        let chosen = choose(&mut resampled, targets.len());
        let of_chosen: Vec<Target> = chosen.iter().map(|target| targets[*target].clone()).collect();
        let (pool, of_chosen) = columns.pool.of_targets(&of_chosen);
        (
            chosen.len(),
            AllReplicates::make(&pool, &of_chosen, order, shares, done)?,
        )
    } else {
        // every run, whether a fit has it or not: which are drawn does not depend on what was fitted
        let made = AllReplicates::make(&columns.pool, &targets, order, shares, done)?;
        (targets.len(), made)
    };
    resampled.into_par_iter().for_each(|task| replicates.add_interval(task));
    let resampling = Resampling {
        scheme: plan.scheme.name(),
        interval: order.method.name(),
        by_sandwich: many,
        replicates: plan.replicates,
        resampled_fits: chosen,
        strata,
        single_run_strata,
        joint: if many {
            vec![]
        } else {
            joint_replicates(scene, runs, &estimates, &places, &replicates)
        },
    };
    let mut found = bootstrap_notices::bootstrap_notices(scene, runs, &resampling, &estimates);
    found.extend(fewer_replicates_notice(
        scene.bootstrap.replicates,
        plan.replicates,
        fits,
    ));
    found.extend(many.then(|| {
        let fits = [chosen, targets.len()];
        notices::bootstrap_by_sandwich(runs.all_measured(), options.most_resampled, fits)
    }));
    Ok((resampling, found))
}

/// The sandwich of each fit, from a sample of the runs: as much narrower as all are more.
fn sandwiches_of_sample(
    (columns, targets): (&Columns, &[Target]),
    scene: &Scene,
    runs: &Runs,
    estimates: &Estimates,
) -> Vec<Sandwich> {
    // no sample need have the run that a fit hangs on
    let all = Columns::new(scene, runs, estimates.dry);
    let weights = FitWeights::new(&all, runs, estimates);
    let (of_all, _) = self::targets(scene, runs, &all, estimates, &weights);
    let of_target = |(own, all): (&Target, &Target)| {
        let share = own.regression.x.len() as f64 / all.regression.counts.iter().sum::<f64>();
        let covariance = sandwich_of_part(&columns.pool, own, all)?;
        Some(covariance.map(|entry| share * entry))
    };
    targets.par_iter().zip(&of_all).map(of_target).collect()
}

/// The fits that some tasks need replicates of; the tasks then count among these.
fn choose(tasks: &mut [Task], all: usize) -> Vec<usize> {
    let mut needed = vec![false; all];
    for task in tasks.iter() {
        std::iter::once(task.target)
            .chain(task.dry)
            .for_each(|target| needed[target] = true);
    }
    let chosen: Vec<usize> = (0..all).filter(|target| needed[*target]).collect();
    let place = |target: usize| chosen.partition_point(|other| *other < target);
    for task in tasks {
        task.target = place(task.target);
        task.dry = task.dry.map(place);
    }
    chosen
}

/// How intervals are made beside what the scene says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// seed of the replicates
    pub seed: u64,
    /// whether every kind of interval is kept beside the one that is quoted
    pub keep_all: bool,
    /// runs of the largest table whose runs are resampled, usually [`MOST_RESAMPLED`]; of more than that the intervals are
    /// those that resampling tends to
    pub most_resampled: usize,
}

/// Where the runs of each fit stand among those of all: dry groups, then series.
struct Strata {
    dry_groups: usize,
}

impl Strata {
    /// The groups of a sphere's dry runs; `None` without any.
    fn of_dry(runs: &Runs, fitted: &FittedDry) -> Option<Range<usize>> {
        let first = runs.dry.partition_point(|group| group.sphere < fitted.sphere);
        let groups = runs.dry_of(fitted.sphere).len();
        (groups > 0).then_some(first..first + groups)
    }

    fn of_series(&self, series: Range<usize>) -> Range<usize> {
        self.dry_groups + series.start..self.dry_groups + series.end
    }
}

/// The weights that fits gave their runs, where these carry measurement errors, in the order of the fits.
struct FitWeights {
    dry: Vec<Option<RunWeights>>,
    series: Vec<Option<RunWeights>>,
    scaling: Vec<Option<RunWeights>>,
}

impl FitWeights {
    fn new(columns: &Columns, runs: &Runs, estimates: &Estimates) -> FitWeights {
        let strata = Strata {
            dry_groups: runs.dry.len(),
        };
        let of = |error_weights: &Option<ErrorWeights>, places: Range<usize>| {
            columns.run_weights(error_weights.as_ref(), places)
        };
        let dry = estimates.dry.iter();
        let series = estimates.series.iter().enumerate();
        let scaling = estimates.scaling.iter();
        FitWeights {
            dry: dry
                .map(|fitted| of(&fitted.error_weights, Strata::of_dry(runs, fitted)?))
                .collect(),
            series: series
                .map(|(index, fit)| of(&fit.error_weights, strata.of_series(index..index + 1)))
                .collect(),
            scaling: scaling
                .map(|fitted| of(&fitted.error_weights, strata.of_series(fitted.series.clone())))
                .collect(),
        }
    }
}

/// Places of the fits among the targets; `None` of a fit without numbers.
struct FitPlaces {
    dry: Vec<Option<usize>>,
    series: Vec<Option<usize>>,
    scaling: Vec<Option<usize>>,
}

/// What every replicate is fitted to: each fit that has numbers.
fn targets<'c>(
    scene: &Scene,
    runs: &Runs,
    columns: &'c Columns,
    estimates: &Estimates,
    weights: &'c FitWeights,
) -> (Vec<Target<'c>>, FitPlaces) {
    let mut targets: Vec<Target> = vec![];
    let mut add = |target: Option<Target<'c>>| {
        targets.push(target?);
        Some(targets.len() - 1)
    };
    let strata = Strata {
        dry_groups: runs.dry.len(),
    };
    let order = scene.model.form().dry;
    let dry = estimates.dry.iter().zip(&weights.dry).map(|(fitted, weights)| {
        let k = fitted.dry.dry_k.value?;
        Some(columns.dry(Strata::of_dry(runs, fitted)?, k, order, weights.as_ref()))
    });
    let dry: Vec<Option<Target>> = dry.collect();
    let series = estimates.series.iter().zip(&weights.series).enumerate();
    let series = series.map(|(index, (fit, weights))| {
        let fitted = [fit.alpha.value?, fit.beta.value?];
        let own = strata.of_series(index..index + 1);
        Some(columns.wet(columns.over_speed(), own, fitted, weights.as_ref()))
    });
    let series: Vec<Option<Target>> = series.collect();
    let scaling = estimates.scaling.iter().zip(&weights.scaling).map(|(fitted, weights)| {
        let own = strata.of_series(fitted.series.clone());
        Some(columns.wet(
            columns.over_stokes(fitted.law),
            own,
            fitted.parameters?,
            weights.as_ref(),
        ))
    });
    let scaling: Vec<Option<Target>> = scaling.collect();
    let [dry, series, scaling] = [dry, series, scaling].map(|fits| fits.into_iter().map(&mut add).collect());
    (targets, FitPlaces { dry, series, scaling })
}

/// Every estimate that replicates give an interval, with its quantity and the fits it follows from.
fn tasks<'e>(scene: &Scene, runs: &Runs, estimates: &'e mut Estimates, places: &FitPlaces) -> Vec<Task<'e>> {
    let reference = DrySpeedReference {
        order: scene.model.form().dry,
        speed: scene.model.dry_speed.reference(),
    };
    let target_of_k: Vec<(usize, Option<usize>)> = estimates
        .dry
        .iter()
        .zip(&places.dry)
        .map(|(fitted, target)| (fitted.sphere, *target))
        .collect();
    let formula = |fitted: ReplicatedLaw| Formula {
        fitted,
        reference,
        at: Place::NONE,
    };
    let mut tasks: Vec<Task> = vec![];
    for (fitted, target) in estimates.dry.iter_mut().zip(&places.dry) {
        let formula = formula(ReplicatedLaw::Dry);
        let own = [(Quantity::DryK, &mut fitted.dry.dry_k)];
        tasks.extend(of_fit(own, formula, *target, None));
    }
    for (fit, target) in estimates.series.iter_mut().zip(&places.series) {
        let formula = formula(ReplicatedLaw::OverSpeed);
        tasks.extend(of_fit(fit.resampled_mut(), formula, *target, None));
    }
    // the energy table follows the film ratios of the scaling table
    let mut energy = estimates.energy.iter_mut();
    for (fitted, target) in estimates.scaling.iter_mut().zip(&places.scaling) {
        let formula = formula(ReplicatedLaw::OverStokes(fitted.law));
        if fitted.scaling.film_ratio.is_some() {
            if let Some(row) = energy.next() {
                let at = Place {
                    roughness: scene.particles[runs.spheres[fitted.sphere].particle].roughness,
                    density_ratio: row.density_ratio,
                };
                let k = target_of_k.iter().find(|(sphere, _)| *sphere == fitted.sphere);
                let k = k.and_then(|(_, target)| *target);
                let none = scene.model.viscous.why_no_critical_separation().is_some();
                let defined = row.resampled_mut().into_iter();
                let defined = defined.filter(|(quantity, _)| !(none && *quantity == Quantity::DeltaC));
                tasks.extend(of_fit(defined, Formula { at, ..formula }, *target, k));
            }
        }
        tasks.extend(of_fit(fitted.scaling.estimates_mut(), formula, *target, None));
    }
    tasks
}

/// The tasks of one fit's estimates; none where it has no numbers. `k` is the target of the sphere's dry runs, for what
/// depends on it.
fn of_fit<'e>(
    estimates: impl IntoIterator<Item = (Quantity, &'e mut Estimate)>,
    formula: Formula,
    target: Option<usize>,
    k: Option<usize>,
) -> impl Iterator<Item = Task<'e>> {
    let estimates = target.map(|target| (target, estimates)).into_iter();
    estimates.flat_map(move |(target, estimates)| {
        estimates.into_iter().map(move |(quantity, estimate)| Task {
            estimate,
            target,
            dry: k.filter(|_| quantity == Quantity::InertialLoss),
            quantity,
            formula,
        })
    })
}

/// Replicates of e_inf and St_c in pairs, for the fits that figures show.
fn joint_replicates(
    scene: &Scene,
    runs: &Runs,
    estimates: &Estimates,
    places: &FitPlaces,
    replicates: &AllReplicates,
) -> Vec<JointReplicates> {
    let reference_ratios: Vec<Option<f64>> = (0..runs.spheres.len())
        .map(|sphere| film_ratio::reference_film_ratio(scene, runs, sphere))
        .collect();
    let of_fit = |(fitted, target): (&FittedScaling, &Option<usize>)| {
        let row = &fitted.scaling;
        let drawn = match row.film_ratio {
            Some(_) => row.film_ratio == reference_ratios[fitted.sphere],
            None => row.verdict.passed,
        };
        let fits = replicates.fits.of(target.filter(|_| drawn)?);
        let pair = |fit: WeightedFit| {
            let wetted = wetted_of(fitted.law, fit.parameters);
            [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted))
        };
        Some(JointReplicates {
            sphere: fitted.sphere,
            film_ratio: row.film_ratio,
            law: fitted.law,
            pairs: fits.map(pair).collect(),
        })
    };
    estimates
        .scaling
        .iter()
        .zip(&places.scaling)
        .filter_map(of_fit)
        .collect()
}
