//! Says what the figures of the posterior show.
//!
//! | file | job |
//! |---|---|
//! | `bands.rs` | where the posterior puts the curve of a series, and single runs about it |
//! | `pairs.rs` | draws of each pair of parameters |
//! | `ranks.rs` | how the chains share the ranks |
//! | `priors.rs` | each parameter before and after the runs |

mod bands;
mod pairs;
mod priors;
mod ranks;

pub(super) use bands::{speeds, Bands, SeriesBands};

use super::super::chart::{grid, Chart, Extent};
use super::super::Told;
use super::{Figure, PAIRS, PRIORS, RANKS};
use crate::findings::posterior::Posterior;
use crate::model::parameters::{Kind, Parameter};

/// Columns of the figures that have a panel a parameter.
const COLUMNS: usize = 4;

const WIDE_AXES: Extent = Extent {
    width: 190.0,
    height: 110.0,
};
const SQUARE_AXES: Extent = Extent {
    width: 96.0,
    height: 96.0,
};

/// Pairs, ranks and priors; nothing where nothing was sampled.
pub(super) fn all(told: Told) -> Vec<Figure> {
    let Some(posterior) = told.posterior else {
        return vec![];
    };
    let panels = |charts: Vec<Chart>| -> Vec<Vec<Option<Chart>>> {
        let rows = charts.chunks(COLUMNS);
        rows.map(|row| row.iter().cloned().map(Some).collect()).collect()
    };
    let figure = |name: &str, svg: String| Figure {
        name: name.to_owned(),
        svg,
    };
    vec![
        figure(RANKS, grid(&panels(ranks::charts(told, posterior, COLUMNS)), WIDE_AXES)),
        figure(PRIORS, grid(&panels(priors::charts(told, posterior)), WIDE_AXES)),
        figure(PAIRS, grid(&pairs::charts(told, posterior), SQUARE_AXES)),
    ]
}

/// Places of at most so many parameters, in their order: those that all runs share go before the k of each particle.
fn first_places(posterior: &Posterior, most: usize) -> Vec<usize> {
    let of_particle = |place: &usize| matches!(kind(posterior, *place), Kind::DryK(_));
    let (own, shared): (Vec<usize>, Vec<usize>) = (0..posterior.sampled.values.len()).partition(of_particle);
    let mut places: Vec<usize> = shared.into_iter().chain(own).take(most).collect();
    places.sort_unstable();
    places
}

fn kind(posterior: &Posterior, place: usize) -> Kind {
    posterior.sampled.parameters.sampled[place].kind
}

/// A parameter's draws, chain after chain.
fn draws(posterior: &Posterior, place: usize) -> Vec<f64> {
    posterior.sampled.values[place].concat()
}

/// A parameter's symbol, with its particle.
fn symbol(told: Told, parameter: &Parameter) -> String {
    match parameter.kind {
        Kind::DryK(particle) => format!("k, {}", told.scene.particles[particle].name),
        Kind::FILM_SCALE => "δ̃_{0}".to_owned(),
        Kind::SigmaDry => "σ_{dry}".to_owned(),
        Kind::SigmaWet => "σ_{wet}".to_owned(),
        Kind::SigmaEnergy => "σ_{r}".to_owned(),
        other => other.symbol().to_owned(),
    }
}

/// Smallest and largest of some numbers, a little apart.
fn range(values: &[f64]) -> (f64, f64) {
    let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let margin = 0.03 * (hi - lo);
    (lo - margin, hi + margin)
}
