//! Draws from a model and predicts each run from the others.
//!
//! Draws of Student's t about the mode, weighed by what the posterior has there and resampled, serve where the Pareto tail of
//! these weights allows; else trajectories are followed. A run is left out by weights of the draws (PSIS); a few that weigh
//! too much for that are left out by draws of the posterior without them.

use std::ops::Range;

use rayon::prelude::*;

use super::least_squares::LeastSquares;
use super::posterior::run_densities::{affordable_draws, RunDensities, FEWEST_DRAWS};
use super::posterior::{effort, start, why_not_sampled, SamplingSetup};
use crate::inference::diagnostics::loo::{difference, loo, relative_efficiency, Loo, LooDraws, WithoutRun};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::importance::DrawCounts;
use crate::inference::mixing::summary_of;
use crate::inference::nuts::{Effort, SamplingPlan, Watcher};
use crate::inference::prepared_posterior::PreparedPosterior;
use crate::inference::sampling::{sample_by_importance, sample_by_nuts, Method, Sampled, PROPOSED};
use crate::model::likelihood::pointwise::{self, Pointwise};
use crate::model::likelihood::{Likelihood, SeriesDensities};
use crate::model::parameters::ModelParameters;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::seed::StreamName;

/// Runs up to which other models are drawn where the density of each is an integral: of more, all of them take minutes.
const MOST_INTEGRATED: usize = 600;

/// Densities, draws a chain times runs, that a model beside the scene's own is judged by, and the draws that this may ask for:
/// few runs make them cheap, and leave the Monte Carlo error large. Where each density is an integral it is the fewest.
const DENSITIES_BESIDE: usize = 400_000;
const DRAWS_BESIDE: [usize; 2] = [500, 2000];

/// Draws that a chain of such a model spends adapting: the space is round already, and more of them have not made chains mix
/// better in scenes with noise on the energy, errors of the speeds or films of their own.
const WARMUP_BESIDE: usize = 300;

/// A form that by rough draws falls behind by more than this in log density, and more than so many standard errors, is not
/// sampled better.
const FAR_BEHIND: f64 = 50.0;
const FAR_BEHIND_IN_SE: f64 = 5.0;

/// Draws that series are left out by, each of which finds the highest offsets anew: the weights of few series need no more.
const DRAWS_OF_SERIES: usize = 2000;

/// Runs, or series, of one model that are left out by draws of their own; where more weigh too much, or more than half of
/// them, the model does not describe them or has as many parameters.
const MOST_REFITS: usize = 8;

/// What models are drawn from.
#[derive(Clone, Copy)]
pub struct ComparisonContext<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// the runs that every model is compared on
    pub runs: &'a Runs,
    /// where sampling starts
    pub least_squares: &'a LeastSquares,
    /// hears of every draw
    pub watcher: Watcher<'a>,
}

/// A model with its draws, every run left out of it.
pub(super) struct LeftOutModel {
    pub sampled: Sampled,
    pub loo: Loo,
    /// by how many draws runs were left out
    pub used: usize,
}

/// Why no other model of these runs is drawn beside the scene's own, of which there are so many draws; `None` where they are.
pub(super) fn why_none_beside(scene: &Scene, runs: &Runs, draws: usize) -> Option<String> {
    let all = runs.all_measured();
    if runs.series.is_empty() {
        Some("no wet runs in use".to_owned())
    } else if affordable_draws(runs, draws).is_none() {
        Some(format!("{all} runs are too many to draw other models of"))
    } else if all > MOST_INTEGRATED && pointwise::is_integrated(scene, runs) {
        Some(format!(
            "the density of each of {all} runs is an integral, and other models are drawn for up to {MOST_INTEGRATED} of those"
        ))
    } else {
        None
    }
}

/// A model that draws are made of, with and without some of the runs.
pub(super) struct Model<'a> {
    pub context: ComparisonContext<'a>,
    pub setup: SamplingSetup,
    pub parameters: &'a ModelParameters,
    /// names the streams
    pub stream: &'a str,
}

