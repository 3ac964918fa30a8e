//! Orders runs by series, so that every series is one contiguous slice of each column.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use super::collect::RunsAsRead;
use super::errors::MeasurementErrors;
use crate::scene::Scene;

/// Diameters that differ by less than this share of the smallest are one diameter.
pub(super) const SAME_DIAMETER: f64 = 1e-3;

/// The runs in use as columns in SI, ordered: dry runs by particle and diameter, then wet runs by particle, film
/// ratio, liquid and diameter; inside a series the rebounds come first, then the stuck runs, each in file order.
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
    /// row of the table each run stood in, from 1 below the header
    pub row: Vec<u32>,
    /// what was measured errs by; `None` where no run carries an error above 0
    pub errors: Option<MeasurementErrors>,
    /// what the physics reads of each run
    pub impacts: Impacts,
    /// the dry runs of one particle and diameter
    pub dry: Vec<DryGroup>,
    /// the series of one particle and film ratio
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
    /// mean D, m
    pub diameter: f64,
    /// runs that rebounded, as a range of every column of [`Runs`]
    pub rebounds: Range<usize>,
    /// runs that stuck
    pub stuck: Range<usize>,
}

/// The series of one particle and film ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct FilmGroup {
    /// index into the scene's particles
    pub particle: usize,
    /// nominal δ/D, or the mean of the runs' own where the file names none
    pub film_ratio: f64,
    /// range of [`Runs::series`]
    pub series: Range<usize>,
}

/// Runs of one particle, liquid, diameter and film ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// index into the scene's particles
    pub particle: usize,
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

impl Series {
    /// Every run of the series.
    pub fn runs(&self) -> Range<usize> {
        self.rebounds.start..self.stuck.end
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

    /// Runs that stuck.
    pub fn stuck(&self) -> usize {
        let wet = self.series.iter().map(|series| series.stuck.len());
        let dry = self.dry.iter().map(|group| group.stuck.len());
        wet.chain(dry).sum()
    }

    /// The dry runs of a particle, by diameter.
    pub fn dry_of(&self, particle: usize) -> &[DryGroup] {
        &self.dry[of_particle(&self.dry, particle, |group| group.particle)]
    }

    /// The film groups of a particle.
    pub fn film_groups_of(&self, particle: usize) -> &[FilmGroup] {
        &self.film_groups[of_particle(&self.film_groups, particle, |group| group.particle)]
    }

    /// The series of a particle.
    pub fn series_of(&self, particle: usize) -> &[Series] {
        &self.series[of_particle(&self.series, particle, |series| series.particle)]
    }

    /// The measurement errors of all runs; one that carries none is taken to err like the median of those that do, its
    /// speed as a share of itself. `None` where no run carries any.
    pub fn errors_with_medians(&self) -> Option<MeasurementErrors> {
        let errors = self.errors.as_ref()?;
        let of = |run: usize| {
            let [s_v, u] = errors.of(run);
            [s_v / self.impact_speed[run], u]
        };
        let carries = |run: &usize| of(*run).iter().any(|sd| *sd > 0.0);
        let median = |which: usize| {
            let mut given: Vec<f64> = (0..self.len()).filter(carries).map(|run| of(run)[which]).collect();
            let middle = given.len() / 2;
            given.select_nth_unstable_by(middle, f64::total_cmp);
            given[middle]
        };
        if !(0..self.len()).any(|run| carries(&run)) {
            return None;
        }
        let [share, u] = [median(0), median(1)];
        let mut all = errors.clone();
        for run in (0..self.len()).filter(|run| !carries(run)) {
            all.impact_speed_sd[run] = share * self.impact_speed[run];
            all.restitution_sd[run] = u;
        }
        Some(all)
    }
}

/// Where the entries of a particle stand in a column that is ordered by particle.
fn of_particle<T>(column: &[T], particle: usize, of: impl Fn(&T) -> usize) -> Range<usize> {
    let start = column.partition_point(|one| of(one) < particle);
    start..start + column[start..].partition_point(|one| of(one) == particle)
}

/// What makes two runs belong together, in the order of the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Key {
    wet: bool,
    particle: u32,
    film_group: u32,
    liquid: u32,
    diameter: u32,
    stuck: bool,
}

