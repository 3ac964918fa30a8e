//! Says what the figures of the posterior show.
//!
//! | file | job |
//! |---|---|
//! | `bands.rs` | where the posterior puts the curve of a series, and single runs about it |
//! | `panels.rs` | which parameters have a panel |
//! | `pairs.rs` | draws of each pair of parameters |
//! | `priors.rs` | each parameter before and after the runs |

mod bands;
mod pairs;
mod panels;
mod priors;

pub(super) use bands::{speeds, Bands, SeriesBands};
pub(in crate::report) use panels::{MOST_PAIRED, MOST_PANELS};

use super::super::chart::{grid, Chart, Extent};
use super::super::ReportInput;
use super::figure::{Figure, PAIRS, PRIORS};

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

/// Pairs and priors; nothing where nothing was sampled.
pub(super) fn all(input: ReportInput) -> Vec<Figure> {
    let Some(posterior) = input.posterior else {
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
        figure(PRIORS, grid(&panels(priors::charts(input, posterior)), WIDE_AXES)),
        figure(PAIRS, grid(&pairs::charts(input, posterior), SQUARE_AXES)),
    ]
}
