//! Draws from a model as cheaply as leaving out its runs allows, and predicts each run from the others.
//!
//! Most posteriors of this kind are so near to a normal that draws of one, weighed by what the posterior has there, serve:
//! a thousand of them cost less than one chain's warm-up. Their weights times those of leaving a run out have one Pareto
//! tail, whose shape says whether they do; where it does not, heavier tails adapted to the posterior are tried, and then
//! trajectories are followed.

use std::ops::Range;

use rayon::prelude::*;

use super::least_squares::LeastSquares;
use super::posterior::{effort, start, until_mixed, why_not_sampled, PosteriorRefusal, SamplingSetup};
use crate::inference::diagnostics::loo::{difference, loo, relative_efficiency, Loo, LooDraws};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::{summarise, Summary};
use crate::inference::importance::DrawCounts;
use crate::inference::nuts::Watcher;
use crate::inference::prepared_posterior::PreparedPosterior;
use crate::inference::sampling::{follow_until_mixed, weigh, Sampled, SamplingPlan};
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::likelihood::{Likelihood, SeriesDensities};
use crate::model::parameters::ModelParameters;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::seed::StreamName;

/// Log densities, runs times draws, that may be computed for one model.
pub const MOST_DENSITIES: usize = 20_000_000;

/// Fewer draws than this do not carry the weights.
const FEWEST_DRAWS: usize = 400;

/// Chains that proposals are drawn in, so that threads share them.
const CHAINS: usize = 4;

/// Draws a chain that are tried in turn.
const ATTEMPTS: [usize; 3] = [500, 1000, 3500];

/// Monte Carlo error of an elpd with which draws do: that of the difference of two is then no more than 0.1.
const LARGEST_MCSE: f64 = 0.07;

/// The same as a share of the standard error of a difference: one of forty standard errors need not be known to 0.1.
const LARGEST_SHARE: f64 = 0.05;

/// k-hat of a run, beyond that of the draws' own weights, at which its weights have no mean: neither more draws nor those of
/// trajectories leave it out.
const HOPELESS: f64 = 1.0;

/// So many runs stand beside each that no draws leave out: of few runs a rough answer is told, by trajectories.
const MANY_BESIDE: usize = 100;

/// What models are drawn from.
#[derive(Clone, Copy)]
pub struct ComparisonContext<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// the runs that every model is compared on
    pub runs: &'a Runs,
    /// where sampling starts
    pub least_squares: LeastSquares<'a>,
    /// hears of every draw
    pub watcher: Watcher<'a>,
}

/// A model with its draws, every run left out of it.
pub(super) struct LeftOutModel {
    /// draws that all weigh the same
    pub sampled: Sampled,
    pub loo: Loo,
    /// by how many draws runs were left out
    pub used: usize,
}

/// How many of the draws can leave each run out; `None` for too many runs, or without wet ones.
pub(super) fn affordable_draws(runs: &Runs, draws: usize) -> Option<usize> {
    let used = draws.min(MOST_DENSITIES / runs.len().max(1));
    (used >= FEWEST_DRAWS.min(draws) && !runs.series.is_empty()).then_some(used)
}

/// Draws from a model with streams of this name and leaves each run out; `Err` says why that cannot be done.
///
/// What it is compared with, where that is known, says how small a Monte Carlo error need be.
pub(super) fn draw_and_leave_out(
    context: ComparisonContext,
    setup: SamplingSetup,
    parameters: ModelParameters,
    stream: &str,
    beside: Option<&Loo>,
) -> Result<LeftOutModel, String> {
    let ComparisonContext {
        scene,
        runs,
        least_squares,
        watcher,
    } = context;
    if let Some(PosteriorRefusal(why)) = why_not_sampled(runs, least_squares, &parameters) {
        return Err(why.text);
    }
    let dimension = parameters.dimension();
    let rows = Likelihood::of_rows(scene, runs, setup.form);
    let stream = StreamName::new(least_squares.seed, stream);
    let start = start(least_squares);
    let prepared = PreparedPosterior::new(parameters, &rows, &start, setup.method.evaluation());
    let prepared = prepared.map_err(|why| why.to_string())?;
    let leaving = Leaving { scene, runs, setup };
    if let Some(found) = leaving.weighed(&prepared, stream, beside) {
        return Ok(found);
    }
    let plan = SamplingPlan {
        effort: effort(scene),
        stream,
        evaluation: setup.method.evaluation(),
    };
    let sampled = follow_until_mixed(&prepared, until_mixed(plan, dimension), watcher);
    let sampled = sampled.map_err(|why| why.to_string())?;
    let used = affordable_draws(runs, sampled.draws()).ok_or("too many runs to leave each out")?;
    let loo = leaving.of_sampled(&sampled, used)?;
    Ok(LeftOutModel { sampled, loo, used })
}

