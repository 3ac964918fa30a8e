//! Says what each figure shows: points, laws and axes, as the paper's figs. 2, 4 and 5 have them.
//!
//! | file | job |
//! |---|---|
//! | `figure.rs` | holds a finished figure |
//! | `names.rs` | names the files of the figures of each particle |
//! | `points.rs` | makes layers of points and curves |
//! | `of_particle.rs` | looks up the series of a particle and the fits to them |
//! | `film.rs` | figures against the film ratio |
//! | `bands.rs` | where the posterior puts the curve of a series, and single runs about it |
//! | `pairs.rs` | draws of each pair of parameters |

mod bands;
mod figure;
mod film;
mod names;
mod of_particle;
mod pairs;
mod points;

use std::ops::Range;

use super::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::ReportInput;
use crate::findings::laws::numbers_of_series;
use crate::findings::series::SeriesFit;
use crate::physics::numbers::stokes;
use crate::physics::{Order, Restitution};
use crate::runs::Series;
use crate::scene::WetLaw;
use bands::{speeds, Bands, SeriesBands};
pub use figure::{Figure, ENERGY, FILM, PAIRS, RESIDUALS};
use film::{energy, film, residuals};
pub use names::Names;
pub(super) use of_particle::series_name;
use of_particle::{dry_k, main_film_ratio, scaling_of, series_at, title_at, ShownSeries};
use pairs::pairs_of_parameters;
pub(super) use pairs::MOST_PAIRED;
use points::{chart, curve, largest, means_of, pairs, points, steps};
pub(super) use points::{means, SAME};

const RESTITUTION: &str = "restitution e_{n}";
const INVERSE_STOKES: &str = "St^{−1}";

/// Every figure the scene has something to show in.
pub fn all(input: ReportInput) -> Vec<Figure> {
    let input = input.of_sample();
    let mut figures: Vec<Figure> = pairs_of_parameters(input).into_iter().collect();
    let bands = Bands::of(input);
    let names = Names::of(input.scene, input.runs);
    let mut add = |name: String, charts: Vec<Chart>| {
        let drawn = |chart: &Chart| chart.layers.iter().any(has_points);
        if charts.iter().any(drawn) {
            figures.push(Figure {
                name,
                svg: svg(&charts),
            });
        }
    };
    for (index, sphere) in input.runs.spheres.iter().enumerate() {
        let label = sphere.label(input.scene);
        add(names.speed(&label), vec![against_speed(input, index, bands.as_ref())]);
        add(names.stokes(&label), vec![against_stokes(input, index, bands.as_ref())]);
    }
    add(FILM.to_owned(), film(input));
    add(ENERGY.to_owned(), energy(input));
    add(RESIDUALS.to_owned(), residuals(input));
    figures
}

fn has_points(layer: &Layer) -> bool {
    matches!(layer, Layer::Points { points, .. } if !points.is_empty())
}

/// (v, e) of some rebounds.
fn speeds_and_restitutions(input: ReportInput, rebounds: &Range<usize>) -> Vec<(f64, f64)> {
    let runs = input.runs;
    pairs(
        &runs.impact_speed[rebounds.clone()],
        &runs.restitution[rebounds.clone()],
    )
}

