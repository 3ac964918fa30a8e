//! Looks up what the figures of one particle show: its series with their names, and the fits to them.

use super::super::{numbers, ReportInput};
use crate::findings::film_ratio::reference_film_ratio;
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;
use crate::runs::Series;
use crate::scene::WetLaw;
use crate::units::{micrometres, millimetres};

pub(super) fn main_film_ratio(input: ReportInput, particle: usize) -> Option<f64> {
    reference_film_ratio(input.scene, input.runs, particle)
}

/// The series of a particle at a film ratio, with the fit of each.
pub(super) fn series_at(input: ReportInput<'_>, particle: usize, ratio: Option<f64>) -> Vec<(&Series, &SeriesFit)> {
    let both = input.runs.series.iter().zip(&input.findings.series);
    both.filter(|(s, _)| s.particle == particle && ratio.is_none_or(|r| s.film_ratio == r))
        .collect()
}

pub(super) fn series_name(input: ReportInput, series: &Series) -> String {
    let liquid = &input.scene.liquids[series.liquid].name;
    let diameter = numbers::short(millimetres(series.diameter));
    format!("{liquid}, D = {diameter} mm, δ = {:.0} µm", micrometres(series.film))
}

pub(super) fn dry_k(input: ReportInput, particle: usize) -> Option<f64> {
    let name = &input.scene.particles[particle].name;
    let dry = input.findings.dry.iter().find(|dry| dry.particle == *name)?;
    dry.dry_k.value
}

pub(super) fn scaling_of<'a>(
    input: ReportInput<'a>,
    particle: usize,
    ratio: Option<f64>,
    law: WetLaw,
) -> Option<&'a Scaling> {
    let name = &input.scene.particles[particle].name;
    input
        .findings
        .scaling
        .iter()
        .find(|row| row.particle == *name && row.film_ratio == ratio && row.law == law)
}
