//! Draws from a model as cheaply as leaving out its runs allows, and predicts each run from the others.
//!
//! Most posteriors of this kind are so near to a normal that draws of one, weighed by what the posterior has there, serve:
//! a thousand of them cost less than one chain's warm-up. Their weights times those of leaving a run out have one Pareto
//! tail, whose shape says whether they do; where it does not, trajectories are followed. A few runs that weigh too much to be
//! left out by weights are left out by draws that are made without them.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use rayon::prelude::*;

use super::least_squares::LeastSquares;
use super::posterior::{effort, start, until_mixed, why_not_sampled, PosteriorRefusal, SamplingSetup};
use crate::inference::diagnostics::loo::{difference, loo, relative_efficiency, LeftOutRun, Loo, LooDraws, WithoutRun};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::{summarise, Summary};
use crate::inference::nuts::Watcher;
use crate::inference::prepared_posterior::PreparedPosterior;
use crate::inference::sampling::{follow_until_mixed, Method, Sampled, SamplingPlan};
use crate::inference::weighing::{LeftOutRuns, WeighedDraws, Weighing};
use crate::model::likelihood::pointwise::{self, Pointwise};
use crate::model::likelihood::{Likelihood, SeriesDensities};
use crate::model::parameters::ModelParameters;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::seed::StreamName;

/// Log densities, runs times draws, that may be computed for one model.
pub const MOST_DENSITIES: usize = 20_000_000;

/// Runs up to which other models are drawn where the density of each is an integral: of more, all of them take minutes.
const MOST_INTEGRATED: usize = 600;

/// Fewer draws than this do not carry the weights.
const FEWEST_DRAWS: usize = 400;

/// Chains that proposals are drawn in, so that threads share them.
const CHAINS: usize = 4;

/// Draws a chain that are tried in turn, the last where few runs make them cheap.
const ATTEMPTS: [usize; 6] = [200, 500, 1000, 2000, 3500, 14_000];

/// Draws a chain that say what a parameter is, too.
pub(super) const FOR_PARAMETERS: usize = 500;

/// Monte Carlo error of an elpd with which draws do: that of the difference of two is then no more than 0.1.
const LARGEST_MCSE: f64 = 0.1 * FRAC_1_SQRT_2;

/// The same as a share of the standard error of a difference, whose own is then no more than a twentieth of it: one of forty
/// standard errors need not be known to 0.1.
const LARGEST_SHARE: f64 = 0.05 * FRAC_1_SQRT_2;

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

/// How many of the draws can leave each run out; `None` for too many runs, few that stand for them, or without wet ones.
pub(super) fn affordable_draws(runs: &Runs, draws: usize) -> Option<usize> {
    let used = draws.min(MOST_DENSITIES / runs.all_measured().max(1));
    (used >= FEWEST_DRAWS.min(draws) && !runs.series.is_empty() && runs.count.is_empty()).then_some(used)
}

/// Why no other model of these runs is drawn beside the scene's own, of which there are so many draws; `None` where they are.
pub(super) fn why_none_beside(scene: &Scene, runs: &Runs, draws: usize) -> Option<String> {
    let all = runs.all_measured();
    if runs.series.is_empty() {
        Some("no wet runs in use".to_owned())
    } else if affordable_draws(runs, draws).is_none() {
        Some(format!("{all} runs are too many to leave each out"))
    } else if all > MOST_INTEGRATED && pointwise::is_integrated(scene, runs) {
        Some(format!(
            "the density of each of {all} runs is an integral, and other models are drawn for up to {MOST_INTEGRATED} of those"
        ))
    } else {
        None
    }
}

/// How well a left-out model must be known.
#[derive(Clone, Copy, Default)]
pub(super) struct Asked<'l> {
    /// what it is compared with, where that is known: it says how small a Monte Carlo error need be
    pub beside: Option<&'l Loo>,
    /// draws a chain at least
    pub fewest: usize,
}