fn against_speed(input: ReportInput, sphere: usize, bands: Option<&Bands>) -> Chart {
    let chosen = main_film_ratio(input, sphere);
    let series = series_at(input, sphere, chosen);
    let of_shown = |shown: &ShownSeries| {
        let each = shown.series().map(|s| speeds_and_restitutions(input, &s.rebounds));
        each.flatten().collect::<Vec<(f64, f64)>>()
    };
    let mut groups: Vec<Vec<(f64, f64)>> = series.iter().map(of_shown).collect();
    let dry = input.runs.dry_of(sphere).iter();
    groups.push(
        dry.flat_map(|group| speeds_and_restitutions(input, &group.rebounds))
            .collect(),
    );
    let mut joined = means_of(groups);
    let stuck = stuck_marks(input, &series, |_, v| v);
    let fastest = largest(&joined)
        .into_iter()
        .chain(largest(&stuck))
        .reduce(f64::max)
        .unwrap_or(1.0);
    let mut layers = dry_layers(input, sphere, joined.pop().unwrap_or_default(), fastest);
    for (group, (shown, points_of)) in series.iter().zip(joined).enumerate() {
        let style = Style::group(group + 1);
        let label = shown.name.clone();
        if let Some((s, fit)) = shown.single() {
            if let Some((bands, ends)) = bands.zip(speeds(input, s)) {
                let drawn = SeriesBands {
                    series: s,
                    speeds: ends,
                    name: label.clone(),
                    style,
                };
                layers.extend(bands.layers(input, drawn, |v| v));
            }
            if let Some(law) = series_curve(input, (s, fit), fastest) {
                layers.push(curve(label.clone(), law, style, Dash::Solid));
            }
        }
        if !points_of.is_empty() {
            layers.push(points(label, points_of, style));
        }
    }
    layers.extend(stuck_layers(&series, stuck));
    let mut drawn = chart(
        Axis::new("impact speed v / (m s^{−1})").between(0.0, 1.05 * fastest),
        Axis::new(RESTITUTION).between(0.0, 1.0),
        layers,
    );
    drawn.title = title_at(input, sphere, chosen);
    widen_to_data(&mut drawn);
    drawn
}

/// The dry runs and the law fitted to them.
fn dry_layers(input: ReportInput, sphere: usize, dry_points: Vec<ChartPoint>, fastest: f64) -> Vec<Layer> {
    let mut layers = vec![];
    if !dry_points.is_empty() {
        layers.push(points("dry", dry_points, Style::group(0)));
    }
    if let Some(k) = dry_k(input, sphere) {
        let order = input.scene.model.form().dry;
        let label = match order {
            Order::First => "dry, 1 − k v^{1/5}",
            Order::Second => "dry, to second order in k v^{1/5}",
        };
        // steep at zero: even steps in v^(1/5)
        let law = steps(0.0, 1.0).map(|u| fastest * u.powi(5));
        let law = law.map(|v| (v, order.restitution(k, v))).collect();
        layers.push(curve(label, law, Style::group(0), Dash::Dashed));
    }
    layers
}

/// Keeps restitutions above one in the picture.
fn widen_to_data(chart: &mut Chart) {
    let highest = chart.layers.iter().filter_map(|layer| match layer {
        Layer::Points { points, .. } => points.iter().map(|p| p.y + p.y_se.unwrap_or(0.0)).reduce(f64::max),
        _ => None,
    });
    if highest.reduce(f64::max).is_some_and(|y| y > 0.99) {
        chart.y = chart.y.clone().between(0.0, 1.15);
    }
}

/// The law of a series; `None` where it has no usable one.
pub(super) fn series_law(input: ReportInput, series: &Series, fit: &SeriesFit) -> Option<Restitution> {
    numbers_of_series(input.scene, input.findings, series, fit).map(Restitution::from)
}

/// The law of a series from its threshold on; `None` where it has no usable one.
fn series_curve(input: ReportInput, (series, fit): (&Series, &SeriesFit), fastest: f64) -> Option<Vec<(f64, f64)>> {
    let numbers = numbers_of_series(input.scene, input.findings, series, fit)?;
    let (law, threshold) = (Restitution::from(numbers), numbers.threshold_speed());
    // steep at its threshold: steps in the root of the distance from it
    let points = steps(0.0, 1.0).map(|u| {
        let v = threshold + (fastest - threshold) * u * u;
        (v, law.at(v))
    });
    (threshold < fastest).then(|| points.collect())
}

/// 1/St of a sphere of a series at a diameter and a speed.
fn inverse_stokes_at(input: ReportInput, series: &Series, diameter: f64, speed: f64) -> f64 {
    let density = input.scene.particles[series.particle].density;
    1.0 / stokes(density, diameter, speed, input.scene.liquids[series.liquid].viscosity)
}

/// (1/St, e) of the rebounds of some series.
fn inverse_stokes(input: ReportInput, series: &Series) -> Vec<(f64, f64)> {
    let of = |run: usize| (input.runs.inverse_stokes(run), input.runs.restitution[run]);
    series.rebounds.clone().map(of).collect()
}

