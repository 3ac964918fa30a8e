//! Samples the posterior and summarises it: each parameter, what follows from it, and whether that may be quoted.
//!
//! | file | job |
//! |---|---|
//! | `sampling.rs` | what is sampled and how |
//! | `runs_alone.rs` | what the runs alone say of each parameter, beside the scene's priors |
//! | `summary.rs` | the summary of each parameter, of what follows and of the offsets that series have, as `findings.json` writes it |
//! | `run_densities.rs` | the log density of every run at the draws |
//! | `contraction.rs` | the parameters that keep much of their prior |
//! | `derived.rs` | what follows from the parameters, draw by draw |
//! | `predictive_checks.rs` | posterior predictive checks: new runs beside the ones made |
//! | `posterior_checks.rs` | what must hold before the posterior is quoted |

pub(super) mod contraction;
pub mod derived;
pub(super) mod posterior_checks;
pub mod predictive_checks;
pub mod run_densities;
mod runs_alone;
mod sampling;
mod summary;

use std::sync::OnceLock;

use rayon::prelude::*;

use super::least_squares::LeastSquares;
use super::predict::{offset_of_new_series, Draw, ParticleLaw};
use super::remarks;
use crate::error::Error;
use crate::inference::accuracy::sample_to_accuracy;
use crate::inference::mixing::{draws_to_add, MixingLines};
use crate::inference::nuts::{SamplingPlan, Watcher};
use crate::inference::prepared_posterior::{seconds_of_rows, PreparedPosterior};
use crate::inference::sampling::{sample_by_nuts, Sampled};
use crate::model::likelihood::tails::Tails;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{physical, ModelParameters, ParameterKind, SHAPE_SLOT};
use crate::physics::Form;
use crate::remark::Remark;
use crate::runs::Runs;
use crate::scene::{NoiseOn, Scene};
use crate::seed::StreamName;
use derived::DerivedDraws;
use run_densities::RunDensities;
use runs_alone::UnderDefaults;
use summary::summarise_posterior;

pub use posterior_checks::{refusal, speed_errors, why_not_sampled};
pub use runs_alone::RunsAlone;
pub use sampling::{check_room, effort, most_draws, start, MethodChoice, SamplingSetup, MOST_NUMBERS};
pub use summary::{CompressionSummary, HeldParameter, PosteriorFindings, PriorSummary, QuantitySummary, SeriesOffset};

/// A posterior with its draws, for the report and the files of draws.
#[derive(Debug)]
pub struct Posterior {
    /// which model was sampled, and how
    pub setup: SamplingSetup,
    /// the summary
    pub findings: PosteriorFindings,
    /// the draws
    pub sampled: Sampled,
    /// the draws of what follows
    pub derived: Vec<DerivedDraws>,
    /// what must hold
    pub checks: Vec<Remark>,
    /// the scene it was sampled from, where that is not the one that was given: with noise on the energy, too, which barely
    /// rebounding runs ask for
    pub scene: Option<Box<Scene>>,
    /// the posterior of the scene that was given, where this one stands for it
    pub as_given: Option<Box<Posterior>>,
    densities: OnceLock<Option<RunDensities>>,
}

impl Posterior {
    /// Whether every check of the sampling passed; those of the model and the runs do not count.
    pub fn sampling_holds(&self) -> bool {
        let is_of_sampling = |check: &Remark| posterior_checks::OF_SAMPLING.iter().any(|kind| kind.is(check));
        !self.checks.iter().any(|check| is_of_sampling(check) && check.forbids())
    }

    /// That the runs contradict a prior; `None` where they do not.
    pub fn prior_conflict(&self) -> Option<&Remark> {
        let is_conflict = |check: &&Remark| remarks::PRIOR_CONFLICT.is(check) && !check.passed;
        self.checks.iter().find(is_conflict)
    }

    /// The log density of every run under the scene it was sampled from, made where it is first asked for; `None` of too many
    /// runs.
    pub fn run_densities(&self, scene: &Scene, runs: &Runs) -> Option<&RunDensities> {
        let made = || RunDensities::of(scene, runs, self.setup.form, &self.sampled);
        self.densities.get_or_init(made).as_ref()
    }

