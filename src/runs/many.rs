//! Reads tables of more runs than memory has room for, as few runs that stand for all and an even sample of the runs
//! themselves.
//!
//! They are read twice. Once for what divides runs into series, and for the sample, which then tells where slabs lie; and once
//! for what stands for the runs of each slab (`condense.rs`), of each table and then of all. So it does not matter which
//! process reads which table.

use std::sync::Arc;

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::collect::{Collected, CONDENSED_RUNS};
use super::csv::about_rows;
use super::errors::RunError;
use super::film_groups::FilmGroup;
use super::read_run::{ReadRun, RowSetting};
use super::series::{arrange_part, ClassCells, DryGroup, Runs, Series};
use super::slabs::Slabs;
use super::source::TableSource;
use super::spheres::check_spheres;
use super::stated_errors::check_stated_errors;
use super::table::{read, read_rows, Joined, Table};
use crate::error::Error;
use crate::physics::numbers::same_diameter;
use crate::ranks::Ranks;
use crate::remark::{Level, Remark};
use crate::scene::{Scene, TableFile};

/// Rows of the longest table whose runs are all kept: of eight values each, twenty million values.
pub const MOST_KEPT: usize = 2_500_000;

/// Runs of the sample, about.
const MOST_SAMPLED: usize = 500_000;

/// Runs that stand for blocks of rows wait to be put together until they are so many.
const MOST_WAITING: usize = 500_000;

/// Tables that a process reads at the same time, at most.
const TABLES_AT_ONCE: usize = 4;

/// What stands for so many tables is exchanged at once, at most: some fifteen megabytes each.
const MOST_EXCHANGED: u64 = 64;

/// About how many rows the tables of a scene have together, rather too many than too few. `None` of tables that are to be read
/// whole: one is a pipe, or cannot be read, which reading it will tell.
fn about_all_rows(scene: &Scene) -> Option<usize> {
    scene.data.runs.iter().map(about_rows_of).sum()
}

/// The same of one table: of a workbook, as many as a sheet can have.
fn about_rows_of(table: &TableFile) -> Option<usize> {
    const MOST_OF_SHEET: usize = 1 << 20;
    // a pipe can be read only once
    let is_file = std::fs::metadata(&table.path).is_ok_and(|about| about.is_file());
    let mut source = is_file.then(|| TableSource::open(&table.path).ok()).flatten()?;
    let rows = if table.ends_with(".parquet") {
        source.parquet(&table.path, u64::MAX).ok()?.rows
    } else if table.ends_with(TableFile::WORKBOOK) {
        MOST_OF_SHEET
    } else {
        let length = source.length;
        about_rows(source.reader(&table.path).ok()?, length).ok()?
    };
    (rows > 0).then_some(rows)
}

/// What a table says at the first reading.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Outline {
    /// with the sample as its runs
    collected: Collected,
    sha256: String,
    cells: ClassCells,
    /// whether its runs cannot stand for one another, or have to be read with all others
    is_whole: bool,
}

/// Reads, checks and screens the runs of a scene, like [`read`]; of more than `most_kept` the table has few that stand for all.
///
/// All are kept where the scene's noise or its question need each of them, or where runs carry measurement errors. Ranks
/// share such tables, and all have the same runs then.
pub fn read_any_number(scene: &Scene, most_kept: usize, ranks: &Ranks) -> Result<Table, Error> {
    let rows = about_all_rows(scene).filter(|rows| *rows > most_kept && !scene.model.needs_every_run());
    let few = rows.map(|rows| read_few(scene, rows, most_kept, ranks)).transpose()?;
    match few.flatten() {
        Some(table) => Ok(table),
        None => read(scene),
    }
}