/// Marks at e = 0 for the stuck runs of each series; `x` places a speed on the horizontal axis.
fn stuck_marks(input: ReportInput, series: &[ShownSeries], x: impl Fn(&Series, f64) -> f64) -> Vec<Vec<ChartPoint>> {
    let of = |s: &Series| -> Vec<(f64, f64)> {
        let speeds = &input.runs.impact_speed[s.stuck.clone()];
        speeds.iter().map(|v| (x(s, *v), 0.0)).collect()
    };
    means_of(
        series
            .iter()
            .map(|shown| shown.series().flat_map(of).collect())
            .collect(),
    )
}

/// Hollow marks of stuck runs at e = 0.
fn stuck_layers(series: &[ShownSeries], stuck: Vec<Vec<ChartPoint>>) -> Vec<Layer> {
    let some = series
        .iter()
        .zip(stuck)
        .enumerate()
        .filter(|(_, (_, marks))| !marks.is_empty());
    let mut layers: Vec<Layer> = some
        .map(|(group, (shown, marks))| {
            // a series that has no other marks is known by these
            let only_stuck = shown.series().all(|s| s.rebounds.is_empty());
            Layer::Points {
                name: only_stuck.then(|| shown.name.clone()),
                points: marks,
                style: Style::group(group + 1).open(),
            }
        })
        .collect();
    if !layers.is_empty() {
        // in the legend, of no series
        layers.push(points("stuck (hollow)", vec![], Style::group(0).open()));
    }
    layers
}

/// Both laws of 1/St, from 0 to where they vanish or the picture ends.
fn laws(input: ReportInput, sphere: usize, ratio: Option<f64>, end: f64) -> Vec<Layer> {
    let mut layers = vec![];
    let values = |law: WetLaw| {
        let row = scaling_of(input, sphere, ratio, law).filter(|row| row.verdict.passed)?;
        Some((row.e_inf.value?, row.st_c.value?))
    };
    if let Some((e_inf, st_c)) = values(WetLaw::Linear) {
        let last = end.min(1.0 / st_c);
        let line = [0.0, last].map(|x| (x, e_inf * (1.0 - st_c * x))).to_vec();
        layers.push(curve("linear law", line, Style::group(0), Dash::Dashed));
    }
    if let Some((e_inf, st_c)) = values(WetLaw::Sqrt) {
        let last = 0.5 / st_c;
        let root = |u: f64| {
            let x = last * (1.0 - u * u);
            (x, e_inf * (1.0 - 2.0 * st_c * x).max(0.0).sqrt())
        };
        let law = steps(0.0, 1.0).map(root).filter(|(x, _)| *x <= end).collect();
        layers.push(curve("square-root law", law, Style::group(0), Dash::Solid));
    }
    layers
}

fn against_stokes(input: ReportInput, sphere: usize, bands: Option<&Bands>) -> Chart {
    let chosen = main_film_ratio(input, sphere);
    let series = series_at(input, sphere, chosen);
    let of_shown = |shown: &ShownSeries| shown.series().flat_map(|s| inverse_stokes(input, s)).collect();
    let joined = means_of(series.iter().map(of_shown).collect());
    let inverse = |s: &Series, v: f64| inverse_stokes_at(input, s, s.diameter, v);
    let stuck = stuck_marks(input, &series, inverse);
    let ends = largest(&joined).into_iter().chain(largest(&stuck));
    let end = 1.1 * ends.reduce(f64::max).unwrap_or(0.1);
    let mut layers = laws(input, sphere, chosen, end);
    // of those that are shown by themselves
    let all: Vec<&Series> = series.iter().filter_map(|shown| Some(shown.single()?.0)).collect();
    let bands = bands.filter(|_| all.len() == series.len());
    for (group, (shown, points_of)) in series.iter().zip(joined).enumerate() {
        let (label, style) = (shown.name.clone(), Style::group(group + 1));
        layers.extend(
            bands
                .into_iter()
                .flat_map(|bands| bands.of_liquid(input, &all, group, inverse)),
        );
        if !points_of.is_empty() {
            layers.push(points(label, points_of, style));
        }
    }
    layers.extend(stuck_layers(&series, stuck));
    let mut drawn = chart(
        Axis::new(INVERSE_STOKES).between(0.0, end),
        Axis::new(RESTITUTION).between(0.0, 1.0),
        layers,
    );
    drawn.title = title_at(input, sphere, chosen);
    widen_to_data(&mut drawn);
    drawn
}
