//! Replaces very many runs by few of them that stand for all.
//!
//! In a slab (`slabs.rs`) every law is nearly a polynomial of degree [`DEGREE`] in m, δ̃ and D, as is the probability to stick. A
//! few runs of it with counts of their own have the sums of all (`condensing`), each with the nearest polynomial for its
//! restitution. Near the turn and the slowest rebound, and where settings repeat, each setting stands for its own runs, which
//! is exact.

use std::ops::Range;

use rayon::prelude::*;

use super::series::{DryGroup, Runs, Series};
use super::slabs::{Slab, Slabs, MANY};
use crate::condensing::nearest::Nearest;
use crate::condensing::polynomials::{functions, Axis, Polynomials};
use crate::condensing::recombination::{recombine, Kept};

/// Beyond so many runs laws and the posterior read few that stand for all.
const MANY_RUNS: usize = 100_000;

/// Degree of the polynomials that laws are taken for in a slab.
const DEGREE: usize = 4;

/// Share of the squares of restitutions by which those of few runs may differ from those of all.
const ROUNDING: f64 = 1e-10;

/// One run that stands for several.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StandIn {
    run: usize,
    restitution: f64,
    count: f64,
}

/// The runs of one setting.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SettingRuns {
    run: usize,
    count: f64,
    /// mean restitution
    mean: f64,
    /// about that
    variance: f64,
}

impl SettingRuns {
    /// Sum of the squares of their restitutions.
    fn squares(&self) -> f64 {
        self.count * (self.mean * self.mean + self.variance)
    }

    /// One run on either side of the mean, or one alone: they have its mean and variance, and so every sum of squares.
    fn stand_ins(self) -> impl Iterator<Item = StandIn> {
        let sd = self.variance.sqrt();
        let sides: &[f64] = if sd > 0.0 { &[-1.0, 1.0] } else { &[0.0] };
        sides.iter().map(move |side| StandIn {
            run: self.run,
            restitution: self.mean + side * sd,
            count: self.count / sides.len() as f64,
        })
    }
}

/// Runs that may stand for one another, in columns that begin with the first of them.
struct Members<'r> {
    runs: &'r Runs,
    first: usize,
    /// what tells settings apart
    settings: [&'r [f64]; 3],
    /// what laws are polynomials in
    axes: Vec<&'r [f64]>,
}

impl Runs {
    /// Few of very many runs that stand for all, where restitutions up to `limit` stick; `None` of fewer runs, of those that
    /// stand for others, or where they carry measurement errors, which differ from run to run.
    pub fn condensed(&self, limit: f64) -> Option<Runs> {
        let is_possible = self.len() > MANY_RUNS && self.count.is_empty() && self.errors.is_empty();
        is_possible.then(|| self.few(limit))
    }

    /// Few of the runs that stand for all, of however many.
    pub fn few(&self, limit: f64) -> Runs {
        self.condensed_in(&Slabs::of(self, limit))
    }

    /// Few of the runs that stand for all, by slabs.
    pub(super) fn condensed_in(&self, slabs: &Slabs) -> Runs {
        let of_dry = |group: &DryGroup| {
            group.kinds().map(|range| {
                let ends = self.ends(&range);
                let is_end = |place: &usize| ends.contains(&(range.start + place));
                let (ends, between): (Vec<usize>, Vec<usize>) = (0..range.len()).partition(is_end);
                let slabs = [(ends, true), (between, range.len() < MANY)];
                let of_speed = &self.impacts.speed_root[range.clone()];
                self.members(range.clone(), vec![of_speed]).stand_ins(&slabs)
            })
        };
        let dry: Vec<[Vec<StandIn>; 2]> = self.dry.par_iter().map(of_dry).collect();
        let of_series = |series: &Series| {
            let all = series.runs();
            let plane = slabs.plane(series);
            let means = plane.map_or_else(|| vec![0.0; all.len()], |plane| plane.means(self, series));
            let others = [&self.impacts.film_ratio, &self.diameter].map(|column| &column[all.clone()]);
            let axes = std::iter::once(&means[..]).chain(others).collect();
            let members = self.members(all, axes);
            let of_kinds = self.slabs(series, &means, plane.map(|plane| (plane, slabs.limit)));
            of_kinds.map(|own| members.stand_ins(&own))
        };
        let wet: Vec<[Vec<StandIn>; 2]> = self.series.par_iter().map(of_series).collect();
        let mut each = dry.into_iter().chain(wet).flatten();
        self.regrouped(|few, _| few.take_stand_ins(self, each.next().unwrap_or_default()))
    }

    fn take_stand_ins(&mut self, from: &Runs, some: Vec<StandIn>) {
        for one in some {
            self.take_run(from, one.run);
            // in place of those of the run itself
            self.count.truncate(self.len() - 1);
            self.count.push(one.count);
            if let Some(own) = self.restitution.last_mut() {
                *own = one.restitution;
            }
        }
    }

    fn members<'r>(&'r self, range: Range<usize>, axes: Vec<&'r [f64]>) -> Members<'r> {
        Members {
            runs: self,
            first: range.start,
            settings: [&self.impact_speed, &self.film, &self.diameter].map(|column| &column[range.clone()]),
            axes,
        }
    }
}