pub(super) fn arrange(columns: RunsAsRead, scene: &Scene) -> Runs {
    let diameters = Classes::new(&columns.diameter, |first, next| next > first * (1.0 + SAME_DIAMETER));
    let groups = FilmClasses::new(&columns, scene);
    let mut ids: BTreeMap<Key, (u32, usize)> = BTreeMap::new();
    let mut id_of_row: Vec<u32> = Vec::with_capacity(columns.restitution.len());
    let mut last: Option<(Key, u32)> = None;
    let mut counts: Vec<usize> = vec![];
    let mut diameter_classes = diameters.lookup();
    let mut film_classes = groups.lookup();
    for row in 0..columns.restitution.len() {
        let wet = columns.liquid[row] != RunsAsRead::NO_LIQUID;
        let key = Key {
            wet,
            particle: columns.particle[row],
            film_group: if wet { film_classes.of(&columns, row) } else { 0 },
            liquid: if wet { columns.liquid[row] } else { 0 },
            diameter: diameter_classes.of(columns.diameter[row]),
            stuck: columns.restitution[row] <= scene.data.smallest_restitution,
        };
        let id = match last {
            Some((same, id)) if same == key => id,
            _ => {
                let next = counts.len();
                let (id, _) = *ids.entry(key).or_insert_with(|| {
                    counts.push(0);
                    (next as u32, next)
                });
                id
            }
        };
        last = Some((key, id));
        counts[id as usize] += 1;
        id_of_row.push(id);
    }
    // a counting sort: linear in the runs, stable inside a series
    let mut start_of_id = vec![0usize; counts.len()];
    let mut spans: Vec<(Key, Range<usize>)> = Vec::with_capacity(counts.len());
    let mut start = 0;
    for (key, (_, id)) in &ids {
        start_of_id[*id] = start;
        spans.push((*key, start..start + counts[*id]));
        start += counts[*id];
    }
    let place: Vec<u32> = id_of_row
        .into_iter()
        .map(|id| {
            let next = &mut start_of_id[id as usize];
            *next += 1;
            (*next - 1) as u32
        })
        .collect();
    let mut runs = Runs {
        diameter: columns.diameter,
        film: columns.film,
        impact_speed: columns.impact_speed,
        restitution: columns.restitution,
        row: columns.row,
        errors: Some(columns.errors).filter(|errors| !errors.impact_speed_sd.is_empty()),
        ..Runs::default()
    };
    rayon::join(
        || reorder([&mut runs.diameter, &mut runs.film], &place),
        || reorder([&mut runs.impact_speed, &mut runs.restitution], &place),
    );
    // after the others, whose memory it may then have
    reorder([&mut runs.row], &place);
    if let Some(errors) = &mut runs.errors {
        reorder([&mut errors.impact_speed_sd, &mut errors.restitution_sd], &place);
        if !errors.speed_correlation.is_empty() {
            reorder([&mut errors.speed_correlation], &place);
        }
    }
    name_groups(&mut runs, &spans, &groups);
    runs
}

/// Puts every value of some columns in its place, through the memory of one more.
fn reorder<T: Copy + Default, const N: usize>(columns: [&mut Vec<T>; N], place: &[u32]) {
    let mut ordered = vec![T::default(); place.len()];
    for column in columns {
        for (value, at) in column.iter().zip(place) {
            ordered[*at as usize] = *value;
        }
        std::mem::swap(column, &mut ordered);
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    // about the first value: equal values then have exactly that mean
    let first = values.first().copied().unwrap_or(f64::NAN);
    first + values.iter().map(|x| x - first).sum::<f64>() / values.len() as f64
}

/// Turns spans of equal keys into groups, joining each series' rebounds with its stuck runs.
fn name_groups(runs: &mut Runs, spans: &[(Key, Range<usize>)], groups: &FilmClasses) {
    let mut index = 0;
    while let Some((key, first)) = spans.get(index) {
        let rest = spans.get(index + 1);
        let paired = rest.filter(|(next, _)| *next == Key { stuck: true, ..*key } && !key.stuck);
        let (rebounds, stuck) = match paired {
            Some((_, second)) => (first.clone(), second.clone()),
            None if key.stuck => (first.start..first.start, first.clone()),
            None => (first.clone(), first.end..first.end),
        };
        index += if paired.is_some() { 2 } else { 1 };
        let all = rebounds.start..stuck.end;
        let particle = key.particle as usize;
        let diameter = mean(&runs.diameter[all.clone()]);
        if !key.wet {
            runs.dry.push(DryGroup {
                particle,
                diameter,
                rebounds,
                stuck,
            });
            continue;
        }
        let film_ratio = groups.film_ratio(particle, key.film_group);
        let film = mean(&runs.film[all]);
        let at = runs.series.len();
        match runs.film_groups.last_mut() {
            Some(last) if last.particle == particle && last.film_ratio == film_ratio => {
                last.series.end = at + 1;
            }
            _ => runs.film_groups.push(FilmGroup {
                particle,
                film_ratio,
                series: at..at + 1,
            }),
        }
        let liquid = key.liquid as usize;
        runs.series.push(Series {
            particle,
            liquid,
            diameter,
            film,
            film_ratio,
            rebounds,
            stuck,
        });
    }
}

/// Classes of nearly equal numbers, in increasing order.
struct Classes {
    of_bits: HashMap<u64, u32>,
}

struct Lookup<'a> {
    classes: &'a Classes,
    last: (u64, u32),
}

