//! Gives every estimate its bootstrap interval, beside the delta method's.
//!
//! | file | job |
//! |---|---|
//! | `columns.rs` | lays the runs of every fit out in strata |
//! | `replicates.rs` | turns the replicates of a quantity, or of very many runs the sandwich, into its interval |

mod columns;
mod replicates;

pub use columns::Estimates;
pub use replicates::MOST_RESAMPLED;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::remarks;
use crate::inference::bootstrap::sandwich::{sandwich, sandwich_of_sample, Sandwich};
use crate::inference::bootstrap::{Plan, Target};
use crate::physics::dry::speed_root;
use crate::physics::quantity::{Place, Quantity};
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::{IntervalMethod, ResamplingScheme, Scene};
use columns::{Division, FitRuns};
use replicates::{add_interval_by_sandwich, AllReplicates, ReplicateOrder, Task, FEW_RUNS};

/// The interval quoted unless the scene names one; the coverage table supports it.
pub const DEFAULT_INTERVAL: IntervalMethod = IntervalMethod::Percentile;

/// Replicates of all fits together that are held at once: 2.4 GB.
pub const MOST_HELD: usize = 100_000_000;

/// How many replicates are made of so many fits where a number is wanted: no more than are held at once.
fn affordable_replicates(wanted: u64, fits: usize) -> usize {
    let wanted = usize::try_from(wanted).unwrap_or(usize::MAX);
    wanted.min(MOST_HELD / fits.max(1)).max(1)
}

/// Says that fewer replicates were made than the scene asks for; `None` where they were not.
fn fewer_replicates_notice(wanted: u64, made: usize, fits: usize) -> Option<Remark> {
    (made as u64 != wanted).then(|| {
        let text = format!(
            "[bootstrap] replicates: found {wanted}, of {fits} fits; made {made}, since at most {MOST_HELD} replicates of \
             all fits together are held at once"
        );
        let next = format!("set it to at most {made}, or fit fewer series in one scene");
        remarks::BOOTSTRAP_FEWER_REPLICATES.notice(made, text).then(next)
    })
}

/// How replicates were made.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Resampling {
    /// what was resampled
    pub scheme: &'static str,
    /// the interval that is quoted of replicates
    pub interval: &'static str,
    /// whether the runs are so many that the sandwich stands for the replicates of most fits
    pub by_sandwich: bool,
    /// replicates
    pub replicates: usize,
    /// fits that were resampled: all, but of more runs than are resampled only those that the sandwich does not serve
    pub resampled_fits: usize,
    /// strata of all runs
    pub strata: usize,
    /// strata of one run, which no resample can vary
    pub single_run_strata: usize,
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