/// Draws from a model with streams of this name and leaves each run out; `Err` says why that cannot be done.
pub(super) fn draw_and_leave_out(
    context: ComparisonContext,
    setup: SamplingSetup,
    parameters: ModelParameters,
    stream: &str,
    asked: Asked,
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
    let leaving = Leaving::new(scene, runs, setup);
    if let Some(found) = leaving.weighed(&prepared, stream, asked) {
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
    let mut loo = leaving.of_sampled(&sampled, used)?;
    if let Some(weighing) = Weighing::new(&prepared, CHAINS, stream) {
        loo = leaving.drawn_without(&weighing, loo, used);
    }
    Ok(LeftOutModel { sampled, loo, used })
}

/// PSIS leave-one-out of a sampled model, by so many of its draws; `Err` says which run stands in the way.
pub(super) fn leave_out(
    context: ComparisonContext,
    setup: SamplingSetup,
    sampled: &Sampled,
    used: usize,
) -> Result<Loo, String> {
    let ComparisonContext {
        scene,
        runs,
        least_squares,
        ..
    } = context;
    let leaving = Leaving::new(scene, runs, setup);
    let loo = leaving.of_sampled(sampled, used)?;
    if loo.worst_khat(khat_threshold(used)).1 == 0 {
        return Ok(loo);
    }
    let rows = Likelihood::of_rows(scene, runs, setup.form);
    let start = start(least_squares);
    let parameters = sampled.parameters.clone();
    let Ok(prepared) = PreparedPosterior::new(parameters, &rows, &start, setup.method.evaluation()) else {
        return Ok(loo);
    };
    let stream = StreamName::new(least_squares.seed, "leave out");
    Ok(match Weighing::new(&prepared, CHAINS, stream) {
        Some(weighing) => leaving.drawn_without(&weighing, loo, used),
        None => loo,
    })
}

/// What is left out: each run or, where series have offsets, each dry run and series, since a run would leave its series'
/// offset known, which takes what a form misfits between series.
enum Units<'r> {
    Runs(Box<Pointwise<'r>>),
    Series(Box<SeriesDensities<'r>>),
}

/// The runs that are left out of a model.
struct Leaving<'r> {
    runs: &'r Runs,
    units: Units<'r>,
    /// whether the density of one unit costs little beside that of all
    can_draw_without: bool,
}

impl<'r> Leaving<'r> {
    fn new(scene: &Scene, runs: &'r Runs, setup: SamplingSetup) -> Leaving<'r> {
        let pointwise = Pointwise::new(scene, runs, setup.form);
        Leaving {
            runs,
            can_draw_without: !pointwise.is_integrated(),
            units: if scene.model.series_offsets {
                let rows = Likelihood::of_rows(scene, runs, setup.form);
                Units::Series(Box::new(SeriesDensities::new(pointwise, rows, runs)))
            } else {
                Units::Runs(Box::new(pointwise))
            },
        }
    }

    /// By draws of a proposal with weights, by more of them as long as the Monte Carlo error is too large; `None` where the
    /// weights do not do.
    fn weighed(&self, prepared: &PreparedPosterior, stream: StreamName, asked: Asked) -> Option<LeftOutModel> {
        let weighing = Weighing::new(prepared, CHAINS, stream)?;
        let mut found = None;
        // so many will do, by what those before say
        let mut needed = 0.0;
        let mut attempts = ATTEMPTS.into_iter().filter(|draws| *draws >= asked.fewest).peekable();
        while let Some(draws) = attempts.next() {
            let used = CHAINS * draws;
            if !self.can_afford(used) {
                break;
            }
            if (used as f64) < needed && attempts.peek().is_some_and(|more| self.can_afford(CHAINS * more)) {
                continue;
            }
            let line = khat_threshold(used);
            let Some(weighed) = weighing.draw(draws).filter(|weighed| weighed.khat() <= line) else {
                continue;
            };
            let full = weighed.full_draws(&prepared.posterior);
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let ln_weights = weighed.ln_ratios();
            let draws = LooDraws {
                count: used,
                r_eff: 1.0,
                ln_weights: Some(&ln_weights),
            };
            let Ok(loo) = self.units.leave_out(&full, draws) else {
                continue;
            };
            let of_difference = asked.beside.and_then(|beside| difference(&loo, beside)?.se);
            let enough = LARGEST_MCSE.max(LARGEST_SHARE * of_difference.unwrap_or(0.0));
            needed = used as f64 * (loo.mcse / enough).powi(2);
            let all_leave = self.can_draw_without || self.do_weights(&loo, &weighed, line);
            let done = all_leave && loo.mcse <= enough;
            found = Some((weighed, loo, used));
            if done {
                break;
            }
        }
        let (weighed, loo, used) = found?;
        let loo = self.drawn_without(&weighing, loo, used);
        self.do_weights(&loo, &weighed, khat_threshold(used))
            .then(|| LeftOutModel {
                sampled: weighed.resample(prepared, 1, stream),
                loo,
                used,
            })
    }

    /// Whether each run can be left out of so many draws.
    fn can_afford(&self, used: usize) -> bool {
        /// that many where the density of a run is an integral
        const OF_INTEGRALS: usize = 14_000;
        let most = if self.can_draw_without { used } else { OF_INTEGRALS };
        used <= most && affordable_draws(self.runs, used) == Some(used)
    }

    /// Whether draws leave out all runs, but for a few that no draws do.
    fn do_weights(&self, loo: &Loo, weighed: &WeighedDraws, line: f64) -> bool {
        let (worst, high) = loo.worst_khat(line);
        let is_few = high * MANY_BESIDE <= self.runs.len();
        high == 0 || is_few && worst.is_some_and(|khat| khat > HOPELESS + weighed.khat().max(0.0))
    }

    /// With runs that weights do not leave out left out by draws of the posterior without them: the density of a run given
    /// the others is that of all over that of the others.
    fn drawn_without(&self, weighing: &Weighing, loo: Loo, used: usize) -> Loo {
        /// runs for which that is done
        const MOST: usize = 16;
        /// draws a chain for each integral, the more the fewer runs make them dear; that of all, whose error each run has, has
        /// more, up to so many times these
        const DRAWS: [usize; 2] = [500, 4000];
        const DENSITIES: usize = 40_000;
        const MOST_TIMES: usize = 8;
        let integral = (DENSITIES / self.runs.len().max(1)).clamp(DRAWS[0], DRAWS[1]);
        let line = khat_threshold(used);
        let is_high = |(_, run): &(usize, &LeftOutRun)| run.khat.is_some_and(|khat| khat > line);
        let high: Vec<usize> = loo
            .runs
            .iter()
            .enumerate()
            .filter(is_high)
            .map(|(run, _)| run)
            .collect();
        if high.is_empty() || high.len() > MOST || !self.can_draw_without {
            return loo;
        }
        let times = (high.len() * high.len()).min(MOST_TIMES);
        let Some(all) = weighing.draw(times * integral).map(|draws| weighing.integral(&draws)) else {
            return loo;
        };
        let without = |run: &usize| {
            let others = weighing.integral_without(
                &LeftOutRuns {
                    name: format!("{}", run + 1),
                    ln_likelihood: &|full| self.units.ln_densities_of(*run, full),
                },
                integral,
            )?;
            let found = WithoutRun {
                run: *run,
                elpd: all.ln - others.ln,
                khat: all.khat.max(others.khat),
            };
            (found.khat <= khat_threshold(CHAINS * integral)).then_some((found, others.mcse))
        };
        let found: Vec<(WithoutRun, f64)> = high.iter().filter_map(without).collect();
        // that of all is common to all
        let squares: f64 = found.iter().map(|(_, mcse)| mcse * mcse).sum();
        let mcse = (found.len() as f64 * all.mcse).hypot(squares.sqrt());
        let found: Vec<WithoutRun> = found.into_iter().map(|(run, _)| run).collect();
        loo.with(&found, mcse)
    }

    /// By so many of draws that weigh the same.
    fn of_sampled(&self, sampled: &Sampled, used: usize) -> Result<Loo, String> {
        let full = sampled.full_draws();
        let step = full.len().div_ceil(used).max(1);
        let some: Vec<&[f64]> = full.iter().step_by(step).map(Vec::as_slice).collect();
        let draws = LooDraws::of_one_weight(some.len(), efficiency(sampled));
        self.units.leave_out(&some, draws)
    }
}

impl Units<'_> {
    fn leave_out(&self, full: &[&[f64]], draws: LooDraws) -> Result<Loo, String> {
        match self {
            Units::Runs(pointwise) => {
                let some = pointwise.at_draws(full.to_vec());
                let fill = |runs: Range<usize>, rows: &mut [f64]| some.ln_likelihoods(runs, rows);
                let found = loo(pointwise.len(), draws, fill);
                found.map_err(|(run, why)| format!("run {}: {why}", run + 1))
            }
            Units::Series(units) => leave_series_out(units, full, draws),
        }
    }

    /// Log density of one at some draws; not a number where a draw has none.
    fn ln_densities_of(&self, unit: usize, full: &[Vec<f64>]) -> Vec<f64> {
        match self {
            Units::Runs(pointwise) => {
                let mut row = vec![0.0; full.len()];
                let full = full.iter().map(Vec::as_slice).collect();
                pointwise.at_draws(full).ln_likelihoods(unit..unit + 1, &mut row);
                row
            }
            Units::Series(units) => {
                let of_unit = |full: &Vec<f64>| units.ln_densities(full).map_or(f64::NAN, |each| each[unit]);
                full.par_iter().map(of_unit).collect()
            }
        }
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
    each.filter(|_| sampled.method == Method::Nuts).reduce(f64::max)
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
            let leaving = Leaving::new(&scene, runs, setup);
            let parameters = ModelParameters::of(&scene, runs, setup.form).expect("room");
            let rows = Likelihood::of_rows(&scene, runs, setup.form);
            let start = start(found.least_squares());
            let prepared = PreparedPosterior::new(parameters, &rows, &start, setup.method.evaluation());
            let prepared = prepared.expect("a start");
            let stream = StreamName::new(1, "weighed_draws_leave_out_as_trajectories_do");
            let weighed = leaving
                .weighed(&prepared, stream, Asked::default())
                .expect("weights that do");
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
            let weighing = Weighing::new(&prepared, CHAINS, stream).expect("weights");
            let proposed = weighing.draw(1000).expect("weights");
            let full = proposed.full_draws(&prepared.posterior);
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let plain = LooDraws::of_one_weight(full.len(), 1.0);
            let plain = leaving.units.leave_out(&full, plain).expect("finite");
            assert!(z(&plain).abs() > 4.0, "{inertia:?} {}", z(&plain));
        }
    }

    /// A run that is wildly off is left out as draws of the other runs alone leave it, and not as draws of all do.
    #[test]
    fn a_run_that_weighs_too_much_is_left_out_by_draws_without_it() {
        /// the last of the table that rebounds in a thick film, and by how much it is off
        const OFF: f64 = 0.15;
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/mueller2016/scene.toml");
        let mut scene = scene::read(&path).expect("a good scene");
        let text = std::fs::read_to_string(&scene.data.runs[0].path).expect("runs");
        let lines: Vec<&str> = text.lines().step_by(7).collect();
        let parts = |line: &str| {
            let (before, e) = line.rsplit_once(',').expect("columns");
            (before.to_owned(), e.parse().unwrap_or(0.0))
        };
        let place = lines
            .iter()
            .rposition(|line| line.contains("M50") && parts(line).1 > 0.3);
        let place = place.expect("a rebound");
        let (before, e): (String, f64) = parts(lines[place]);
        let off = format!("{before},{}", e - OFF);
        let folder = tempfile::TempDir::new().expect("a folder");
        let mut read = |lines: &[&str]| {
            // the first of seven lines is the header, then every seventh run
            scene.data.runs = vec![folder.path().join(format!("{}.csv", lines.len())).into()];
            std::fs::write(&scene.data.runs[0].path, lines.join("\n")).expect("room");
            (runs::read(&scene).expect("good runs"), scene.clone())
        };
        let mut with = lines.clone();
        with[place] = &off;
        let (all, scene_of_all) = read(&with);
        with.remove(place);
        let (others, scene_of_others) = read(&with);
        let form = Form::new(Inertia::Saturating, DrySpeed::Reference(REFERENCE_SPEED));
        let setup = SamplingSetup {
            form,
            method: Default::default(),
        };
        let stream = StreamName::new(1, "a_run_that_weighs_too_much_is_left_out_by_draws_without_it");
        let weighing_of = |table: &runs::Table, scene: &Scene, then: &dyn Fn(&PreparedPosterior, Weighing)| {
            let found = findings::fit_least_squares(scene, table, 1, false);
            let parameters = ModelParameters::of(scene, &table.runs, form).expect("room");
            let rows = Likelihood::of_rows(scene, &table.runs, form);
            let start = start(found.least_squares());
            let prepared = PreparedPosterior::new(parameters, &rows, &start, setup.method.evaluation());
            let prepared = prepared.expect("a start");
            then(&prepared, Weighing::new(&prepared, CHAINS, stream).expect("weights"));
        };
        let leaving = Leaving::new(&scene_of_all, &all.runs, setup);
        let run = (0..all.runs.len())
            .find(|run| (all.runs.restitution[*run] - (e - OFF)).abs() < 1e-12)
            .expect("the run");
        let predicted = |prepared: &PreparedPosterior, sampled: &Sampled| {
            let ln = leaving.units.ln_densities_of(run, &sampled.full_draws());
            assert_eq!(ln.len(), sampled.draws());
            assert!(prepared.bound.is_some());
            let top = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            top + (ln.iter().map(|ln| (ln - top).exp()).sum::<f64>() / ln.len() as f64).ln()
        };
        let long = Effort {
            draws: 4000,
            ..effort(&scene_of_all)
        };
        let by_trajectories = std::cell::Cell::new(0.0);
        weighing_of(&others, &scene_of_others, &|prepared, _| {
            let sampled = sample_by_nuts(prepared, long, stream, &|_, _| {}).expect("chains");
            by_trajectories.set(predicted(prepared, &sampled));
        });
        weighing_of(&all, &scene_of_all, &|prepared, weighing| {
            let sampled = sample_by_nuts(prepared, long, stream, &|_, _| {}).expect("chains");
            let used = sampled.draws();
            let loo = leaving.of_sampled(&sampled, used).expect("finite");
            let khat = loo.runs[run].khat.expect("a shape");
            assert!(khat > khat_threshold(used), "{khat}");
            let mended = leaving.drawn_without(&weighing, loo, used);
            let expected = by_trajectories.get();
            let shape = mended.runs[run].khat.expect("a shape");
            assert!(shape < khat_threshold(used), "{shape}");
            let gap = mended.runs[run].elpd - expected;
            assert!(gap.abs() < 0.2, "{gap} of {expected}");
            // that of draws which have seen the run
            let seen = predicted(prepared, &sampled) - expected;
            assert!(seen > 1.0, "{seen}");
        });
    }
}
