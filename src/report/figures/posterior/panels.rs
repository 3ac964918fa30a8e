//! Chooses the parameters that have a panel, with their draws, symbols and limits.

use super::super::super::quantities::{in_scripts, parameter_label};
use super::super::super::ReportInput;
use crate::findings::posterior::Posterior;
use crate::model::parameters::{ModelParameter, ParameterKind};

/// More panels than this are a wall.
pub(in crate::report) const MOST_PANELS: usize = 16;
/// More parameters than this leave no room to see anything of their pairs.
pub(in crate::report) const MOST_PAIRED: usize = 8;

/// Places of at most so many parameters, in their order: those that all runs share go before the k of each particle.
pub(super) fn first_places(posterior: &Posterior, most: usize) -> Vec<usize> {
    let of_particle = |place: &usize| matches!(kind(posterior, *place), ParameterKind::DryK(_));
    let (own, shared): (Vec<usize>, Vec<usize>) = (0..posterior.sampled.values.len()).partition(of_particle);
    let mut places: Vec<usize> = shared.into_iter().chain(own).take(most).collect();
    places.sort_unstable();
    places
}

fn kind(posterior: &Posterior, place: usize) -> ParameterKind {
    posterior.sampled.parameters.sampled[place].kind
}

/// A parameter's draws, chain after chain.
pub(super) fn draws(posterior: &Posterior, place: usize) -> Vec<f64> {
    posterior.sampled.values[place].concat()
}

/// A parameter's symbol, with its particle.
pub(super) fn symbol(input: ReportInput, parameter: &ModelParameter) -> String {
    let kind = parameter.kind;
    parameter_label(input.scene, input.runs, kind, &in_scripts(kind.symbol()))
}

/// Smallest and largest of some numbers, a little apart.
pub(super) fn range(values: &[f64]) -> (f64, f64) {
    let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let margin = 0.03 * (hi - lo);
    (lo - margin, hi + margin)
}
