//! Looks up what the figures of one sphere show, a particle or one of its diameters: its series with their names, and the fits to them.

use super::super::ReportInput;
use crate::findings::dry::fit_of_sphere;
use crate::findings::film_groups::reference_film_ratio;
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

/// What the figures of one sphere show.
pub(super) struct OfSphere<'a> {
    pub input: ReportInput<'a>,
    pub sphere: usize,
    /// film ratio of its series; `None`: they are of all
    ratio: Option<f64>,
    pub series: Vec<ShownSeries<'a>>,
}

impl<'a> OfSphere<'a> {
    pub fn new(input: ReportInput<'a>, sphere: usize) -> OfSphere<'a> {
        let ratio = reference_film_ratio(input.scene, input.runs, sphere);
        OfSphere {
            input,
            sphere,
            ratio,
            series: series_at(input, sphere, ratio),
        }
    }

    /// The title of a figure: a range where the series have no one film ratio.
    pub fn title(&self) -> Option<String> {
        let mut groups = self.input.runs.film_groups_of(self.sphere).iter();
        let group = groups.find(|group| Some(group.film_ratio) == self.ratio)?;
        let ratio = match group.has_one_film_ratio() {
            true => rounding::short(group.film_ratio),
            false => rounding::range(group.ends),
        };
        let sphere = self.input.runs.spheres[self.sphere].words(self.input.scene);
        Some(format!("{sphere}, δ/D = {ratio}"))
    }

    /// k of its dry runs.
    pub fn dry_k(&self) -> Option<f64> {
        fit_of_sphere(&self.input.findings.dry, self.sphere)?.dry_k.value
    }

    /// The fit of a law to the series.
    pub fn scaling(&self, law: WetLaw) -> Option<&'a Scaling> {
        let mut rows = self.input.findings.scaling.iter();
        rows.find(|row| (row.sphere, row.film_ratio, row.law) == (self.sphere, self.ratio, law))
    }
}

/// The series of a sphere at a film ratio, with the fit of each.
fn series_at<'a>(input: ReportInput<'a>, sphere: usize, ratio: Option<f64>) -> Vec<ShownSeries<'a>> {
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

pub(in crate::report) fn series_name(input: ReportInput, series: &Series) -> String {
    let liquid = &input.scene.liquids[series.liquid].name;
    let diameter = rounding::short(millimetres(series.diameter));
    format!("{liquid}, D = {diameter} mm, δ = {:.0} µm", micrometres(series.film))
}