impl Model<'_> {
    /// Draws of the model of these runs; a few rough ones where these may do and do. `Err` says why it cannot be sampled.
    pub fn draw(
        &self,
        runs: &Runs,
        stream: &str,
        rough_do: Option<&mut dyn FnMut(&Sampled) -> bool>,
    ) -> Result<Sampled, String> {
        let (scene, least_squares) = (self.context.scene, self.context.least_squares);
        if let Some(why) = why_not_sampled(runs, least_squares, self.parameters) {
            return Err(why.text);
        }
        let likelihood = Likelihood::new(scene, runs, self.setup.form);
        let prepared = PreparedPosterior::new(self.parameters.clone(), &likelihood, &start(least_squares));
        let prepared = prepared.map_err(|why| why.to_string())?;
        let stream = StreamName::new(least_squares.seed, stream);
        let Effort { chains, .. } = effort(scene);
        let draws = match pointwise::is_integrated(scene, runs) {
            true => DRAWS_BESIDE[0],
            false => (DENSITIES_BESIDE / runs.len().max(1)).clamp(DRAWS_BESIDE[0], DRAWS_BESIDE[1]),
        };
        let few = FEWEST_DRAWS.div_ceil(chains);
        let weighed = |draws: usize| sample_by_importance(&prepared, DrawCounts { chains, draws }, stream);
        if let Some(rough) = rough_do.and_then(|rough_do| weighed(few).filter(|rough| rough_do(rough))) {
            return Ok(rough);
        }
        let line = khat_threshold(PROPOSED * chains * draws);
        let serves = |sampled: &Sampled| sampled.khat.is_some_and(|khat| khat <= line);
        if let Some(sampled) = weighed(draws).filter(serves) {
            return Ok(sampled);
        }
        // not followed until they have mixed: how rough the answer is, R-hat and the Monte Carlo error say
        let effort = Effort {
            draws: draws.min(effort(scene).draws),
            warmup: effort(scene).warmup.min(WARMUP_BESIDE),
            ..effort(scene)
        };
        let plan = SamplingPlan {
            effort,
            streams: stream,
            watcher: self.context.watcher,
        };
        let sampled = sample_by_nuts(&prepared, plan, &mut |_| 0);
        sampled.map_err(|why| why.to_string())
    }

    /// Draws of the model of all runs but these, which keep their places among the spheres and series.
    pub fn draw_without(&self, left_out: &Range<usize>) -> Result<Sampled, String> {
        let stream = format!("{} without {}", self.stream, left_out.start + 1);
        self.draw(&self.context.runs.without(left_out), &stream, None)
    }

    /// Draws of the model of all runs, each of them left out; `Err` says why that cannot be done. One that falls far behind
    /// `beside` is judged by whatever draws there are.
    pub fn draw_and_leave_out(&self, beside: Option<&Loo>) -> Result<LeftOutModel, String> {
        let runs = self.context.runs;
        // rough draws of a model that predicts so much less will do
        let is_far = |loo: &Loo| {
            let apart = beside.and_then(|beside| difference(loo, beside));
            apart.is_some_and(|apart| {
                -apart.value > FAR_BEHIND.max(FAR_BEHIND_IN_SE * apart.se.unwrap_or(f64::INFINITY))
            })
        };
        let mut by_rough = None;
        let mut rough_do = |rough: &Sampled| {
            by_rough = self.weigh_out(rough, None).ok().filter(|(loo, _)| is_far(loo));
            by_rough.is_some()
        };
        let sampled = self.draw(runs, self.stream, Some(&mut rough_do))?;
        let (mut loo, used) = by_rough.map_or_else(|| self.weigh_out(&sampled, None), Ok)?;
        if !is_far(&loo) {
            loo = self.mend(loo, &sampled, used);
        }
        Ok(LeftOutModel { sampled, loo, used })
    }

    /// PSIS leave-one-out by its draws, where the runs may have known densities, with how many could be used; `Err` says which
    /// run stands in the way.
    pub fn leave_out(&self, sampled: &Sampled, held: Option<&RunDensities>) -> Result<(Loo, usize), String> {
        let (loo, used) = self.weigh_out(sampled, held)?;
        Ok((self.mend(loo, sampled, used), used))
    }

    /// Each run left out by weights alone.
    fn weigh_out(&self, sampled: &Sampled, held: Option<&RunDensities>) -> Result<(Loo, usize), String> {
        let used = affordable_draws(self.context.runs, sampled.draws()).ok_or("too many runs to leave each out")?;
        let has_offsets = self.context.scene.model.series_offsets;
        let used = if has_offsets { used.min(DRAWS_OF_SERIES) } else { used };
        let units = Units::new(self.context.scene, self.context.runs, self.setup);
        let full = sampled.full_draws();
        let step = full.len().div_ceil(used).max(1);
        let some: Vec<&[f64]> = full.iter().step_by(step).map(Vec::as_slice).collect();
        let draws = LooDraws {
            count: some.len(),
            r_eff: efficiency(sampled),
        };
        Ok((units.leave_out(&some, draws, held)?, used))
    }

    /// Runs left out by weights, but a few that weigh too much by draws without them.
    fn mend(&self, loo: Loo, sampled: &Sampled, used: usize) -> Loo {
        let units = Units::new(self.context.scene, self.context.runs, self.setup);
        let line = khat_threshold(used);
        let is_high = |unit: &usize| loo.runs[*unit].khat.is_some_and(|khat| khat > line);
        let high: Vec<usize> = (0..loo.runs.len()).filter(is_high).collect();
        if high.is_empty() || high.len() > MOST_REFITS.min(loo.runs.len() / 2) || units.are_integrals() {
            return loo;
        }
        let predicted = |unit: usize| self.predicted(&units, unit, sampled);
        let found: Vec<WithoutRun> = high.into_iter().filter_map(predicted).collect();
        loo.with(&found)
    }

    /// The density of a run or series given the others, by draws without it and with it; `None` where these are too far apart.
    fn predicted(&self, units: &Units, unit: usize, with: &Sampled) -> Option<WithoutRun> {
        let without = self.draw_without(&units.runs_of(unit)).ok()?;
        let [of_others, of_all] = [&without, with].map(|sampled| units.ln_densities_of(unit, &sampled.full_draws()));
        let fewest = of_others.len().min(of_all.len());
        let of_others = (&of_others[..], efficiency(&without));
        let found = WithoutRun::between(unit, of_others, (&of_all, efficiency(with)))?;
        (found.khat <= khat_threshold(fewest)).then_some(found)
    }
}

