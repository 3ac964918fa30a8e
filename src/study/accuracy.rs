//! Measures how often a requested accuracy is kept, on simulated scenes with a long run for each.

use std::path::Path;

use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::findings;
use crate::findings::posterior::{fit_posterior, MethodChoice, Posterior, SamplingSetup};
use crate::inference::diagnostics::summary::Summary;
use crate::inference::mixing::summary_of;
use crate::inference::nuts::{Effort, TARGET_ACCEPT};
use crate::inference::prepared_posterior::{Evaluation, PreparedPosterior};
use crate::inference::sampling::{sample_by_nuts, Method, Sampled};
use crate::model::likelihood::Likelihood;
use crate::model::parameters::ModelParameters;
use crate::model::simulate::Simulation;
use crate::physics::Form;
use crate::ranks::Ranks;
use crate::runs::{self, Table};
use crate::scene::{self, Scene};
use crate::seed::{stream, StreamName};

/// Accuracies that are requested.
pub const REQUESTED: [f64; 4] = [0.3, 0.2, 0.1, 0.05];

/// A long run's Monte Carlo error is at most this share of the accuracy.
const SHARE: f64 = 0.1;

/// Simulated scenes.
pub const SCENES: u64 = 200;

/// The share of scenes in which an accuracy must be kept.
pub const KEPT: f64 = 0.95;

/// How often one accuracy was kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Promise {
    /// the accuracy
    pub requested: f64,
    /// what came out where it was reached, by the method's own word
    pub answers: Vec<Answer>,
}

/// What came out where an accuracy was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// the method taken
    pub method: Method,
    /// the true error
    pub error: f64,
    /// whether every check of the sampling passed
    pub quotable: bool,
}

impl Promise {
    /// Scenes whose true error is no larger than `line`.
    pub fn within(&self, line: f64) -> usize {
        self.answers.iter().filter(|answer| answer.error <= line).count()
    }

    /// Scenes that kept the accuracy, and may be quoted as far as the sampling goes.
    pub fn quotable_where_kept(&self) -> usize {
        let kept = self.answers.iter().filter(|answer| answer.error <= self.requested);
        kept.filter(|answer| answer.quotable).count()
    }

