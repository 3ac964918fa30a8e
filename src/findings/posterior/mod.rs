//! Says what the posterior says: each parameter and what follows from it, and whether the sampling may be trusted.
//!
//! | file | job |
//! |---|---|
//! | `contraction.rs` | the parameters that keep much of their prior |
//! | `derived.rs` | what follows from the parameters, draw by draw |
//! | `predictive.rs` | new runs beside the ones made |
//! | `trust.rs` | what must hold before the posterior is quoted |

mod contraction;
pub mod derived;
pub mod predictive;
pub(super) mod trust;

use rayon::prelude::*;
use serde::Serialize;

use super::predict::Basis;
use super::verdicts::Check;
use super::Findings;
use crate::error::Error;
use crate::inference::accuracy::sample_to;
use crate::inference::diagnostics::energy::e_bfmi;
use crate::inference::diagnostics::summary::summarise;
use crate::inference::nuts::{divergences, Effort, Watcher, LARGEST_DEPTH, TARGET_ACCEPT};
use crate::inference::posed::{Evaluation, Start};
use crate::inference::sampling::{sample_posterior, Method, Plan, Sampled};
use crate::model::likelihood::pointwise::Pointwise;
use crate::model::likelihood::Likelihood;
use crate::model::parameters::{Kind, Parameter, Parameters};
use crate::notice::Notice;
use crate::physics::impact::{DrySpeed, Form};
use crate::runs::Runs;
use crate::scene::{terms_of, Scene, Term};
use derived::Derived;
use predictive::Predictive;

pub use trust::decline;

/// What the posterior says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PosteriorFindings {
    /// the sampled parameters
    pub parameters: Vec<Quantity>,
    /// what follows from them
    pub derived: Vec<Quantity>,
    /// parameters that were not sampled
    pub left_out: Vec<LeftOut>,
    /// correlations of the sampled parameters, in their order
    pub correlation: Vec<Vec<f64>>,
    /// chains
    pub chains: usize,
    /// draws a chain spent adapting
    pub warmup: usize,
    /// draws a chain kept
    pub draws: usize,
    /// acceptance the step size was adapted to; above 0.8 where trajectories had diverged with that
    pub target_accept: f64,
    /// kept draws whose trajectory diverged
    pub divergences: usize,
    /// kept draws whose trajectory was cut at its largest length
    pub trajectories_cut: usize,
    /// energy Bayesian fraction of missing information of each chain
    pub e_bfmi: Vec<Option<f64>>,
    /// how it was sampled
    pub method: Method,
    /// Pareto shape of the weights of the normal about the mode; `None` where none were asked for
    #[serde(skip_serializing_if = "Option::is_none")]
    pub khat: Option<f64>,
    /// the accuracy that was asked for; `None` if none was
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// the terms of the energy balance, as a scene names them
    pub terms: Vec<&'static str>,
    /// the form of the inertial loss
    pub inertia: &'static str,
    /// the speed at which e_dry enters, m/s; `None`: each run's own
    pub dry_speed_m_s: Option<f64>,
    /// what stood for the runs; `None` if every row was used
    pub compression: Option<Compression>,
    /// new runs beside the ones made
    pub predictive: Predictive,
    /// what `wetcor predict` needs besides these and the draws
    pub basis: Basis,
}

/// One quantity of the posterior.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// its name
    pub name: String,
    /// mean
    pub mean: Option<f64>,
    /// standard deviation
    pub sd: Option<f64>,
    /// median
    pub median: Option<f64>,
    /// 5 % point
    pub q05: Option<f64>,
    /// 95 % point
    pub q95: Option<f64>,
    /// rank-normalised split R-hat
    pub rhat: Option<f64>,
    /// effective draws for the centre
    pub ess_bulk: Option<f64>,
    /// effective draws for the 5 % and 95 % points
    pub ess_tail: Option<f64>,
    /// Monte Carlo error of the mean
    pub mcse_mean: Option<f64>,
    /// Monte Carlo error of the sd
    pub mcse_sd: Option<f64>,
    /// Monte Carlo error of the 5 % point; of a parameter only
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse_q05: Option<f64>,
    /// Monte Carlo error of the 95 % point; of a parameter only
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcse_q95: Option<f64>,
    /// what was believed before; `None` for a derived quantity
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorTold>,
    /// why numbers are missing; stands exactly then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
}

