//! Looks up what the figures of one sphere show, a particle or one of its diameters: its series with their names, and the fits to them.

use super::super::ReportInput;
use crate::findings::dry::fit_of_sphere;
use crate::findings::film_groups::reference_film_ratio;
use crate::findings::scaling::Scaling;
use crate::rounding;
use crate::runs::{Runs, Series};
use crate::scene::WetLaw;
use crate::units::{micrometres, millimetres};

/// More series than this are shown by liquid: a figure of hundreds is all legend.
const MOST_SERIES: usize = 12;

/// Series that a figure shows as one: each its own, or all of a liquid where there are too many.
pub(super) struct ShownSeries {
    /// text of the legend
    pub name: String,
    /// their places among all series
    pub members: Vec<usize>,
}

impl ShownSeries {
    /// The series, where it is shown by itself.
    pub fn single(&self) -> Option<usize> {
        match self.members.as_slice() {
            [one] => Some(*one),
            _ => None,
        }
    }

    pub fn series<'r>(&self, runs: &'r Runs) -> impl Iterator<Item = &'r Series> + use<'_, 'r> {
        self.members.iter().map(|place| &runs.series[*place])
    }
}

/// What the figures of one sphere show.
pub(super) struct OfSphere<'a> {
    pub input: ReportInput<'a>,
    pub sphere: usize,
    /// film ratio of its series; `None`: they are of all
    ratio: Option<f64>,
    pub series: Vec<ShownSeries>,
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

/// The series of a sphere at a film ratio.
fn series_at(input: ReportInput, sphere: usize, ratio: Option<f64>) -> Vec<ShownSeries> {
    let series = &input.runs.series;
    let is_shown = |own: &Series| own.sphere == sphere && ratio.is_none_or(|ratio| own.film_ratio == ratio);
    let mut all: Vec<usize> = (0..series.len()).filter(|place| is_shown(&series[*place])).collect();
    if all.len() <= MOST_SERIES {
        let single = |place: usize| ShownSeries {
            name: series_name(input, &series[place]),
            members: vec![place],
        };
        return all.into_iter().map(single).collect();
    }
    all.sort_by_key(|place| series[*place].liquid);
    let of_liquid = |members: &[usize]| {
        let liquid = &input.scene.liquids[series[members[0]].liquid].name;
        ShownSeries {
            name: format!("{liquid}, {} series", members.len()),
            members: members.to_vec(),
        }
    };
    all.chunk_by(|a, b| series[*a].liquid == series[*b].liquid)
        .map(of_liquid)
        .collect()
}

pub(in crate::report) fn series_name(input: ReportInput, series: &Series) -> String {
    let liquid = &input.scene.liquids[series.liquid].name;
    let diameter = rounding::short(millimetres(series.diameter));
    format!("{liquid}, D = {diameter} mm, δ = {:.0} µm", micrometres(series.film))
}
