//! Measures, on a scene's own runs, what each way to its parameters costs and how far off it is.
//!
//! | file | job |
//! |---|---|
//! | `laws.rs` | parameters read off the fitted laws |
//!
//! The ways from the cheapest on: the two laws by least squares, the normal about the posterior's mode, the same with
//! importance weights, trajectories on few nodes, on as many as the default bound asks for, and on every row.

mod laws;

use std::time::Instant;

use serde::Serialize;

use crate::error::Error;
use crate::findings::estimate::Quoting;
use crate::findings::posterior::{decline, effort, start, Asked, Way};
use crate::findings::{self, dry, energy, scaling, Findings};
use crate::inference::accuracy::{look, monte_carlo_error, SURE};
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::Effort;
use crate::inference::posed::{Evaluation, Posed, LARGEST_ERROR};
use crate::inference::sampling::{by_normal, by_weights, follow, Method, Sampled};
use crate::model::likelihood::{Likelihood, Resolution};
use crate::model::parameters::Parameters;
use crate::runs::Table;
use crate::scene::{Law, Scene};
use laws::{by_law, Fits};

/// The name and version of the file's layout.
pub const SCHEMA: &str = "wetcor.trade/1";

/// Φ⁻¹(0.95).
const NORMAL_95: f64 = 1.644_853_626_951_472_2;

/// Draws a chain of the reference keeps.
const REFERENCE_DRAWS: usize = 25_000;

/// Runs up to which the reference evaluates every row; beyond, nodes to a bound a hundred times the default's.
const REFERENCE_ROWS: usize = 100_000;

/// Times each way is timed; the shortest counts.
const TIMED: usize = 5;

/// Ways longer than this are timed once, s.
const LONG: f64 = 5.0;

/// A way that takes less than this share of another's time is clearly quicker; one with less than this share of
/// another's error clearly more accurate.
const CLEARLY: f64 = 0.8;

/// What every way was found to cost and to miss. Field names are those of `trade.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trade {
    /// always [`SCHEMA`]
    pub schema: &'static str,
    /// the scene's title
    pub title: String,
    /// version that made this
    pub wetcor: &'static str,
    /// seed of every use of chance
    pub seed: u64,
    /// runs in use
    pub runs: usize,
    /// threads in use
    pub threads: usize,
    /// what the others are held against
    pub reference: Reference,
    /// the ways, cheapest kind first
    pub rungs: Vec<Rung>,
    /// what the linear law gets wrong on this design without any noise
    pub linear_bias: Vec<LinearBias>,
}

/// A long run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// how its draws were made
    pub method: &'static str,
    /// chains
    pub chains: usize,
    /// draws a chain
    pub draws: usize,
    /// s
    pub seconds: f64,
    /// largest Monte Carlo error of a mean, in sds
    pub mcse_mean: f64,
    /// largest Monte Carlo error of an sd, relative
    pub mcse_sd: f64,
    /// largest R-hat
    pub rhat: f64,
    /// each parameter
    pub parameters: Vec<Named>,
}

/// A parameter by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// its name in files
    pub name: String,
    /// where it lies
    #[serde(flatten)]
    pub marginal: Marginal,
}

/// Where a parameter lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Marginal {
    /// mean
    pub mean: f64,
    /// standard deviation
    pub sd: f64,
    /// 5 % point
    pub q05: f64,
    /// 95 % point
    pub q95: f64,
}

/// One way to the parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rung {
    /// its name
    pub name: String,
    /// seconds from runs in memory to the parameters, least squares' start included
    pub seconds: f64,
    /// nodes that stood for the wet runs; `None` where every row was used or no likelihood
    pub nodes: Option<usize>,
    /// how far each parameter is off; `None` where the way gives none
    pub errors: Vec<Option<Miss>>,
    /// largest error of a mean, in posterior sds
    pub worst_mean: Option<f64>,
    /// largest error of an sd, relative
    pub worst_sd: Option<f64>,
    /// the error its own check vouches for: Monte Carlo errors times 3.3; `None` without draws, or without a check
    pub vouched: Option<f64>,
    /// smallest number of effective draws
    pub effective: Option<f64>,
    /// the same a second
    pub effective_per_second: Option<f64>,
    /// a way that is clearly better in time or in error, and not clearly worse in the other
    pub dominated_by: Option<String>,
    /// why there is nothing, or why it is not to be trusted
    pub failed: Option<String>,
}

