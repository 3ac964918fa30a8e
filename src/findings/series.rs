//! Estimates the square-root law of each series: α, β, e_inf and the speed below which nothing rebounds.

use std::ops::Deref;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::film_groups::why_no_laws;
use super::quantities::LawOver;
use super::wet_fit::{FitSetup, WetFit, WetRuns};

/// The square-root law e = √(α + β/v) of one series.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SeriesFit {
    /// name of the particle
    pub particle: String,
    /// name of the liquid
    pub liquid: String,
    /// mean D, m
    pub diameter_m: f64,
    /// mean δ, m
    pub film_m: f64,
    /// film ratio of the group it belongs to
    pub film_ratio: f64,
    /// rebounds used
    pub runs: usize,
    /// runs that stuck, left out
    pub stuck: usize,
    /// the law
    #[serde(flatten)]
    pub fitted: WetFit,
}

impl Deref for SeriesFit {
    type Target = WetFit;

    fn deref(&self) -> &WetFit {
        &self.fitted
    }
}

/// The fit of every series, in the order of the runs.
pub fn fit_series(setup: FitSetup) -> Vec<SeriesFit> {
    let of_place = |place: usize| of_series(setup, place);
    (0..setup.runs.series.len()).into_par_iter().map(of_place).collect()
}

fn of_series(setup: FitSetup, place: usize) -> SeriesFit {
    let FitSetup { scene, runs, .. } = setup;
    let series = &runs.series[place];
    let rebounds = WetRuns::over_speed(setup, std::slice::from_ref(series));
    let mut fitted = rebounds.fit(LawOver::Speed, series.sphere, place..place + 1);
    if let Some(why) = runs.film_group_of(place).and_then(why_no_laws) {
        fitted.withhold(&why);
    }
    SeriesFit {
        particle: scene.particles[series.particle].name.clone(),
        liquid: scene.liquids[series.liquid].name.clone(),
        diameter_m: series.diameter,
        film_m: series.film,
        film_ratio: series.film_ratio,
        runs: rebounds.rebounds,
        stuck: rebounds.stuck,
        fitted,
    }
}
