//! Looks up what the figures of one sphere show, a particle or one of its diameters: its series with their names, and the fits to them.

use super::super::ReportInput;
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;
use crate::rounding;
use crate::runs::Series;
use crate::scene::WetLaw;
use crate::units::{micrometres, millimetres};

/// More series than this are shown by liquid: a figure of hundreds is all legend.
const MOST_SERIES: usize = 12;

/// Series that a figure shows as one: each its own, or all of a liquid where there are too many.
pub(super) struct ShownSeries<'a> {
    /// text of the legend
    pub name: String,
    pub members: Vec<(&'a Series, &'a SeriesFit)>,
}

impl<'a> ShownSeries<'a> {
    /// The series, where it is shown by itself.
    pub fn single(&self) -> Option<(&'a Series, &'a SeriesFit)> {
        match self.members.as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    pub fn series(&self) -> impl Iterator<Item = &'a Series> + '_ {
        self.members.iter().map(|(series, _)| *series)
    }
}

/// The series of a sphere at a film ratio, with the fit of each.
pub(super) fn series_at<'a>(input: ReportInput<'a>, sphere: usize, ratio: Option<f64>) -> Vec<ShownSeries<'a>> {
    let both = input.runs.series.iter().zip(&input.findings.series);
    let mut all: Vec<(&Series, &SeriesFit)> = both
        .filter(|(s, _)| s.sphere == sphere && ratio.is_none_or(|r| s.film_ratio == r))
        .collect();
    if all.len() <= MOST_SERIES {
        let single = |one: (&'a Series, &'a SeriesFit)| ShownSeries {
            name: series_name(input, one.0),
            members: vec![one],
        };
        return all.into_iter().map(single).collect();
    }
    all.sort_by_key(|(series, _)| series.liquid);
    let of_liquid = |members: &[(&'a Series, &'a SeriesFit)]| {
        let liquid = &input.scene.liquids[members[0].0.liquid].name;
        ShownSeries {
            name: format!("{liquid}, {} series", members.len()),
            members: members.to_vec(),
        }
    };
    all.chunk_by(|a, b| a.0.liquid == b.0.liquid).map(of_liquid).collect()
}

/// The title of a figure at a film ratio: a range where the series have no one film ratio.
pub(super) fn title_at(input: ReportInput, sphere: usize, ratio: Option<f64>) -> Option<String> {
    let mut groups = input.runs.film_groups_of(sphere).iter();
    let group = groups.find(|group| Some(group.film_ratio) == ratio)?;
    let ratio = match group.has_one_film_ratio() {
        true => rounding::short(group.film_ratio),
        false => rounding::range(group.ends),
    };
    let sphere = input.runs.spheres[sphere].words(input.scene);
    Some(format!("{sphere}, δ/D = {ratio}"))
}

pub(in crate::report) fn series_name(input: ReportInput, series: &Series) -> String {
    let liquid = &input.scene.liquids[series.liquid].name;
    let diameter = rounding::short(millimetres(series.diameter));
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
