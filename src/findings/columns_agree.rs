//! Questions columns that tell the same thing of each run and contradict each other.

use super::remarks;
use crate::error::and_more;
use crate::remark::Remark;
use crate::runs::{ComparedBlock, ComparedColumns, RowPlaces};
use crate::scene::RunColumn;

/// A failed check of each two columns that tell the same thing and do not: over the whole table, in a block of it, or in many
/// single rows.
pub(super) fn check_columns(compared: &[ComparedColumns], places: &RowPlaces) -> Vec<Remark> {
    let off = compared.iter().filter_map(|both| contradiction(both, places));
    let checks = off.map(|(value, text)| remarks::COLUMNS_AGREE.check(value, text));
    checks.collect()
}

/// By which share two columns contradict each other, and in which rows; `None` where they agree.
fn contradiction(both: &ComparedColumns, places: &RowPlaces) -> Option<(f64, String)> {
    let [one, other] = &both.names;
    if is_of_films(both) {
        return contradicting_films(both, places);
    }
    let slip = |ratio: f64| likely_slip(both, ratio);
    let value = distance(both.ratio);
    if !remarks::COLUMNS_AGREE.holds(value) {
        let text = format!(
            "`{one}` gives {:.3} times the speeds of `{other}` (median of {} runs, {}){}",
            both.ratio,
            both.runs,
            places.of_range(both.rows, None),
            slip(both.ratio)
        );
        return Some((value, text));
    }
    if !both.blocks.is_empty() {
        /// blocks that are named
        const NAMED: usize = 5;
        let words = |block: &ComparedBlock| {
            let rows = places.of_range(block.rows, None);
            format!("{:.3} times in {rows}{}", block.ratio, slip(block.ratio))
        };
        let mut blocks: Vec<String> = both.blocks.iter().take(NAMED).map(words).collect();
        if both.blocks.len() > NAMED {
            blocks.push(format!("and {} blocks more", both.blocks.len() - NAMED));
        }
        let text = format!(
            "`{one}` gives another speed than `{other}` in a part of the table: {}",
            blocks.join(", ")
        );
        let worst = both.blocks.iter().map(|block| distance(block.ratio));
        return Some((worst.fold(0.0, f64::max), text));
    }
    let (row, ratio) = both.apart.first().filter(|_| is_no_slip(both))?;
    let text = format!(
        "`{one}` gives another speed than `{other}` by more than 10 % in {} of {} runs, nearly all on one side (the first: {}, \
         {ratio:.2} times){}",
        both.all_apart,
        both.runs,
        places.of_range([*row; 2], None),
        slip(*ratio)
    );
    Some((distance(*ratio), text))
}

/// Whether so many rows lie apart, and on one side, that they are neither slips nor scatter.
fn is_no_slip(both: &ComparedColumns) -> bool {
    /// rows, at least
    const FEWEST: usize = 5;
    /// share of the runs, at least
    const SHARE: f64 = 0.1;
    /// share of those apart that lie on one side, at least
    const ON_ONE_SIDE: f64 = 0.9;
    let apart = both.all_apart as f64;
    both.all_apart >= FEWEST && apart > SHARE * both.runs as f64 && both.on_one_side as f64 >= ON_ONE_SIDE * apart
}

fn is_of_films(both: &ComparedColumns) -> bool {
    both.columns[0] == RunColumn::FilmRatio
}