/// What was believed of a parameter before the runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PriorTold {
    /// the letter of the formulas
    pub symbol: &'static str,
    /// its unit
    pub unit: &'static str,
    /// it lies above this
    pub lower: f64,
    /// it lies below this; `None` without a bound
    pub upper: Option<f64>,
    /// the density, as a scene writes it
    pub density: String,
    /// its median
    pub median: f64,
    /// its standard deviation; `None` where it has none
    pub sd: Option<f64>,
    /// where it comes from
    pub source: &'static str,
    /// sd of the posterior over sd of the prior
    pub sd_ratio: Option<f64>,
}

/// A parameter that was not sampled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// its name
    pub name: String,
    /// the value it was held at; `None` where nothing reads it
    pub value: Option<f64>,
    /// why
    pub reason: String,
}

/// An accuracy that was asked for: the largest error of any mean, in posterior sds, and of any sd, relative.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Accuracy {
    /// what was asked for
    pub asked: f64,
    /// what the method's own check vouches for; `None`: nothing
    pub vouched: Option<f64>,
    /// cheaper ways that did not do
    pub tried: Vec<Tried>,
}

/// A way to the draws that did not do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tried {
    /// which
    pub method: Method,
    /// why it did not do
    pub why: String,
}

/// What stood for the runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Compression {
    /// nodes of wet runs
    pub nodes: usize,
    /// wet runs
    pub rows: usize,
    /// wet runs whose own setting was a node
    pub rows_exact: usize,
    /// the error that was allowed
    pub bound: f64,
    /// largest difference from the sum over all rows at some of the draws
    pub max_log_density_error: f64,
}

/// A posterior with its draws, for the report and the files of draws.
#[derive(Debug)]
pub struct Posterior {
    /// what was sampled
    pub asked: Asked,
    /// what is said
    pub findings: PosteriorFindings,
    /// the draws
    pub sampled: Sampled,
    /// the draws of what follows
    pub derived: Vec<Derived>,
    /// what must hold
    pub checks: Vec<Check>,
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// Why no posterior was sampled, though it was asked for; the check fails and gates.
#[derive(Debug)]
pub struct Declined(pub Check);

impl Declined {
    /// Its check among all, if nothing was sampled.
    pub fn among(checks: &[Check]) -> Option<&Check> {
        checks.iter().find(|check| trust::DECLINED.contains(&check.check))
    }
}

/// What is sampled, and how.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// the terms of the energy balance
    pub form: Form,
    /// how
    pub way: Way,
}

/// The way to the draws.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Way {
    /// as the scene's `[sampler]` says, on nodes
    #[default]
    Nodes,
    /// the same, on every row
    Rows,
    /// the cheapest that vouches for this accuracy
    Accuracy(f64),
}

impl Way {
    /// What stands for the runs where trajectories are followed.
    pub fn evaluation(self) -> Evaluation {
        match self {
            Way::Rows => Evaluation::Rows,
            Way::Nodes | Way::Accuracy(_) => Evaluation::default(),
        }
    }
}

/// The scene's sampling effort.
pub fn effort(scene: &Scene) -> Effort {
    let count = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    Effort {
        chains: count(scene.sampler.chains),
        warmup: count(scene.sampler.warmup),
        draws: count(scene.sampler.draws),
        target_accept: TARGET_ACCEPT,
    }
}