impl Members<'_> {
    /// What stands for the runs of each slab.
    fn stand_ins(&self, slabs: &[Slab]) -> Vec<StandIn> {
        let few = slabs.iter().flat_map(|(places, is_kept)| match is_kept {
            true => self.settings(places),
            false => self.few_of(self.settings(places)),
        });
        few.flat_map(SettingRuns::stand_ins).collect()
    }

    /// Few of some settings, where they are more than it takes.
    fn few_of(&self, settings: Vec<SettingRuns>) -> Vec<SettingRuns> {
        let of_settings = |column: &&[f64]| settings.iter().map(|own| column[own.run - self.first]).collect();
        let own: Vec<Vec<f64>> = self.axes.iter().map(of_settings).collect();
        let axes: Vec<Axis> = own.iter().filter_map(|column| Axis::new(column)).collect();
        if 2 * functions(axes.len(), 2 * DEGREE) > settings.len() {
            return settings;
        }
        let counts: Vec<f64> = settings.iter().map(|own| own.count).collect();
        let means: Vec<f64> = settings.iter().map(|own| own.mean).collect();
        let kept = recombine(&counts, &Polynomials::new(&axes, 2 * DEGREE));
        let places = || kept.iter().map(|(place, _)| *place);
        let polynomials = Polynomials::new(&axes, DEGREE);
        let Some(nearest) = Nearest::new(&polynomials, &kept, &counts, &means) else {
            return settings;
        };
        let left = nearest.at(&polynomials, 0..settings.len()).zip(&settings);
        let variances: Vec<f64> = left
            .map(|(mean, own)| (own.mean - mean).powi(2) + own.variance)
            .collect();
        // in so narrow a slab near a straight line; where that leads below 0, their mean
        let spread = |degree: usize| {
            let line = Polynomials::new(&axes, degree);
            let spread = Nearest::new(&line, &kept, &counts, &variances)?;
            Some(spread.at(&line, places()).collect::<Vec<f64>>())
        };
        let above_zero = |variances: &Vec<f64>| variances.iter().all(|variance| *variance >= 0.0);
        let Some(spread) = spread(1).filter(above_zero).or_else(|| spread(0)) else {
            return settings;
        };
        let each = kept.iter().zip(nearest.at(&polynomials, places())).zip(spread);
        let stand_in = |((&(place, count), mean), variance): ((&Kept, f64), f64)| SettingRuns {
            run: settings[place].run,
            count,
            mean,
            variance,
        };
        let few: Vec<SettingRuns> = each.map(stand_in).collect();
        // where runs lie very unevenly, rounding may tell
        let squares = |some: &[SettingRuns]| some.iter().map(SettingRuns::squares).sum::<f64>();
        let (of_few, of_all) = (squares(&few), squares(&settings));
        let is_exact = (of_few - of_all).abs() <= ROUNDING * of_all;
        if is_exact {
            few
        } else {
            self.few_of_halves(settings, &own)
        }
    }

    /// Few of either half of some settings, along the axis of these columns that they fill least evenly.
    fn few_of_halves(&self, settings: Vec<SettingRuns>, columns: &[Vec<f64>]) -> Vec<SettingRuns> {
        // share of the range that the middle half has, and the median
        let evenness = |column: &Vec<f64>| {
            let mut sorted = column.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let [lo, quarter, middle, three, hi] = [0, 1, 2, 3, 4].map(|part| sorted[part * (sorted.len() - 1) / 4]);
            ((three - quarter) / (hi - lo), middle)
        };
        let each = columns.iter().map(|column| (evenness(column), column));
        // an axis that does not vary has none
        let varying = each.filter(|((evenness, _), _)| evenness.is_finite());
        let Some(((_, middle), column)) = varying.min_by(|a, b| a.0 .0.total_cmp(&b.0 .0)) else {
            return settings;
        };
        let (mut less, mut more) = (vec![], vec![]);
        for (own, at) in settings.into_iter().zip(column) {
            if *at < middle {
                less.push(own);
            } else {
                more.push(own);
            }
        }
        if less.is_empty() {
            return more;
        }
        let mut few = self.few_of(less);
        few.extend(self.few_of(more));
        few
    }

    /// Each different setting of some runs.
    fn settings(&self, places: &[usize]) -> Vec<SettingRuns> {
        let compare = |a: &usize, b: &usize| {
            let mut orders = self.settings.iter().map(|column| column[*a].total_cmp(&column[*b]));
            orders.find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        };
        let mut order = places.to_vec();
        order.sort_by(compare);
        let own = |place: &usize| {
            let run = self.first + place;
            (self.runs.count(run), self.runs.restitution[run])
        };
        let setting = |same: &[usize]| {
            let count: f64 = same.iter().map(|place| own(place).0).sum();
            let mean_of = |of: &dyn Fn(f64) -> f64| {
                let each = same.iter().map(own);
                each.map(|(count, e)| count * of(e)).sum::<f64>() / count
            };
            let mean = mean_of(&|e| e);
            SettingRuns {
                run: self.first + same[0],
                count,
                mean,
                variance: mean_of(&|e| (e - mean).powi(2)),
            }
        };
        order.chunk_by(|a, b| compare(a, b).is_eq()).map(setting).collect()
    }
}