/// PSIS leave-one-out of a sampled model, by so many of its draws; `Err` says which run stands in the way.
pub(super) fn leave_out(
    scene: &Scene,
    runs: &Runs,
    setup: SamplingSetup,
    sampled: &Sampled,
    used: usize,
) -> Result<Loo, String> {
    Leaving { scene, runs, setup }.of_sampled(sampled, used)
}

/// A form and the runs that are left out of it.
#[derive(Clone, Copy)]
struct Leaving<'a> {
    scene: &'a Scene,
    runs: &'a Runs,
    setup: SamplingSetup,
}

impl Leaving<'_> {
    /// By draws of a proposal with weights, by more of them as long as the Monte Carlo error is too large; `None` where the
    /// weights do not do.
    fn weighed(&self, prepared: &PreparedPosterior, stream: StreamName, beside: Option<&Loo>) -> Option<LeftOutModel> {
        let mut best = None;
        for draws in ATTEMPTS {
            let used = CHAINS * draws;
            if affordable_draws(self.runs, used) != Some(used) {
                continue;
            }
            let line = khat_threshold(used);
            let size = DrawCounts { chains: CHAINS, draws };
            let Some(weighed) = weigh(prepared, size, stream) else {
                continue;
            };
            if weighed.khat() > line {
                continue;
            }
            let full = weighed.full_draws(&prepared.posterior);
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let ln_weights = weighed.ln_ratios();
            let draws = LooDraws {
                count: used,
                r_eff: 1.0,
                ln_weights: Some(&ln_weights),
            };
            let Ok(loo) = self.out_of(&full, draws) else {
                continue;
            };
            let of_difference = beside.and_then(|beside| difference(&loo, beside)?.se);
            let enough = LARGEST_MCSE.max(LARGEST_SHARE * of_difference.unwrap_or(0.0));
            let (worst, high) = loo.worst_khat(line);
            let is_few = high * MANY_BESIDE <= self.runs.len();
            let is_hopeless = is_few && worst.is_some_and(|khat| khat > HOPELESS + weighed.khat().max(0.0));
            if high == 0 || is_hopeless {
                let done = is_hopeless || loo.mcse <= enough;
                let sampled = weighed.resample(prepared, 1, stream);
                best = Some(LeftOutModel { sampled, loo, used });
                if done {
                    break;
                }
            }
        }
        best
    }

    /// By so many of draws that weigh the same.
    fn of_sampled(&self, sampled: &Sampled, used: usize) -> Result<Loo, String> {
        let full = sampled.full_draws();
        let step = full.len().div_ceil(used).max(1);
        let some: Vec<&[f64]> = full.iter().step_by(step).map(Vec::as_slice).collect();
        let draws = LooDraws::of_one_weight(some.len(), efficiency(sampled));
        self.out_of(&some, draws)
    }

    /// Where series have offsets a whole series is left out: a run would leave its offset known, which takes what a form
    /// misfits between series.
    fn out_of(&self, full: &[&[f64]], draws: LooDraws) -> Result<Loo, String> {
        let Leaving { scene, runs, setup } = *self;
        let pointwise = Pointwise::new(scene, runs, setup.form);
        if scene.model.series_offsets {
            let rows = Likelihood::of_rows(scene, runs, setup.form);
            return leave_series_out(&SeriesDensities::new(pointwise, rows, runs), full, draws);
        }
        let some = pointwise.at_draws(full.to_vec());
        let fill = |runs: Range<usize>, rows: &mut [f64]| some.ln_likelihoods(runs, rows);
        loo(runs.len(), draws, fill).map_err(|(run, why)| format!("run {}: {why}", run + 1))
    }
}

