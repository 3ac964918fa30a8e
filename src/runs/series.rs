//! Orders runs by series, so that every series is one contiguous slice of each column.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::classes::{Cells, DiameterClasses};
use super::errors::RunError;
use super::film_groups::{mean_by_count, rounded_film_ratio, FilmClass, FilmClasses, FilmGroup};
use super::places::RowPlaces;
use super::read_run::ReadRun;
use super::spheres::{diameter_in_mm, Sphere};
use crate::scene::{DryKOf, Scene};

/// The runs in use as columns in SI, ordered: dry runs by particle and diameter, then wet runs by particle, film
/// ratio, liquid and diameter, or by diameter before film ratio where each has its own k; inside a series the rebounds come first, then the stuck runs, each in file order.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    /// D of each run, m
    pub diameter: Vec<f64>,
    /// δ of each run, m; 0 for a dry run
    pub film: Vec<f64>,
    /// v of each run, m/s
    pub impact_speed: Vec<f64>,
    /// e of each run
    pub restitution: Vec<f64>,
    /// row each run stood in, from 1, counted over all tables below their headers
    pub row: Vec<u32>,
    /// where these rows stand in their files
    pub places: Arc<RowPlaces>,
    /// what each run errs by; empty where none carries an error above 0
    pub errors: Vec<RunError>,
    /// how many runs each stands for, which need not be whole; empty where that is itself
    pub count: Vec<f64>,
    /// an even sample of the runs themselves, in the same series, where these are few that stand for all of a table
    pub sample: Option<Box<Runs>>,
    /// what the physics reads of each run
    pub impacts: Impacts,
    /// the spheres that have a k of their own, by particle and diameter
    pub spheres: Vec<Sphere>,
    /// the dry runs of one particle and diameter
    pub dry: Vec<DryGroup>,
    /// the series of one sphere and film ratio
    pub film_groups: Vec<FilmGroup>,
    /// particle × liquid × diameter × film ratio
    pub series: Vec<Series>,
}

/// What the physics reads of each run, as columns in the order of [`Runs`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Impacts {
    /// v^(1/5), (m/s)^(1/5)
    pub speed_root: Vec<f64>,
    /// 4/St; 0 for a dry run
    pub over_stokes: Vec<f64>,
    /// δ̃ = δ/D; 0 for a dry run
    pub film_ratio: Vec<f64>,
}

/// The dry runs of one particle and diameter.
#[derive(Debug, Clone, PartialEq)]
pub struct DryGroup {
    /// index into the scene's particles
    pub particle: usize,
    /// index into [`Runs::spheres`]: its k
    pub sphere: usize,
    /// mean D, m
    pub diameter: f64,
    /// runs that rebounded, as a range of every column of [`Runs`]
    pub rebounds: Range<usize>,
    /// runs that stuck
    pub stuck: Range<usize>,
}

/// Runs of one particle, liquid, diameter and film ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// index into the scene's particles
    pub particle: usize,
    /// index into [`Runs::spheres`]: its k
    pub sphere: usize,
    /// index into the scene's liquids
    pub liquid: usize,
    /// mean D, m
    pub diameter: f64,
    /// mean δ, m
    pub film: f64,
    /// δ/D of the film group
    pub film_ratio: f64,
    /// runs that rebounded, as a range of every column of [`Runs`]
    pub rebounds: Range<usize>,
    /// runs that stuck
    pub stuck: Range<usize>,
}

impl DryGroup {
    /// Every run of the group.
    pub fn runs(&self) -> Range<usize> {
        self.rebounds.start..self.stuck.end
    }

    /// Its rebounds, and its stuck runs.
    pub(super) fn kinds(&self) -> [Range<usize>; 2] {
        [self.rebounds.clone(), self.stuck.clone()]
    }
}

impl Series {
    /// Its words in names of files: `PTFE,AK10,4.762,0.06`, particle, liquid, D in mm, δ/D of the film group.
    pub fn label(&self, scene: &Scene) -> String {
        let [particle, liquid] = [&scene.particles[self.particle].name, &scene.liquids[self.liquid].name];
        let (diameter, film_ratio) = (diameter_in_mm(self.diameter), rounded_film_ratio(self.film_ratio));
        format!("{particle},{liquid},{diameter},{film_ratio}")
    }

