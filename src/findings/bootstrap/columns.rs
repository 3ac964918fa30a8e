//! Lays the runs of all fits out as columns, in the order in which the strata are drawn.

use std::ops::Range;

use crate::findings::dry::{own_dry_speed, FittedDry};
use crate::inference::bootstrap::{strata, Pool, RunErrors, Target};
use crate::inference::effective_variance::ErrorWeights;
use crate::inference::law::Law;
use crate::inference::regression::Regression;
use crate::physics::dry::Order;
use crate::runs::{Runs, Series};
use crate::scene::{Scene, WetLaw};

/// Where the runs of a series, or dry runs of a diameter, stand.
struct SeriesColumns {
    runs: Range<usize>,
    strata: Range<usize>,
    /// empty where nothing rebounded: there is nothing to draw
    series: Range<usize>,
    /// first of its rebounds in the table
    first: usize,
}

/// The runs of all fits as columns in the order of the strata.
pub(super) struct Columns {
    pub(super) pool: Pool,
    places: Vec<SeriesColumns>,
    dry_runs: usize,
    /// where each run stands in the table; empty where none is weighed by its errors
    order: Vec<usize>,
    speed_root: Vec<f64>,
    dry_restitution: Vec<f64>,
    inverse_speed: Vec<f64>,
    inverse_stokes: Vec<f64>,
    restitution: Vec<f64>,
    offset: Vec<f64>,
    /// how many runs each stands for; empty where that is itself
    dry_count: Vec<f64>,
    count: Vec<f64>,
}

impl Columns {
    pub(super) fn new(scene: &Scene, runs: &Runs, dry: &[FittedDry]) -> Columns {
        let mut columns = Columns {
            pool: Pool::default(),
            places: vec![],
            dry_runs: 0,
            order: vec![],
            speed_root: vec![],
            dry_restitution: vec![],
            inverse_speed: vec![],
            inverse_stokes: vec![],
            restitution: vec![],
            offset: vec![],
            dry_count: vec![],
            count: vec![],
        };
        let weighs = runs.errors.is_some();
        for group in &runs.dry {
            let order = columns.divide(&runs.impact_speed, &group.rebounds);
            for run in &order {
                columns.speed_root.push(runs.impacts.speed_root[*run]);
                columns.dry_restitution.push(runs.restitution[*run]);
            }
            columns
                .dry_count
                .extend(order.iter().filter_map(|run| runs.count.get(*run)));
            columns.order.extend(order.into_iter().filter(|_| weighs));
        }
        columns.dry_runs = columns.dry_restitution.len();
        let own_of = |series: &Series| own_dry_speed(scene, dry, series.sphere);
        let has_offsets = runs.series.iter().any(|series| own_of(series).is_some());
        for series in &runs.series {
            let order = columns.divide(&runs.impact_speed, &series.rebounds);
            let speeds: Vec<f64> = order.iter().map(|run| runs.impact_speed[*run]).collect();
            columns.inverse_speed.extend(speeds.iter().map(|v| 1.0 / v));
            let inverse_stokes = order.iter().map(|run| runs.inverse_stokes(*run));
            columns.inverse_stokes.extend(inverse_stokes);
            let restitution = order.iter().map(|run| runs.restitution[*run]);
            columns.restitution.extend(restitution);
            columns
                .count
                .extend(order.iter().filter_map(|run| runs.count.get(*run)));
            match own_of(series) {
                Some(own) => columns.offset.extend(own.offsets(&speeds)),
                None if has_offsets => columns.offset.extend(std::iter::repeat_n(0.0, speeds.len())),
                None => {}
            }
            columns.order.extend(order.into_iter().filter(|_| weighs));
        }
        if columns.offset.iter().all(|offset| *offset == 0.0) {
            columns.offset.clear();
        }
        columns
    }

