//! Looks up what the figures of one sphere show, a particle or one of its diameters: its series with their names, and the fits to them.

use super::super::{numbers, ReportInput};
use crate::findings::film_ratio::reference_film_ratio;
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;
use crate::runs::Series;
use crate::scene::WetLaw;
use crate::units::{micrometres, millimetres};

pub(super) fn main_film_ratio(input: ReportInput, sphere: usize) -> Option<f64> {
    reference_film_ratio(input.scene, input.runs, sphere)
}

/// The series of a sphere at a film ratio, with the fit of each.
pub(super) fn series_at(input: ReportInput<'_>, sphere: usize, ratio: Option<f64>) -> Vec<(&Series, &SeriesFit)> {
    let both = input.runs.series.iter().zip(&input.findings.series);
    both.filter(|(s, _)| s.sphere == sphere && ratio.is_none_or(|r| s.film_ratio == r))
        .collect()
}

pub(super) fn series_name(input: ReportInput, series: &Series) -> String {
    let liquid = &input.scene.liquids[series.liquid].name;
    let diameter = numbers::short(millimetres(series.diameter));
    format!("{liquid}, D = {diameter} mm, δ = {:.0} µm", micrometres(series.film))
}

pub(super) fn dry_k(input: ReportInput, sphere: usize) -> Option<f64> {
    let dry = input.findings.dry.iter().find(|dry| dry.sphere == sphere)?;
    dry.dry_k.value
}

pub(super) fn scaling_of<'a>(
    input: ReportInput<'a>,
    sphere: usize,
    ratio: Option<f64>,
    law: WetLaw,
) -> Option<&'a Scaling> {
    let sphere = input.runs.spheres[sphere];
    let own = |row: &&Scaling| sphere.owns(input.scene, &row.particle, row.diameter_m);
    input
        .findings
        .scaling
        .iter()
        .filter(own)
        .find(|row| row.film_ratio == ratio && row.law == law)
}
