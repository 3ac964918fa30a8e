//! Draws how the chains share the ranks of all draws.

use super::super::super::chart::{Axis, Chart, Dash, Layer, Style};
use super::super::super::ReportInput;
use super::panels::{first_places, symbol, MOST_PANELS};
use crate::findings::posterior::Posterior;
use crate::inference::diagnostics::rank_counts::RankCounts;

/// Bins of ranks, where the draws are many enough.
const BINS: usize = 20;
/// Top of the vertical axis where nothing is higher: even shares lie in the middle.
const LOWEST_TOP: f64 = 2.0;
/// Draws a bin should expect of each chain.
const EXPECTED: usize = 10;

/// A panel a parameter, for rows of so many.
pub(super) fn charts(input: ReportInput, posterior: &Posterior, columns: usize) -> Vec<Chart> {
    let places = first_places(posterior, MOST_PANELS);
    let count = places.len();
    let panel = |(index, place): (usize, usize)| {
        let chains = &posterior.sampled.values[place];
        let mut chart = of_chains(chains);
        chart.title = Some(symbol(input, &posterior.sampled.parameters.sampled[place]));
        if index + columns >= count {
            chart.x.label = "rank / draws".to_owned();
        }
        if index % columns == 0 {
            chart.y.label = "share".to_owned();
        }
        chart
    };
    let mut charts: Vec<Chart> = places.into_iter().enumerate().map(panel).collect();
    // one scale for all: neighbours share their ticks
    let highest = charts.iter().filter_map(|chart| chart.y.range).map(|range| range.1);
    let highest = highest.fold(LOWEST_TOP, f64::max);
    charts.iter_mut().for_each(|chart| chart.y.range = Some((0.0, highest)));
    charts
}

fn of_chains(chains: &[Vec<f64>]) -> Chart {
    let each = chains.first().map_or(0, Vec::len);
    let bins = (each / EXPECTED).clamp(2, BINS);
    let RankCounts { counts, expected, sd } = RankCounts::new(chains, bins);
    let mut layers = vec![Layer::Band {
        name: Some("two sd of independent draws".to_owned()),
        edges: vec![
            (0.0, 1.0 - 2.0 * sd, 1.0 + 2.0 * sd),
            (1.0, 1.0 - 2.0 * sd, 1.0 + 2.0 * sd),
        ],
        style: Style::group(0),
    }];
    for (chain, of_chain) in counts.iter().enumerate() {
        let steps = of_chain.iter().enumerate().flat_map(|(bin, count)| {
            let height = *count as f64 / expected;
            [bin, bin + 1].map(|edge| (edge as f64 / bins as f64, height))
        });
        layers.push(Layer::Line {
            name: Some(format!("chain {}", chain + 1)),
            xy: steps.collect(),
            style: Style::group(chain + 1),
            dash: Dash::Solid,
        });
    }
    let highest = counts
        .iter()
        .flatten()
        .max()
        .map_or(1.0, |most| *most as f64 / expected);
    Chart {
        title: None,
        x: Axis::new("").between(0.0, 1.0),
        y: Axis::new("").between(0.0, 1.05 * highest),
        layers,
    }
}