/// `None` where every run is to be kept: also where the tables, whose rows are only estimated before, turn out to have no more
/// than `most_kept`.
fn read_few(scene: &Scene, about_rows: usize, most_kept: usize, ranks: &Ranks) -> Result<Option<Table>, Error> {
    let share = MOST_SAMPLED as f64 / about_rows as f64;
    let tables = &scene.data.runs;
    let outlines = of_each(tables, ranks, |place, table| outline(scene, table, place, share))?;
    let is_whole = |outline: &Outline| outline.is_whole || outline.collected.rows == 0;
    let rows: usize = outlines.iter().map(|outline| outline.collected.rows).sum();
    if rows <= most_kept || outlines.iter().any(is_whole) {
        return Ok(None);
    }
    let mut cells = ClassCells::default();
    let mut joined = Joined::default();
    for (table, outline) in tables.iter().zip(outlines) {
        cells.extend(outline.cells);
        joined.add((outline.collected, outline.sha256), table)?;
    }
    let (collected, mut table) = joined.finish(scene)?;
    let mut sample = arrange_part(collected.in_use, &cells, scene);
    sample.places = std::mem::take(&mut table.runs.places);
    check_spheres(scene, &sample.spheres)?;
    let slabs = Slabs::of(&sample, scene.data.smallest_restitution);
    let condensing = Condensing {
        scene,
        cells: &cells,
        slabs: &slabs,
    };
    let columns = condensing.all(ranks)?;
    let mut runs = arrange_part(columns, &cells, scene);
    runs.places = Arc::clone(&sample.places);
    runs.film_groups.iter_mut().for_each(|group| group.measure_by(&sample));
    check_stated_errors(scene, &runs)?;
    let sample = runs.alike(&sample);
    table.notices.push(condensed_notice(&runs, &sample));
    runs.sample = Some(Box::new(sample));
    table.runs = runs;
    Ok(Some(table))
}

fn condensed_notice(runs: &Runs, sample: &Runs) -> Remark {
    let (all, few, some) = (runs.all_measured(), runs.len(), sample.len());
    let text = format!(
        "{all} runs are more than are kept: laws and posterior are fitted to {few} that stand for all of them; scatter, the \
         bootstrap's widths, sensitivities to constants, the dry law's fit, predictive checks and figures are of an even sample \
         of {some}"
    );
    let next = "nothing; what needs every run (comparing models, densities of each) is for a part of the table";
    Remark::new(CONDENSED_RUNS, all, text, next).at(Level::Informs)
}

/// What each of some tables gives, in their order; ranks share them.
fn of_each<T: Send + Serialize + DeserializeOwned>(
    tables: &[TableFile],
    ranks: &Ranks,
    of_table: impl Fn(u64, &TableFile) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    ranks.gather(tables.len() as u64, |own| {
        let mut all = Vec::with_capacity(own.len());
        for some in own.chunks(TABLES_AT_ONCE) {
            let of_some = some.par_iter().map(|place| of_table(*place, &tables[*place as usize]));
            // of several that fail the first is told
            for of_one in of_some.collect::<Vec<Result<T, Error>>>() {
                all.push(of_one?);
            }
        }
        Ok(all)
    })
}

/// Reads a table, and gives its runs away. Fails with every bad cell of it.
fn read_blocks(
    source: &mut TableSource,
    table: &TableFile,
    scene: &Scene,
    take: &mut dyn FnMut(Vec<ReadRun>),
) -> Result<Collected, Error> {
    let mut collected = read_rows(source, table, scene, Some(&mut *take))?;
    take(std::mem::take(&mut collected.in_use));
    Ok(collected)
}

/// What one table says at the first reading.
fn outline(scene: &Scene, table: &TableFile, place: u64, share: f64) -> Result<Outline, Error> {
    let mut source = TableSource::open(&table.path)?;
    let mut outline = Outline::default();
    let mut sample = vec![];
    let mut before = 0u64;
    let mut take = |block: Vec<ReadRun>| {
        outline.is_whole |= block.iter().any(|run| run.errors != RunError::default());
        outline.cells.extend(ClassCells::of(&block, scene));
        let sampled = (before..).zip(&block).filter(|(run, _)| even(place, *run) < share);
        sample.extend(sampled.map(|(_, run)| *run));
        before += block.len() as u64;
    };
    let collected = read_blocks(&mut source, table, scene, &mut take)?;
    outline.sha256 = source.sha256(&table.path)?;
    // whether a word excludes the whole column tells
    outline.is_whole |= !collected.words_for_no().is_empty();
    outline.collected = collected;
    outline.collected.in_use = sample;
    Ok(outline)
}

