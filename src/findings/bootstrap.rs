//! Gives every estimate its bootstrap interval, beside the delta method's.

use rayon::prelude::*;
use serde::Serialize;

use super::dry::FittedDry;
use super::energy::Energy;
use super::estimate::Estimate;
use super::own_dry_speed::{reference_dry_speed, OwnDrySpeed};
use super::scaling::FittedScaling;
use super::series::SeriesFit;
use crate::inference::bootstrap::intervals::{acceleration, studentized, Replicates};
use crate::inference::bootstrap::kernel::Weighted;
use crate::inference::bootstrap::{leave_one_out, replicate, Law, Plan, Pool, Target};
use crate::inference::delta::LEVELS;
use crate::physics::dry as dry_physics;
use crate::physics::numbers::stokes;
use crate::physics::viscous::critical_separation;
use crate::runs::Runs;
use crate::scene::{self, IntervalMethod, Scene};

/// What the replicates of a quantity say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bootstrapped {
    /// standard deviation of the replicates
    pub se: f64,
    /// their mean minus the estimate
    pub bias: f64,
    /// replicates without a number
    pub failed: usize,
    /// replicates asked for
    pub replicates: usize,
    /// why the percentile interval stands in for BCa; `None` where it does not
    pub fallback: Option<&'static str>,
}

/// The interval quoted unless the scene names one; the coverage table supports it.
pub const DEFAULT_INTERVAL: IntervalMethod = IntervalMethod::Percentile;

/// The runs of all fits as columns in the order of the strata.
struct Columns {
    pool: Pool,
    dry_runs: usize,
    speed_root: Vec<f64>,
    dry_restitution: Vec<f64>,
    inverse_speed: Vec<f64>,
    inverse_stokes: Vec<f64>,
    restitution: Vec<f64>,
    offset: Vec<f64>,
}

impl Columns {
    fn new(scene: &Scene, runs: &Runs, dry: &[FittedDry]) -> Columns {
        let mut columns = Columns {
            pool: Pool::default(),
            dry_runs: 0,
            speed_root: vec![],
            dry_restitution: vec![],
            inverse_speed: vec![],
            inverse_stokes: vec![],
            restitution: vec![],
            offset: vec![],
        };
        let mut end = 0;
        let mut stratum = |size: usize, pool: &mut Pool| {
            pool.strata.push(end..end + size);
            end += size;
        };
        for group in &runs.dry {
            stratum(group.rebounds.len(), &mut columns.pool);
            let range = group.rebounds.clone();
            columns
                .speed_root
                .extend(runs.impact_speed[range.clone()].iter().map(|v| v.powf(0.2)));
            columns.dry_restitution.extend_from_slice(&runs.restitution[range]);
        }
        columns.dry_runs = columns.dry_restitution.len();
        for series in &runs.series {
            stratum(series.rebounds.len(), &mut columns.pool);
            let range = series.rebounds.clone();
            let density = scene.particles[series.particle].density;
            let viscosity = scene.liquids[series.liquid].viscosity;
            let speeds = &runs.impact_speed[range.clone()];
            columns.inverse_speed.extend(speeds.iter().map(|v| 1.0 / v));
            let inverse = runs.diameter[range.clone()].iter().zip(speeds);
            columns
                .inverse_stokes
                .extend(inverse.map(|(d, v)| 1.0 / stokes(density, *d, *v, viscosity)));
            columns.restitution.extend_from_slice(&runs.restitution[range]);
            match OwnDrySpeed::new(scene, dry, series.particle) {
                Some(own) => columns.offset.extend(own.offsets(speeds)),
                None => columns.offset.extend(std::iter::repeat_n(0.0, speeds.len())),
            }
        }
        if columns.offset.iter().all(|offset| *offset == 0.0) {
            columns.offset.clear();
        }
        columns
    }

