//! Counts how the chains share the ranks of all draws.

use super::super::super::chart::{Axis, Chart, Dash, Layer, Style};
use super::super::super::ReportInput;
use super::panels::{first_places, symbol};
use crate::findings::posterior::Posterior;

/// More panels than this are a wall.
const MOST_PARAMETERS: usize = 16;
/// Bins of ranks, where the draws are many enough.
const BINS: usize = 20;
/// Top of the vertical axis where nothing is higher: even shares lie in the middle.
const LOWEST_TOP: f64 = 2.0;
/// Draws a bin should expect of each chain.
const EXPECTED: usize = 10;

/// A panel a parameter, for rows of so many.
pub(super) fn charts(input: ReportInput, posterior: &Posterior, columns: usize) -> Vec<Chart> {
    let places = first_places(posterior, MOST_PARAMETERS);
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
    let counts = counts(chains, bins);
    let expected = each as f64 / bins as f64;
    // of one chain every bin has its even share; of several, what the others leave
    let others = 1.0 - 1.0 / chains.len().max(1) as f64;
    let sd = (others * (bins as f64 - 1.0) / each.max(1) as f64).sqrt();
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

/// How many draws of each chain lie in each bin of the ranks of all; equal draws rank by chain and place.
fn counts(chains: &[Vec<f64>], bins: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<(f64, usize)> = chains
        .iter()
        .enumerate()
        .flat_map(|(chain, draws)| draws.iter().map(move |draw| (*draw, chain)))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut counts = vec![vec![0; bins]; chains.len()];
    let all = order.len();
    for (rank, (_, chain)) in order.into_iter().enumerate() {
        counts[chain][rank * bins / all] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_that_agree_share_the_ranks_evenly_and_one_that_does_not_stands_out() {
        let even = |chain: usize| (0..100).map(|draw| (2 * draw + chain) as f64).collect();
        assert_eq!(counts(&[even(0), even(1)], 4), [[25; 4]; 2]);
        let apart = [even(0), (0..100).map(|draw| f64::from(draw) + 1e6).collect()];
        assert_eq!(counts(&apart, 4), [[50, 50, 0, 0], [0, 0, 50, 50]]);
    }
}