/// How far one parameter is off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Miss {
    /// mean less the reference's, in posterior sds
    pub mean: f64,
    /// sd over the reference's, less 1
    pub sd: f64,
    /// 5 % point less the reference's, in posterior sds
    pub q05: f64,
    /// 95 % point less the reference's, in posterior sds
    pub q95: f64,
}

/// What the linear law gets wrong on this design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinearBias {
    /// name of the particle
    pub particle: String,
    /// film ratio; `None`: over all
    pub film_ratio: Option<f64>,
    /// in e_inf
    pub e_inf: f64,
    /// in standard errors of e_inf
    pub e_inf_se: Option<f64>,
    /// in St_c
    pub st_c: f64,
    /// in standard errors of St_c
    pub st_c_se: Option<f64>,
}

/// What a way answers, before it is held against the reference.
struct Answer {
    marginals: Vec<Option<Marginal>>,
    nodes: Option<usize>,
    effective: Option<f64>,
    vouched: Option<f64>,
    failed: Option<String>,
}

/// A way to the parameters.
#[derive(Debug, Clone, Copy)]
enum Path {
    /// read off a law fitted by least squares
    Law(Law),
    /// the normal about the posterior's mode
    Laplace,
    /// the same with importance weights
    LaplacePsis,
    /// trajectories
    Nuts(Evaluation),
}

impl Path {
    const ALL: [Path; 10] = [
        Path::Law(Law::Linear),
        Path::Law(Law::Sqrt),
        Path::Laplace,
        Path::LaplacePsis,
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(4))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(8))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(12))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(16))),
        Path::Nuts(Evaluation::Compressed(Resolution::Bound(LARGEST_ERROR))),
        Path::Nuts(Evaluation::Rows),
    ];

    fn name(self) -> String {
        match self {
            Path::Law(law) => law.name().to_owned(),
            Path::Laplace => Method::Laplace.name().to_owned(),
            Path::LaplacePsis => Method::LaplacePsis.name().to_owned(),
            Path::Nuts(Evaluation::Rows) => Method::NutsExact.name().to_owned(),
            Path::Nuts(Evaluation::Compressed(Resolution::Nodes(nodes))) => {
                format!("{}/{nodes}", Method::NutsCompressed.name())
            }
            Path::Nuts(Evaluation::Compressed(Resolution::Bound(_))) => Method::NutsCompressed.name().to_owned(),
        }
    }
}

/// How many ways there are, the reference included.
pub const PATHS: u64 = 1 + Path::ALL.len() as u64;

/// What all ways start from.
struct Ground<'g> {
    scene: &'g Scene,
    table: &'g Table,
    seed: u64,
    asked: Asked,
    parameters: Parameters,
    effort: Effort,
}

/// Goes every way on the runs of a scene and holds each against a long run. `progress` is called after each way.
///
/// Fails where a prior leaves a parameter no room, where the runs are such that no posterior should be sampled, or where
/// the long run does not come off; the text says why.
pub fn measure(scene: &Scene, table: &Table, seed: u64, progress: &dyn Fn()) -> Result<Trade, Error> {
    let runs = &table.runs;
    let least_squares = findings::find(scene, table, seed, false);
    let asked = Asked {
        form: least_squares.form,
        way: Way::Nodes,
    };
    let parameters = Parameters::of(scene, runs, asked.form)?;
    if let Some(declined) = decline(runs, &least_squares, &parameters) {
        return Err(Error::Usage(format!("nothing to trade: {}", declined.0.text)));
    }
    let ground = Ground {
        scene,
        table,
        seed,
        asked,
        parameters,
        effort: effort(scene),
    };
    let reference = ground.reference(&least_squares)?;
    progress();
    let mut rungs = vec![];
    for path in Path::ALL {
        let (seconds, answer) = ground.timed(path);
        rungs.push(rung(path, seconds, answer, &reference));
        progress();
    }
    mark_dominated(&mut rungs);
    Ok(Trade {
        schema: SCHEMA,
        title: scene.title.clone(),
        wetcor: env!("CARGO_PKG_VERSION"),
        seed,
        runs: runs.len(),
        threads: rayon::current_num_threads(),
        reference,
        rungs,
        linear_bias: least_squares.scaling.iter().filter_map(linear_bias).collect(),
    })
}

