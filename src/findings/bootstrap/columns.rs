//! Lays the runs of every fit out as columns, in the order in which the strata are drawn.

use std::ops::Range;

use crate::findings::dry::{own_dry_speed, Dry};
use crate::findings::fit_columns::{FitColumns, OwnDrySpeed};
use crate::findings::scaling::Scaling;
use crate::findings::series::SeriesFit;
use crate::findings::wet_fit::WetFit;
use crate::inference::bootstrap::{strata, Pool, RunErrors, Target};
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::law::Law;
use crate::runs::Runs;
use crate::scene::Scene;

/// The estimates that get a bootstrap interval.
pub struct Estimates<'e> {
    /// k of each sphere
    pub dry: &'e mut [Dry],
    /// the square-root law of each series
    pub series: &'e mut [SeriesFit],
    /// e_inf and St_c, and where the energy went
    pub scaling: &'e mut [Scaling],
}

/// Where the rebounds of a series, or the dry ones of a diameter, stand.
struct Group {
    /// among those of all groups
    runs: Range<usize>,
    strata: Range<usize>,
    /// empty where nothing rebounded: there is nothing to draw
    series: Range<usize>,
    /// first of its rebounds in the table
    first: usize,
}

/// The rebounds of a table, divided into dry groups and then series, and inside these by impact speed.
pub(super) struct Division<'r> {
    pub(super) pool: Pool,
    runs: &'r Runs,
    groups: Vec<Group>,
    /// the rebounds of all groups, those of each by impact speed
    order: Vec<usize>,
}

/// The runs that a fit is made to, in the order of their division.
pub(super) struct FitRuns {
    law: Law,
    columns: FitColumns,
    strata: Range<usize>,
    series: Range<usize>,
    fitted: [f64; 2],
    errors: Option<RunErrors>,
}

impl FitRuns {
    pub(super) fn target(&self) -> Target<'_> {
        Target {
            regression: self.columns.regression(self.law),
            strata: self.strata.clone(),
            series: self.series.clone(),
            fitted: self.fitted,
            errors: self.errors.as_ref(),
        }
    }
}

impl<'r> Division<'r> {
    pub(super) fn new(runs: &'r Runs) -> Division<'r> {
        let mut division = Division {
            pool: Pool::default(),
            runs,
            groups: vec![],
            order: vec![],
        };
        let dry = runs.dry.iter().map(|group| &group.rebounds);
        for rebounds in dry.chain(runs.series.iter().map(|series| &series.rebounds)) {
            division.add(rebounds);
        }
        division
    }

    fn add(&mut self, rebounds: &Range<usize>) {
        let speeds = &self.runs.impact_speed;
        let first = self.order.len();
        self.order.extend(rebounds.clone());
        let own = &mut self.order[first..];
        own.sort_by(|a, b| speeds[*a].total_cmp(&speeds[*b]));
        let sorted: Vec<f64> = own.iter().map(|run| speeds[*run]).collect();
        let (strata, series) = (self.pool.strata.len(), self.pool.series.len());
        let shifted = strata::by_speed(&sorted).into_iter();
        let shifted = shifted.map(|stratum| first + stratum.start..first + stratum.end);
        self.pool.strata.extend(shifted);
        let runs = first..self.order.len();
        self.pool.series.extend((!runs.is_empty()).then(|| runs.clone()));
        self.groups.push(Group {
            runs,
            strata: strata..self.pool.strata.len(),
            series: series..self.pool.series.len(),
            first: rebounds.start,
        });
    }

    /// The runs of every fit, of dry laws, series and scaling laws in turn; `None` of a fit without numbers.
    pub(super) fn fits(&self, scene: &Scene, estimates: &Estimates) -> Vec<Option<FitRuns>> {
        let (runs, dry) = (self.runs, &*estimates.dry);
        let wet = |series: Range<usize>| runs.dry.len() + series.start..runs.dry.len() + series.end;
        let of_dry = |fitted: &Dry| {
            let first = runs.dry.partition_point(|group| group.sphere < fitted.sphere);
            let groups = first..first + runs.dry_of(fitted.sphere).len();
            let end = (Law::Dry(scene.model.form().dry), [fitted.dry_k.value?, 0.0]);
            let weights = fitted.error_weights.as_ref();
            let x = |run: usize| runs.impacts.speed_root[run];
            (!groups.is_empty()).then(|| self.runs_of(groups, end, None, weights, x))
        };
        let of_wet = |fitted: &WetFit| {
            let end = (Law::Wet(fitted.over.law()), fitted.parameters()?);
            let own = own_dry_speed(scene, dry, fitted.sphere);
            let x = |run: usize| fitted.over.abscissa(runs, run);
            Some(self.runs_of(wet(fitted.series.clone()), end, own, fitted.weights.as_ref(), x))
        };
        let dry = dry.iter().map(of_dry);
        let series = estimates.series.iter().map(|own| of_wet(own));
        let scaling = estimates.scaling.iter().map(|own| of_wet(own));
        dry.chain(series).chain(scaling).collect()
    }

    /// The runs of some groups with their abscissae; a law that is fitted to them, and where that ended.
    fn runs_of(
        &self,
        groups: Range<usize>,
        (law, fitted): (Law, [f64; 2]),
        own_speed: Option<OwnDrySpeed>,
        error_weights: Option<&ErrorWeights>,
        x: impl Fn(usize) -> f64,
    ) -> FitRuns {
        let groups = &self.groups[groups];
        let joined = |of: fn(&Group) -> &Range<usize>| {
            let (first, last) = (groups.first().map(of), groups.last().map(of));
            first.map_or(0, |range| range.start)..last.map_or(0, |range| range.end)
        };
        let own = &self.order[joined(|group| &group.runs)];
        // where each run stands among those of the fit, which come as in the table
        let in_fit = || {
            let mut places = Vec::with_capacity(own.len());
            for group in groups {
                let (before, order) = (places.len(), &self.order[group.runs.clone()]);
                places.extend(order.iter().map(|run| before + run - group.first));
            }
            places
        };
        FitRuns {
            law,
            columns: FitColumns::of(self.runs, own.iter().copied(), x, own_speed.as_ref()),
            strata: joined(|group| &group.strata),
            series: joined(|group| &group.series),
            fitted,
            errors: error_weights.map(|weights| RunErrors::new(weights, &in_fit())),
        }
    }
}