    fn range(&self, strata: &std::ops::Range<usize>) -> std::ops::Range<usize> {
        let strata = &self.pool.strata[strata.clone()];
        let (first, last) = (strata.first(), strata.last());
        first.map_or(0, |s| s.start)..last.map_or(0, |s| s.end)
    }

    fn dry(&self, strata: std::ops::Range<usize>, k: f64) -> Target<'_> {
        let range = self.range(&strata);
        Target {
            law: Law::Dry,
            x: &self.speed_root[range.clone()],
            offset: &[],
            restitution: &self.dry_restitution[range],
            strata,
            fitted: [k, 0.0],
        }
    }

    fn wet(&self, law: Law, x: &'_ Vec<f64>, strata: std::ops::Range<usize>, fitted: [f64; 2]) -> Target<'_> {
        let range = self.range(&strata);
        let range = range.start - self.dry_runs..range.end - self.dry_runs;
        // the caller names one of our columns
        let x = if std::ptr::eq(x, &self.inverse_speed) {
            &self.inverse_speed
        } else {
            &self.inverse_stokes
        };
        let with_offset = law == Law::SquareRoot && !self.offset.is_empty();
        Target {
            law,
            x: &x[range.clone()],
            offset: if with_offset { &self.offset[range.clone()] } else { &[] },
            restitution: &self.restitution[range],
            strata,
            fitted,
        }
    }
}

/// A quantity as a function of a law's parameters and of k; NaN where it is not defined.
type Quantity = Box<dyn Fn([f64; 2], f64) -> f64 + Send + Sync>;

/// An estimate to complete: the targets its parameters and its k come from, and how.
struct Task<'e> {
    estimate: &'e mut Estimate,
    target: usize,
    dry: Option<usize>,
    quantity: Quantity,
}

/// Every replicate and every leave-one-out fit, by target.
struct Replicated {
    fits: Vec<Vec<Weighted>>,
    without: Vec<Vec<Vec<[f64; 2]>>>,
    fitted: Vec<[f64; 2]>,
}

/// The estimates that get a bootstrap interval.
pub struct Estimates<'e> {
    /// k of each particle
    pub dry: &'e mut [FittedDry],
    /// the square-root law of each series
    pub series: &'e mut [SeriesFit],
    /// e_inf and St_c
    pub scaling: &'e mut [FittedScaling],
    /// the energy table
    pub energy: &'e mut [Energy],
}

