//! Summarises the draws of each parameter, of what follows from it and of the offsets of series, as `findings.json` writes it.

use std::ops::Deref;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::derived::DerivedDraws;
use super::predictive_checks::PredictiveChecks;
use super::runs_alone::{RunsAlone, UnderDefaults};
use super::sampling::{effort, SamplingSetup};
use crate::findings::predict::Basis;
use crate::findings::range::range;
use crate::inference::diagnostics::energy::e_bfmi;
use crate::inference::diagnostics::summary::{summarise, Summary};
use crate::inference::mixing::summary_of;
use crate::inference::nuts::{divergences, LARGEST_DEPTH};
use crate::inference::sampling::{Method, ReachedAccuracy, Sampled};
use crate::model::parameters::{LeftOut, ModelParameter, ParameterKind};
use crate::physics::form::Term;
use crate::physics::{DrySpeed, Inertia, Viscous};
use crate::runs::{Runs, Series};
use crate::scene::{Prior, Scene};

/// The summary of the posterior.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PosteriorFindings {
    /// the sampled parameters
    pub parameters: Vec<QuantitySummary>,
    /// what follows from them, which the file has as estimates
    #[serde(skip)]
    pub derived: Vec<QuantitySummary>,
    /// the offset of r of each series, where the model has them
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub series_offsets: Vec<SeriesOffset>,
    /// parameters that were not sampled
    pub left_out: Vec<HeldParameter>,
    /// correlations of the sampled parameters, in their order
    pub correlation: Vec<Vec<f64>>,
    /// chains
    pub chains: usize,
    /// draws a chain spent adapting
    pub warmup: usize,
    /// draws a chain kept
    pub draws: usize,
    /// draws a chain was to keep, and where it kept more it was drawn on until the chains had mixed; `None` where an
    /// accuracy was asked for in place of draws
    #[serde(skip_serializing_if = "Option::is_none")]
    pub draws_asked: Option<usize>,
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
    /// the accuracy that was asked for, the largest error of any mean, in posterior sds, and of any sd, relative; `None` if
    /// none was
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<ReachedAccuracy>,
    /// the terms of the energy balance, as a scene names them
    pub terms: Vec<Term>,
    /// the form of the inertial loss
    pub inertia: Inertia,
    /// the form of the viscous loss
    pub viscous: Viscous,
    /// the speed at which e_dry enters, m/s; `None`: each run's own
    pub dry_speed_m_s: Option<f64>,
    /// what stood for the runs; `None` if every row was used
    pub compression: Option<CompressionSummary>,
    /// new runs beside the ones made
    pub predictive: PredictiveChecks,
    /// what `wetcor predict` reads
    pub basis: Basis,
}

/// One quantity of the posterior.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct QuantitySummary {
    /// its name
    pub name: String,
    /// where its draws lie, and how reliable they are; Monte Carlo errors of quantiles are those of a parameter only
    #[serde(flatten)]
    pub numbers: Summary,
    /// `wet runs` of a diameter's own k that no dry run tells
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<&'static str>,
    /// what was believed before; `None` for a derived quantity
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prior: Option<PriorSummary>,
    /// why numbers are missing; stands exactly then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
}

impl Deref for QuantitySummary {
    type Target = Summary;

    fn deref(&self) -> &Summary {
        &self.numbers
    }
}

/// The offset of one series, and where that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SeriesOffset {
    /// name of the particle
    pub particle: String,
    /// name of the liquid
    pub liquid: String,
    /// mean D of its runs, m
    pub diameter_m: f64,
    /// δ/D of its film group
    pub film_ratio: f64,
    /// smallest and largest δ/D of its runs
    pub film_ratios: [f64; 2],
    /// runs, stuck ones with them
    pub runs: usize,
    /// the offset, in r
    #[serde(flatten)]
    pub offset: QuantitySummary,
}

/// What was believed of a parameter before the runs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PriorSummary {
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
    /// sd of the posterior over sd of the prior, on the scale of the prior: the logarithm for a lognormal; over the half-width
    /// of its middle 68 % for a Student-t without an sd
    pub sd_ratio: Option<f64>,
    /// mean of the posterior less the centre of the prior, in sds of the prior on its scale
    pub distance: Option<f64>,
    /// what the runs alone say; `None` where they say no more than the prior
    pub runs_alone: Option<RunsAlone>,
}

/// Share of its prior sd from which a parameter is led by its prior: what each of two keeps that only move together, where
/// the runs say as much of their common direction as the priors, √(½ · ½).
const PRIOR_LED: f64 = 0.5;

