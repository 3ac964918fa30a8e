//! Gathers the restitution of every pair against the impact speed, for a reader to pick one.

use rayon::prelude::*;
use serde::Serialize;

use super::super::figures::{means, series_law, series_name, SAME};
use super::super::ReportInput;
use crate::findings::predict::ParticleLaw;
use crate::inference::diagnostics::quantile;
use crate::runs::Series;

/// Draws a curve is made of; `predict` takes all of them.
const DRAWS: usize = 400;
/// A page holds no more pairs than this.
const MOST_PAIRS: usize = 200;
/// Speeds along a curve lie between so many and two and a half times as many.
const FEWEST_SPEEDS: f64 = 80.0;
/// How far beyond the fastest run curves go.
const BEYOND: f64 = 1.25;

/// e_n(v) of the pairs of a scene, all at the same speeds.
#[derive(Debug, Default, Serialize)]
pub(in super::super) struct Curves {
    /// v, m/s
    pub speeds: Vec<f64>,
    /// where the curves come from, in words
    pub source: String,
    /// each pair
    pub pairs: Vec<Pair>,
    /// pairs there was no room for
    #[serde(skip)]
    pub left_out: usize,
}

/// The curve of a sphere, dry or in a liquid under a film, and the runs that were made with it.
#[derive(Debug, Serialize)]
pub(in super::super) struct Pair {
    /// its words
    pub name: String,
    /// whether it is of wet impacts
    pub wet: bool,
    /// slowest and fastest of its runs, m/s; empty without any
    pub measured: Vec<f64>,
    /// e at each speed; 0: no rebound
    pub restitution: Vec<f64>,
    /// 5 % and 95 % points there, of the posterior; empty without one
    pub band: Vec<[f64; 2]>,
    /// (v, e, standard error) of the rebounds, repeated speeds as one; an error of 0: one run
    pub rebounds: Vec<[f64; 3]>,
    /// v of the runs that stuck, repeated speeds as one
    pub stuck: Vec<f64>,
}

impl Curves {
    /// The curves of every pair that has one: the posterior's, or without it those of the square-root law and the dry law.
    pub(in super::super) fn of(input: ReportInput) -> Curves {
        let input = input.of_sample();
        let speeds = speeds(input);
        let laws: Option<Vec<ParticleLaw>> = input.posterior.map(|posterior| {
            let spheres = 0..input.runs.spheres.len();
            spheres
                .map(|sphere| posterior.law(input.scene, input.runs, sphere, DRAWS))
                .collect()
        });
        let law = |sphere: usize| laws.as_ref().map(|laws| &laws[sphere]);
        let of_sphere = |sphere: usize| {
            let wet = (0..input.runs.series.len()).filter(move |place| input.runs.series[*place].sphere == sphere);
            std::iter::once(None)
                .chain(wet.map(Some))
                .map(move |place| (sphere, place))
        };
        let all: Vec<(usize, Option<usize>)> = (0..input.runs.spheres.len()).flat_map(of_sphere).collect();
        let shown = &all[..all.len().min(MOST_PAIRS)];
        let pair = |&(sphere, series): &(usize, Option<usize>)| match series {
            None => dry_pair(input, sphere, law(sphere), &speeds),
            Some(place) => wet_pair(input, place, law(sphere), &speeds),
        };
        Curves {
            source: match input.posterior {
                Some(_) => format!("the posterior's median with its 90 % band, of {DRAWS} draws at most"),
                None => "the law fitted by least squares".to_owned(),
            },
            pairs: shown.par_iter().filter_map(pair).collect(),
            left_out: all.len() - shown.len(),
            speeds,
        }
    }
}

/// Speeds at even steps of 1, 2 or 5 in their leading digit, from the first step to beyond the fastest run.
fn speeds(input: ReportInput) -> Vec<f64> {
    let fastest = input.runs.impact_speed.iter().copied().fold(0.0, f64::max);
    let longest = BEYOND * fastest / FEWEST_SPEEDS;
    let decade = 10f64.powf(longest.log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|step| step * decade);
    let step = steps.into_iter().find(|step| *step <= longest).unwrap_or(decade);
    let count = (BEYOND * fastest / step).ceil();
    if !count.is_finite() {
        return vec![];
    }
    (1..=count as usize).map(|i| rounded(step * i as f64)).collect()
}

