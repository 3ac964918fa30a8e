//! Puts the wet runs of a particle in groups of one film ratio, and measures how wide each is.

use std::ops::Range;

use super::classes::{mean_of_cells, Cell, Cells, Grid};
use super::read_run::ReadRun;
use crate::scene::Scene;

/// A run belongs to the nearest of the scene's nominal film ratios if it lies no further off than this share of it.
pub const NEAR_NOMINAL: f64 = 0.15;

/// A group whose film ratios spread over more than this share of their mean has no film ratio of its own.
pub const WIDEST: f64 = 0.15;

/// A width below this is none.
const ROUNDING: f64 = 1e-12;

/// The probabilities between whose quantiles the width of a group lies.
const ENDS: [f64; 2] = [0.05, 0.95];

/// The series of one sphere and film ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmGroup {
    /// index into the scene's particles
    pub particle: usize,
    /// index into [`super::Runs::spheres`]: its k
    pub sphere: usize,
    /// nominal δ/D, or the mean of the runs' own where neither file nor scene names one
    pub film_ratio: f64,
    /// whether the scene names film ratios and these runs are near none of them
    pub outside: bool,
    /// 5 % and 95 % quantiles of the runs' own δ/D
    pub ends: [f64; 2],
    /// their distance over the mean of the runs' own δ/D
    pub width: f64,
    /// range of [`super::Runs::series`]
    pub series: Range<usize>,
}

impl FilmGroup {
    /// Whether its runs have one film ratio, so that a law at one may be fitted to them.
    pub fn has_one_film_ratio(&self) -> bool {
        !self.outside && self.width <= WIDEST
    }

    /// Takes its width from the own δ/D of its runs.
    pub(super) fn measure(&mut self, mut ratios: Vec<f64>) {
        self.ends = ENDS.map(|probability| quantile(&mut ratios, probability));
        let width = (self.ends[1] - self.ends[0]) / mean(&ratios);
        // what rounding leaves of films that were computed from one film ratio
        self.width = if width > ROUNDING { width } else { 0.0 };
    }
}

/// A film ratio as names have it: nominal ones as they are, measured means to four decimals.
pub fn rounded_film_ratio(film_ratio: f64) -> f64 {
    (film_ratio * 1e4).round() / 1e4
}

/// A quantile by linear interpolation between the ordered values; NaN of none.
fn quantile(values: &mut [f64], probability: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let place = probability * (values.len() - 1) as f64;
    let (_, below, above) = values.select_nth_unstable_by(place as usize, f64::total_cmp);
    let next = above.iter().copied().fold(f64::INFINITY, f64::min);
    let share = place.fract();
    if share == 0.0 {
        *below
    } else {
        *below + share * (next - *below)
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    mean_by_count(values, &[])
}

/// The mean of values that stand for so many each; without counts, for themselves.
pub(super) fn mean_by_count(values: &[f64], counts: &[f64]) -> f64 {
    // about the first value: equal values then have exactly that mean
    let first = values.first().copied().unwrap_or(f64::NAN);
    let above = values.iter().map(|x| x - first);
    first
        + match counts {
            [] => above.sum::<f64>() / values.len() as f64,
            counts => above.zip(counts).map(|(x, count)| count * x).sum::<f64>() / counts.iter().sum::<f64>(),
        }
}

/// Film-ratio groups of each particle: by the nominal ratios of the file, else by those of the scene, else by gaps in δ/D.
pub(super) struct FilmClasses {
    /// the groups of each particle, in increasing order
    groups: Vec<Vec<FilmClass>>,
}

/// One group of a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FilmClass {
    /// least film ratio that belongs to it
    lower_end: f64,
    pub film_ratio: f64,
    pub outside: bool,
}

