//! Lays out draws of each pair of parameters, with each one's histogram and prior on the diagonal.

use super::super::super::chart::{Axis, Chart, ChartPoint, Dash, Layer, Style};
use super::super::super::ReportInput;
use super::panels::{draws, first_places, range, symbol, MOST_PAIRED};
use crate::findings::posterior::Posterior;
use crate::inference::density::bars;

/// Points in all panels together.
const MOST_POINTS: usize = 2000;
/// Bars of a histogram.
const BARS: usize = 24;
/// Points along a prior.
const CURVE: usize = 40;

/// The lower triangle of panels, row by row.
pub(super) fn charts(input: ReportInput, posterior: &Posterior) -> Vec<Vec<Option<Chart>>> {
    let places = first_places(posterior, MOST_PAIRED);
    let parameters = &posterior.sampled.parameters.sampled;
    let all: Vec<Vec<f64>> = places.iter().map(|place| draws(posterior, *place)).collect();
    let ranges: Vec<(f64, f64)> = all.iter().map(|draws| range(draws)).collect();
    let names: Vec<String> = places.iter().map(|place| symbol(input, &parameters[*place])).collect();
    let panels = places.len() * places.len().saturating_sub(1) / 2;
    let (plain, diverging) = points(posterior, MOST_POINTS / panels.max(1));
    let last = places.len().saturating_sub(1);
    let axis = |place: usize, at_edge: bool| {
        let label = if at_edge { names[place].as_str() } else { "" };
        Axis::new(label).between(ranges[place].0, ranges[place].1)
    };
    let panel = |row: usize, column: usize| -> Option<Chart> {
        if column > row {
            return None;
        }
        let x = axis(column, row == last);
        if column == row {
            let (layers, highest) = histogram(&all[row], ranges[row], |x| {
                let (ln, _) = parameters[places[row]].prior.ln_density(x)?;
                Some(ln.exp())
            });
            let y = Axis::new("").between(0.0, 1.08 * highest);
            return Some(Chart {
                title: None,
                x,
                y,
                layers,
            });
        }
        let cloud = |name: &str, which: &[usize], style: Style| Layer::Points {
            name: Some(name.to_owned()),
            points: which
                .iter()
                .map(|draw| ChartPoint {
                    x: all[column][*draw],
                    y: all[row][*draw],
                    y_se: None,
                })
                .collect(),
            style,
        };
        let mut layers = vec![cloud("draws", &plain, Style::group(1))];
        if !diverging.is_empty() {
            layers.push(cloud("divergent draws", &diverging, Style::group(2).open()));
        }
        let y = axis(row, column == 0);
        Some(Chart {
            title: None,
            x,
            y,
            layers,
        })
    };
    (0..places.len())
        .map(|row| (0..places.len()).map(|column| panel(row, column)).collect())
        .collect()
}

/// Draws to show in a panel: every so many, and of the diverging ones a quarter of the room.
fn points(posterior: &Posterior, most: usize) -> (Vec<usize>, Vec<usize>) {
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
    let heights = bars(draws, (lo, hi), BARS).into_iter().enumerate();
    let bars = heights.flat_map(|(bar, height)| {
        let left = lo + width * bar as f64;
        [(left, 0.0, height), (left + width, 0.0, height)]
    });
    let edges: Vec<(f64, f64, f64)> = bars.collect();
    let curve: Vec<(f64, f64)> = (0..=CURVE)
        .map(|i| lo + (hi - lo) * i as f64 / CURVE as f64)
        .map(|x| (x, prior(x).unwrap_or(0.0)))
        .collect();
    let heights = edges.iter().map(|edge| edge.2).chain(curve.iter().map(|point| point.1));
    let highest = heights.filter(|height| height.is_finite()).fold(0.0, f64::max);
    let layers = vec![
        Layer::Band {
            name: Some("posterior density".to_owned()),
            edges,
            style: Style::group(1),
        },
        Layer::Line {
            name: Some("prior density".to_owned()),
            xy: curve,
            style: Style::group(2),
            dash: Dash::Solid,
        },
    ];
    (layers, highest)
}
