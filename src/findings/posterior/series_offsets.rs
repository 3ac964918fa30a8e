//! Summarises the offsets of r that series have, and lists the series, so that one that was measured is found again.

use rayon::prelude::*;
use serde::Serialize;

use super::summarise::summarise_quantity;
use super::summary::QuantitySummary;
use crate::inference::sampling::Sampled;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// The offset of one series.
#[derive(Debug, Clone, PartialEq, Serialize)]
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

/// The offsets in the order of the series; none where the model has none.
pub(super) fn summarise_offsets(scene: &Scene, runs: &Runs, sampled: &Sampled) -> Vec<SeriesOffset> {
    let names = &sampled.parameters.series_offsets;
    let each = names.par_iter().zip(&sampled.series_offsets).zip(&runs.series);
    let of = |((name, values), series): ((&String, &Vec<Vec<f64>>), &Series)| SeriesOffset {
        particle: scene.particles[series.particle].name.clone(),
        liquid: scene.liquids[series.liquid].name.clone(),
        diameter_m: series.diameter,
        film_ratio: series.film_ratio,
        film_ratios: film_ratios(runs, series),
        runs: series.runs().len(),
        offset: QuantitySummary {
            mcse_q05: None,
            mcse_q95: None,
            ..summarise_quantity(name, values, sampled.mcse_factor)
        },
    };
    each.map(of).collect()
}

fn film_ratios(runs: &Runs, series: &Series) -> [f64; 2] {
    let own = &runs.impacts.film_ratio[series.runs()];
    let (lo, hi) = own.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), ratio| {
        (lo.min(*ratio), hi.max(*ratio))
    });
    [lo, hi]
}
