//! Gathers the restitution of every pair against the impact speed, for a reader to pick one.

use rayon::prelude::*;
use serde::Serialize;

use super::super::figures::{means, series_name, SAME};
use super::super::ReportInput;
use crate::findings::laws::Pair;
use crate::findings::predict::ParticleLaw;
use crate::findings::range::range;
use crate::physics::Restitution;

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
    pub pairs: Vec<PairCurve>,
    /// pairs there was no room for
    #[serde(skip)]
    pub left_out: usize,
}

/// The curve of a sphere, dry or in a liquid under a film, and the runs that were made with it.
#[derive(Debug, Serialize)]
pub(in super::super) struct PairCurve {
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
        let laws = input.laws(DRAWS);
        let pairs = (0..input.runs.spheres.len()).flat_map(|sphere| Pair::of_sphere(sphere, input.runs));
        let all: Vec<Pair> = pairs.collect();
        let shown = &all[..all.len().min(MOST_PAIRS)];
        let pair = |pair: &Pair| {
            let law = laws.as_ref().map(|laws| &laws[pair.sphere]);
            let (restitution, band) = restitution(input, pair, law, &speeds)?;
            Some(PairCurve {
                restitution,
                band,
                ..runs_of(input, pair)
            })
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

/// e at each speed, and with a posterior its 5 % and 95 % points; `None` where no law is usable.
fn restitution(
    input: ReportInput,
    pair: &Pair,
    law: Option<&ParticleLaw>,
    speeds: &[f64],
) -> Option<(Vec<f64>, Vec<[f64; 2]>)> {
    let Some(law) = law else {
        let fitted = Restitution::from(pair.fitted(input.scene, input.findings)?);
        return Some((speeds.iter().map(|v| rounded(fitted.at(*v))).collect(), vec![]));
    };
    let curve = law.curve(pair.setting(input.scene, input.runs).as_ref());
    let points = speeds.iter().map(|v| curve.at(*v));
    let rounded = points.map(|at| (rounded(at.q50), [at.q05, at.q95].map(rounded)));
    Some(rounded.unzip())
}

/// The runs of a pair, before its curve is known.
fn runs_of(input: ReportInput, pair: &Pair) -> PairCurve {
    let own = input.runs.spheres[pair.sphere];
    let (name, all, rebounds, stuck) = match pair.series {
        Some(place) => {
            let series = &input.runs.series[place];
            // a diameter stands in the words of the series
            let particle = &input.scene.particles[own.particle].name;
            let name = format!("{particle}, {}", series_name(input, series));
            (
                name,
                series.runs().collect(),
                series.rebounds.clone().collect(),
                series.stuck.clone(),
            )
        }
        None => {
            let groups = input.runs.dry_of(pair.sphere).iter();
            let rebounds: Vec<usize> = groups.flat_map(|group| group.rebounds.clone()).collect();
            let name = format!("{}, dry", own.words(input.scene));
            (name, rebounds.clone(), rebounds, 0..0)
        }
    };
    let ends = range(all.iter().map(|run: &usize| input.runs.impact_speed[*run]));
    PairCurve {
        name,
        wet: pair.series.is_some(),
        measured: ends.iter().flatten().copied().map(rounded).collect(),
        restitution: vec![],
        band: vec![],
        rebounds: points(input, rebounds),
        stuck: points(input, stuck).into_iter().map(|[v, ..]| v).collect(),
    }
}

fn points(input: ReportInput, runs: impl IntoIterator<Item = usize>) -> Vec<[f64; 3]> {
    let of = |run: usize| (input.runs.impact_speed[run], input.runs.restitution[run]);
    let mut pairs: Vec<(f64, f64)> = runs.into_iter().map(of).collect();
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