    /// Every run of the series.
    pub fn runs(&self) -> Range<usize> {
        self.rebounds.start..self.stuck.end
    }

    /// Its rebounds, and its stuck runs.
    pub(super) fn kinds(&self) -> [Range<usize>; 2] {
        [self.rebounds.clone(), self.stuck.clone()]
    }
}

impl Runs {
    /// Runs in use.
    pub fn len(&self) -> usize {
        self.restitution.len()
    }

    /// Whether no run is in use.
    pub fn is_empty(&self) -> bool {
        self.restitution.is_empty()
    }

    /// How many runs one stands for.
    pub fn count(&self, run: usize) -> f64 {
        self.count.get(run).copied().unwrap_or(1.0)
    }

    /// How many each of a range stands for; empty where that is itself.
    pub fn counts(&self, range: Range<usize>) -> &[f64] {
        self.count.get(range).unwrap_or_default()
    }

    /// How many runs a range stands for.
    pub fn measured(&self, range: Range<usize>) -> usize {
        match self.counts(range.clone()) {
            [] => range.len(),
            counts => counts.iter().sum::<f64>().round() as usize,
        }
    }

    /// Runs that stuck.
    pub fn stuck(&self) -> usize {
        let wet = self.series.iter().map(|series| &series.stuck);
        let dry = self.dry.iter().map(|group| &group.stuck);
        wet.chain(dry).map(|stuck| self.measured(stuck.clone())).sum()
    }

    /// How many runs these are, or stand for.
    pub fn all_measured(&self) -> usize {
        self.measured(0..self.len())
    }

    /// Runs as they were measured: these, or an even sample of those they stand for.
    pub fn sample(&self) -> &Runs {
        self.sample.as_deref().unwrap_or(self)
    }

    /// Where the spheres of a particle stand in [`Runs::spheres`].
    pub fn spheres_of(&self, particle: usize) -> Range<usize> {
        let start = self.spheres.partition_point(|sphere| sphere.particle < particle);
        start..self.spheres.partition_point(|sphere| sphere.particle <= particle)
    }

    /// The particles that have wet runs, by their places in the scene and in its order.
    pub fn wet_particles(&self) -> impl Iterator<Item = usize> + '_ {
        let of_each = self.series.chunk_by(|a, b| a.particle == b.particle);
        of_each.map(|of_one| of_one[0].particle)
    }

    /// The dry runs of a sphere, by its index; by diameter.
    pub fn dry_of(&self, sphere: usize) -> &[DryGroup] {
        self.dry_in(sphere..sphere + 1)
    }

    /// The dry runs of some spheres.
    pub fn dry_in(&self, spheres: Range<usize>) -> &[DryGroup] {
        &self.dry[within(&self.dry, spheres, |group| group.sphere)]
    }

    /// The film groups of a sphere, by its index.
    pub fn film_groups_of(&self, sphere: usize) -> &[FilmGroup] {
        &self.film_groups[within(&self.film_groups, sphere..sphere + 1, |group| group.sphere)]
    }

    /// The series of a sphere, by its index.
    pub fn series_of(&self, sphere: usize) -> &[Series] {
        self.series_in(sphere..sphere + 1)
    }

    /// The series of some spheres.
    pub fn series_in(&self, spheres: Range<usize>) -> &[Series] {
        &self.series[within(&self.series, spheres, |series| series.sphere)]
    }

    /// The film group that a series belongs to, by its place; `None` beyond them.
    pub fn film_group_of(&self, series: usize) -> Option<&FilmGroup> {
        let place = self.film_groups.partition_point(|group| group.series.end <= series);
        self.film_groups.get(place)
    }

    /// The measurement errors of all runs; one that carries none is taken to err like the median of those that do, its
    /// speed as a share of itself. `None` where no run carries any.
    pub fn errors_with_medians(&self) -> Option<Vec<RunError>> {
        let of = |run: usize| {
            let error = &self.errors[run];
            [error.impact_speed_sd / self.impact_speed[run], error.restitution_sd]
        };
        let carries = |run: &usize| of(*run).iter().any(|sd| *sd > 0.0);
        let (carrying, others): (Vec<usize>, Vec<usize>) = (0..self.errors.len()).partition(carries);
        if carrying.is_empty() {
            return None;
        }
        let median = |which: usize| {
            let mut given: Vec<f64> = carrying.iter().map(|run| of(*run)[which]).collect();
            let middle = given.len() / 2;
            given.select_nth_unstable_by(middle, f64::total_cmp);
            given[middle]
        };
        let [share, u] = [median(0), median(1)];
        let mut all = self.errors.clone();
        for run in others {
            all[run].impact_speed_sd = share * self.impact_speed[run];
            all[run].restitution_sd = u;
        }
        Some(all)
    }
}

