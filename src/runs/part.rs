//! Takes a part of the runs, in the order of the whole.

use std::ops::Range;
use std::sync::Arc;

use super::film_groups::{mean, FilmGroup};
use super::series::{DryGroup, Runs, Series};

/// Whether a place among others is in a share of them that is spread evenly.
pub fn is_in_even_share(place: usize, share: f64) -> bool {
    /// multiples of this have parts behind the point that fill [0, 1) evenly, and fall in step with no repeat of a design
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    (place as f64 * GOLDEN).fract() < share
}

impl Runs {
    /// The dry runs, and the wet runs whose own δ/D lies below `film_ratio`; a series left without runs is gone.
    ///
    /// A film group keeps its name, also where some of its runs are gone.
    pub fn with_films_below(&self, film_ratio: f64) -> Runs {
        // a dry run has a film of 0
        let mut part = self.with_runs(|run| self.film[run] / self.diameter[run] < film_ratio);
        let all = std::mem::take(&mut part.series);
        for group in std::mem::take(&mut part.film_groups) {
            let first = part.series.len();
            for series in &all[group.series.clone()] {
                let runs = series.runs();
                if !runs.is_empty() {
                    part.series.push(Series {
                        diameter: mean(&part.diameter[runs.clone()]),
                        film: mean(&part.film[runs]),
                        ..series.clone()
                    });
                }
            }
            let series = first..part.series.len();
            if !series.is_empty() {
                part.film_groups.push(FilmGroup { series, ..group });
            }
        }
        part
    }

    /// All runs but these.
    pub fn without(&self, left_out: &Range<usize>) -> Runs {
        self.with_runs(|run| !left_out.contains(&run))
    }

    /// The runs that `keep` selects by their places. Spheres, film groups and series keep theirs, with their mean diameters and
    /// films, also where none of their runs is left.
    pub fn with_runs(&self, keep: impl Fn(usize) -> bool) -> Runs {
        self.regrouped(|part, runs| part.take(self, runs.filter(|run| keep(*run))))
    }

    /// The same groups and series with other runs: `take` appends those that come in place of the rebounds of each, then those
    /// in place of its stuck runs.
    pub(super) fn regrouped(&self, take: impl FnMut(&mut Runs, Range<usize>)) -> Runs {
        let mut part = self.of_groups(&self.dry, &self.series, take);
        part.film_groups.clone_from(&self.film_groups);
        part
    }

    /// The same of some of the groups of dry runs and of the series alone, without film groups.
    fn of_groups(&self, dry: &[DryGroup], series: &[Series], mut take: impl FnMut(&mut Runs, Range<usize>)) -> Runs {
        let mut part = Runs {
            spheres: self.spheres.clone(),
            places: Arc::clone(&self.places),
            ..Runs::default()
        };
        let mut taken = |part: &mut Runs, runs: Range<usize>| {
            let first = part.len();
            take(part, runs);
            first..part.len()
        };
        for group in dry {
            let [rebounds, stuck] = group.kinds().map(|runs| taken(&mut part, runs));
            part.dry.push(DryGroup {
                rebounds,
                stuck,
                ..group.clone()
            });
        }
        for one in series {
            let [rebounds, stuck] = one.kinds().map(|runs| taken(&mut part, runs));
            part.series.push(Series {
                rebounds,
                stuck,
                ..one.clone()
            });
        }
        part
    }

    /// The dry runs, and the runs of each film group, as tables of their own.
    pub fn parts(&self) -> impl Iterator<Item = Runs> + '_ {
        let whole = move |part: &mut Runs, runs: Range<usize>| part.take(self, runs);
        let dry = (!self.dry.is_empty()).then(|| self.of_groups(&self.dry, &[], whole));
        let wet = self.film_groups.iter().map(move |group| {
            let mut part = self.of_groups(&[], &self.series[group.series.clone()], whole);
            part.film_groups.push(FilmGroup {
                series: 0..part.series.len(),
                ..group.clone()
            });
            part
        });
        dry.into_iter().chain(wet)
    }

    /// Wet runs.
    pub fn wet(&self) -> usize {
        self.series.iter().map(|series| series.runs().len()).sum()
    }

    /// How many wet runs these are, or stand for.
    pub fn wet_measured(&self) -> usize {
        self.series.iter().map(|series| self.measured(series.runs())).sum()
    }

    /// Appends some runs of another table.
    pub(super) fn take(&mut self, from: &Runs, runs: impl Iterator<Item = usize>) {
        runs.for_each(|run| self.take_run(from, run));
    }

    /// Appends a run of another table, with what it stands for there.
    pub(super) fn take_run(&mut self, from: &Runs, run: usize) {
        // every column: one that is added must be taken, too
        self.diameter.push(from.diameter[run]);
        self.film.push(from.film[run]);
        self.impact_speed.push(from.impact_speed[run]);
        self.restitution.push(from.restitution[run]);
        self.row.push(from.row[run]);
        self.impacts.speed_root.push(from.impacts.speed_root[run]);
        self.impacts.over_stokes.push(from.impacts.over_stokes[run]);
        self.impacts.film_ratio.push(from.impacts.film_ratio[run]);
        self.errors.extend(from.errors.get(run));
        self.count.extend(from.count.get(run));
    }
}