/// What is left out: each run or, where series have offsets, each dry run and series, since a run would leave its series'
/// offset known, which takes what a form misfits between series.
enum Units<'r> {
    Runs(Box<Pointwise>),
    Series(Box<SeriesDensities<'r>>),
}

impl<'r> Units<'r> {
    fn new(scene: &Scene, runs: &'r Runs, setup: SamplingSetup) -> Units<'r> {
        if scene.model.series_offsets {
            let likelihood = Likelihood::new(scene, runs, setup.form);
            Units::Series(Box::new(SeriesDensities::new(likelihood, runs)))
        } else {
            Units::Runs(Box::new(Pointwise::new(scene, runs, setup.form)))
        }
    }

    /// Whether the density of one costs as much as that of many, or is told by runs that share its true speed.
    fn are_integrals(&self) -> bool {
        match self {
            Units::Runs(pointwise) => pointwise.is_integrated(),
            Units::Series(units) => units.are_integrals(),
        }
    }

    fn runs_of(&self, unit: usize) -> Range<usize> {
        match self {
            Units::Runs(_) => unit..unit + 1,
            Units::Series(units) => units.runs_of(unit),
        }
    }

    fn leave_out(&self, full: &[&[f64]], draws: LooDraws, held: Option<&RunDensities>) -> Result<Loo, String> {
        match self {
            Units::Runs(pointwise) => {
                let found = match held {
                    Some(held) => loo(pointwise.len(), draws, |runs, rows| {
                        rows.copy_from_slice(held.rows(runs))
                    }),
                    None => {
                        let some = pointwise.at_draws(full.to_vec());
                        loo(pointwise.len(), draws, |runs, rows| some.ln_likelihoods(runs, rows))
                    }
                };
                found.map_err(|run| format!("run {}: a draw is not finite", run + 1))
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
    let found = loo(units.count(), draws, fill);
    found.map_err(|unit| format!("dry run or series {}: a draw is not finite", unit + 1))
}

/// Relative efficiency of the draws: over the sampled parameters, or what their weights leave of them.
fn efficiency(sampled: &Sampled) -> f64 {
    if sampled.method != Method::Nuts {
        return sampled.mcse_factor.powi(-2);
    }
    let each = sampled.values.iter().filter_map(|chains| summary_of(chains).ess_mean);
    let ess: Vec<f64> = each.collect();
    relative_efficiency(&ess, sampled.chains.len(), sampled.draws())
}

/// The largest R-hat of the sampled parameters; `None` where no trajectories were followed.
pub(super) fn largest_rhat(sampled: &Sampled) -> Option<f64> {
    let followed = sampled.values.iter().filter(|_| sampled.method == Method::Nuts);
    followed.filter_map(|chains| summary_of(chains).rhat).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::fit_least_squares;
    use crate::findings::tests::read_example;
    use crate::physics::dry::REFERENCE_SPEED;
    use crate::physics::{DrySpeed, Form, Inertia};
    use crate::runs::Table;

    const SCENE: &str = "datasets/mueller2016/scene.toml";

    /// Has a model of these runs do something.
    fn with_model(scene: &Scene, table: &Table, inertia: Inertia, stream: &str, then: impl Fn(&Model)) {
        let found = fit_least_squares(scene, table, 1, false);
        let setup = SamplingSetup {
            form: Form::new(inertia, DrySpeed::Reference(REFERENCE_SPEED)),
            method: Default::default(),
        };
        let parameters = ModelParameters::of(scene, &table.runs, setup.form).expect("room");
        then(&Model {
            context: ComparisonContext {
                scene,
                runs: &table.runs,
                least_squares: &found.fits,
                watcher: &|_, _| {},
            },
            setup,
            parameters: &parameters,
            stream,
        });
    }

    fn followed(model: &Model, draws: usize) -> Sampled {
        let context = &model.context;
        let likelihood = Likelihood::new(context.scene, context.runs, model.setup.form);
        let start = start(context.least_squares);
        let prepared = PreparedPosterior::new(model.parameters.clone(), &likelihood, &start).expect("a start");
        let long = Effort {
            draws,
            ..effort(context.scene)
        };
        let plan = SamplingPlan::new(long, StreamName::new(1, model.stream));
        sample_by_nuts(&prepared, plan, &mut |_| 0).expect("chains")
    }

    /// The elpd of forms that fit well and badly, by draws of Student's t about the mode and by many of trajectories: as far
    /// apart as their Monte Carlo errors say.
    #[test]
    fn weighed_draws_leave_out_as_trajectories_do() {
        let name = "weighed_draws_leave_out_as_trajectories_do";
        let (scene, table) = read_example(SCENE);
        for inertia in [Inertia::Saturating, Inertia::None] {
            with_model(&scene, &table, inertia, name, |model| {
                let drawn = model.draw(&table.runs, name, None).expect("draws");
                assert_eq!(drawn.method, Method::LaplacePsis);
                let left_out = |sampled: &Sampled| model.leave_out(sampled, None).expect("finite").0;
                let weighed = left_out(&drawn);
                let long = left_out(&followed(model, 3500));
                let apart = difference(&weighed, &long).expect("the same runs");
                let z = apart.value / apart.mcse;
                assert!(z.abs() < 4.0, "{inertia:?} {z}");
                assert!(weighed.mcse < 0.2, "{inertia:?} {}", weighed.mcse);
            });
        }
    }

    /// A run that is wildly off is left out as draws of the other runs alone leave it, and not as draws of all do.
    #[test]
    fn a_run_that_weighs_too_much_is_left_out_by_draws_without_it() {
        /// by how much the last run that rebounds well is off
        const OFF: f64 = 0.15;
        const DRAWS: usize = 4000;
        let name = "a_run_that_weighs_too_much_is_left_out_by_draws_without_it";
        let (scene, mut table) = read_example(SCENE);
        table.runs = table.runs.with_runs(|run| run % 7 == 0);
        let run = table
            .runs
            .restitution
            .iter()
            .rposition(|e| *e > 0.3)
            .expect("a rebound");
        table.runs.restitution[run] -= OFF;
        with_model(&scene, &table, Inertia::Saturating, name, |model| {
            let sampled = followed(model, DRAWS);
            let used = sampled.draws();
            let units = Units::new(&scene, &table.runs, model.setup);
            // ln of the mean density, with its standard error as if the draws were independent
            let mean_density = |sampled: &Sampled| {
                let ln = units.ln_densities_of(run, &sampled.full_draws());
                let (top, n) = (ln.iter().copied().fold(f64::NEG_INFINITY, f64::max), ln.len() as f64);
                let scaled = || ln.iter().map(|ln| (ln - top).exp());
                let mean = scaled().sum::<f64>() / n;
                let variance = scaled().map(|x| (x / mean - 1.0).powi(2)).sum::<f64>() / n;
                (top + mean.ln(), (variance / n).sqrt())
            };
            let others = table.runs.without(&(run..run + 1));
            let without = Model {
                context: ComparisonContext {
                    runs: &others,
                    ..model.context
                },
                ..*model
            };
            let (expected, error) = mean_density(&followed(&without, DRAWS));
            let full = sampled.full_draws();
            let full: Vec<&[f64]> = full.iter().map(Vec::as_slice).collect();
            let draws = LooDraws {
                count: used,
                r_eff: 1.0,
            };
            let plain = units.leave_out(&full, draws, None).expect("finite");
            let khat = plain.runs[run].khat.expect("a shape");
            assert!(khat > khat_threshold(used), "{khat}");
            let mended = model.mend(plain, &sampled, used);
            let shape = mended.runs[run].khat.expect("a shape");
            assert!(shape < khat_threshold(used), "{shape}");
            let gap = mended.runs[run].elpd - expected;
            // both are of as many draws
            let line = 4.0 * 2f64.sqrt() * error;
            assert!(gap.abs() < line, "{gap} of {expected}, line {line}");
            // that of draws which have seen the run
            let seen = mean_density(&sampled).0 - expected;
            assert!(seen > 2.0 * line, "{seen}, line {line}");
        });
    }
}
