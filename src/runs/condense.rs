//! Replaces very many runs by few of them that stand for all.
//!
//! The restitution of the runs of a series is nearly m = √u, u being the plane in 1/v, δ̃ and D that is nearest to their
//! e². Along it runs are divided in slabs, so that in each every law is nearly a polynomial of degree [`DEGREE`] in m, δ̃
//! and D, as is the probability to stick. A few runs of a slab with counts of their own have the sums of all (`condensing`), each
//! with the nearest polynomial for its restitution. Near the turn and the slowest rebound, and where settings repeat, each
//! setting stands for its own runs, which is exact.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::film_groups::FilmGroup;
use super::series::{DryGroup, Runs, Series};
use crate::condensing::nearest::Nearest;
use crate::condensing::polynomials::{functions, Axis, Polynomials};
use crate::condensing::recombination::{recombine, Kept};

/// Beyond so many runs laws and the posterior read few that stand for all.
const MANY_RUNS: usize = 100_000;

/// Degree of the polynomials that laws are taken for in a slab.
const DEGREE: usize = 4;

/// The near side of a slab, as a share of the distance of its far side from the turn.
const NEAR_SIDE: f64 = 0.8;

/// Energy kept, as a share of that of the impact, below which no runs are put together: the plane is no nearer to the
/// turn.
const NEAR_TURN: f64 = 0.005;

/// Share of 1/v at the slowest rebound of a series, from there, in which none are put together either: the square root's edge
/// cannot lie before that run, and may lie at it.
const NEAR_EDGE: f64 = 0.002;

/// Standard deviations of a restitution about the limit within which a slab is no wider than one, as the probability to
/// stick turns there, too.
const ABOUT_THE_LIMIT: f64 = 6.0;

/// Reach of a slab in ln δ̃: a shape that rises over δ̃0 is then nearly such a polynomial, too.
const FILMS: f64 = 0.2;

/// A series of fewer runs is kept as it is, as is one whose films have no film ratio in common.
const MANY: usize = 1000;

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

/// Neighbouring runs of a series, by their places in it.
struct Slab {
    places: Vec<usize>,
    /// whether each setting has to stand for itself
    is_kept: bool,
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
    /// Few of very many runs that stand for all, where restitutions up to `limit` stick; `None` of fewer runs, or where they
    /// carry measurement errors, which differ from run to run.
    pub fn condensed(&self, limit: f64) -> Option<Runs> {
        if self.len() <= MANY_RUNS || self.errors.is_some() {
            return None;
        }
        let of_dry = |group: &DryGroup| {
            [&group.rebounds, &group.stuck].map(|range| {
                let slab = Slab {
                    places: (0..range.len()).collect(),
                    is_kept: range.len() < MANY,
                };
                let of_speed = &self.impacts.speed_root[range.clone()];
                self.members(range.clone(), vec![of_speed]).stand_ins(&[slab])
            })
        };
        let dry: Vec<[Vec<StandIn>; 2]> = self.dry.par_iter().map(of_dry).collect();
        let of_series = |(place, series): (usize, &Series)| {
            let all = series.runs();
            // about films of all kinds no plane is near to e²
            let is_narrow = self.film_group_of(place).is_some_and(FilmGroup::has_one_film_ratio);
            let kept = self.energy_kept(series).filter(|_| is_narrow);
            let kept = kept.unwrap_or_else(|| vec![0.0; all.len()]);
            let means: Vec<f64> = kept.iter().map(|u| u.abs().sqrt().copysign(*u)).collect();
            let others = [&self.impacts.film_ratio, &self.diameter].map(|column| &column[all.clone()]);
            let axes = std::iter::once(&means[..]).chain(others).collect();
            let members = self.members(all, axes);
            self.slabs(series, &means, limit).map(|slabs| members.stand_ins(&slabs))
        };
        let wet: Vec<[Vec<StandIn>; 2]> = self.series.par_iter().enumerate().map(of_series).collect();
        let mut few = Runs {
            spheres: self.spheres.clone(),
            film_groups: self.film_groups.clone(),
            ..Runs::default()
        };
        for (group, stand_ins) in self.dry.iter().zip(dry) {
            let [rebounds, stuck] = stand_ins.map(|some| few.take_stand_ins(self, &some));
            few.dry.push(DryGroup {
                rebounds,
                stuck,
                ..group.clone()
            });
        }
        for (series, stand_ins) in self.series.iter().zip(wet) {
            let [rebounds, stuck] = stand_ins.map(|some| few.take_stand_ins(self, &some));
            few.series.push(Series {
                rebounds,
                stuck,
                ..series.clone()
            });
        }
        Some(few)
    }

    fn take_stand_ins(&mut self, from: &Runs, some: &[StandIn]) -> Range<usize> {
        let first = self.len();
        for one in some {
            self.take_run(from, one.run);
            if let Some(own) = self.restitution.last_mut() {
                *own = one.restitution;
            }
            self.count.push(one.count);
        }
        first..self.len()
    }

