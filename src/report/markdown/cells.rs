//! Words what tables of several sections have in common.

use super::super::{numbers, ReportInput};
use super::table::ReportTable;
use crate::findings::checks::Check;
use crate::findings::main_numbers::MainPlace;
use crate::findings::Verdict;
use crate::runs::Sphere;
use crate::scene::WetLaw;
use crate::units::millimetres;

/// The particles that have any estimate, or those of their diameters that have a k of their own, in their order.
pub(super) fn estimated(input: ReportInput) -> Vec<Sphere> {
    let (scene, findings) = (input.scene, input.findings);
    let has = |sphere: &Sphere| {
        let mut dry = findings.dry.iter();
        let mut scaling = findings.scaling.iter();
        dry.any(|row| sphere.owns(scene, &row.particle, row.diameter_m))
            || scaling.any(|row| sphere.owns(scene, &row.particle, row.diameter_m))
    };
    input.runs.spheres.iter().copied().filter(has).collect()
}

pub(super) fn law_name(law: WetLaw) -> &'static str {
    match law {
        WetLaw::Sqrt => "square root",
        WetLaw::Linear => law.name(),
    }
}

/// A diameter, mm.
pub(super) fn diameter(metres: f64) -> String {
    numbers::short(millimetres(metres))
}

/// A place in a sentence: particle, film ratio, diameter where it is of one, liquid.
pub(super) fn place_name(place: &MainPlace) -> String {
    let of_one = place
        .diameter_m
        .map_or(String::new(), |d| format!(", D = {} mm", diameter(d)));
    let liquid = place.liquid.as_deref().unwrap_or("liquids pooled");
    format!(
        "{}, δ/D = {}{of_one}, {liquid}",
        place.particle,
        numbers::short(place.film_ratio)
    )
}

pub(super) fn list(values: &[f64], scale: impl Fn(f64) -> f64) -> String {
    let texts: Vec<String> = values.iter().map(|x| numbers::short(scale(*x))).collect();
    match texts.as_slice() {
        // a long list says less than its ends
        [first, .., last] if texts.len() > 8 => format!("{} from {first} to {last}", texts.len()),
        _ => texts.join(", "),
    }
}

pub(super) fn interval_header(input: ReportInput) -> String {
    format!("{} % interval", numbers::short(100.0 * input.scene.bootstrap.level))
}

/// Checks with what was found to so many digits, the line each is held against, and what came of it.
pub(super) fn check_table<'c>(
    checks: impl Iterator<Item = &'c Check>,
    digits: usize,
    text: impl Fn(&Check) -> String,
    outcome: impl Fn(&Check) -> &'static str,
) -> ReportTable<&'c Check> {
    ReportTable::of(checks)
        .column("check", text)
        .column("value", |check| numbers::optional(check.value, digits))
        .column("line", |check| numbers::significant(check.threshold, 3))
        .column("outcome", outcome)
        .column("why this line", |check| check.source)
}

/// A number of rebounds, and of the runs beside them that stuck.
pub(super) fn rebounds_and_stuck(rebounds: usize, stuck: usize) -> String {
    format!("{rebounds} ({stuck})")
}

pub(super) fn usable(verdict: &Verdict) -> String {
    if verdict.passed {
        "usable".to_owned()
    } else {
        format!("not usable: {}", verdict.reason)
    }
}
