//! Summarises the draws of the offsets of r that series have.

use rayon::prelude::*;

use super::summarise::summarise_quantity;
use super::summary::{QuantitySummary, SeriesOffset};
use crate::inference::sampling::Sampled;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

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
        runs: runs.measured(series.runs()),
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
