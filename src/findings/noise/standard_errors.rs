//! Says by how much standard errors are too small, and from where on that matters.

use serde::Serialize;

use super::rows::Rows;

/// Standard errors too small by more than this factor matter: a 95 % interval then covers less than 94 %.
///
/// An interval of ± 1.960 standard errors that are too small by c reaches ± 1.960/c of the right ones, and covers 94 %
/// where that is 1.881: c = 1.042. It is the line of 0.25 for a bias, for a width.
pub const LINE: f64 = 1.042;

/// Probability below which groups or series are taken to differ.
pub const LEVEL: f64 = 0.01;

/// By how much the standard error of a parameter is too small.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StandardErrorRatio {
    /// its name
    pub parameter: String,
    /// the standard error that allows for what was found over the one that does not; below 1 it is too large
    pub ratio: f64,
}

/// The parameters the runs see, with what their standard errors lack.
pub(super) fn standard_error_ratios(rows: &Rows, widening: &[Option<f64>]) -> Vec<StandardErrorRatio> {
    let named = |(name, ratio): (&String, &Option<f64>)| {
        Some(StandardErrorRatio {
            parameter: name.clone(),
            ratio: (*ratio)?,
        })
    };
    rows.names.iter().zip(widening).filter_map(named).collect()
}

/// The one that lacks most.
pub(super) fn worst(all: &[StandardErrorRatio]) -> Option<&StandardErrorRatio> {
    all.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
}
