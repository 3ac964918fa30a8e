//! Words what tables of several sections have in common.

use super::super::{numbers, Told};
use crate::findings::Verdict;
use crate::scene::WetLaw;

/// Names of the particles that have any estimate, in the order of the scene.
pub(super) fn estimated(told: Told) -> Vec<String> {
    let findings = told.findings;
    let has = |name: &str| {
        findings.dry.iter().any(|dry| dry.particle == name) || findings.scaling.iter().any(|row| row.particle == name)
    };
    told.scene
        .particles
        .iter()
        .map(|p| p.name.clone())
        .filter(|name| has(name))
        .collect()
}

pub(super) fn law_name(law: &str) -> String {
    if law == WetLaw::Sqrt.name() {
        "square root".to_owned()
    } else {
        law.to_owned()
    }
}

pub(super) fn list(values: &[f64], scale: impl Fn(f64) -> f64) -> String {
    let texts: Vec<String> = values.iter().map(|x| numbers::short(scale(*x))).collect();
    match texts.as_slice() {
        // a long list says less than its ends
        [first, .., last] if texts.len() > 8 => format!("{} from {first} to {last}", texts.len()),
        _ => texts.join(", "),
    }
}

pub(super) fn interval_header(told: Told) -> String {
    format!("{} % interval", numbers::short(100.0 * told.scene.bootstrap.level))
}

pub(super) fn told_verdict(verdict: &Verdict) -> String {
    if verdict.passed {
        "usable".to_owned()
    } else {
        format!("not usable: {}", verdict.reason)
    }
}
