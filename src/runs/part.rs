//! Takes a part of the runs, in the order of the whole.

use std::ops::Range;

use super::film_groups::{mean, FilmGroup};
use super::series::{DryGroup, Runs, Series};

impl Runs {
    /// The dry runs, and the wet runs whose own δ/D lies below `film_ratio`; a series left without runs is gone.
    ///
    /// A film group keeps its name, also where some of its runs are gone.
    pub fn with_films_below(&self, film_ratio: f64) -> Runs {
        let mut part = Runs {
            spheres: self.spheres.clone(),
            ..Runs::default()
        };
        let all = |_: usize| true;
        let thin = |run: usize| self.film[run] / self.diameter[run] < film_ratio;
        for group in &self.dry {
            let rebounds = part.take(self, group.rebounds.clone(), all);
            let stuck = part.take(self, group.stuck.clone(), all);
            part.dry.push(DryGroup {
                rebounds,
                stuck,
                ..group.clone()
            });
        }
        for group in &self.film_groups {
            let first = part.series.len();
            for series in &self.series[group.series.clone()] {
                let rebounds = part.take(self, series.rebounds.clone(), thin);
                let stuck = part.take(self, series.stuck.clone(), thin);
                let runs = rebounds.start..stuck.end;
                if !runs.is_empty() {
                    part.series.push(Series {
                        diameter: mean(&part.diameter[runs.clone()]),
                        film: mean(&part.film[runs]),
                        rebounds,
                        stuck,
                        ..series.clone()
                    });
                }
            }
            let series = first..part.series.len();
            if !series.is_empty() {
                part.film_groups.push(FilmGroup {
                    series,
                    ..group.clone()
                });
            }
        }
        part
    }

    /// The dry rebounds, and of each series those whose place among its rebounds `keep` selects. What stuck is gone, and a
    /// series keeps its mean diameter and film.
    pub fn with_rebounds(&self, keep: impl Fn(usize) -> bool) -> Runs {
        let mut part = Runs {
            spheres: self.spheres.clone(),
            film_groups: self.film_groups.clone(),
            ..Runs::default()
        };
        for group in &self.dry {
            let rebounds = part.take(self, group.rebounds.clone(), |_| true);
            part.dry.push(DryGroup {
                stuck: rebounds.end..rebounds.end,
                rebounds,
                ..group.clone()
            });
        }
        for series in &self.series {
            let first = series.rebounds.start;
            let rebounds = part.take(self, series.rebounds.clone(), |run| keep(run - first));
            part.series.push(Series {
                stuck: rebounds.end..rebounds.end,
                rebounds,
                ..series.clone()
            });
        }
        part
    }

    /// Wet runs.
    pub fn wet(&self) -> usize {
        self.series.iter().map(|series| series.runs().len()).sum()
    }

    /// Appends some runs of another table, and says where they are.
    fn take(&mut self, from: &Runs, range: Range<usize>, keep: impl Fn(usize) -> bool) -> Range<usize> {
        let first = self.len();
        // every column by name: one that is added must be taken, too
        let Runs {
            diameter,
            film,
            impact_speed,
            restitution,
            row,
            errors,
            impacts,
            spheres: _,
            dry: _,
            film_groups: _,
            series: _,
        } = self;
        for run in range.filter(|run| keep(*run)) {
            diameter.push(from.diameter[run]);
            film.push(from.film[run]);
            impact_speed.push(from.impact_speed[run]);
            restitution.push(from.restitution[run]);
            row.push(from.row[run]);
            impacts.speed_root.push(from.impacts.speed_root[run]);
            impacts.over_stokes.push(from.impacts.over_stokes[run]);
            impacts.film_ratio.push(from.impacts.film_ratio[run]);
            if let Some(all) = &from.errors {
                errors.get_or_insert_default().push(all.error(run));
            }
        }
        first..self.len()
    }
}