/// The same of a column of film ratios, which are nominal and so need only be near δ/D: by a factor that nearly all runs have,
/// or by a larger one in a part of the table.
fn contradicting_films(both: &ComparedColumns, places: &RowPlaces) -> Option<(f64, String)> {
    /// no nominal film ratio is off by such a factor in nearly every run
    const ANOTHER: f64 = 1.2;
    /// nor by such a one in a block of runs, or in a tenth of so many
    const OF_PART: f64 = 1.6;
    const FEWEST: usize = 50;
    let [least, most] = both.ends;
    let is_another = least > ANOTHER || most < 1.0 / ANOTHER;
    let [ratio, film] = &both.names;
    let text = |times: f64, runs: String| {
        let slip = likely_slip(both, times);
        let text = format!("`{ratio}` is {times:.3} times `{film}` over the diameter ({runs}){slip}");
        (distance(times), text)
    };
    if is_another {
        let runs = format!("median of {} runs, {}", both.runs, places.of_range(both.rows, None));
        return Some(text(both.ratio, runs));
    }
    let is_far = |ratio: f64| distance(ratio) > OF_PART - 1.0;
    if let Some(block) = both.blocks.iter().find(|block| is_far(block.ratio)) {
        let rows = places.of_range(block.rows, None);
        return Some(text(block.ratio, format!("mean of {} runs, {rows}", block.runs)));
    }
    // rows of a part that are not one after the other
    let far = both.ends.into_iter().find(|end| is_far(*end))?;
    let rows = places.of_range(both.rows, None);
    (both.runs >= FEWEST).then(|| text(far, format!("a tenth of {} runs or more, {rows}", both.runs)))
}

/// How far a ratio lies from one, as a share of the smaller.
fn distance(ratio: f64) -> f64 {
    ratio.max(1.0 / ratio) - 1.0
}

/// Names the rows in which such columns lie apart, where they agree in the others.
pub(super) fn rows_apart(compared: &[ComparedColumns], places: &RowPlaces) -> Option<Remark> {
    let agree =
        |both: &&ComparedColumns| both.all_apart > 0 && !is_of_films(both) && contradiction(both, places).is_none();
    let words = |both: &&ComparedColumns| {
        let (rows, ratios): (Vec<u32>, Vec<f64>) = both.apart.iter().copied().unzip();
        let rows = places.of_each(&rows).into_iter().zip(ratios);
        let rows = rows.map(|(row, ratio)| format!("{row} ({ratio:.2} times)")).collect();
        let [one, other] = &both.names;
        format!(
            "`{one}` gives another speed than `{other}` by more than 10 % in {}",
            and_more(rows, both.all_apart, ", ")
        )
    };
    let apart: Vec<&ComparedColumns> = compared.iter().filter(agree).collect();
    let (count, each) = (apart.iter().map(|both| both.all_apart).sum(), apart.iter().map(words));
    (!apart.is_empty()).then(|| remarks::COLUMNS_DISAGREE.notice(count, each.collect::<Vec<_>>().join("; ")))
}

/// What makes a column of heights, of Stokes numbers or of film ratios off by a factor.
const HEIGHT_SLIPS: [(f64, &str); 3] = [
    (10.0, "a factor of 10 in the height"),
    (100.0, "a factor of 100 in the height"),
    (1000.0, "a factor of 1000 in the height"),
];
const STOKES_SLIPS: [(f64, &str); 5] = [
    (9.0, "as of a Stokes number without its 9"),
    (2.0, "as of a Stokes number with the radius for the diameter"),
    (
        4.5,
        "as of a Stokes number with the radius for the diameter and without its 9",
    ),
    (10.0, "a factor of 10 in St"),
    (1000.0, "a factor of 1000 in St, as of a viscosity in mPa s for Pa s"),
];
const FILM_SLIPS: [(f64, &str); 1] = [(2.0, "as of the film over the radius, or of half the film ratio")];

/// What was likely mistaken, by the factor; nothing where that is of no slip.
fn likely_slip(both: &ComparedColumns, ratio: f64) -> String {
    const NEAR: f64 = 0.1;
    let is_height = matches!(both.columns[0], RunColumn::DropHeight | RunColumn::ReboundHeight);
    // h grows as v²
    let factor = if is_height { ratio.powi(2) } else { ratio };
    let is_near = |other: f64| (factor / other).ln().abs() < if is_height { 2.0 * NEAR } else { NEAR };
    let slips: &[(f64, &str)] = match both.columns[0] {
        RunColumn::FilmRatio => &FILM_SLIPS,
        _ if is_height => &HEIGHT_SLIPS,
        _ => &STOKES_SLIPS,
    };
    let is_slip = |(other, _): &&(f64, &str)| is_near(*other) || is_near(1.0 / *other);
    let found = slips.iter().find(is_slip);
    found.map_or(String::new(), |(_, words)| format!(": {words}"))
}