impl Ground<'_> {
    /// The long run.
    fn reference(&self, least_squares: &Findings) -> Result<Reference, Error> {
        let began = Instant::now();
        let rows = self.rows();
        let evaluation = if self.table.runs.len() <= REFERENCE_ROWS {
            Evaluation::Rows
        } else {
            Evaluation::Compressed(Resolution::Bound(0.01 * LARGEST_ERROR))
        };
        let effort = Effort {
            draws: REFERENCE_DRAWS,
            warmup: self.effort.warmup.max(1000),
            chains: self.effort.chains.max(4),
            ..self.effort
        };
        let fail = |why: String| Error::Usage(format!("no long run to hold the others against: {why}"));
        let start = start(self.scene, least_squares);
        let posed =
            Posed::new(self.parameters.clone(), &rows, &start, evaluation).map_err(|why| fail(why.to_string()))?;
        let stream = (self.seed, "trade reference");
        let sampled = follow(&posed, effort, stream, &|_, _| ()).map_err(|why| fail(why.to_string()))?;
        let mut parameters = vec![];
        let (mut mcse_mean, mut mcse_sd, mut rhat) = (0.0, 0.0, 0.0);
        for (parameter, values) in sampled.parameters.sampled.iter().zip(&sampled.values) {
            let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            let found = summarise(&chains);
            let told = || {
                fail(format!(
                    "the draws of {} do not tell how far they may be trusted",
                    parameter.name
                ))
            };
            let marginal = marginal(&sampled, values).ok_or_else(told)?;
            mcse_mean = f64::max(mcse_mean, found.mcse_mean.ok_or_else(told)? / marginal.sd);
            mcse_sd = f64::max(mcse_sd, found.mcse_sd.ok_or_else(told)? / marginal.sd);
            rhat = f64::max(rhat, found.rhat.ok_or_else(told)?);
            parameters.push(Named {
                name: parameter.name.clone(),
                marginal,
            });
        }
        Ok(Reference {
            method: sampled.method.name(),
            chains: effort.chains,
            draws: effort.draws,
            seconds: began.elapsed().as_secs_f64(),
            mcse_mean,
            mcse_sd,
            rhat,
            parameters,
        })
    }

    fn rows(&self) -> Likelihood {
        Likelihood::of_rows(self.scene, &self.table.runs, self.asked.form)
    }

    /// The shortest of a few times, and what came out each time.
    fn timed(&self, path: Path) -> (f64, Answer) {
        let mut shortest = f64::INFINITY;
        let mut again = 1;
        loop {
            let began = Instant::now();
            let answer = self.go(path);
            let seconds = began.elapsed().as_secs_f64();
            shortest = shortest.min(seconds);
            if again == TIMED || seconds > LONG {
                return (shortest, answer);
            }
            again += 1;
        }
    }

    fn go(&self, path: Path) -> Answer {
        match path {
            Path::Law(law) => self.read_off(law),
            Path::Laplace | Path::LaplacePsis => {
                self.on_nodes(Evaluation::default(), |posed, size, stream| match path {
                    Path::Laplace => Ok(by_normal(posed, size, stream)),
                    _ => by_weights(posed, size, stream).ok_or("the densities allow no weights".to_owned()),
                })
            }
            Path::Nuts(evaluation) => self.on_nodes(evaluation, |posed, (_, draws), stream| {
                let effort = Effort { draws, ..self.effort };
                follow(posed, effort, stream, &|_, _| ()).map_err(|why| why.to_string())
            }),
        }
    }

    fn read_off(&self, law: Law) -> Answer {
        let (scene, runs) = (self.scene, &self.table.runs);
        let quoting = Quoting {
            level: scene.bootstrap.level,
        };
        let dry = dry::find(scene, runs, quoting);
        let scaling = scaling::find(scene, runs, &dry, quoting);
        let energy = energy::find(scene, runs, &dry, &scaling, quoting);
        let fits = Fits {
            dry: &dry,
            scaling: &scaling,
            energy: &energy,
        };
        Answer {
            marginals: by_law(law, &self.parameters, self.asked.form.inertia, &fits),
            nodes: None,
            effective: None,
            vouched: None,
            failed: None,
        }
    }

    fn on_nodes(
        &self,
        evaluation: Evaluation,
        draw: impl Fn(&Posed, (usize, usize), (u64, &str)) -> Result<Sampled, String>,
    ) -> Answer {
        let least_squares = findings::find(self.scene, self.table, self.seed, false);
        let rows = self.rows();
        let start = start(self.scene, &least_squares);
        let size = (self.effort.chains, self.effort.draws);
        let stream = (self.seed, "trade");
        let sampled = Posed::new(self.parameters.clone(), &rows, &start, evaluation)
            .map_err(|why| why.to_string())
            .and_then(|posed| {
                let sampled = draw(&posed, size, stream)?;
                // a normal's own error is none that its draws could tell
                let off = match sampled.method {
                    Method::Laplace => look(&posed, stream).map(|(off, _)| off),
                    _ => Ok(0.0),
                };
                Ok((sampled, off))
            });
        let (sampled, off) = match sampled {
            Ok(sampled) => sampled,
            Err(why) => {
                return Answer {
                    marginals: vec![None; self.parameters.sampled.len()],
                    nodes: None,
                    effective: None,
                    vouched: None,
                    failed: Some(why),
                }
            }
        };
        let khat = sampled.khat.filter(|khat| *khat > khat_threshold(sampled.draws()));
        let unbounded = matches!(evaluation, Evaluation::Compressed(Resolution::Nodes(_)));
        let breach = sampled
            .checked_error
            .filter(|error| *error > sampled.bound.unwrap_or(LARGEST_ERROR));
        let failed = match (khat, breach, &off) {
            (Some(khat), _, _) => Some(format!("importance weights have the shape {khat:.2}")),
            (_, Some(error), _) => Some(format!("the nodes' log density is off by up to {error:.2}")),
            (_, _, Err(why)) => Some(why.clone()),
            _ => None,
        };
        let effective = sampled.values.iter().filter_map(|values| {
            let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
            summarise(&chains).ess_bulk
        });
        let effective = effective.fold(f64::INFINITY, f64::min) / (sampled.mcse_factor * sampled.mcse_factor);
        let vouched = monte_carlo_error(&sampled) + off.unwrap_or(0.0);
        Answer {
            marginals: sampled.values.iter().map(|values| marginal(&sampled, values)).collect(),
            nodes: sampled.compression.map(|made| made.nodes),
            effective: Some(effective).filter(|effective| effective.is_finite()),
            vouched: Some(vouched).filter(|_| failed.is_none() && !unbounded),
            failed,
        }
    }
}

