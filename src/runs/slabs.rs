//! Divides the runs of each series in slabs, in each of which every law is nearly a polynomial.
//!
//! The restitution of the runs of a series is nearly m = √u, u being the plane over 1/v, δ̃ and D that is nearest to their e²,
//! less their variance. Slabs lie along it, narrower towards the turn and the slowest rebound, where the square root of a law
//! may have its edge.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::series::{Runs, Series};
use crate::condensing::nearest::Nearest;
use crate::condensing::polynomials::{Axis, Polynomials, Scale};
use crate::condensing::recombination::Kept;

/// The near side of a slab, as a share of the distance of its far side from the turn.
const NEAR_SIDE: f64 = 0.85;

/// Energy kept, as a share of that of the impact, below which no runs are put together: the plane is no nearer to the
/// turn.
const NEAR_TURN: f64 = 0.001;

/// Standard deviations above the limit from which on hardly a run sticks.
const CLEAR: f64 = 3.0;

/// Share of 1/v at the slowest rebound of a series, from there, in which only runs of one speed are put together: the square
/// root's edge cannot lie before that run, and may lie at it.
const NEAR_EDGE: f64 = 0.002;

/// Standard deviations of a restitution about the limit within which a slab is no wider than one, as the probability to
/// stick turns there, too.
const ABOUT_THE_LIMIT: f64 = 6.0;

/// Reach of a slab in ln δ̃: a shape that rises over δ̃0 is then nearly such a polynomial, too.
const FILMS: f64 = 0.2;

/// A series of fewer runs is kept as it is.
pub(super) const MANY: usize = 1000;

/// Neighbouring runs of a series, by their places in it, and whether each setting has to stand for itself.
pub(super) type Slab = (Vec<usize>, bool);

/// Where slabs lie in each series: the same for every part of a table, so that what stands for parts can be put together.
pub(super) struct Slabs {
    /// a restitution up to which sticks
    pub limit: f64,
    planes: Vec<Plane>,
}

/// The plane nearest to e² of a series.
pub(super) struct Plane {
    series: Series,
    /// its axes, by their places among [`Runs::plane_axes`]
    axes: Vec<(usize, Scale)>,
    nearest: Nearest,
    /// spread of the rebounds about it
    sd: f64,
    /// the slowest rebound, m/s
    slowest: f64,
}

impl Slabs {
    /// Those of the series of some runs: of all, or of as many as tell them. A series of few has none.
    pub fn of(runs: &Runs, limit: f64) -> Slabs {
        let of_series = |series: &Series| Plane::of(runs, series, limit);
        Slabs {
            limit,
            planes: runs.series.par_iter().filter_map(of_series).collect(),
        }
    }

