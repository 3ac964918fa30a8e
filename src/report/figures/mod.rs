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

use super::chart::{svg, Axis, Chart, ChartPoint, Dash, Layer, Marks, Style};
use super::ReportInput;
use crate::findings::laws::Pair;
use crate::physics::{Order, Quantity, Restitution};
use crate::runs::Series;
use crate::scene::WetLaw;
use bands::Bands;
pub use figure::{Figure, ENERGY, FILM, PAIRS, RESIDUALS};
use film::{energy, film, residuals};
pub use names::file_names;
pub(super) use of_particle::series_name;
use of_particle::{OfSphere, ShownSeries};
use pairs::pairs_of_parameters;
pub(super) use pairs::MOST_PAIRED;
use points::{largest, means_of, points, steps};
pub(super) use points::{means, SAME};

/// Every figure the scene has something to show in.
pub fn all(input: ReportInput) -> Vec<Figure> {
    let input = input.of_sample();
    let mut figures: Vec<Figure> = pairs_of_parameters(input).into_iter().collect();
    let bands = Bands::of(input);
    let mut add = |name: String, charts: Vec<Chart>| {
        let has_points = |layer: &Layer| matches!(&layer.marks, Marks::Points(points) if !points.is_empty());
        if charts.iter().flat_map(|chart| &chart.layers).any(has_points) {
            figures.push(Figure {
                name,
                svg: svg(&charts),
            });
        }
    };
    for (sphere, [speed, stokes]) in file_names(input.scene, input.runs).into_iter().enumerate() {
        let own = OfSphere::new(input, sphere);
        add(speed, vec![against_speed(&own, bands.as_ref())]);
        add(stokes, vec![against_stokes(&own, bands.as_ref())]);
    }
    add(FILM.to_owned(), film(input));
    add(ENERGY.to_owned(), energy(input));
    add(RESIDUALS.to_owned(), residuals(input));
    figures
}

/// (x, e) of some rebounds; `x` places a run on the horizontal axis.
fn rebounds(input: ReportInput, rebounds: &Range<usize>, x: impl Fn(usize) -> f64) -> Vec<(f64, f64)> {
    rebounds
        .clone()
        .map(|run| (x(run), input.runs.restitution[run]))
        .collect()
}

fn against_speed(own: &OfSphere, bands: Option<&Bands>) -> Chart {
    let (input, series) = (own.input, &own.series);
    let of_rebounds = |own: &Range<usize>| rebounds(input, own, |run| input.runs.impact_speed[run]);
    let of_shown = |shown: &ShownSeries| {
        let rebounds = shown.series(input.runs).map(|own| &own.rebounds);
        rebounds.flat_map(of_rebounds).collect()
    };
    let dry = input.runs.dry_of(own.sphere).iter();
    let dry = dry.flat_map(|group| of_rebounds(&group.rebounds)).collect();
    let mut joined = means_of(series.iter().map(of_shown).chain([dry]).collect());
    let stuck = stuck_marks(own, |_, v| v);
    let fastest = largest(joined.iter().chain(&stuck)).unwrap_or(1.0);
    let mut layers = dry_layers(own, joined.pop().unwrap_or_default(), fastest);
    for (group, (shown, points_of)) in series.iter().zip(joined).enumerate() {
        let style = Style::group(group + 1);
        let label = &shown.name;
        if let Some(place) = shown.single() {
            let own = &input.runs.series[place];
            layers.extend(bands.map_or(vec![], |bands| bands.of_series(own, style, |v| v)));
            let law = series_curve(input, place, fastest);
            layers.extend(law.map(|law| Layer::curve(label.clone(), law, style, Dash::Solid)));
        }
        layers.extend(points(label.clone(), points_of, style));
    }
    layers.extend(stuck_layers(own, stuck));
    let x = Axis::new("impact speed v / (m s^{−1})").between(0.0, 1.05 * fastest);
    of_restitution(own.title(), x, layers)
}

/// A chart of restitutions; those above one stay in the picture.
fn of_restitution(title: Option<String>, x: Axis, layers: Vec<Layer>) -> Chart {
    let highest = layers.iter().filter_map(|layer| match &layer.marks {
        Marks::Points(points) => points.iter().map(|p| p.y + p.y_se.unwrap_or(0.0)).reduce(f64::max),
        _ => None,
    });
    let end = if highest.reduce(f64::max).is_some_and(|y| y > 0.99) {
        1.15
    } else {
        1.0
    };
    let y = Axis::new("restitution e_{n}").between(0.0, end);
    Chart {
        title,
        ..Chart::new(x, y, layers)
    }
}

/// The dry runs and the law fitted to them.
fn dry_layers(own: &OfSphere, dry_points: Vec<ChartPoint>, fastest: f64) -> Vec<Layer> {
    let mut layers = Vec::from_iter(points("dry", dry_points, Style::group(0)));
    if let Some(k) = own.dry_k() {
        let order = own.input.scene.model.form().dry;
        let label = match order {
            Order::First => "dry, 1 − k v^{1/5}",
            Order::Second => "dry, to second order in k v^{1/5}",
        };
        // steep at zero: even steps in v^(1/5)
        let law = steps(0.0, 1.0).map(|u| fastest * u.powi(5));
        let law = law.map(|v| (v, order.restitution(k, v))).collect();
        layers.push(Layer::curve(label, law, Style::group(0), Dash::Dashed));
    }
    layers
}