/// A number between 0 and 1 for a run of a table, evenly spread and in step with no design. Row numbers would not do: they
/// end at `u32::MAX`, beyond which all runs would be sampled alike.
///
/// Source: the finalizer of SplitMix64, Steele, Lea & Flood 2014, doi:10.1145/2660193.2660195.
fn even(table: u64, run: u64) -> f64 {
    let mut x = (table << 40 | run).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x ^ (x >> 31)) as f64 / u64::MAX as f64
}

/// Puts few runs in the place of all.
struct Condensing<'a> {
    scene: &'a Scene,
    cells: &'a ClassCells,
    slabs: &'a Slabs,
}

impl Condensing<'_> {
    fn few(&self, read: Vec<ReadRun>) -> Vec<ReadRun> {
        let runs = arrange_part(read, self.cells, self.scene);
        runs.condensed_in(self.slabs).as_read(self.cells.has_film_ratio)
    }

    /// Those of all tables; each rank reads some of them at a time.
    fn all(&self, ranks: &Ranks) -> Result<Vec<ReadRun>, Error> {
        let mut waiting = Waiting::default();
        let step = (ranks.count() * TABLES_AT_ONCE as u64).min(MOST_EXCHANGED);
        for some in self.scene.data.runs.chunks(step as usize) {
            let next = of_each(some, ranks, |_, table| self.of_table(table))?;
            next.iter().for_each(|few| waiting.add(few, self));
        }
        Ok(self.few(waiting.runs))
    }

    fn of_table(&self, table: &TableFile) -> Result<Vec<ReadRun>, Error> {
        let mut waiting = Waiting::default();
        let mut take = |block: Vec<ReadRun>| waiting.add(&self.few(block), self);
        // what it says besides is known from the first reading
        read_blocks(&mut TableSource::open(&table.path)?, table, self.scene, &mut take)?;
        Ok(self.few(waiting.runs))
    }
}

/// Runs that stand for others, until they are many enough for few to take their place.
#[derive(Default)]
struct Waiting {
    runs: Vec<ReadRun>,
    /// how many were left of them when they were last put together
    few: usize,
}

impl Waiting {
    /// Adds some behind those that wait.
    fn add(&mut self, runs: &[ReadRun], condensing: &Condensing) {
        self.runs.extend(runs);
        // where few are many, they are not put together again before as many have come
        if self.runs.len() > MOST_WAITING.max(2 * self.few) {
            self.runs = condensing.few(std::mem::take(&mut self.runs));
            self.few = self.runs.len();
        }
    }
}

impl Runs {
    /// The runs as they would be read, in this order.
    fn as_read(&self, has_film_ratio: bool) -> Vec<ReadRun> {
        let of_dry = |group: &DryGroup| (group.kinds(), group.particle, None, None);
        let of_series = |series: &Series| {
            let film_ratio = has_film_ratio.then_some(series.film_ratio);
            (series.kinds(), series.particle, Some(series.liquid as u32), film_ratio)
        };
        let groups = self.dry.iter().map(of_dry);
        let mut all = Vec::with_capacity(self.len());
        for (kinds, particle, liquid, film_ratio) in groups.chain(self.series.iter().map(of_series)) {
            for (runs, stuck) in kinds.into_iter().zip([false, true]) {
                all.extend(runs.map(|run| ReadRun {
                    setting: RowSetting {
                        particle: particle as u32,
                        liquid,
                        diameter: self.diameter[run],
                        film: self.film[run],
                    },
                    impact_speed: self.impact_speed[run],
                    restitution: self.restitution[run],
                    film_ratio,
                    row: self.row[run],
                    count: self.count.get(run).copied(),
                    stuck: Some(stuck),
                    ..ReadRun::default()
                }));
            }
        }
        all
    }