/// Leaves out dry runs one by one and whole series.
fn leave_series_out(units: &SeriesDensities, full: &[&[f64]], draws: LooDraws) -> Result<Loo, String> {
    let each: Result<Vec<Vec<f64>>, _> = full.par_iter().map(|full| units.ln_densities(full)).collect();
    let each = each.map_err(|_| "a draw has no density".to_owned())?;
    let fill = |some: Range<usize>, rows: &mut [f64]| {
        for (unit, row) in some.zip(rows.chunks_exact_mut(each.len().max(1))) {
            for (value, of_draw) in row.iter_mut().zip(&each) {
                *value = of_draw[unit];
            }
        }
    };
    let found = loo(units.len(), draws, fill);
    found.map_err(|(unit, why)| format!("dry run or series {}: {why}", unit + 1))
}

/// Relative efficiency of the draws over the sampled parameters.
fn efficiency(sampled: &Sampled) -> f64 {
    let each = sampled.values.iter().filter_map(|chains| summary_of(chains).ess_mean);
    let ess: Vec<f64> = each.collect();
    relative_efficiency(&ess, sampled.chains.len(), sampled.draws())
}

/// The largest R-hat of the sampled parameters; `None` where no trajectories were followed.
pub(super) fn largest_rhat(sampled: &Sampled) -> Option<f64> {
    let each = sampled.values.iter().filter_map(|chains| summary_of(chains).rhat);
    each.filter(|_| sampled.method.is_nuts()).reduce(f64::max)
}

fn summary_of(chains: &[Vec<f64>]) -> Summary {
    let slices: Vec<&[f64]> = chains.iter().map(Vec::as_slice).collect();
    summarise(&slices)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::findings;
    use crate::inference::nuts::Effort;
    use crate::inference::sampling::sample_by_nuts;
    use crate::physics::dry::REFERENCE_SPEED;
    use crate::physics::{DrySpeed, Form, Inertia};
    use crate::{runs, scene};

    /// The elpd of forms that fit well and badly, by weighed draws and by many of trajectories: as far apart as their Monte
    /// Carlo errors say, and not so without the weights.
    #[test]
    fn weighed_draws_leave_out_as_trajectories_do() {
        const DRAWS: usize = 3500;
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
        let scene = scene::read(&path).expect("a good scene");
        let table = runs::read(&scene).expect("good runs");
        let found = findings::fit_least_squares(&scene, &table, 1, false);
        let runs = &table.runs;
        for inertia in [Inertia::Saturating, Inertia::None] {
            let setup = SamplingSetup {
                form: Form::new(inertia, DrySpeed::Reference(REFERENCE_SPEED)),
                method: Default::default(),
            };
            let leaving = Leaving {
                scene: &scene,
                runs,
                setup,
            };
            let parameters = ModelParameters::of(&scene, runs, setup.form).expect("room");
            let rows = Likelihood::of_rows(&scene, runs, setup.form);
            let start = start(found.least_squares());
            let prepared = PreparedPosterior::new(parameters, &rows, &start, setup.method.evaluation());
            let prepared = prepared.expect("a start");
            let stream = StreamName::new(1, "weighed_draws_leave_out_as_trajectories_do");
            let weighed = leaving.weighed(&prepared, stream, None).expect("weights that do");
            let long = Effort {
                draws: DRAWS,
                ..effort(&scene)
            };
            let long = sample_by_nuts(&prepared, long, stream, &|_, _| {}).expect("chains");
            let long = leaving.of_sampled(&long, long.draws()).expect("finite");
            let z = |loo: &Loo| {
                let apart = difference(loo, &long).expect("the same runs");
                apart.value / apart.mcse
            };
            assert!(z(&weighed.loo).abs() < 4.0, "{inertia:?} {}", z(&weighed.loo));
            assert!(weighed.loo.mcse < 0.1, "{inertia:?} {}", weighed.loo.mcse);
            // as if the proposal were the posterior
            let size = DrawCounts {
                chains: CHAINS,
                draws: ATTEMPTS[1],
            };
            let proposed = weigh(&prepared, size, stream).expect("weights");
            let full = proposed.full_draws(&prepared.posterior);
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let plain = LooDraws::of_one_weight(full.len(), 1.0);
            let plain = leaving.out_of(&full, plain).expect("finite");
            assert!(z(&plain).abs() > 4.0, "{inertia:?} {}", z(&plain));
        }
    }
}