    /// The law of a sphere, by its index, by at most so many draws, evenly taken; of a new series, where series have offsets.
    pub fn law(&self, scene: &Scene, runs: &Runs, sphere: usize, most: usize) -> ParticleLaw {
        let full = self.sampled.full_draws();
        let step = full.len().div_ceil(most).max(1);
        let model = &scene.model;
        let draw = |(index, full): (usize, &Vec<f64>)| {
            // of a spread that the model does not have the slot says nothing
            let spread = |held: bool, kind: ParameterKind| if held { full[kind.slot()] } else { 0.0 };
            let sigma_series = spread(model.series_offsets, ParameterKind::SigmaSeries);
            Draw {
                parameters: physical(full, sphere),
                sigma_dry: full[ParameterKind::SigmaDry.slot()],
                sigma_wet: full[ParameterKind::SigmaWet.slot()],
                sigma_energy: spread(model.noise == NoiseOn::Both, ParameterKind::SigmaEnergy),
                tails: Tails::of(model.likelihood, full[SHAPE_SLOT]),
                series_offset: offset_of_new_series(index, sigma_series),
            }
        };
        let basis = &self.findings.basis;
        let particle = &basis.particles[runs.spheres[sphere].particle];
        let draws = full.iter().step_by(step).enumerate().map(draw);
        basis.law(particle, self.setup.form, draws.collect())
    }
}

/// About how long a posterior will be sampled that takes one run at a time; `None` of one by sums, which is done in no time.
pub fn expected_sampling(
    scene: &Scene,
    runs: &Runs,
    least_squares: &LeastSquares,
    setup: SamplingSetup,
) -> Option<ExpectedSampling> {
    /// slopes that a draw takes, the warm-up's included: 4.6 to 6.7 in the posteriors of `benches/README.md`
    const OF_A_DRAW: f64 = 6.0;
    let parameters = ModelParameters::of(scene, runs, setup.form).ok()?;
    if !Likelihood::needs_every_row(scene, runs) {
        return None;
    }
    let likelihood = Likelihood::new(scene, runs, setup.form);
    let one = seconds_of_rows(parameters, likelihood, &start(least_squares))?;
    let effort = effort(scene);
    let draws = (effort.warmup + effort.draws) as f64;
    let at_once = rayon::current_num_threads().min(effort.chains).max(1);
    let rounds = effort.chains.div_ceil(at_once) as f64;
    Some(ExpectedSampling {
        one,
        all: rounds * draws * OF_A_DRAW * one,
    })
}

/// What sampling is expected to take, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedSampling {
    /// the log density once, with its slopes
    pub one: f64,
    /// all draws, as the scene's `[sampler]` says
    pub all: f64,
}