fn marginal(sampled: &Sampled, values: &[Vec<f64>]) -> Option<Marginal> {
    debug_assert!(!sampled.chains.is_empty());
    let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let found = summarise(&chains);
    Some(Marginal {
        mean: found.mean?,
        sd: found.sd.filter(|sd| *sd > 0.0)?,
        q05: found.q05?,
        q95: found.q95?,
    })
}

fn rung(path: Path, seconds: f64, answer: Answer, reference: &Reference) -> Rung {
    let errors: Vec<Option<Miss>> = answer
        .marginals
        .iter()
        .zip(&reference.parameters)
        .map(|(found, truth)| {
            let (found, truth) = ((*found)?, truth.marginal);
            Some(Miss {
                mean: (found.mean - truth.mean) / truth.sd,
                sd: found.sd / truth.sd - 1.0,
                q05: (found.q05 - truth.q05) / truth.sd,
                q95: (found.q95 - truth.q95) / truth.sd,
            })
        })
        .collect();
    let worst = |of: fn(&Miss) -> f64| errors.iter().flatten().map(|miss| of(miss).abs()).reduce(f64::max);
    Rung {
        name: path.name(),
        seconds,
        nodes: answer.nodes,
        worst_mean: worst(|miss| miss.mean),
        worst_sd: worst(|miss| miss.sd),
        vouched: answer.vouched,
        effective: answer.effective,
        effective_per_second: answer.effective.map(|effective| effective / seconds),
        dominated_by: None,
        failed: answer.failed,
        errors,
    }
}