impl FilmClasses {
    /// The film ratios of the wet runs of each particle in a part of a table: the nominal ones, where the file has them.
    pub(super) fn cells(runs: &[ReadRun], by_column: bool, scene: &Scene) -> Vec<Cells> {
        /// cells in which a gap is seen whole
        const CELLS_OF_GAP: f64 = 8.0;
        /// of what lies far from nominal film ratios only the mean is asked for
        const SHARE: f64 = 1e-4;
        let data = &scene.data;
        let grid = match data.film_ratios.as_slice() {
            _ if by_column => Grid::Exact,
            [] => Grid::Steps(data.film_ratio_gap / CELLS_OF_GAP),
            _ => Grid::Shares(SHARE),
        };
        let mut ratios: Vec<Vec<f64>> = vec![vec![]; scene.particles.len()];
        for run in runs.iter().filter(|run| run.setting.liquid.is_some()) {
            ratios[run.setting.particle as usize].push(ratio_of(run));
        }
        ratios.into_iter().map(|ratios| Cells::new(grid, ratios)).collect()
    }

    /// From those cells of all of it.
    pub(super) fn new(cells: &[Cells], by_column: bool, scene: &Scene) -> FilmClasses {
        let data = &scene.data;
        let of_particle = |cells: &Cells| match data.film_ratios.as_slice() {
            _ if by_column => split_at_gaps(&cells.all(), 0.0),
            [] => split_at_gaps(&cells.all(), data.film_ratio_gap),
            nominal => split_by_nominal(&cells.all(), nominal),
        };
        FilmClasses {
            groups: cells.iter().map(of_particle).collect(),
        }
    }

    /// One group of a particle, by its place among them.
    pub(super) fn class(&self, particle: usize, group: u32) -> FilmClass {
        self.groups[particle][group as usize]
    }

    /// The group of a wet run, by its place among those of its particle.
    pub(super) fn of(&self, run: &ReadRun) -> u32 {
        let ratio = ratio_of(run);
        let classes = &self.groups[run.setting.particle as usize];
        let group = classes.partition_point(|class| class.lower_end <= ratio);
        group.saturating_sub(1) as u32
    }
}

/// The nominal film ratio of a wet run, in a table that has none its own δ/D.
fn ratio_of(run: &ReadRun) -> f64 {
    run.film_ratio.unwrap_or_else(|| run.own_film_ratio())
}

/// Splits ratios at gaps; a group's film ratio is the mean of its own.
fn split_at_gaps(ratios: &[Cell], gap: f64) -> Vec<FilmClass> {
    let class = |own: &[Cell]| FilmClass {
        lower_end: own[0].lo,
        film_ratio: mean_of_cells(own),
        outside: false,
    };
    let groups = ratios.chunk_by(|less, more| more.lo - less.hi <= gap);
    groups.map(class).collect()
}

/// Puts ratios in a group for each nominal one, which are sorted, and what lies between these in groups of its own,
/// each with the mean of its ratios.
fn split_by_nominal(ratios: &[Cell], nominal: &[f64]) -> Vec<FilmClass> {
    let middle = |near: usize| 0.5 * (nominal[near] + nominal[near + 1]);
    // lower ends, with the nominal ratio where there is one
    let mut ends: Vec<(f64, Option<f64>)> = vec![(0.0, None)];
    for (index, ratio) in nominal.iter().enumerate() {
        let (mut from, mut to) = ((1.0 - NEAR_NOMINAL) * ratio, (1.0 + NEAR_NOMINAL) * ratio);
        if index > 0 {
            from = from.max(middle(index - 1));
        }
        if index + 1 < nominal.len() {
            to = to.min(middle(index));
        }
        // what lies outside ends where this begins
        if ends.last().is_some_and(|(last, _)| *last >= from) {
            ends.pop();
        }
        ends.extend([(from, Some(*ratio)), (to.next_up(), None)]);
    }
    let after = ends.iter().skip(1).map(|(end, _)| *end).chain([f64::INFINITY]);
    let classes = ends.iter().zip(after).map(|((from, named), to)| {
        let place = |end: f64| ratios.partition_point(|ratio| ratio.lo < end);
        FilmClass {
            lower_end: *from,
            film_ratio: named.unwrap_or_else(|| mean_of_cells(&ratios[place(*from)..place(to)])),
            outside: named.is_none(),
        }
    });
    classes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_lies_between_the_quantiles() {
        let mut values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(ENDS.map(|p| quantile(&mut values, p)), [5.0, 95.0]);
        assert!((quantile(&mut [1.0, 2.0], 0.05) - 1.05).abs() < 1e-15);
        assert_eq!(quantile(&mut [0.06; 7], 0.95), 0.06);
        assert!(quantile(&mut [], 0.5).is_nan());
    }
}