/// Bootstraps every estimate that has a fit, and quotes the interval the scene names.
///
/// Of the other intervals only the delta method's are kept, unless all are asked for.
/// `done` is called with the number of replicates finished. The remark says where these are fewer than were asked for.
pub fn add_bootstrap_intervals(
    scene: &Scene,
    runs: &Runs,
    mut estimates: Estimates,
    options: Options,
    done: &(dyn Fn(usize) + Sync),
) -> (Resampling, Option<Remark>) {
    let number = estimates.dry.len() + estimates.series.len() + estimates.scaling.len();
    let plan = Plan {
        replicates: affordable_replicates(scene.bootstrap.replicates, number),
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
    let division = Division::new(runs.sample());
    let pool = &division.pool;
    let fits = division.fits(scene, &estimates);
    let targets: Vec<Option<Target>> = fits.iter().map(|fit| fit.as_ref().map(FitRuns::target)).collect();
    // no sample need have the run that a fit hangs on
    let of_all = is_sampled.then(|| Division::new(runs).fits(scene, &estimates));
    let sandwich_of = |fit: usize| {
        let own = targets[fit].as_ref()?;
        Some(match &of_all {
            Some(all) => sandwich_of_sample(pool, own, &all[fit].as_ref()?.target()),
            None => sandwich(pool, own),
        })
    };
    let sandwiches: Vec<Option<Sandwich>> = match many {
        true => (0..number).into_par_iter().map(sandwich_of).collect(),
        false => vec![],
    };
    let is_resampled = |target: &Target| !many || target.regression.x.len() < FEW_RUNS;
    // replicates of a sample would be those of fewer runs
    let numbered = targets.iter().cloned().enumerate().filter(|_| !is_sampled);
    let with_target = numbered.filter_map(|(fit, target)| Some((fit, target.filter(is_resampled)?)));
    let resampled: Vec<(usize, Target)> = with_target.collect();
    let resampled_fits = resampled.len();
    let replicates = AllReplicates::make(pool, resampled, order, done);
    let mut by_replicates = vec![];
    for task in tasks(scene, runs, &mut estimates, &targets) {
        if !task.fits().all(|fit| targets[fit].as_ref().is_some_and(is_resampled)) {
            add_interval_by_sandwich(task, order.method, &sandwiches);
        } else if !is_sampled {
            by_replicates.push(task);
        }
    }
    let tasks = by_replicates.into_par_iter();
    tasks.for_each(|task| replicates.add_interval(task));
    let resampling = Resampling {
        scheme: plan.scheme.name(),
        interval: order.method.name(),
        by_sandwich: many,
        replicates: plan.replicates,
        resampled_fits,
        strata: pool.strata.len(),
        single_run_strata: pool.single_runs(),
    };
    let fewer = fewer_replicates_notice(scene.bootstrap.replicates, plan.replicates, number);
    (resampling, fewer)
}

/// Every estimate of a fit with numbers that replicates give an interval, with its quantity; fits are numbered as by
/// [`Division::fits`].
fn tasks<'e>(scene: &Scene, runs: &Runs, estimates: &'e mut Estimates, targets: &[Option<Target>]) -> Vec<Task<'e>> {
    let order = scene.model.form().dry;
    let root = speed_root(scene.model.dry_speed.reference());
    let spheres: Vec<usize> = estimates.dry.iter().map(|fitted| fitted.sphere).collect();
    let mut tasks: Vec<Task> = vec![];
    let mut numbers = 0..targets.len();
    // the next fit, if it has numbers
    let mut next = || numbers.next().filter(|fit| targets[*fit].is_some());
    for fitted in estimates.dry.iter_mut() {
        let own = next().map(|fit| Task::new(&mut fitted.dry_k, fit, |[k, _], _| k));
        tasks.extend(own);
    }
    let has_delta_c = scene.model.viscous.why_no_critical_separation().is_none();
    let series = estimates.series.iter_mut().map(|own| (&mut own.fitted, f64::NAN));
    let scaling = estimates.scaling.iter_mut().map(|own| {
        let density_ratio = own.energy.as_ref().map_or(f64::NAN, |energy| energy.density_ratio);
        (&mut own.fitted, density_ratio)
    });
    for (fitted, density_ratio) in series.chain(scaling) {
        let Some(fit) = next() else { continue };
        let over = fitted.over;
        let at = Place {
            roughness: scene.particles[runs.spheres[fitted.sphere].particle].roughness,
            density_ratio,
        };
        let of_k = spheres.iter().position(|sphere| *sphere == fitted.sphere);
        let of_k = of_k.filter(|fit| targets[*fit].is_some());
        for (quantity, estimate) in fitted.estimates.iter_mut() {
            // near β = 0 replicates of the threshold speed have no mean
            if quantity == Quantity::ThresholdSpeed || quantity == Quantity::DeltaC && !has_delta_c {
                continue;
            }
            let value = move |parameters, k| {
                let wetted = over.wetted(parameters).with_e_dry(order.of_loss(k * root)[0]);
                quantity.value(&at, &wetted)
            };
            let mut own = Task::new(estimate, fit, value);
            own.dry = of_k.filter(|_| quantity == Quantity::InertialLoss);
            tasks.push(own);
        }
    }
    tasks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_replicates_are_made_than_are_held() {
        // the largest number a scene may ask for, of as many fits as the published example has
        assert_eq!(affordable_replicates(1_000_000, 88), 1_000_000);
        assert_eq!(affordable_replicates(1_000_000, 1000), 100_000);
        assert_eq!(affordable_replicates(10_000, 20_000), 5000);
        assert_eq!(affordable_replicates(10_000, usize::MAX), 1);
        assert_eq!(fewer_replicates_notice(10_000, 10_000, 88), None);
        let notice = fewer_replicates_notice(10_000, 5000, 20_000).expect("fewer");
        assert!(notice
            .text
            .starts_with("[bootstrap] replicates: found 10000, of 20000 fits; made 5000, since at most"));
    }
}