/// The law of a series from its threshold on; `None` where it has no usable one.
fn series_curve(input: ReportInput, place: usize, fastest: f64) -> Option<Vec<(f64, f64)>> {
    let pair = Pair {
        sphere: input.runs.series[place].sphere,
        series: Some(place),
    };
    let numbers = pair.fitted(input.scene, input.findings)?;
    let (law, threshold) = (Restitution::from(numbers), numbers.threshold_speed());
    // steep at its threshold: steps in the root of the distance from it
    let points = steps(0.0, 1.0).map(|u| {
        let v = threshold + (fastest - threshold) * u * u;
        (v, law.at(v))
    });
    (threshold < fastest).then(|| points.collect())
}

/// Marks at e = 0 for the stuck runs of each series; `x` places a speed on the horizontal axis.
fn stuck_marks(own: &OfSphere, x: impl Fn(&Series, f64) -> f64) -> Vec<Vec<ChartPoint>> {
    let of = |s: &Series| -> Vec<(f64, f64)> {
        let speeds = &own.input.runs.impact_speed[s.stuck.clone()];
        speeds.iter().map(|v| (x(s, *v), 0.0)).collect()
    };
    let of_shown = |shown: &ShownSeries| shown.series(own.input.runs).flat_map(of).collect();
    means_of(own.series.iter().map(of_shown).collect())
}

/// Hollow marks of stuck runs at e = 0.
fn stuck_layers(own: &OfSphere, stuck: Vec<Vec<ChartPoint>>) -> Vec<Layer> {
    let some = own
        .series
        .iter()
        .zip(stuck)
        .enumerate()
        .filter(|(_, (_, marks))| !marks.is_empty());
    let mut layers: Vec<Layer> = some
        .map(|(group, (shown, marks))| {
            // a series that has no other marks is known by these
            let only_stuck = shown.series(own.input.runs).all(|s| s.rebounds.is_empty());
            let name = only_stuck.then(|| shown.name.clone());
            Layer::points(name, marks, Style::group(group + 1).open())
        })
        .collect();
    if !layers.is_empty() {
        // in the legend, of no series
        let name = Some("stuck (hollow)".to_owned());
        layers.push(Layer::points(name, vec![], Style::group(0).open()));
    }
    layers
}

/// Both laws of 1/St, from 0 to where they vanish or the picture ends.
fn laws(own: &OfSphere, end: f64) -> Vec<Layer> {
    let mut layers = vec![];
    let values = |law: WetLaw| {
        let row = own.scaling(law).filter(|row| row.verdict.passed)?;
        Some((
            row.estimates[Quantity::EInf].value?,
            row.estimates[Quantity::StC].value?,
        ))
    };
    if let Some((e_inf, st_c)) = values(WetLaw::Linear) {
        let last = end.min(1.0 / st_c);
        let line = [0.0, last].map(|x| (x, e_inf * (1.0 - st_c * x))).to_vec();
        layers.push(Layer::curve("linear law", line, Style::group(0), Dash::Dashed));
    }
    if let Some((e_inf, st_c)) = values(WetLaw::Sqrt) {
        let last = 0.5 / st_c;
        let root = |u: f64| {
            let x = last * (1.0 - u * u);
            (x, e_inf * (1.0 - 2.0 * st_c * x).max(0.0).sqrt())
        };
        let law = steps(0.0, 1.0).map(root).filter(|(x, _)| *x <= end).collect();
        layers.push(Layer::curve("square-root law", law, Style::group(0), Dash::Solid));
    }
    layers
}

fn against_stokes(own: &OfSphere, bands: Option<&Bands>) -> Chart {
    let (input, series) = (own.input, &own.series);
    let of_series = |s: &Series| rebounds(input, &s.rebounds, |run| input.runs.inverse_stokes(run));
    let of_shown = |shown: &ShownSeries| shown.series(input.runs).flat_map(of_series).collect();
    let joined = means_of(series.iter().map(of_shown).collect());
    let inverse = |s: &Series, v: f64| 1.0 / s.setting(input.scene).stokes(v);
    let stuck = stuck_marks(own, inverse);
    let end = 1.1 * largest(joined.iter().chain(&stuck)).unwrap_or(0.1);
    let mut layers = laws(own, end);
    // of those that are shown by themselves
    let single = series.iter().filter_map(ShownSeries::single);
    let all: Vec<&Series> = single.map(|place| &input.runs.series[place]).collect();
    let bands = bands.filter(|_| all.len() == series.len());
    for (group, (shown, points_of)) in series.iter().zip(joined).enumerate() {
        layers.extend(bands.map_or(vec![], |bands| bands.of_liquid(&all, group, inverse)));
        layers.extend(points(shown.name.clone(), points_of, Style::group(group + 1)));
    }
    layers.extend(stuck_layers(own, stuck));
    let x = Axis::new("St^{−1}").between(0.0, end);
    of_restitution(own.title(), x, layers)
}
