//! Summarises the draws of the offsets of r that series have.

use rayon::prelude::*;

use super::summarise::summarise_derived;
use super::summary::SeriesOffset;
use crate::findings::range::range;
use crate::inference::sampling::Sampled;
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// The offsets in the order of the series; none where the model has none.
pub(super) fn summarise_offsets(scene: &Scene, runs: &Runs, sampled: &Sampled) -> Vec<SeriesOffset> {
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