/// Where the entries of some spheres stand in a column that is ordered by sphere.
fn within<T>(column: &[T], spheres: Range<usize>, of: impl Fn(&T) -> usize) -> Range<usize> {
    let start = column.partition_point(|one| of(one) < spheres.start);
    start..start + column[start..].partition_point(|one| of(one) < spheres.end)
}

/// What makes two runs belong together, in the order of the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Key {
    wet: bool,
    particle: u32,
    /// the diameter's class where each has its own k, else 0
    sphere: u32,
    film_group: u32,
    liquid: u32,
    diameter: u32,
}

/// Runs that belong together: where their rebounds stand, and those that stuck.
type Span = (Key, [Range<usize>; 2]);

/// What a part of a table says of the classes its runs are put in, or all of it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct ClassCells {
    diameters: Cells,
    /// of each particle
    films: Vec<Cells>,
    /// whether the table has nominal film ratios
    pub has_film_ratio: bool,
}

impl ClassCells {
    pub fn of(runs: &[ReadRun], scene: &Scene) -> ClassCells {
        let has_film_ratio = runs.iter().any(|run| run.film_ratio.is_some());
        let diameters = || runs.iter().map(|run| run.setting.diameter).collect();
        let (diameters, films) = rayon::join(
            || Cells::new(DiameterClasses::GRID, diameters()),
            || FilmClasses::cells(runs, has_film_ratio, scene),
        );
        ClassCells {
            diameters,
            films,
            has_film_ratio,
        }
    }

    /// Adds what another part says.
    pub fn extend(&mut self, other: ClassCells) {
        self.films
            .resize(self.films.len().max(other.films.len()), Cells::default());
        for (own, other) in self.films.iter_mut().zip(other.films) {
            own.extend(other);
        }
        self.diameters.extend(other.diameters);
        self.has_film_ratio |= other.has_film_ratio;
    }
}

/// Orders the runs of a table by series, and computes of each what the physics reads.
pub(super) fn arrange(read: Vec<ReadRun>, scene: &Scene) -> Runs {
    let cells = ClassCells::of(&read, scene);
    arrange_part(read, &cells, scene)
}