    /// The rebounds and the stuck runs of a series by slabs, from the restitution that is expected of each.
    fn slabs(&self, series: &Series, means: &[f64], limit: f64) -> [Vec<Slab>; 2] {
        let first = series.rebounds.start;
        let rebounds = series
            .rebounds
            .clone()
            .zip(means)
            .filter(|(_, m)| **m > NEAR_TURN.sqrt());
        let residuals = rebounds.map(|(run, m)| self.restitution[run] - m);
        let (count, squares) = residuals.fold((0.0, 0.0), |(n, squares), left| (n + 1.0, squares + left * left));
        let sd = f64::sqrt(squares / count);
        let slowest = self.impact_speed[series.rebounds.clone()].iter().copied();
        let slowest = slowest.fold(f64::INFINITY, f64::min);
        // the sides of slabs are powers of one number
        let side = |distance: f64| (distance.ln() / NEAR_SIDE.ln()).floor();
        let slab = |place: usize, rebounded: bool| {
            let m = means[place];
            let from_edge = match rebounded {
                true => 1.0 - slowest / self.impact_speed[first + place],
                false => 1.0,
            };
            if m * m < NEAR_TURN || from_edge < NEAR_EDGE {
                return None;
            }
            let spreads = (m - limit) / sd;
            let about_limit = spreads.abs() < ABOUT_THE_LIMIT;
            let spread = if about_limit { spreads.floor() } else { ABOUT_THE_LIMIT };
            let film = (self.impacts.film_ratio[first + place] / series.film_ratio).ln() / FILMS;
            let numbers = [m.signum(), side(m * m), side(from_edge), spread, film.round()];
            Some(numbers.map(|number| number as i64))
        };
        [(&series.rebounds, true), (&series.stuck, false)].map(|(range, rebounded)| {
            let mut slabs: BTreeMap<Option<[i64; 5]>, Vec<usize>> = BTreeMap::new();
            for place in range.start - first..range.end - first {
                slabs.entry(slab(place, rebounded)).or_default().push(place);
            }
            let slabs = slabs.into_iter().map(|(slab, places)| Slab {
                places,
                is_kept: slab.is_none(),
            });
            slabs.collect()
        })
    }

    /// The plane nearest to e² of the rebounds, at every run of a series; `None` of too few.
    fn energy_kept(&self, series: &Series) -> Option<Vec<f64>> {
        let all = series.runs();
        if all.len() < MANY {
            return None;
        }
        let inverse_speed: Vec<f64> = self.impact_speed[all.clone()].iter().map(|v| 1.0 / v).collect();
        let others = [&self.impacts.film_ratio, &self.diameter].map(|column| &column[all.clone()]);
        let columns = std::iter::once(&inverse_speed[..]).chain(others);
        let axes: Vec<Axis> = columns.filter_map(Axis::new).collect();
        let plane = Polynomials::new(&axes, 1);
        let rebounds: Vec<Kept> = (0..series.rebounds.len()).map(|place| (place, 1.0)).collect();
        let squares = self.restitution[series.rebounds.clone()].iter().map(|e| e * e);
        let squares: Vec<f64> = squares.collect();
        let nearest = Nearest::new(&plane, &rebounds, &vec![1.0; squares.len()], &squares)?;
        Some(nearest.at(&plane, 0..all.len()).collect())
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
        let few = slabs.iter().flat_map(|slab| self.few(slab));
        few.flat_map(SettingRuns::stand_ins).collect()
    }

    /// The settings of a slab, or few of them for all.
    fn few(&self, slab: &Slab) -> Vec<SettingRuns> {
        let settings = self.settings(&slab.places);
        let of_settings = |column: &&[f64]| settings.iter().map(|own| column[own.run - self.first]).collect();
        let own: Vec<Vec<f64>> = self.axes.iter().map(of_settings).collect();
        let axes: Vec<Axis> = own.iter().filter_map(|column| Axis::new(column)).collect();
        if slab.is_kept || 2 * functions(axes.len(), 2 * DEGREE) > settings.len() {
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
        each.map(stand_in).collect()
    }

    /// Each different setting of some runs.
    fn settings(&self, places: &[usize]) -> Vec<SettingRuns> {
        let compare = |a: &usize, b: &usize| {
            let mut orders = self.settings.iter().map(|column| column[*a].total_cmp(&column[*b]));
            orders.find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        };
        let mut order = places.to_vec();
        order.sort_by(compare);
        let restitution = &self.runs.restitution[self.first..];
        let setting = |same: &[usize]| {
            let count = same.len() as f64;
            let own = || same.iter().map(|place| restitution[*place]);
            let mean = own().sum::<f64>() / count;
            SettingRuns {
                run: self.first + same[0],
                count,
                mean,
                variance: own().map(|e| (e - mean).powi(2)).sum::<f64>() / count,
            }
        };
        order.chunk_by(|a, b| compare(a, b).is_eq()).map(setting).collect()
    }
}
