//! Looks whether a column of film ratios holds nominal ones, by which runs are put in groups.

use super::read_run::ReadRun;
use super::told_twice::Comparison;
use crate::error::quoted;
use crate::remark::{Level, Remark};
use crate::rounding::by_number;

pub(super) const FILM_RATIO_OF_EACH_RUN: &str = "film_ratio_of_each_run";
pub(super) const MANY_FILM_RATIOS: &str = "many_film_ratios";

/// The wet runs of a table with a column of film ratios, with these.
fn with_film_ratio(runs: &[ReadRun]) -> impl Iterator<Item = (&ReadRun, f64)> {
    runs.iter().filter_map(|run| Some((run, run.film_ratio?)))
}

/// Compares the column of film ratios with film over diameter.
pub(super) fn compare_film_ratios(runs: &[ReadRun]) -> Comparison {
    let mut comparison = Comparison::default();
    for (run, nominal) in with_film_ratio(runs) {
        let ratio = nominal / run.own_film_ratio();
        if ratio > 0.0 && ratio.is_finite() {
            comparison.add(run.row, run.setting, ratio);
        }
    }
    comparison
}

/// Whether a value of the column is the run's own δ/D, up to rounding.
fn is_own(run: &ReadRun, value: f64) -> bool {
    /// share by which a written film ratio may miss the film over the diameter
    const ROUNDING: f64 = 0.01;
    /// or rounded to so many in one
    const THOUSANDTHS: f64 = 1000.0;
    let own = run.own_film_ratio();
    let in_thousandths = THOUSANDTHS * value;
    let is_whole = (in_thousandths - in_thousandths.round()).abs() < 1e-6;
    let is_rounded = is_whole && (in_thousandths - THOUSANDTHS * own).abs() <= 0.5 + 1e-6;
    (value / own - 1.0).abs() <= ROUNDING || is_rounded
}

/// Takes film ratios that are each run's own δ/D for no nominal ones, and says so; says as well where there are as many of them
/// as if they were. The column is called `name`; films whose δ/D lies no further apart than `gap` would be one group.
pub(super) fn drop_own_film_ratios(runs: &mut [ReadRun], name: &str, gap: f64) -> Option<Remark> {
    /// values that are many, at least: fewer groups can be looked at
    const FEWEST: usize = 10;
    /// values of a group of films that are many, at least
    const OF_GROUP: usize = 3;
    /// rows of a value where these are many, on average: with fewer its laws have less than ten degrees of freedom
    const ROWS_OF_MANY: usize = 10;
    /// rows of a nominal film ratio, on average, at least
    const ROWS: usize = 3;
    let wet: Vec<(&ReadRun, f64)> = with_film_ratio(runs).collect();
    // of each particle
    let different = |of: &dyn Fn(&ReadRun, f64) -> f64| {
        let each = wet.iter().map(|(run, value)| (run.setting.particle, of(run, *value)));
        let mut each: Vec<(u32, f64)> = each.collect();
        // neighbours mostly are equal
        each.dedup();
        each.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        each.dedup();
        each
    };
    let values = different(&|_, value| value).len();
    // the runs of one row are one film
    let rows = wet.chunk_by(|a, b| a.0.row == b.0.row).count();
    if rows >= ROWS_OF_MANY * values {
        return None;
    }
    let films = different(&|run, _| run.own_film_ratio());
    let groups = films
        .chunk_by(|less, more| less.0 == more.0 && more.1 - less.1 <= gap)
        .count();
    let are_many = values >= FEWEST && values >= OF_GROUP * groups;
    // what is rounded has one value for several films
    let hides_films = are_many && films.len() >= 2 * values;
    if (rows < ROWS * values || hides_films) && wet.iter().all(|(run, value)| is_own(run, *value)) {
        let count = wet.len();
        runs.iter_mut().for_each(|run| run.film_ratio = None);
        let text = format!(
            "the column film_ratio holds the own δ/D of each of {count} wet runs and no nominal film ratio: it is not used, and \
             film groups are found from the films"
        );
        let next = "nothing; name the film ratios that were meant as film_ratios in [data]";
        return Some(Remark::new(FILM_RATIO_OF_EACH_RUN, count, text, next).at(Level::Informs));
    }
    let (noun, verb) = by_number(groups, ("group", "is"), ("groups", "are"));
    let text = format!(
        "the column {} has {values} different film ratios in {rows} wet rows, where by their films there {verb} {groups} \
         {noun}: each value is a film group of its own, of {:.1} rows on average",
        quoted(name),
        rows as f64 / values as f64
    );
    let next =
        "write the nominal film ratio of each run into the column, or give it another name, which leaves it out: film \
                groups are then found from the films, or by film_ratios in [data]";
    are_many.then(|| Remark::new(MANY_FILM_RATIOS, values, text, next))
}
