//! Lays out draws of each pair of parameters, with each one's histogram and prior on the diagonal.

use super::super::chart::{grid, Axis, Chart, ChartPoint, Dash, Extent, Layer, Style};
use super::super::quantities::{in_scripts, parameter_label};
use super::super::ReportInput;
use super::figure::{Figure, PAIRS};
use super::points::points;
use crate::findings::posterior::Posterior;
use crate::findings::range::range;
use crate::model::parameters::{ModelParameter, ParameterKind};

/// More parameters than this leave no room to see anything of their pairs.
pub(in crate::report) const MOST_PAIRED: usize = 8;
/// Points in all panels together.
const MOST_POINTS: usize = 2000;
/// Bars of a histogram.
const BARS: usize = 24;
/// Points along a prior.
const CURVE: usize = 40;

/// Axes of a panel.
const AXES: Extent = Extent {
    width: 96.0,
    height: 96.0,
};

/// The figure; `None` where nothing was sampled.
pub(super) fn pairs_of_parameters(input: ReportInput) -> Option<Figure> {
    let posterior = input.posterior?;
    Some(Figure {
        name: PAIRS.to_owned(),
        svg: grid(&charts(input, posterior), AXES),
    })
}

/// The lower triangle of panels, row by row.
fn charts(input: ReportInput, posterior: &Posterior) -> Vec<Vec<Chart>> {
    let places = first_places(posterior);
    let parameters = &posterior.sampled.parameters.sampled;
    // chain after chain
    let all: Vec<Vec<f64>> = places
        .iter()
        .map(|place| posterior.sampled.values[*place].concat())
        .collect();
    let ranges: Vec<(f64, f64)> = all.iter().map(|draws| limits(draws)).collect();
    let names: Vec<String> = places.iter().map(|place| symbol(input, &parameters[*place])).collect();
    let panels = places.len() * places.len().saturating_sub(1) / 2;
    let (plain, diverging) = shown_draws(posterior, MOST_POINTS / panels.max(1));
    let last = places.len().saturating_sub(1);
    let axis = |place: usize, at_edge: bool| {
        let label = if at_edge { names[place].as_str() } else { "" };
        Axis::new(label).between(ranges[place].0, ranges[place].1)
    };
    let panel = |row: usize, column: usize| {
        let x = axis(column, row == last);
        if column == row {
            let (layers, highest) = histogram(&all[row], ranges[row], |x| {
                let (ln, _) = parameters[places[row]].prior.ln_density(x)?;
                Some(ln.exp())
            });
            return Chart::new(x, Axis::new("").between(0.0, 1.08 * highest), layers);
        }
        let cloud = |name: &str, which: &[usize], style: Style| {
            let point = |draw: &usize| ChartPoint::at(all[column][*draw], all[row][*draw]);
            points(name, which.iter().map(point).collect(), style)
        };
        let mut layers = Vec::from_iter(cloud("draws", &plain, Style::group(1)));
        layers.extend(cloud("divergent draws", &diverging, Style::group(2).open()));
        Chart::new(x, axis(row, column == 0), layers)
    };
    let of_row = |row: usize| (0..=row).map(|column| panel(row, column)).collect();
    (0..places.len()).map(of_row).collect()
}

/// Places of the parameters that are shown, in their order: those that all runs share go before the k of each particle.
fn first_places(posterior: &Posterior) -> Vec<usize> {
    let parameters = &posterior.sampled.parameters.sampled;
    let of_particle = |place: &usize| matches!(parameters[*place].kind, ParameterKind::DryK(_));
    let (own, shared): (Vec<usize>, Vec<usize>) = (0..parameters.len()).partition(of_particle);
    let mut places: Vec<usize> = shared.into_iter().chain(own).take(MOST_PAIRED).collect();
    places.sort_unstable();
    places
}

/// A parameter's symbol, with its particle.
fn symbol(input: ReportInput, parameter: &ModelParameter) -> String {
    let kind = parameter.kind;
    parameter_label(input.scene, input.runs, kind, &in_scripts(kind.symbol()))
}

/// Smallest and largest of some numbers, a little apart.
fn limits(values: &[f64]) -> (f64, f64) {
    let [lo, hi] = range(values.iter().copied()).unwrap_or_default();
    let margin = 0.03 * (hi - lo);
    (lo - margin, hi + margin)
}

/// Draws to show in a panel: every so many, and of the diverging ones a quarter of the room.
fn shown_draws(posterior: &Posterior, most: usize) -> (Vec<usize>, Vec<usize>) {
    let flags = posterior.sampled.chains.iter().flat_map(|chain| &chain.diverging);
    let (diverging, plain): (Vec<(usize, &bool)>, _) = flags.enumerate().partition(|(_, diverging)| **diverging);
    let some = |of: Vec<(usize, &bool)>, most: usize| -> Vec<usize> {
        let step = of.len().div_ceil(most.max(1)).max(1);
        of.into_iter().step_by(step).map(|(draw, _)| draw).collect()
    };
    let of_diverging = some(diverging, most / 4);
    let room = most - of_diverging.len();
    (some(plain, room), of_diverging)
}

/// Bars and prior, and the highest of both.
fn histogram(draws: &[f64], (lo, hi): (f64, f64), prior: impl Fn(f64) -> Option<f64>) -> (Vec<Layer>, f64) {
    let width = (hi - lo) / BARS as f64;
    let mut counts = [0.0; BARS];
    for draw in draws {
        // of draws that are all the same the bar is NaN, which becomes 0
        counts[(((draw - lo) / width) as usize).min(BARS - 1)] += 1.0;
    }
    let bars = counts.iter().enumerate().flat_map(|(bar, count)| {
        let left = lo + width * bar as f64;
        let height = count / (draws.len() as f64 * width);
        [(left, 0.0, height), (left + width, 0.0, height)]
    });
    let edges: Vec<(f64, f64, f64)> = bars.collect();
    let density: Vec<(f64, f64)> = (0..=CURVE)
        .map(|i| lo + (hi - lo) * i as f64 / CURVE as f64)
        .map(|x| (x, prior(x).unwrap_or(0.0)))
        .collect();
    let heights = edges
        .iter()
        .map(|edge| edge.2)
        .chain(density.iter().map(|point| point.1));
    let highest = heights.filter(|height| height.is_finite()).fold(0.0, f64::max);
    let layers = vec![
        Layer::band("posterior density", edges, Style::group(1)),
        Layer::curve("prior density", density, Style::group(2), Dash::Solid),
    ];
    (layers, highest)
}