fn dry_pair(input: ReportInput, sphere: usize, law: Option<&ParticleLaw>, speeds: &[f64]) -> Option<Pair> {
    let order = input.scene.model.form().dry;
    let e_dry = |dry_k: f64, v: f64| order.restitution(dry_k, v).max(0.0);
    let (restitution, band) = match law {
        Some(law) => median_and_band(speeds, |v| {
            law.draws.iter().map(|draw| e_dry(draw.parameters.dry_k, v)).collect()
        }),
        None => {
            let dry_k = input
                .findings
                .dry
                .iter()
                .find(|dry| dry.sphere == sphere)?
                .dry_k
                .value?;
            (speeds.iter().map(|v| rounded(e_dry(dry_k, *v))).collect(), vec![])
        }
    };
    let groups = input.runs.dry_of(sphere).iter();
    let runs: Vec<usize> = groups.flat_map(|group| group.rebounds.clone()).collect();
    Some(Pair {
        name: format!("{}, dry", input.runs.spheres[sphere].words(input.scene)),
        wet: false,
        measured: ends(input, &runs),
        restitution,
        band,
        rebounds: points(input, &runs),
        stuck: vec![],
    })
}

fn wet_pair(input: ReportInput, place: usize, law: Option<&ParticleLaw>, speeds: &[f64]) -> Option<Pair> {
    let series: &Series = &input.runs.series[place];
    let (restitution, band) = match law {
        Some(law) => {
            let setting = input
                .scene
                .setting(series.particle, series.liquid, series.diameter, series.film);
            let curves = law.restitutions(&setting);
            median_and_band(speeds, |v| curves.iter().map(|curve| curve.at(v)).collect())
        }
        None => {
            let law = series_law(input, series, &input.findings.series[place])?;
            (speeds.iter().map(|v| rounded(law.at(*v))).collect(), vec![])
        }
    };
    let rebounds: Vec<usize> = series.rebounds.clone().collect();
    let stuck: Vec<usize> = series.stuck.clone().collect();
    let sphere = input.runs.spheres[series.sphere];
    // a diameter stands in the words of the series
    let particle = &input.scene.particles[sphere.particle].name;
    Some(Pair {
        name: format!("{particle}, {}", series_name(input, series)),
        wet: true,
        measured: ends(input, &series.runs().collect::<Vec<_>>()),
        restitution,
        band,
        rebounds: points(input, &rebounds),
        stuck: points(input, &stuck).into_iter().map(|[v, ..]| v).collect(),
    })
}

/// The median and the 5 % and 95 % points of a value of every draw, at each speed.
fn median_and_band(speeds: &[f64], of_draws: impl Fn(f64) -> Vec<f64>) -> (Vec<f64>, Vec<[f64; 2]>) {
    let at = |v: &f64| {
        let values = quantile::sorted(of_draws(*v));
        let [low, median, high] = [0.05, 0.5, 0.95].map(|p| rounded(quantile::of_sorted(&values, p)));
        (median, [low, high])
    };
    speeds.iter().map(at).unzip()
}

fn ends(input: ReportInput, runs: &[usize]) -> Vec<f64> {
    let speeds = runs.iter().map(|run| input.runs.impact_speed[*run]);
    let slowest = speeds.clone().reduce(f64::min);
    let fastest = speeds.reduce(f64::max);
    slowest.into_iter().chain(fastest).map(rounded).collect()
}

fn points(input: ReportInput, runs: &[usize]) -> Vec<[f64; 3]> {
    let of = |run: &usize| (input.runs.impact_speed[*run], input.runs.restitution[*run]);
    let mut pairs: Vec<(f64, f64)> = runs.iter().map(of).collect();
    let points = means(&mut pairs, SAME).into_iter();
    points
        .map(|point| [point.x, point.y, point.y_se.unwrap_or(0.0)].map(rounded))
        .collect()
}

/// To the digits a page shows.
fn rounded(x: f64) -> f64 {
    const PLACES: f64 = 1e4;
    (x * PLACES).round() / PLACES
}