    /// How far the share of scenes within `line` lies from [`KEPT`], in standard errors of a binomial share.
    pub fn z(&self, line: f64) -> f64 {
        let n = self.answers.len() as f64;
        (self.within(line) as f64 / n - KEPT) / (KEPT * (1.0 - KEPT) / n).sqrt()
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct AccuracyTable {
    /// scenes
    pub scenes: u64,
    /// scenes left out, because no long run converged
    pub left_out: u64,
    /// each accuracy
    pub promises: Vec<Promise>,
}

const METHODS: [Method; 4] = [
    Method::Laplace,
    Method::LaplacePsis,
    Method::NutsCompressed,
    Method::NutsExact,
];

/// Simulates so many scenes, asks each accuracy of each, and holds the answers against a long run over every row.
/// `progress` is called after each scene of this rank.
pub fn measure(scenes: u64, seed: u64, ranks: &Ranks, progress: &dyn Fn()) -> Result<AccuracyTable, Error> {
    let of_scene = |index: u64| {
        let found = one(index, seed)?;
        progress();
        Ok(found)
    };
    // one after the other: the chains of each take every thread, and many long runs at once would fill the memory
    let found = ranks.gather(scenes, |own| own.into_iter().map(of_scene).collect())?;
    let promise = |(place, requested): (usize, &f64)| Promise {
        requested: *requested,
        answers: found.iter().flatten().filter_map(|answers| answers[place]).collect(),
    };
    let promises = REQUESTED.iter().enumerate().map(promise).collect();
    Ok(AccuracyTable {
        scenes,
        left_out: found.iter().filter(|found| found.is_none()).count() as u64,
        promises,
    })
}

/// For each accuracy what came out, if it was reached; `None` without a long run.
type Answers = Option<Vec<Option<Answer>>>;

fn one(index: u64, seed: u64) -> Result<Answers, Error> {
    let simulated = SimulatedRuns::new(index, seed)?;
    let SimulatedRuns { scene, table, form, .. } = &simulated;
    let parameters = ModelParameters::of(scene, &table.runs, *form)?;
    let rows = Likelihood::of_rows(scene, &table.runs, *form);
    let Some(truth) = long_run(&parameters, &rows, seed, index) else {
        return Ok(None);
    };
    let fits = simulated.fit(&REQUESTED)?;
    let answer = |fitted: Option<Posterior>| {
        let fitted = fitted?;
        Some(Answer {
            method: fitted.sampled.method,
            error: error(&summaries(&fitted.sampled), &truth),
            quotable: fitted.sampling_holds(),
        })
    };
    Ok(Some(fits.into_iter().map(answer).collect()))
}

/// One of the study's scenes with its runs.
pub struct SimulatedRuns {
    scene: Scene,
    table: Table,
    form: Form,
    /// seed of the fits
    seed: u64,
}

impl SimulatedRuns {
    /// Draws a scene, and its runs.
    pub fn new(index: u64, seed: u64) -> Result<SimulatedRuns, Error> {
        let scene = simulated(index, seed)?;
        let drawn = Simulation::new(&scene, None)?.draw_from(stream(seed, "accuracy runs", index));
        let runs = runs::arrange(&scene, &drawn);
        let table = Table::of(runs);
        Ok(SimulatedRuns {
            form: scene.model.form(),
            scene,
            table,
            seed: stream(seed, "accuracy fits", index).random(),
        })
    }

    /// Fits as `wetcor fit --accuracy X` does, for each X; `None` where that was not reached.
    pub fn fit(&self, requested: &[f64]) -> Result<Vec<Option<Posterior>>, Error> {
        let SimulatedRuns {
            scene,
            table,
            form,
            seed,
        } = self;
        let found = findings::fit_least_squares(scene, table, *seed, false);
        let fit = |requested: &f64| {
            let setup = SamplingSetup {
                form: *form,
                method: MethodChoice::Accuracy(*requested),
            };
            let fitted = fit_posterior(scene, &table.runs, found.least_squares(), setup, &|_, _| ())?;
            let reached = |fitted: &Posterior| fitted.sampled.accuracy.as_ref().is_some_and(|one| one.reached());
            Ok(fitted.ok().filter(reached))
        };
        requested.iter().map(fit).collect()
    }
}

fn effort(draws: usize) -> Effort {
    Effort {
        chains: 4,
        warmup: 1000,
        draws,
        target_accept: TARGET_ACCEPT,
    }
}

/// A long run over every row, whose Monte Carlo error is small beside the finest accuracy; `None` where it does not
/// converge.
fn long_run(parameters: &ModelParameters, rows: &Likelihood, seed: u64, index: u64) -> Option<Vec<Summary>> {
    const FIRST: usize = 10_000;
    const MOST: usize = 200_000;
    let finest = REQUESTED.iter().copied().fold(f64::INFINITY, f64::min);
    let prepared = PreparedPosterior::new(parameters.clone(), rows, &vec![], Evaluation::Rows).ok()?;
    let mut draws = FIRST;
    loop {
        let name = format!("accuracy long run {index}");
        let sampled = sample_by_nuts(&prepared, effort(draws), StreamName::new(seed, &name), &|_, _| ()).ok()?;
        let found = summaries(&sampled);
        let agreed = found.iter().all(|one| one.rhat.is_some_and(|rhat| rhat < 1.01));
        let mcse = found.iter().map(largest_mcse).fold(0.0, f64::max);
        if agreed && mcse <= SHARE * finest {
            return Some(found);
        }
        // the error falls as the root of the draws
        let wanted = draws as f64 * (1.2 * (mcse / (SHARE * finest)).powi(2)).max(1.5);
        if !agreed || wanted > MOST as f64 {
            return None;
        }
        draws = wanted.ceil() as usize;
    }
}

fn summaries(sampled: &Sampled) -> Vec<Summary> {
    sampled.values.iter().map(|values| summary_of(values)).collect()
}

/// Monte Carlo error of mean or sd, in sds.
fn largest_mcse(found: &Summary) -> f64 {
    match (found.sd, found.mcse_mean, found.mcse_sd) {
        (Some(sd), Some(mean), Some(of_sd)) => mean.max(of_sd) / sd,
        _ => f64::INFINITY,
    }
}

/// Largest error of a mean, in sds, or of an sd, relative.
fn error(found: &[Summary], truth: &[Summary]) -> f64 {
    let of = |(found, truth): (&Summary, &Summary)| match (found.mean, found.sd, truth.mean, truth.sd) {
        (Some(mean), Some(sd), Some(true_mean), Some(true_sd)) => {
            ((mean - true_mean) / true_sd).abs().max((sd / true_sd - 1.0).abs())
        }
        _ => f64::INFINITY,
    };
    found.iter().zip(truth).map(of).fold(0.0, f64::max)
}

/// A scene of its own: its design, its truth and its noise are drawn.
fn simulated(index: u64, seed: u64) -> Result<Scene, Error> {
    let mut rng = stream(seed, "accuracy scenes", index);
    let mut between = |lo: f64, hi: f64| lo + (hi - lo) * rng.random::<f64>();
    let k = between(0.1, 0.2);
    let l = between(1.4, 2.6);
    let c = between(0.3, 0.7);
    let sigma = 0.005 * 10f64.powf(between(0.0, 1.0));
    let sigma_dry = 0.005 * 10f64.powf(between(0.0, 0.7));
    let repeats = 2 + (between(0.0, 4.0) as u32);
    let form = ["stepwise", "saturating", "none"][between(0.0, 3.0) as usize];
    let films = ["[0.06]", "[0.03, 0.1]", "[0.02, 0.05, 0.1]"][between(0.0, 3.0) as usize];
    let liquids = ["\"M50\"", "\"AK10\", \"M50\""][between(0.0, 2.0) as usize];
    let text = format!(
        "title = \"accuracy {index}\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n\
         roughness_um = 5\n[liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n[liquids.M50]\n\
         density_kg_m3 = 965\nviscosity_mPa_s = 48.3\n[model]\ninertia = \"{form}\"\n[truth]\ndry_k = {{ PTFE = {k} }}\n\
         lubrication_log = {l}\ninertia = \"{form}\"\ninertial_prefactor = {c}\nfilm_scale = 0.07\n\
         sigma_dry = {sigma_dry}\nsigma_wet = {sigma}\n[design]\ndiameter_mm = {{ PTFE = [4.762, 8.0] }}\n\
         liquids = [{liquids}]\nfilm_ratio = {{ PTFE = {films} }}\nheight_mm = [30, 60, 100, 150]\n\
         dry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = {repeats}\n"
    );
    scene::parse(&text, Path::new("accuracy/scene.toml"), String::new())
}

/// The table as markdown.
pub fn markdown(table: &AccuracyTable) -> String {
    let mut text = String::from("\n## Is an accuracy that was asked for kept?\n\n");
    text.push_str(&format!(
        "`wetcor fit --accuracy X` on {} simulated scenes, whose design (16 to 240 wet runs of 1 or 2 liquids, 2 diameters, \
         1 to 3 film ratios, 4 heights, 2 to 5 repeats; 16 to 40 dry ones), truth, noise (σ from 0.005 to 0.05) and form of \
         inertia are drawn anew for each. The true error is the largest of any mean, in posterior sds, and of any sd, \
         relative, against trajectories over every row that are followed until their Monte Carlo error is at most {} of \
         the finest X; {} scenes without such a run are left out. X must be kept in {:.0} % of the scenes; z is the \
         distance from that in standard errors. Quotable: of those that kept it, the share whose checks of the sampling \
         (R-hat, effective draws, divergences, energy fraction, weights, nodes, the accuracy itself) all pass.\n\n",
        table.scenes,
        SHARE,
        table.left_out,
        100.0 * KEPT
    ));
    text.push_str("| X | reached | kept | share / % | z | quotable / % | largest true error |");
    for method in METHODS {
        text.push_str(&format!(" `{}` |", method.name()));
    }
    text.push_str("\n| --- | --- | --- | --- | --- | --- | --- |");
    text.push_str(&" --- |".repeat(METHODS.len()));
    text.push('\n');
    for promise in &table.promises {
        let kept = promise.within(promise.requested);
        text.push_str(&format!(
            "| {} | {} | {kept} | {:.1} | {:.1} | {:.1} | {:.3} |",
            promise.requested,
            promise.answers.len(),
            100.0 * kept as f64 / promise.answers.len() as f64,
            promise.z(promise.requested),
            100.0 * promise.quotable_where_kept() as f64 / kept as f64,
            promise.answers.iter().map(|answer| answer.error).fold(0.0, f64::max)
        ));
        for method in METHODS {
            let taken = promise.answers.iter().filter(|answer| answer.method == method);
            text.push_str(&format!(" {} |", taken.count()));
        }
        text.push('\n');
    }
    text
}