/// Samples the posterior from where least squares stands, and says what it says.
///
/// `Err` where a prior leaves no room; the inner `Err` where the runs are such that nothing should be sampled.
pub fn find(
    scene: &Scene,
    runs: &Runs,
    least_squares: &Findings,
    asked: Asked,
    seed: u64,
    watcher: Watcher,
) -> Result<Result<Posterior, Declined>, Error> {
    let parameters = Parameters::of(scene, runs, asked.form)?;
    if let Some(declined) = trust::decline(runs, least_squares, &parameters) {
        return Ok(Err(declined));
    }
    let rows = Likelihood::of_rows(scene, runs, asked.form);
    let effort = effort(scene);
    let plan = Plan {
        effort,
        stream: (seed, "posterior"),
        evaluation: asked.way.evaluation(),
    };
    let start = start(scene, least_squares);
    let sampled = match asked.way {
        Way::Accuracy(x) => sample_to(x, parameters, &rows, &start, plan, watcher),
        Way::Nodes | Way::Rows => sample_posterior(parameters, &rows, &start, plan, watcher),
    };
    let sampled = match sampled {
        Ok(sampled) => sampled,
        Err(why) => return Ok(Err(trust::no_posterior(&why.to_string()))),
    };
    let derived = derived::find(scene, runs, asked.form, &sampled);
    let pointwise = Pointwise::new(scene, runs, asked.form);
    let predictive = predictive::find(scene, runs, &pointwise, &sampled.full_draws());
    let basis = Basis::of(scene, runs);
    let findings = tell(asked, effort, rows.nodes(), &sampled, &derived, (predictive, basis));
    let checks = trust::checks(&findings, least_squares);
    let notices = contraction::notices(&findings, least_squares);
    Ok(Ok(Posterior {
        asked,
        findings,
        sampled,
        derived,
        checks,
        notices,
    }))
}

/// Where least squares stands, by parameter.
pub fn start(scene: &Scene, least_squares: &Findings) -> Start {
    let mut start = vec![];
    let particle = |name: &str| scene.particles.iter().position(|p| p.name == name);
    for dry in &least_squares.dry {
        if let (Some(particle), Some(k)) = (particle(&dry.particle), dry.dry_k.value) {
            start.push((Kind::DryK(particle), k));
        }
    }
    let spreads: Vec<(f64, f64)> = least_squares
        .dry
        .iter()
        .filter_map(|dry| Some((dry.residual_sd?, dry.runs as f64)))
        .collect();
    let runs: f64 = spreads.iter().map(|(_, runs)| runs).sum();
    if runs > 0.0 {
        let pooled = spreads.iter().map(|(sd, runs)| sd * sd * runs).sum::<f64>() / runs;
        start.push((Kind::SigmaDry, pooled.sqrt()));
    }
    let Some(balance) = &least_squares.energy_balance else {
        return start;
    };
    for kind in [Kind::LubricationLog, Kind::InertialPrefactor, Kind::FilmScale] {
        let found = balance.parameters.iter().find(|parameter| parameter.name == kind.key());
        if let Some(value) = found.and_then(|parameter| parameter.estimate.value) {
            start.push((kind, value));
        }
    }
    if let Some(sd) = balance.residual_sd {
        start.push((Kind::SigmaWet, sd));
    }
    // a value at or below zero is on no parameter's way
    start.retain(|(_, value)| *value > 0.0);
    start
}