impl PriorSummary {
    /// Whether more than half of the prior's sd is left; where the two contradict each other, neither leads.
    pub fn leads(&self) -> bool {
        let conflict = self.runs_alone.is_some_and(|alone| alone.contradicts_prior());
        self.sd_ratio.is_some_and(|ratio| ratio > PRIOR_LED) && !conflict
    }
}

/// A parameter that was not sampled.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldParameter {
    /// its name
    pub name: String,
    /// the value it was held at; `None` where nothing reads it
    pub value: Option<f64>,
    /// why
    pub reason: String,
    /// what the runs alone say of it, where a scene's prior holds it
    #[serde(skip_serializing_if = "Option::is_none", skip_deserializing)]
    pub runs_alone: Option<RunsAlone>,
}

/// The few runs that stood for very many.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct CompressionSummary {
    /// how many
    pub nodes: usize,
    /// wet runs that they stand for
    pub rows: usize,
    /// what the log density was held against where that is not the sum over all rows: `sample`, of rows that are not kept
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_against: Option<&'static str>,
    /// the error that is allowed
    pub bound: f64,
    /// largest difference from the sum over all rows at some of the draws; over a sample, in proportion to its share
    pub max_log_density_error: f64,
}

/// Summarises the draws and those of what follows from them, with how they were made; `under_defaults` is what the runs say under
/// the default priors, where the scene sets others. What stood for the runs, and how they were predicted, is not in it yet.
pub(super) fn summarise_posterior(
    scene: &Scene,
    runs: &Runs,
    setup: SamplingSetup,
    sampled: &Sampled,
    derived: &[DerivedDraws],
    under_defaults: Option<&UnderDefaults>,
) -> PosteriorFindings {
    let effort = effort(scene);
    let parameters = &sampled.parameters;
    let with_draws = parameters.sampled.par_iter().zip(&sampled.values);
    let of_parameter = |(parameter, values): (&ModelParameter, &Vec<Vec<f64>>)| QuantitySummary {
        from: is_of_wet_runs(runs, parameter.kind).then_some("wet runs"),
        ..summarise_parameter(parameter, values, sampled.mcse_factor, under_defaults)
    };
    let of_derived = |own: &DerivedDraws| summarise_derived(&own.name, &own.values, sampled.mcse_factor);
    let of_held = |left: &LeftOut| HeldParameter {
        name: left.name.clone(),
        value: left.value,
        reason: left.reason.to_owned(),
        runs_alone: under_defaults.and_then(|runs| runs.beside_held(left.kind, left.value?)),
    };
    let is_followed = sampled.method == Method::Nuts;
    let depths = sampled.chains.iter().flat_map(|chain| &chain.tree_depth);
    let energies = sampled.chains.iter().map(|chain| chain.energy.as_slice());
    PosteriorFindings {
        parameters: with_draws.map(of_parameter).collect(),
        derived: derived.par_iter().map(of_derived).collect(),
        series_offsets: summarise_offsets(scene, runs, sampled),
        left_out: parameters.left_out.iter().map(of_held).collect(),
        correlation: correlations(&sampled.values),
        chains: sampled.chains.len(),
        warmup: if is_followed { effort.warmup } else { 0 },
        draws: sampled.chains.first().map_or(0, |chain| chain.ln_density.len()),
        draws_asked: sampled.accuracy.is_none().then_some(effort.draws),
        target_accept: sampled.target_accept,
        divergences: divergences(&sampled.chains),
        trajectories_cut: depths.filter(|depth| **depth >= LARGEST_DEPTH).count(),
        e_bfmi: energies.filter(|own| !own.is_empty()).map(e_bfmi).collect(),
        method: sampled.method,
        khat: sampled.khat.filter(|khat| khat.is_finite()),
        accuracy: sampled.accuracy.clone(),
        terms: setup.form.terms(),
        inertia: setup.form.inertia,
        viscous: setup.form.viscous,
        dry_speed_m_s: match setup.form.dry_speed {
            DrySpeed::Reference(v) => Some(v),
            DrySpeed::Impact => None,
        },
        compression: None,
        predictive: PredictiveChecks::default(),
        basis: Basis::of(scene, runs, sampled),
    }
}

/// Whether a parameter is a diameter's own k that comes from wet runs alone.
fn is_of_wet_runs(runs: &Runs, kind: ParameterKind) -> bool {
    let is_alone = |sphere: usize| runs.spheres[sphere].diameter.is_some() && runs.dry_of(sphere).is_empty();
    kind.sphere().is_some_and(is_alone)
}

