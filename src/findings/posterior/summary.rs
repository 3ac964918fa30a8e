//! Holds the summary of the posterior, as `findings.json` writes it.

use std::ops::Deref;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::predictive_checks::PredictiveChecks;
use super::runs_alone::RunsAlone;
use crate::findings::predict::Basis;
use crate::inference::diagnostics::summary::Summary;
use crate::inference::sampling::{Method, ReachedAccuracy};
use crate::physics::form::Term;
use crate::physics::{Inertia, Viscous};

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
