//! Words what tables of several sections have in common.

use super::super::{numbers, ReportInput};
use crate::findings::main_numbers::MainPlace;
use crate::findings::scaling::Scaling;
use crate::findings::{Findings, Verdict};
use crate::remark::{Line, Remark};
use crate::runs::Sphere;
use crate::scene::{Sticking, WetLaw};
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

/// Whether a law of some runs tells what stands nowhere else: not where these have no film ratio of their own, and the linear
/// law only where the square root does not stand and is not what biases it.
pub(super) fn is_told(findings: &Findings, particle: &str, place: [Option<f64>; 2], law: WetLaw) -> bool {
    let of = |law: WetLaw| {
        let mut laws = findings.scaling.iter();
        laws.find(|own| own.law == law && own.particle == particle && [own.diameter_m, own.film_ratio] == place)
    };
    let stands = |own: &Scaling| own.verdict.passed;
    match law {
        WetLaw::Sqrt => !of(law).is_some_and(|root| root.is_withheld),
        WetLaw::Linear => {
            let tells = |line: &Scaling| line.e_inf.value.is_some() && (stands(line) || line.bias.is_none());
            !of(WetLaw::Sqrt).is_some_and(stands) && of(law).is_some_and(tells)
        }
    }
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

/// The runs of a posterior.
pub(super) fn fitted_runs(input: ReportInput) -> &'static str {
    match input.scene.model.sticking {
        Sticking::Censored if input.runs.stuck() == 0 => "all runs",
        Sticking::Censored => "all runs, stuck runs included",
        Sticking::Truncated => "the runs that rebounded, since those that stuck were not logged",
        Sticking::Excluded => "all runs that rebounded",
    }
}

/// What a failed check found, with its value where the words do not have it, and the line that it passed.
pub(super) fn found(check: &Remark) -> String {
    // a count of what failed stands in words
    let line = check.line.filter(|line| ![0.0, 1.0].contains(&line.threshold()));
    let Some((value, line)) = check.value.zip(line) else {
        return check.text.clone();
    };
    let value = numbers::significant(value, 3);
    let value = if check.text.contains(&value) {
        String::new()
    } else {
        value + ", "
    };
    let side = match line {
        Line::AtMost(_) => "above",
        Line::AtLeast(_) => "below",
    };
    format!("{} ({value}{side} {})", check.text, numbers::short(line.threshold()))
}

/// A number of rebounds, and of the runs beside them that stuck.
pub(super) fn rebounds_and_stuck(rebounds: usize, stuck: usize) -> String {
    format!("{rebounds} ({stuck})")
}

/// The header over why a fit is not usable.
pub(super) const NOT_USABLE: &str = "not usable";

/// Why a fit is not usable; empty where it is.
pub(super) fn why_not_usable(verdict: &Verdict) -> &str {
    if verdict.passed {
        ""
    } else {
        &verdict.reason
    }
}