fn summarise_parameter(
    parameter: &ModelParameter,
    values: &[Vec<f64>],
    mcse_factor: f64,
    under_defaults: Option<&UnderDefaults>,
) -> QuantitySummary {
    let summary = summarise_quantity(&parameter.name, values, mcse_factor);
    let sd = parameter.prior.sd();
    let on_scale = values.iter().flatten().map(|x| parameter.prior.standard(*x));
    let on_scale: Option<Vec<f64>> = on_scale.collect();
    let on_scale = on_scale.and_then(|z| {
        let found = summarise(&[z.as_slice()]);
        found.mean.zip(found.sd)
    });
    // that of a half-normal in its scale
    let of_prior = match (parameter.prior, sd) {
        (Prior::HalfNormal(scale), Some(sd)) => sd / scale,
        _ => 1.0,
    };
    let prior = PriorSummary {
        symbol: parameter.kind.symbol(),
        unit: parameter.kind.unit(),
        lower: parameter.bounds.0,
        upper: Some(parameter.bounds.1).filter(|upper| upper.is_finite()),
        density: parameter.prior.text(),
        median: parameter.prior.median(),
        sd,
        source: parameter.source,
        sd_ratio: on_scale.map(|(_, posterior)| posterior / of_prior),
        distance: on_scale.map(|(mean, _)| mean),
        runs_alone: on_scale.and_then(|(mean, sd)| match under_defaults {
            Some(runs) => runs.beside(parameter, [mean, sd]),
            None => RunsAlone::of(&parameter.prior, mean, sd),
        }),
    };
    QuantitySummary {
        prior: Some(prior),
        ..summary
    }
}

/// `mcse_factor` is that of [`Sampled`].
fn summarise_quantity(name: &str, values: &[Vec<f64>], mcse_factor: f64) -> QuantitySummary {
    let missing = values.iter().flatten().filter(|value| !value.is_finite()).count();
    let all: usize = values.iter().map(Vec::len).sum();
    let found = summary_of(values);
    let why_none = (!found.is_whole()).then(|| match missing {
        0 => "the draws are too few or too much alike".to_owned(),
        _ => format!("{missing} of {all} draws leave no energy at infinite speed"),
    });
    let larger = |mcse: f64| mcse_factor * mcse;
    let fewer = |effective: f64| effective / (mcse_factor * mcse_factor);
    QuantitySummary {
        name: name.to_owned(),
        numbers: Summary {
            ess_bulk: found.ess_bulk.map(fewer),
            ess_tail: found.ess_tail.map(fewer),
            mcse_mean: found.mcse_mean.map(larger),
            mcse_sd: found.mcse_sd.map(larger),
            mcse_q05: found.mcse_q05.map(larger),
            mcse_q95: found.mcse_q95.map(larger),
            ..found
        },
        from: None,
        prior: None,
        why_none,
    }
}

/// The same without Monte Carlo errors of quantiles.
fn summarise_derived(name: &str, values: &[Vec<f64>], mcse_factor: f64) -> QuantitySummary {
    let mut own = summarise_quantity(name, values, mcse_factor);
    (own.numbers.mcse_q05, own.numbers.mcse_q95) = (None, None);
    own
}

/// The offsets in the order of the series; none where the model has none.
fn summarise_offsets(scene: &Scene, runs: &Runs, sampled: &Sampled) -> Vec<SeriesOffset> {
    let names = &sampled.parameters.series_offsets;
    let each = names.par_iter().zip(&sampled.series_offsets).zip(&runs.series);
    let film_ratios = |series: &Series| range(runs.impacts.film_ratio[series.runs()].iter().copied());
    let of = |((name, values), series): ((&String, &Vec<Vec<f64>>), &Series)| SeriesOffset {
        particle: scene.particles[series.particle].name.clone(),
        liquid: scene.liquids[series.liquid].name.clone(),
        diameter_m: series.diameter,
        film_ratio: series.film_ratio,
        film_ratios: film_ratios(series).unwrap_or([series.film_ratio; 2]),
        runs: runs.measured(series.runs()),
        offset: summarise_derived(name, values, sampled.mcse_factor),
    };
    each.map(of).collect()
}

fn correlations(values: &[Vec<Vec<f64>>]) -> Vec<Vec<f64>> {
    let centre = |chains: &Vec<Vec<f64>>| -> Vec<f64> {
        let all: Vec<f64> = chains.concat();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let norm = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>().sqrt();
        all.iter().map(|x| (x - mean) / norm).collect()
    };
    let centred: Vec<Vec<f64>> = values.iter().map(centre).collect();
    let pair = |a: &Vec<f64>, b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).sum();
    let with_each = |a: &Vec<f64>| centred.iter().map(|b| pair(a, b)).collect();
    centred.iter().map(with_each).collect()
}