    /// Some of the runs that these stand for, in the same series; of a series of which they have none, these.
    fn alike(&self, some: &Runs) -> Runs {
        let of_dry = self.dry.iter().map(|group| {
            let is_same =
                |own: &&DryGroup| own.particle == group.particle && same_diameter(own.diameter, group.diameter);
            let own = some.dry.iter().find(is_same);
            own.map_or((self, group.kinds()), |own| (some, own.kinds()))
        });
        let of_series = self.series.iter().map(|series| {
            let own = some.series.iter().find(|own| own.is_same(series));
            own.map_or((self, series.kinds()), |own| (some, own.kinds()))
        });
        let each = of_dry.chain(of_series);
        let mut each = each.flat_map(|(from, kinds)| kinds.map(|runs| (from, runs)));
        let mut alike = self.regrouped(|alike, runs| {
            let (from, own) = each.next().unwrap_or((self, runs));
            alike.take(from, own);
        });
        // as runs by themselves
        alike.count.clear();
        alike
    }
}

impl Series {
    /// What it is told by besides its diameter.
    pub(super) fn key(&self) -> (usize, usize, u64) {
        (self.particle, self.liquid, self.film_ratio.to_bits())
    }

    fn is_same(&self, other: &Series) -> bool {
        self.key() == other.key() && self.is_as_large_as(other)
    }
}

impl FilmGroup {
    /// Takes its width from that of the same group in a sample, where it has one.
    fn measure_by(&mut self, sample: &Runs) {
        let is_same = |own: &&FilmGroup| {
            let diameters = [&*self, own].map(|group| sample.spheres.get(group.sphere).and_then(|s| s.diameter));
            let same_sphere = match diameters {
                [Some(one), Some(other)] => same_diameter(one, other),
                _ => true,
            };
            own.particle == self.particle && own.film_ratio.to_bits() == self.film_ratio.to_bits() && same_sphere
        };
        if let Some(own) = sample.film_groups.iter().find(is_same) {
            (self.ends, self.width) = (own.ends, own.width);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::runs::tests::plain;

    #[test]
    fn a_run_beyond_the_last_row_number_is_sampled_like_any_other() {
        let first = 1u64 << 33;
        let sampled = (first..first + 10_000).filter(|run| even(3, *run) < 0.1).count();
        assert!((900..1100).contains(&sampled), "{sampled}");
    }

    #[test]
    fn what_stands_for_rebounds_near_the_limit_does_not_stick() {
        let (mut scene, _) = plain();
        scene.data.smallest_restitution = 0.1;
        let limit = scene.data.smallest_restitution;
        let mut rng = crate::seed::stream(1, "rebounds near the limit", 0);
        let mut read = vec![];
        for row in 0..60_000 {
            let noise: f64 = StandardNormal.sample(&mut rng);
            let speed = 0.8 + 0.4 * (f64::from(row) * 0.618_034).fract();
            let e = 0.3 * (speed - 0.8) + 0.05 * noise;
            read.push(ReadRun {
                setting: RowSetting {
                    particle: 0,
                    liquid: Some(0),
                    diameter: 4.762e-3,
                    film: 4e-4,
                },
                impact_speed: speed,
                restitution: if e > limit { e } else { 0.0 },
                row,
                ..ReadRun::default()
            });
        }
        let cells = ClassCells::of(&read, &scene);
        let all = arrange_part(read, &cells, &scene);
        let slabs = Slabs::of(&all, limit);
        let few = all.condensed_in(&slabs).as_read(false);
        assert!(few.len() < 20_000, "{}", few.len());
        // some of them are such that they would
        let is_below = |run: &ReadRun| run.stuck == Some(false) && run.restitution <= limit;
        assert!(few.iter().any(is_below));
        let again = arrange_part(few, &cells, &scene).condensed_in(&slabs);
        assert!(all.stuck() > 1000);
        assert_eq!([again.stuck(), again.all_measured()], [all.stuck(), all.all_measured()]);
    }
}