    pub fn plane(&self, series: &Series) -> Option<&Plane> {
        let alike = self.planes.iter().filter(|plane| plane.series.key() == series.key());
        let distance = |plane: &&Plane| (plane.series.diameter - series.diameter).abs();
        alike.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

impl Plane {
    /// `None` of too few runs.
    fn of(runs: &Runs, series: &Series, limit: f64) -> Option<Plane> {
        let all = series.runs();
        if all.len() < MANY {
            return None;
        }
        let columns = runs.plane_axes(all.clone());
        let (places, axes): (Vec<usize>, Vec<Axis>) = columns
            .iter()
            .enumerate()
            .filter_map(|(place, column)| Some((place, Axis::new(column)?)))
            .unzip();
        let polynomials = Polynomials::new(&axes, 1);
        let restitution = &runs.restitution[series.rebounds.clone()];
        let squares: Vec<f64> = restitution.iter().map(|e| e * e).collect();
        let through = |which: &dyn Fn(usize) -> bool| -> Option<(Vec<f64>, Nearest, f64)> {
            let weights: Vec<f64> = (0..squares.len()).map(|place| f64::from(which(place))).collect();
            let some: Vec<Kept> = weights
                .iter()
                .copied()
                .enumerate()
                .filter(|(_, weight)| *weight > 0.0)
                .collect();
            let nearest = Nearest::new(&polynomials, &some, &weights, &squares)?;
            let at: Vec<f64> = nearest.at(&polynomials, 0..squares.len()).collect();
            let left = |(place, _): &Kept| restitution[*place] - at[*place].max(0.0).sqrt();
            let squared = some.iter().map(|kept| left(kept).powi(2)).sum::<f64>();
            Some((at, nearest, (squared / some.len() as f64).sqrt()))
        };
        let (first, nearest, sd) = through(&|_| true)?;
        // near the limit only what was lucky rebounds
        let is_clear = |place: usize| first[place] > (limit + CLEAR * sd).powi(2);
        let clear = (0..squares.len()).filter(|place| is_clear(*place)).count();
        let second = if clear >= MANY / 2 { through(&is_clear) } else { None };
        let (nearest, sd) = second.map_or((nearest, sd), |(_, nearest, sd)| (nearest, sd));
        let speeds = runs.impact_speed[series.rebounds.clone()].iter().copied();
        Some(Plane {
            series: series.clone(),
            axes: places.into_iter().zip(axes.iter().map(Axis::scale)).collect(),
            nearest,
            sd,
            slowest: speeds.fold(f64::INFINITY, f64::min),
        })
    }

    /// √u of every run of a series, with the sign of u.
    pub fn means(&self, runs: &Runs, series: &Series) -> Vec<f64> {
        let all = series.runs();
        let columns = runs.plane_axes(all.clone());
        let axes: Vec<Axis> = self
            .axes
            .iter()
            .map(|(place, scale)| scale.axis(&columns[*place]))
            .collect();
        let polynomials = Polynomials::new(&axes, 1);
        let kept = self.nearest.at(&polynomials, 0..all.len());
        // the mean of a square is that of its root, squared, and a variance
        let kept = kept.map(|square| square - self.sd * self.sd);
        kept.map(|u| u.abs().sqrt().copysign(u)).collect()
    }
}

impl Runs {
    /// The rebounds and the stuck runs of a series by slabs, from the restitution that is expected of each; without a
    /// plane all are kept.
    pub(super) fn slabs(&self, series: &Series, means: &[f64], plane: Option<(&Plane, f64)>) -> [Vec<Slab>; 2] {
        let first = series.rebounds.start;
        // the sides of slabs are powers of one number
        let side = |distance: f64| (distance.ln() / NEAR_SIDE.ln()).floor();
        let slab = |place: usize, rebounded: bool| {
            let (plane, limit) = plane?;
            let m = means[place];
            let from_edge = match rebounded {
                true => 1.0 - plane.slowest / self.impact_speed[first + place],
                false => 1.0,
            };
            if m * m < NEAR_TURN {
                return None;
            }
            let speed = match from_edge < NEAR_EDGE {
                true => self.impact_speed[first + place].to_bits() as i64,
                false => side(from_edge) as i64,
            };
            let spreads = (m - limit) / plane.sd;
            let about_limit = spreads.abs() < ABOUT_THE_LIMIT;
            let spread = if about_limit { spreads.floor() } else { ABOUT_THE_LIMIT };
            let film = (self.impacts.film_ratio[first + place] / series.film_ratio).ln() / FILMS;
            let [sign, kept, spread, film] =
                [m.signum(), side(m * m), spread, film.round()].map(|number| number as i64);
            Some([sign, kept, speed, spread, film])
        };
        [(&series.rebounds, true), (&series.stuck, false)].map(|(range, rebounded)| {
            let ends = self.ends(range);
            let mut slabs: BTreeMap<Option<[i64; 5]>, Vec<usize>> = BTreeMap::new();
            for run in range.clone() {
                let place = run - first;
                let own = slab(place, rebounded).filter(|_| !ends.contains(&run));
                slabs.entry(own).or_default().push(place);
            }
            let slabs = slabs.into_iter().map(|(slab, places)| (places, slab.is_none()));
            slabs.collect()
        })
    }

    /// The runs that are first or last of a range in speed, film ratio or diameter: they stand for themselves, so that the
    /// ranges of few are those of all.
    pub(super) fn ends(&self, range: &Range<usize>) -> Vec<usize> {
        let columns = [&self.impact_speed, &self.impacts.film_ratio, &self.diameter];
        let ends = columns.into_iter().flat_map(|column| {
            let compare = |a: &usize, b: &usize| column[*a].total_cmp(&column[*b]);
            [range.clone().min_by(compare), range.clone().max_by(compare)]
        });
        ends.flatten().collect()
    }

    /// What planes lie over: 1/v, δ̃, D.
    fn plane_axes(&self, range: Range<usize>) -> [Vec<f64>; 3] {
        let inverse_speed = self.impact_speed[range.clone()].iter().map(|v| 1.0 / v).collect();
        let [films, diameters] =
            [&self.impacts.film_ratio, &self.diameter].map(|column| column[range.clone()].to_vec());
        [inverse_speed, films, diameters]
    }
}