/// The same of a part of the table whose classes are these.
pub(super) fn arrange_part(read: Vec<ReadRun>, cells: &ClassCells, scene: &Scene) -> Runs {
    let diameters = DiameterClasses::new(&cells.diameters);
    let groups = FilmClasses::new(&cells.films, cells.has_film_ratio, scene);
    let by_diameter = scene.model.dry_k == DryKOf::Diameter;
    let key = |run: &ReadRun| {
        let diameter = diameters.of(run.setting.diameter);
        Key {
            wet: run.setting.liquid.is_some(),
            particle: run.setting.particle,
            sphere: if by_diameter { diameter } else { 0 },
            film_group: run.setting.liquid.map_or(0, |_| groups.of(run)),
            liquid: run.setting.liquid.unwrap_or(0),
            diameter,
        }
    };
    let is_stuck = |run: &ReadRun| run.is_stuck(scene.data.smallest_restitution);
    // runs of one series stay in the order of the file
    let mut by_key: BTreeMap<Key, [Vec<&ReadRun>; 2]> = BTreeMap::new();
    for run in &read {
        by_key.entry(key(run)).or_default()[usize::from(is_stuck(run))].push(run);
    }
    let mut spans: Vec<Span> = vec![];
    for (key, [rebounds, stuck]) in &by_key {
        let start = spans.last().map_or(0, |(_, [_, stuck])| stuck.end);
        let turn = start + rebounds.len();
        spans.push((*key, [start..turn, turn..turn + stuck.len()]));
    }
    let read: Vec<&ReadRun> = by_key.into_values().flatten().flatten().collect();
    let column = |of: fn(&ReadRun) -> f64| read.par_iter().map(|run| of(run)).collect();
    let any_errs = read.iter().any(|run| run.errors != RunError::default());
    let mut runs = Runs {
        diameter: column(|run| run.setting.diameter),
        film: column(|run| run.setting.film),
        impact_speed: column(|run| run.impact_speed),
        restitution: column(|run| run.restitution),
        row: read.iter().map(|run| run.row).collect(),
        errors: read.iter().filter(|_| any_errs).map(|run| run.errors).collect(),
        count: read.iter().filter_map(|run| run.count).collect(),
        ..Runs::default()
    };
    let of_spheres = runs_of_spheres(&spans, scene);
    let sphere = |((particle, _), own): (&SphereClass, &Vec<usize>)| Sphere {
        particle: *particle as usize,
        diameter: (!own.is_empty()).then(|| {
            let diameters: Vec<f64> = own.iter().map(|run| runs.diameter[*run]).collect();
            let counts: Vec<f64> = own.iter().map(|run| runs.count(*run)).collect();
            mean_by_count(&diameters, &counts)
        }),
    };
    runs.spheres = of_spheres.iter().map(sphere).collect();
    let classes: Vec<SphereClass> = of_spheres.into_keys().collect();
    name_groups(&mut runs, spans, &groups, &classes);
    for group in &mut runs.film_groups {
        let own = runs.series[group.series.clone()].iter().flat_map(Series::runs);
        group.measure(own.map(|run| runs.film[run] / runs.diameter[run]).collect());
    }
    runs.compute_impacts(scene);
    runs
}

/// Particle of a sphere, and class of its diameter.
type SphereClass = (u32, u32);

/// The runs of each diameter of each particle that has its own k; none where a particle has one.
fn runs_of_spheres(spans: &[Span], scene: &Scene) -> BTreeMap<SphereClass, Vec<usize>> {
    let mut runs: BTreeMap<SphereClass, Vec<usize>> = BTreeMap::new();
    if scene.model.dry_k == DryKOf::Diameter {
        for (key, [rebounds, stuck]) in spans {
            let of_class = runs.entry((key.particle, key.sphere)).or_default();
            of_class.extend(rebounds.start..stuck.end);
        }
    }
    for particle in 0..scene.particles.len() as u32 {
        if runs.keys().all(|(own, _)| *own != particle) {
            runs.insert((particle, 0), vec![]);
        }
    }
    runs
}

/// Names what the runs of each span have in common.
fn name_groups(runs: &mut Runs, spans: Vec<Span>, groups: &FilmClasses, spheres: &[SphereClass]) {
    let mut last_group = None;
    for (key, [rebounds, stuck]) in spans {
        let all = rebounds.start..stuck.end;
        let particle = key.particle as usize;
        let sphere = spheres.partition_point(|class| *class < (key.particle, key.sphere));
        let mean = |column: &[f64]| mean_by_count(&column[all.clone()], runs.counts(all.clone()));
        let (diameter, film) = (mean(&runs.diameter), mean(&runs.film));
        if !key.wet {
            runs.dry.push(DryGroup {
                particle,
                sphere,
                diameter,
                rebounds,
                stuck,
            });
            continue;
        }
        let FilmClass {
            film_ratio, outside, ..
        } = groups.class(particle, key.film_group);
        let at = runs.series.len();
        let group = (key.particle, key.sphere, key.film_group);
        if last_group.replace(group) != Some(group) {
            runs.film_groups.push(FilmGroup {
                particle,
                sphere,
                film_ratio,
                outside,
                ends: [film_ratio; 2],
                width: 0.0,
                series: at..at,
            });
        }
        if let Some(last) = runs.film_groups.last_mut() {
            last.series.end = at + 1;
        }
        let liquid = key.liquid as usize;
        runs.series.push(Series {
            particle,
            sphere,
            liquid,
            diameter,
            film,
            film_ratio,
            rebounds,
            stuck,
        });
    }
}