/// Bootstraps every estimate that has a fit, and quotes the interval the scene names.
///
/// Of the other intervals only the delta method's are kept, unless `keep_all`.
pub fn complete(scene: &Scene, runs: &Runs, estimates: Estimates, seed: u64, keep_all: bool) {
    let Estimates {
        dry,
        series,
        scaling,
        energy,
    } = estimates;
    let plan = Plan {
        replicates: usize::try_from(scene.bootstrap.replicates).unwrap_or(usize::MAX),
        scheme: scene.bootstrap.scheme,
        seed,
    };
    let method = scene.bootstrap.interval.unwrap_or(DEFAULT_INTERVAL);
    let columns = Columns::new(scene, runs, dry);
    let mut targets: Vec<Target> = vec![];
    let mut add = |target| {
        targets.push(target);
        targets.len() - 1
    };
    let dry_targets: Vec<Option<usize>> = dry
        .iter()
        .map(|fitted| {
            let first = runs.dry.iter().position(|group| group.particle == fitted.particle)?;
            let count = runs
                .dry
                .iter()
                .filter(|group| group.particle == fitted.particle)
                .count();
            Some(add(columns.dry(first..first + count, fitted.dry.dry_k.value?)))
        })
        .collect();
    let wet = runs.dry.len();
    let series_targets: Vec<Option<usize>> = series
        .iter()
        .enumerate()
        .map(|(index, fit)| {
            let fitted = [fit.alpha.value?, fit.beta.value?];
            let strata = wet + index..wet + index + 1;
            Some(add(columns.wet(
                Law::SquareRoot,
                &columns.inverse_speed,
                strata,
                fitted,
            )))
        })
        .collect();
    let scaling_targets: Vec<Option<usize>> = scaling
        .iter()
        .map(|fitted| {
            let law = match fitted.law {
                scene::Law::Sqrt => Law::SquareRoot,
                scene::Law::Linear => Law::Linear,
            };
            let strata = wet + fitted.series.start..wet + fitted.series.end;
            Some(add(columns.wet(
                law,
                &columns.inverse_stokes,
                strata,
                fitted.parameters?,
            )))
        })
        .collect();
    let replicated = Replicated {
        fits: replicate(&columns.pool, &targets, plan),
        without: targets
            .par_iter()
            .map(|target| leave_one_out(&columns.pool, target))
            .collect(),
        fitted: targets.iter().map(|target| target.fitted).collect(),
    };
    let dry_of = |particle: usize| {
        dry.iter()
            .zip(&dry_targets)
            .find(|(d, _)| d.particle == particle)
            .and_then(|(_, target)| *target)
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
        let quantities: [(&mut Estimate, Quantity); 4] = [
            (&mut fit.alpha, Box::new(|[alpha, _], _| alpha)),
            (&mut fit.beta, Box::new(|[_, beta], _| beta)),
            (&mut fit.e_inf, Box::new(|[alpha, _], _| alpha.sqrt())),
            (
                &mut fit.threshold_speed_m_s,
                Box::new(|p, _| where_it_falls(p, -p[1] / p[0])),
            ),
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
    let energy_targets: Vec<(Option<usize>, usize, scene::Law)> = of_ratio
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
    let reference = reference_dry_speed(scene);
    for (row, (target, particle, law)) in energy.iter_mut().zip(energy_targets) {
        let Some(target) = target else { continue };
        let roughness = scene.particles[particle].roughness;
        let density_ratio = row.density_ratio;
        let loss = move |p: [f64; 2], k: f64| {
            let e_dry = dry_physics::restitution(k, reference);
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
    tasks
        .into_par_iter()
        .for_each(|task| replicated.tell(task, plan, method, keep_all));
}

fn where_it_falls([alpha, beta]: [f64; 2], value: f64) -> f64 {
    if alpha > 0.0 && beta < 0.0 {
        value
    } else {
        f64::NAN
    }
}

fn e_inf(law: scene::Law, [a, _]: [f64; 2]) -> f64 {
    match law {
        scene::Law::Sqrt => a.sqrt(),
        scene::Law::Linear if a > 0.0 => a,
        scene::Law::Linear => f64::NAN,
    }
}

fn st_c(law: scene::Law, p: [f64; 2]) -> f64 {
    match law {
        scene::Law::Sqrt => where_it_falls(p, -p[1] / (2.0 * p[0])),
        scene::Law::Linear => where_it_falls([p[0], -p[1]], p[1] / p[0]),
    }
}

fn lubrication_log(law: scene::Law, p: [f64; 2]) -> f64 {
    match law {
        scene::Law::Sqrt => where_it_falls(p, -p[1] / 4.0),
        scene::Law::Linear => where_it_falls([p[0], -p[1]], 0.5 * p[0] * p[1]),
    }
}

impl Replicated {
    fn tell(&self, task: Task, plan: Plan, method: IntervalMethod, keep_all: bool) {
        let Task {
            estimate,
            target,
            dry,
            quantity,
        } = task;
        let (Some(value), Some(se)) = (estimate.value, estimate.se) else {
            return;
        };
        let k_at = |number: usize| dry.map_or(f64::NAN, |dry| self.fits[dry][number].parameters[0]);
        let k_fitted = dry.map_or(f64::NAN, |dry| self.fitted[dry][0]);
        let of = |(number, fit): (usize, &Weighted)| quantity(fit.parameters, k_at(number));
        let replicates = Replicates::new(self.fits[target].iter().enumerate().map(of));
        let Some((mean, sd)) = replicates.mean_sd() else {
            return;
        };
        let influence = |at: f64, without: Vec<f64>| -> Vec<f64> {
            let n = without.len() as f64;
            without.into_iter().map(|left| (n - 1.0) * (at - left)).collect()
        };
        let wet = self.without[target]
            .iter()
            .map(|stratum| influence(value, stratum.iter().map(|p| quantity(*p, k_fitted)).collect()));
        let of_dry = dry.iter().flat_map(|dry| &self.without[*dry]).map(|stratum| {
            influence(
                value,
                stratum.iter().map(|p| quantity(self.fitted[target], p[0])).collect(),
            )
        });
        // a stratum of one run cannot be left out and says nothing of the skewness
        let acceleration = acceleration(wet.chain(of_dry).filter(|stratum| stratum.len() > 1));
        let t = self.studentized(target, dry, &quantity, value);
        let mut fallback = None;
        let mut make = |method: IntervalMethod, level: f64| match method {
            IntervalMethod::Bca => match replicates.bca(value, acceleration, level) {
                Ok(made) => Some(made),
                Err(reason) => {
                    fallback = Some(reason);
                    None
                }
            },
            IntervalMethod::Percentile => replicates.percentile(level),
            IntervalMethod::Studentized => studentized(&t, value, se, level),
            IntervalMethod::Delta => None,
        };
        let mut levels: Vec<f64> = LEVELS.to_vec();
        if !levels.contains(&estimate.level) {
            levels.push(estimate.level);
        }
        let all = [
            IntervalMethod::Percentile,
            IntervalMethod::Bca,
            IntervalMethod::Studentized,
        ];
        for level in levels {
            for other in all.into_iter().filter(|other| keep_all || *other == method) {
                estimate.intervals.extend(make(other, level));
            }
        }
        let quoted = match method {
            IntervalMethod::Delta => None,
            method => make(method, estimate.level).or_else(|| replicates.percentile(estimate.level)),
        };
        if let Some(quoted) = quoted {
            estimate.interval = Some([quoted.lo, quoted.hi]);
            estimate.method = quoted.method;
        }
        estimate.bootstrap = Some(Bootstrapped {
            se: sd,
            bias: mean - value,
            failed: replicates.failed,
            replicates: plan.replicates,
            fallback,
        });
    }

    /// t* = (θ* − θ̂)/se*, with each replicate's own delta-method standard error.
    fn studentized(&self, target: usize, dry: Option<usize>, quantity: &Quantity, value: f64) -> Replicates {
        let t = self.fits[target].iter().enumerate().map(|(number, fit)| {
            let k = dry.map(|dry| &self.fits[dry][number]);
            let k_at = k.map_or(f64::NAN, |k| k.parameters[0]);
            let p = fit.parameters;
            // central differences: the quantities are smooth and the parameters of order one
            let step = |x: f64| 1e-5 * x.abs().max(1e-3);
            let (h0, h1, hk) = (step(p[0]), step(p[1]), step(k_at));
            let g0 = (quantity([p[0] + h0, p[1]], k_at) - quantity([p[0] - h0, p[1]], k_at)) / (2.0 * h0);
            let g1 = (quantity([p[0], p[1] + h1], k_at) - quantity([p[0], p[1] - h1], k_at)) / (2.0 * h1);
            let [aa, ab, bb] = fit.covariance;
            let mut variance = g0 * g0 * aa + 2.0 * g0 * g1 * ab + g1 * g1 * bb;
            if let Some(k) = k {
                let gk = (quantity(p, k_at + hk) - quantity(p, k_at - hk)) / (2.0 * hk);
                variance += gk * gk * k.covariance[0];
            }
            (quantity(p, k_at) - value) / variance.sqrt()
        });
        Replicates::new(t)
    }
}