fn tell(
    asked: Asked,
    effort: Effort,
    rows: usize,
    sampled: &Sampled,
    derived: &[Derived],
    (predictive, basis): (Predictive, Basis),
) -> PosteriorFindings {
    let parameters = &sampled.parameters;
    let told = parameters.sampled.par_iter().zip(&sampled.values);
    let kept = sampled.chains.iter();
    PosteriorFindings {
        parameters: told
            .map(|(parameter, values)| of_parameter(parameter, values, sampled.mcse_factor))
            .collect(),
        derived: derived
            .par_iter()
            .map(|derived| Quantity {
                mcse_q05: None,
                mcse_q95: None,
                ..quantity(&derived.name, &derived.values, sampled.mcse_factor)
            })
            .collect(),
        left_out: parameters
            .left_out
            .iter()
            .map(|left| LeftOut {
                name: left.name.clone(),
                value: left.value,
                reason: left.reason.clone(),
            })
            .collect(),
        correlation: correlation(&sampled.values),
        chains: sampled.chains.len(),
        warmup: if sampled.method.is_nuts() { effort.warmup } else { 0 },
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
        target_accept: sampled.target_accept,
        divergences: divergences(&sampled.chains),
        trajectories_cut: kept
            .clone()
            .flat_map(|chain| &chain.tree_depth)
            .filter(|depth| **depth >= LARGEST_DEPTH)
            .count(),
        e_bfmi: kept
            .filter(|chain| !chain.energy.is_empty())
            .map(|chain| e_bfmi(&chain.energy))
            .collect(),
        method: sampled.method,
        khat: sampled.khat.filter(|khat| khat.is_finite()),
        accuracy: sampled.accuracy.as_ref().map(|accuracy| Accuracy {
            asked: accuracy.asked,
            vouched: Some(accuracy.vouched).filter(|error| error.is_finite()),
            tried: accuracy
                .tried
                .iter()
                .map(|(method, why)| Tried {
                    method: *method,
                    why: why.clone(),
                })
                .collect(),
        }),
        terms: terms_of(asked.form).into_iter().map(Term::name).collect(),
        inertia: asked.form.inertia.name(),
        dry_speed_m_s: match asked.form.dry_speed {
            DrySpeed::Reference(v) => Some(v),
            DrySpeed::Impact => None,
        },
        compression: sampled
            .compression
            .zip(sampled.checked_error)
            .map(|(made, checked)| Compression {
                nodes: made.nodes,
                rows,
                rows_exact: made.rows_exact,
                bound: sampled.bound.unwrap_or(f64::INFINITY),
                max_log_density_error: checked,
            }),
        predictive,
        basis,
    }
}

fn of_parameter(parameter: &Parameter, values: &[Vec<f64>], mcse_factor: f64) -> Quantity {
    let told = quantity(&parameter.name, values, mcse_factor);
    let sd = parameter.prior.sd();
    let prior = PriorTold {
        symbol: parameter.kind.symbol(),
        unit: parameter.kind.unit(),
        lower: parameter.bounds.0,
        upper: Some(parameter.bounds.1).filter(|upper| upper.is_finite()),
        density: parameter.prior.text(),
        median: parameter.prior.median(),
        sd,
        source: parameter.source,
        sd_ratio: told.sd.zip(sd).map(|(posterior, prior)| posterior / prior),
    };
    Quantity {
        prior: Some(prior),
        ..told
    }
}

/// `mcse_factor` is that of [`Sampled`].
fn quantity(name: &str, values: &[Vec<f64>], mcse_factor: f64) -> Quantity {
    let chains: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    let missing = values.iter().flatten().filter(|value| !value.is_finite()).count();
    let all: usize = values.iter().map(Vec::len).sum();
    let found = summarise(&chains);
    let why_none = match found.why_none {
        Some(_) if missing > 0 => Some(format!("{missing} of {all} draws leave no energy at infinite speed")),
        why => why.map(|why| why.to_string()),
    };
    let larger = |mcse: f64| mcse_factor * mcse;
    let fewer = |effective: f64| effective / (mcse_factor * mcse_factor);
    Quantity {
        name: name.to_owned(),
        mean: found.mean,
        sd: found.sd,
        median: found.median,
        q05: found.q05,
        q95: found.q95,
        rhat: found.rhat,
        ess_bulk: found.ess_bulk.map(fewer),
        ess_tail: found.ess_tail.map(fewer),
        mcse_mean: found.mcse_mean.map(larger),
        mcse_sd: found.mcse_sd.map(larger),
        mcse_q05: found.mcse_q05.map(larger),
        mcse_q95: found.mcse_q95.map(larger),
        prior: None,
        why_none,
    }
}

fn correlation(values: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let centred: Vec<Vec<f64>> = values
        .iter()
        .map(|chains| {
            let all: Vec<f64> = chains.concat();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let norm = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>().sqrt();
            all.iter().map(|x| (x - mean) / norm).collect()
        })
        .collect();
    let pair = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum();
    centred
        .iter()
        .map(|a| centred.iter().map(|b| pair(a, b)).collect())
        .collect()
}