/// Samples the posterior from where least squares stands, and summarises it.
///
/// `Err` where a prior leaves no room, or the draws do not fit into memory; the inner `Err`, a check that fails and gates, where
/// the runs are such that nothing should be sampled.
pub fn fit_posterior(
    scene: &Scene,
    runs: &Runs,
    least_squares: &LeastSquares,
    setup: SamplingSetup,
    watcher: Watcher,
) -> Result<Result<Posterior, Box<Remark>>, Error> {
    let parameters = ModelParameters::of(scene, runs, setup.form)?;
    if let Some(not_sampled) = posterior_checks::why_not_sampled(runs, least_squares, &parameters) {
        return Ok(Err(not_sampled));
    }
    let effort = effort(scene);
    let quantities = parameters.dimension() + derived::count_derived(scene, runs, setup.form);
    check_room(effort, quantities)?;
    let by_rows = matches!(setup.method, MethodChoice::Rows) || Likelihood::needs_every_row(scene, runs);
    let few = || runs.condensed(scene.data.smallest_restitution);
    let condensed = (!by_rows).then(few).flatten();
    let likelihood = Likelihood::new(scene, condensed.as_ref().unwrap_or(runs), setup.form);
    let plan = SamplingPlan {
        effort,
        streams: StreamName::new(least_squares.seed, "posterior"),
        watcher,
    };
    let start = start(least_squares);
    let prepared = PreparedPosterior::new(parameters, &likelihood, &start).map_err(|why| why.to_string());
    let sampled = prepared.and_then(|prepared| {
        let sampled = match setup.method {
            MethodChoice::Accuracy(accuracy) => sample_to_accuracy(&prepared, accuracy, plan),
            MethodChoice::Sampler | MethodChoice::Rows => {
                let (lines, most) = (MixingLines::of_chains(effort.chains), most_draws(effort, quantities));
                sample_by_nuts(&prepared, plan, &mut |draws| draws_to_add(lines, draws, most))
            }
        };
        sampled.map_err(|why| why.to_string())
    });
    let sampled = match sampled {
        Ok(sampled) => sampled,
        // it could not even start
        Err(why) => return Ok(Err(Box::new(remarks::DRAWS_MADE.check(0.0, why)))),
    };
    let derived = derived::derived_draws(scene, runs, setup.form, &sampled);
    let draws = sampled.full_draws();
    // what stands for the runs, what it is held against, and by how much it errs
    let compressed = match (&condensed, &runs.sample) {
        (Some(few), _) => {
            let error = largest_difference(scene, runs, setup.form, (&likelihood, &draws));
            Some((few, None, error))
        }
        (None, Some(sample)) => {
            let few = Likelihood::new(scene, &sample.few(scene.data.smallest_restitution), setup.form);
            let share = sample.len() as f64 / runs.all_measured() as f64;
            let error = largest_difference(scene, sample, setup.form, (&few, &draws)) / share;
            Some((runs, Some("sample"), error))
        }
        (None, None) => None,
    };
    let compression = compressed.map(|(few, held_against, max_log_density_error)| CompressionSummary {
        nodes: few.wet(),
        rows: runs.wet_measured(),
        held_against,
        bound: LARGEST_ERROR,
        max_log_density_error,
    });
    let predictive = predictive_checks::check_predictions(scene, runs.sample(), setup.form, &draws);
    let under_defaults = UnderDefaults::of(scene, runs, setup, (&likelihood, &start), least_squares.seed);
    let findings = PosteriorFindings {
        compression,
        predictive,
        ..summarise_posterior(scene, runs, setup, &sampled, &derived, under_defaults.as_ref())
    };
    let mut checks = posterior_checks::check_posterior(&findings, least_squares);
    checks.extend(posterior_checks::speed_errors(scene, runs));
    Ok(Ok(Posterior {
        setup,
        findings,
        sampled,
        derived,
        checks,
        scene: None,
        as_given: None,
        densities: OnceLock::new(),
    }))
}

/// Error of the log density, over the posterior's region, that the few may have that stand for very many runs.
const LARGEST_ERROR: f64 = 1e-3;

/// Draws at which very many runs are held against the few that stand for them.
pub const CHECKED_RUNS: usize = 20;

/// Largest difference of the log density between every run and the few that stand for them, at some of these draws; up to a
/// constant, which no draw sees.
fn largest_difference(scene: &Scene, runs: &Runs, form: Form, (few, draws): (&Likelihood, &[Vec<f64>])) -> f64 {
    let ln_density = |likelihood: &Likelihood, full: &Vec<f64>| {
        let mut slopes = vec![0.0; full.len()];
        likelihood.ln_density(full, &mut slopes).unwrap_or(f64::INFINITY)
    };
    let step = draws.len().div_ceil(CHECKED_RUNS).max(1);
    let some: Vec<&Vec<f64>> = draws.iter().step_by(step).collect();
    let of = |likelihood: &Likelihood| -> Vec<f64> {
        let each = some.par_iter().map(|full| ln_density(likelihood, full));
        each.collect()
    };
    let mut left: Vec<f64> = of(few).into_iter().map(|of_few| -of_few).collect();
    for part in runs.parts() {
        let own = of(&Likelihood::new(scene, &part, form));
        left.iter_mut().zip(own).for_each(|(left, own)| *left += own);
    }
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    left.into_iter().map(|left| (left - mean).abs()).fold(0.0, f64::max)
}
