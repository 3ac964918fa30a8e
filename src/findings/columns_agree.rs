//! Questions columns that tell the same thing of each run and contradict each other.

use super::checks::{self, Check};
use super::notices;
use crate::notice::Notice;
use crate::runs::{ComparedColumns, RowPlaces};
use crate::scene::RunColumn;

/// A failed check of each two columns that tell the same thing and do not.
pub(super) fn check_columns(compared: &[ComparedColumns]) -> Vec<Check> {
    let check = |both: &ComparedColumns| {
        let [one, other] = &both.names;
        let text = format!(
            "`{one}` gives {:.3} times the speeds of `{other}` (median of {} runs){}",
            both.ratio,
            both.runs,
            likely_slip(both).unwrap_or_default()
        );
        checks::COLUMNS_AGREE.check(distance(both), text).with_advice()
    };
    let off = compared
        .iter()
        .filter(|both| !checks::COLUMNS_AGREE.holds(distance(both)));
    off.map(check).collect()
}

/// How far the speeds of both lie apart, as a share of the smaller.
fn distance(both: &ComparedColumns) -> f64 {
    both.ratio.max(1.0 / both.ratio) - 1.0
}

/// Names the rows in which such columns lie apart, where they agree in the others.
pub(super) fn rows_apart(compared: &[ComparedColumns], places: &RowPlaces) -> Option<Notice> {
    let agree = |both: &&ComparedColumns| both.all_apart > 0 && checks::COLUMNS_AGREE.holds(distance(both));
    let mut count = 0;
    let each: Vec<String> = compared
        .iter()
        .filter(agree)
        .map(|both| {
            count += both.all_apart;
            let (rows, ratios): (Vec<u32>, Vec<f64>) = both.apart.iter().copied().unzip();
            let rows = places.of_each(&rows).into_iter().zip(ratios);
            let mut rows: Vec<String> = rows.map(|(row, ratio)| format!("{row} ({ratio:.2} times)")).collect();
            if both.all_apart > rows.len() {
                rows.push(format!("and {} more", both.all_apart - rows.len()));
            }
            let [one, other] = &both.names;
            format!(
                "`{one}` gives another speed than `{other}` by more than 10 % in {}",
                rows.join(", ")
            )
        })
        .collect();
    (!each.is_empty()).then(|| notices::columns_disagree(count, each.join("; ")))
}

/// What was likely mistaken, by the factor.
fn likely_slip(both: &ComparedColumns) -> Option<String> {
    const NEAR: f64 = 0.1;
    let is_height = matches!(both.columns[0], RunColumn::DropHeight | RunColumn::ReboundHeight);
    // h grows as v²
    let factor = if is_height { both.ratio.powi(2) } else { both.ratio };
    let is_near = |other: f64| (factor / other).ln().abs() < if is_height { 2.0 * NEAR } else { NEAR };
    let height = [10.0, 100.0, 1000.0].map(|factor| (factor, format!("a factor of {factor} in the height")));
    let stokes = [
        (9.0, "as of a Stokes number without its 9".to_owned()),
        (2.0, "as of a Stokes number with the radius for the diameter".to_owned()),
        (
            4.5,
            "as of a Stokes number with the radius for the diameter and without its 9".to_owned(),
        ),
        (10.0, "a factor of 10 in St".to_owned()),
        (
            1000.0,
            "a factor of 1000 in St, as of a viscosity in mPa s for Pa s".to_owned(),
        ),
    ];
    let slips: &[(f64, String)] = if is_height { &height } else { &stokes };
    let found = slips
        .iter()
        .find(|(factor, _)| is_near(*factor) || is_near(1.0 / *factor));
    found.map(|(_, words)| format!(": {words}"))
}
