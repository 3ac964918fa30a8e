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
pub use resampling::{Estimates, Resampling};

use std::ops::Range;

use rayon::prelude::*;

use super::dry::FittedDry;
use super::estimate::Estimate;
use super::notices;
use crate::inference::bootstrap::sandwich::{sandwich, sandwich_of_sample, Sandwich};
use crate::inference::bootstrap::{Plan, RunErrors, Target};
use crate::inference::effective_variance::ErrorWeights;
use crate::notice::Notice;
use crate::physics::quantity::{Place, Quantity};
use crate::runs::Runs;
use crate::scene::{IntervalMethod, ResamplingScheme, Scene};
use affordable::{affordable_replicates, fewer_replicates_notice};
use by_sandwich::FEW_RUNS;
use columns::Columns;
use replicates::{AllReplicates, DrySpeedReference, Formula, ReplicateOrder, ReplicatedLaw, Task};

/// The interval quoted unless the scene names one; the coverage table supports it.
pub const DEFAULT_INTERVAL: IntervalMethod = IntervalMethod::Percentile;

/// Bootstraps every estimate that has a fit, and quotes the interval the scene names.
///
/// Of the other intervals only the delta method's are kept, unless all are asked for.
/// `done` is called with the number of replicates finished.
pub fn add_bootstrap_intervals(
    scene: &Scene,
    runs: &Runs,
    mut estimates: Estimates,
    options: Options,
    done: &(dyn Fn(usize) + Sync),
) -> (Resampling, Vec<Notice>) {
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
    };
    let is_sampled = runs.sample.is_some();
    let many = is_sampled || runs.len() > options.most_resampled && plan.scheme == ResamplingScheme::Cases;
    // what stands for others has their sums, and not the scatter inside a speed
    let some = runs.sample();
    let columns = Columns::new(scene, some, estimates.dry);
    let errors = FitErrors::new(&columns, some, &estimates);
    let (targets, places) = targets(scene, some, &columns, &estimates, &errors);
    let sandwiches: Vec<Sandwich> = if is_sampled {
        sandwiches_of_sample((&columns, &targets), scene, runs, &estimates)
    } else if many {
        let of_target = |target: &Target| sandwich(&columns.pool, target);
        targets.par_iter().map(of_target).collect()
    } else {
        vec![]
    };
    let is_resampled = |target: &Target| !many || target.regression.x.len() < FEW_RUNS;
    // replicates of a sample would be those of fewer runs
    let resampled = targets.iter().filter(|target| is_resampled(target) && !is_sampled);
    let resampled: Vec<Target> = resampled.cloned().collect();
    let places_of_resampled: Vec<usize> = targets
        .iter()
        .scan(0, |next, target| {
            let place = *next;
            *next += usize::from(is_resampled(target));
            Some(place)
        })
        .collect();
    let replicates = AllReplicates::make(&columns.pool, &resampled, order, done);
    let mut by_replicates = vec![];
    for task in tasks(scene, runs, &mut estimates, &places) {
        let mut fits = std::iter::once(task.target).chain(task.dry);
        if !fits.all(|fit| is_resampled(&targets[fit])) {
            by_sandwich::add_interval(task, order.method, &targets, &sandwiches);
        } else if !is_sampled {
            by_replicates.push(task.moved(&places_of_resampled));
        }
    }
    by_replicates
        .into_par_iter()
        .for_each(|task| replicates.add_interval(task));
    let resampling = Resampling {
        scheme: plan.scheme.name(),
        interval: order.method.name(),
        by_sandwich: many,
        replicates: plan.replicates,
        resampled_fits: resampled.len(),
        strata: columns.pool.strata.len(),
        single_run_strata: columns.pool.single_runs(),
    };
    let mut found = bootstrap_notices::bootstrap_notices(scene, runs, &resampling, &estimates);
    found.extend(fewer_replicates_notice(
        scene.bootstrap.replicates,
        plan.replicates,
        fits,
    ));
    found.extend(many.then(|| {
        let rest = match resampled.len() {
            0 => String::new(),
            some => format!("; {some} of {} fits were resampled, which have few runs", targets.len()),
        };
        let text = format!(
            "{} runs, more than the {} that are resampled: the intervals are made with the sandwich covariance, which that \
             of replicates tends to{rest}",
            runs.all_measured(),
            options.most_resampled
        );
        notices::BOOTSTRAP_BY_SANDWICH.notice(runs.all_measured(), text)
    }));
    (resampling, found)
}

/// The sandwich of each fit, from a sample of the runs.
fn sandwiches_of_sample(
    (columns, targets): (&Columns, &[Target]),
    scene: &Scene,
    runs: &Runs,
    estimates: &Estimates,
) -> Vec<Sandwich> {
    // no sample need have the run that a fit hangs on
    let all = Columns::new(scene, runs, estimates.dry);
    let errors = FitErrors::new(&all, runs, estimates);
    let (of_all, _) = self::targets(scene, runs, &all, estimates, &errors);
    let of_target = |(sample, all): (&Target, &Target)| sandwich_of_sample(&columns.pool, sample, all);
    targets.par_iter().zip(&of_all).map(of_target).collect()
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

/// The errors by which fits weighed their runs, where these carry any, in the order of the fits.
struct FitErrors {
    dry: Vec<Option<RunErrors>>,
    series: Vec<Option<RunErrors>>,
    scaling: Vec<Option<RunErrors>>,
}

impl FitErrors {
    fn new(columns: &Columns, runs: &Runs, estimates: &Estimates) -> FitErrors {
        let strata = Strata {
            dry_groups: runs.dry.len(),
        };
        let of = |weights: &Option<ErrorWeights>, places: Range<usize>| columns.run_errors(weights.as_ref(), places);
        let dry = estimates.dry.iter();
        let series = estimates.series.iter().enumerate();
        let scaling = estimates.scaling.iter();
        FitErrors {
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
    errors: &'c FitErrors,
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
    let dry = estimates.dry.iter().zip(&errors.dry).map(|(fitted, errors)| {
        let k = fitted.dry.dry_k.value?;
        Some(columns.dry(Strata::of_dry(runs, fitted)?, k, order, errors.as_ref()))
    });
    let dry: Vec<Option<Target>> = dry.collect();
    let series = estimates.series.iter().zip(&errors.series).enumerate();
    let series = series.map(|(index, (fit, errors))| {
        let fitted = [fit.alpha.value?, fit.beta.value?];
        let own = strata.of_series(index..index + 1);
        Some(columns.wet(columns.over_speed(), own, fitted, errors.as_ref()))
    });
    let series: Vec<Option<Target>> = series.collect();
    let scaling = estimates.scaling.iter().zip(&errors.scaling).map(|(fitted, errors)| {
        let own = strata.of_series(fitted.series.clone());
        Some(columns.wet(
            columns.over_stokes(fitted.law),
            own,
            fitted.parameters?,
            errors.as_ref(),
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