    /// Adds a series of the pool, divided by impact speed, and gives its runs in the order of their columns.
    fn divide(&mut self, speeds: &[f64], rebounds: &Range<usize>) -> Vec<usize> {
        let mut order: Vec<usize> = rebounds.clone().collect();
        order.sort_by(|a, b| speeds[*a].total_cmp(&speeds[*b]));
        let sorted: Vec<f64> = order.iter().map(|run| speeds[*run]).collect();
        let (strata, series) = (self.pool.strata.len(), self.pool.series.len());
        let first = self.pool.strata.last().map_or(0, |stratum| stratum.end);
        let own = strata::by_speed(&sorted).into_iter();
        let shifted = own.map(|stratum| first + stratum.start..first + stratum.end);
        self.pool.strata.extend(shifted);
        let runs = first..first + order.len();
        self.pool.series.extend((!order.is_empty()).then(|| runs.clone()));
        self.places.push(SeriesColumns {
            runs,
            strata: strata..self.pool.strata.len(),
            series: series..self.pool.series.len(),
            first: rebounds.start,
        });
        order
    }

    /// The errors by which a fit weighed the runs of some places, in the order of their columns.
    pub(super) fn run_errors(&self, error_weights: Option<&ErrorWeights>, places: Range<usize>) -> Option<RunErrors> {
        let own = error_weights?;
        // where each run stands in the columns of the fit
        let mut order = vec![];
        for place in &self.places[places] {
            let before = order.len();
            let runs = self.order[place.runs.clone()].iter();
            order.extend(runs.map(|run| before + run - place.first));
        }
        let variance: Vec<f64> = order.iter().map(|run| own.variance[*run]).collect();
        let left_out: Vec<bool> = variance.iter().map(|variance| variance.is_infinite()).collect();
        let counted = left_out.iter().filter(|left_out| !**left_out).count();
        let mean = variance.iter().map(|variance| 1.0 / variance).sum::<f64>() / counted as f64;
        let bias = |j: usize| own.bias.get(j).copied().unwrap_or(0.0);
        Some(RunErrors {
            columns: own.errors.of_runs(&order),
            left_out,
            weights: variance.iter().map(|variance| 1.0 / (variance * mean)).collect(),
            bias: [bias(0), bias(1)],
        })
    }

    /// What some series cover together.
    fn joined(&self, places: &Range<usize>, of: fn(&SeriesColumns) -> &Range<usize>) -> Range<usize> {
        let places = &self.places[places.clone()];
        let (first, last) = (places.first().map(of), places.last().map(of));
        first.map_or(0, |range| range.start)..last.map_or(0, |range| range.end)
    }

    pub(super) fn dry<'k>(
        &'k self,
        places: Range<usize>,
        k: f64,
        order: Order,
        errors: Option<&'k RunErrors>,
    ) -> Target<'k> {
        let range = self.joined(&places, |place| &place.runs);
        Target {
            regression: Regression {
                counts: self.dry_count.get(range.clone()).unwrap_or(&[]),
                ..Regression::new(
                    Law::Dry(order),
                    &self.speed_root[range.clone()],
                    &self.dry_restitution[range],
                )
            },
            strata: self.joined(&places, |place| &place.strata),
            series: self.joined(&places, |place| &place.series),
            fitted: [k, 0.0],
            errors,
        }
    }

    /// The square-root law of all rebounds over 1/v.
    pub(super) fn over_speed(&self) -> Regression<'_> {
        Regression {
            offset: &self.offset,
            ..Regression::new(Law::SQUARE_ROOT, &self.inverse_speed, &self.restitution)
        }
    }

    /// A law of all rebounds over 1/St.
    pub(super) fn over_stokes(&self, law: WetLaw) -> Regression<'_> {
        Regression {
            offset: if law == WetLaw::Sqrt { &self.offset } else { &[] },
            ..Regression::new(Law::Wet(law), &self.inverse_stokes, &self.restitution)
        }
    }

    /// The fit of a law of all rebounds to those of some places.
    pub(super) fn wet<'k>(
        &'k self,
        all: Regression<'k>,
        places: Range<usize>,
        fitted: [f64; 2],
        errors: Option<&'k RunErrors>,
    ) -> Target<'k> {
        let range = self.joined(&places, |place| &place.runs);
        let range = range.start - self.dry_runs..range.end - self.dry_runs;
        Target {
            regression: Regression {
                offset: all.offset.get(range.clone()).unwrap_or(&[]),
                counts: self.count.get(range.clone()).unwrap_or(&[]),
                ..Regression::new(all.law, &all.x[range.clone()], &all.restitution[range])
            },
            strata: self.joined(&places, |place| &place.strata),
            series: self.joined(&places, |place| &place.series),
            fitted,
            errors,
        }
    }
}