impl Classes {
    /// `apart(first of the class, next)` says that a sorted value opens a new class.
    fn new(values: &[f64], apart: impl Fn(f64, f64) -> bool) -> Classes {
        let mut of_bits: HashMap<u64, u32> = HashMap::new();
        let mut last = None;
        for value in values {
            if last != Some(value.to_bits()) {
                of_bits.insert(value.to_bits(), 0);
                last = Some(value.to_bits());
            }
        }
        let mut distinct: Vec<f64> = of_bits.keys().map(|bits| f64::from_bits(*bits)).collect();
        distinct.sort_by(f64::total_cmp);
        let (mut class, mut first) = (0, distinct.first().copied().unwrap_or(0.0));
        for value in distinct {
            if apart(first, value) {
                class += 1;
                first = value;
            }
            of_bits.insert(value.to_bits(), class);
        }
        Classes { of_bits }
    }

    fn lookup(&self) -> Lookup<'_> {
        Lookup {
            classes: self,
            last: (f64::NAN.to_bits(), 0),
        }
    }
}

impl Lookup<'_> {
    fn of(&mut self, value: f64) -> u32 {
        let bits = value.to_bits();
        if self.last.0 != bits {
            self.last = (bits, self.classes.of_bits.get(&bits).copied().unwrap_or(0));
        }
        self.last.1
    }
}

/// Film-ratio groups of each particle: by the nominal ratio where the file has one, else by gaps in δ/D.
struct FilmClasses {
    nominal: bool,
    /// for each particle the lower ends of its groups, and each group's film ratio
    groups: Vec<(Vec<f64>, Vec<f64>)>,
}

struct FilmLookup<'a> {
    classes: &'a FilmClasses,
    last: (u32, u64, u32),
}

impl FilmClasses {
    fn new(columns: &RunsAsRead, scene: &Scene) -> FilmClasses {
        let nominal = !columns.film_ratio.is_empty();
        let mut ratios: Vec<Vec<f64>> = vec![vec![]; scene.particles.len()];
        for row in 0..columns.restitution.len() {
            if columns.liquid[row] == RunsAsRead::NO_LIQUID {
                continue;
            }
            let of_particle = &mut ratios[columns.particle[row] as usize];
            let ratio = ratio_of(columns, row, nominal);
            // nominal ratios come in blocks: no need to keep each
            if !(nominal && of_particle.last() == Some(&ratio)) {
                of_particle.push(ratio);
            }
        }
        let gap = if nominal { 0.0 } else { scene.data.film_ratio_gap };
        let groups = ratios.into_iter().map(|ratios| split_at_gaps(ratios, gap)).collect();
        FilmClasses { nominal, groups }
    }

    fn film_ratio(&self, particle: usize, group: u32) -> f64 {
        self.groups[particle].1[group as usize]
    }

    fn lookup(&self) -> FilmLookup<'_> {
        FilmLookup {
            classes: self,
            last: (u32::MAX, 0, 0),
        }
    }
}

fn ratio_of(columns: &RunsAsRead, row: usize, nominal: bool) -> f64 {
    if nominal {
        columns.film_ratio[row]
    } else {
        columns.film[row] / columns.diameter[row]
    }
}

/// Splits sorted ratios at gaps: the lower end and the mean of each group.
fn split_at_gaps(mut ratios: Vec<f64>, gap: f64) -> (Vec<f64>, Vec<f64>) {
    ratios.sort_by(f64::total_cmp);
    let starts: Vec<usize> = (0..ratios.len())
        .filter(|i| *i == 0 || ratios[*i] - ratios[*i - 1] > gap)
        .collect();
    let ends = starts.iter().skip(1).copied().chain([ratios.len()]);
    let means = starts
        .iter()
        .zip(ends)
        .map(|(start, end)| mean(&ratios[*start..end]))
        .collect();
    (starts.iter().map(|i| ratios[*i]).collect(), means)
}

impl FilmLookup<'_> {
    fn of(&mut self, columns: &RunsAsRead, row: usize) -> u32 {
        let particle = columns.particle[row];
        let ratio = ratio_of(columns, row, self.classes.nominal);
        if (self.last.0, self.last.1) != (particle, ratio.to_bits()) {
            let lower_ends = &self.classes.groups[particle as usize].0;
            let group = lower_ends.partition_point(|lower| *lower <= ratio).saturating_sub(1);
            self.last = (particle, ratio.to_bits(), group as u32);
        }
        self.last.2
    }
}