impl Rung {
    /// The largest error of a mean or an sd, and never less than chance leaves to its draws.
    ///
    /// `None` for a way that does not give every parameter: it stands in nobody's way.
    pub fn error(&self) -> Option<f64> {
        let whole = self.errors.iter().all(Option::is_some);
        let measured = self.worst_mean?.max(self.worst_sd?);
        whole.then(|| measured.max(self.effective.map_or(0.0, |effective| SURE / effective.sqrt())))
    }
}

/// Marks each way that another is clearly better than, in time or in error, and not clearly worse in the other.
///
/// Ways with the same nodes draw the same; chance alone tells their times apart.
fn mark_dominated(rungs: &mut [Rung]) {
    let marks: Vec<Option<String>> = rungs
        .iter()
        .map(|rung| {
            let error = rung.error()?;
            let better = rungs.iter().find(|other| {
                let Some(of_other) = other.error().filter(|_| other.failed.is_none()) else {
                    return false;
                };
                let same = other.nodes == rung.nodes && other.errors == rung.errors;
                let quicker = other.seconds < CLEARLY * rung.seconds;
                let nearer = of_other < CLEARLY * error;
                let worse = other.seconds > rung.seconds / CLEARLY || of_other > error / CLEARLY;
                !same && (quicker || nearer) && !worse
            });
            better.map(|other| other.name.clone())
        })
        .collect();
    for (rung, mark) in rungs.iter_mut().zip(marks) {
        rung.dominated_by = mark;
    }
}

fn linear_bias(scaling: &scaling::Scaling) -> Option<LinearBias> {
    let bias = scaling.bias.filter(|_| scaling.law == Law::Linear.name())?;
    Some(LinearBias {
        particle: scaling.particle.clone(),
        film_ratio: scaling.film_ratio,
        e_inf: bias.e_inf,
        e_inf_se: scaling.e_inf.se.map(|se| bias.e_inf / se),
        st_c: bias.st_c,
        st_c_se: scaling.st_c.se.map(|se| bias.st_c / se),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rung(name: &str, seconds: f64, error: f64) -> Rung {
        let miss = Miss {
            mean: error,
            sd: 0.0,
            q05: 0.0,
            q95: 0.0,
        };
        Rung {
            name: name.to_owned(),
            seconds,
            nodes: None,
            errors: vec![Some(miss)],
            worst_mean: Some(error),
            worst_sd: Some(0.0),
            vouched: None,
            effective: None,
            effective_per_second: None,
            dominated_by: None,
            failed: None,
        }
    }

    #[test]
    fn a_way_that_is_slower_and_no_better_is_marked() {
        let mut rungs = vec![
            rung("rough", 0.01, 1.0),
            rung("middle", 0.1, 0.1),
            rung("slow", 1.0, 0.11),
            rung("fine", 1.0, 0.01),
        ];
        // quicker than any, but not to be trusted
        rungs.push(Rung {
            failed: Some("breach".to_owned()),
            ..rung("wrong", 1e-3, 1e-3)
        });
        // says nothing of one parameter
        rungs.push(Rung {
            errors: vec![None],
            ..rung("partial", 1e-3, 1e-3)
        });
        mark_dominated(&mut rungs);
        let marks: Vec<Option<&str>> = rungs.iter().map(|rung| rung.dominated_by.as_deref()).collect();
        assert_eq!(marks, [None, None, Some("middle"), None, None, None]);
    }

    #[test]
    fn chance_in_the_time_of_the_same_draws_marks_nothing() {
        let mut rungs = vec![rung("a", 0.1, 0.1), rung("b", 0.2, 0.1)];
        mark_dominated(&mut rungs);
        assert_eq!(rungs[1].dominated_by, None);
    }

    #[test]
    fn draws_are_as_good_as_chance_lets_them_be() {
        let lucky = Rung {
            effective: Some(100.0),
            ..rung("lucky", 0.1, 1e-6)
        };
        assert!(lucky.error().is_some_and(|error| (error - 0.33).abs() < 1e-12));
    }
}
