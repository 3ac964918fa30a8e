//! Attacks the priors of a scene: every parameter, every family, numbers from one end of f64 to the other.

use rayon::prelude::*;

use super::attack::{attack, Outcome};
use crate::common::{entries, Folder, Says};

/// So little sampling and resampling that a fit is mostly its start, where priors are met.
const SMALL: &str = "[sampler]\nchains = 2\nwarmup = 150\ndraws = 100\n[bootstrap]\nreplicates = 200\n";

/// Words that stand for a number that is none, in a text made of numbers and words.
fn holds_no_number(text: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.any(|word| ["nan", "inf", "infinity"].contains(&word.to_lowercase().as_str()))
}

/// What a command printed and wrote holds no number that is none, and a refusal leaves nothing.
fn assert_clean(place: &Folder, outcome: &Outcome, of: &str) {
    outcome.assert_mannered(of);
    assert!(!holds_no_number(&outcome.out), "{of}: {}", outcome.out);
    let written = place.join("report");
    if outcome.status == Some(2) {
        for words in ["nothing was written", "line ", "[priors"] {
            outcome.err.says(words);
        }
        assert_eq!(entries(place.path()), ["runs.csv", "scene.toml"], "{of}");
    } else if written.exists() {
        for name in ["report.md", "findings.json"] {
            let text = std::fs::read_to_string(written.join(name)).expect("written");
            let found = text.lines().find(|line| holds_no_number(line));
            assert_eq!(found, None, "{of}: {name}");
        }
    }
}

/// Runs `check` or `fit` on the plain example with these priors.
fn hold(verb: &str, model: &str, priors: &str) -> Outcome {
    let place = Folder::plain();
    place.add_to_scene(&format!("{SMALL}[model]\n{model}\n[priors]\n{priors}"));
    let more = if verb == "fit" { " --out report --threads 1" } else { "" };
    let outcome = attack(&place, &format!("{verb} scene.toml{more}"));
    assert_clean(&place, &outcome, &format!("{verb} {model} {priors}"));
    outcome
}

const STUDENT: &str = "likelihood = \"student\"";
const BOTH: &str = "noise = \"both\"";

#[test]
fn what_looks_for_numbers_that_are_none_finds_them_and_takes_no_word_for_one() {
    for text in ["| L | inf |", "NaN ± 1", "[-inf, 1]", "\"value\": NaN"] {
        assert!(holds_no_number(text), "{text}");
    }
    assert!(!holds_no_number("e_inf[PTFE] = 0.7, information on the finite e_inf"));
}

const EXTREMES: [&str; 14] = [
    "5e-324", "1e-308", "1e-300", "1e-100", "1e-15", "1e-10", "1e-3", "1", "1e3", "1e10", "1e15", "1e100", "1e300",
    "1.7e308",
];

const PARAMETERS: [(&str, &str); 11] = [
    ("dry_k", ""),
    ("\"dry_k.PTFE\"", ""),
    ("lubrication_log", ""),
    ("inertial_prefactor", ""),
    ("film_scale", "inertia = \"saturating\""),
    ("sigma_dry", ""),
    ("sigma_wet", ""),
    ("sigma_energy", BOTH),
    ("nu", STUDENT),
    ("asymmetry", "likelihood = \"asymmetric_laplace\""),
    ("sigma_series", "series_offsets = true"),
];

/// Every parameter with every family and extreme numbers; the families take turns at the pairs, so that all meet all.
fn attacks() -> Vec<(&'static str, String)> {
    let mut all = vec![];
    let mut turn = 0;
    for (parameter, model) in PARAMETERS {
        for (i, a) in EXTREMES.into_iter().enumerate() {
            // over the parameters every pair of places comes up
            let b = EXTREMES[(5 * i + 3 * turn + 2) % EXTREMES.len()];
            let (low, high) = if i % 2 == 0 { (a, b) } else { (b, a) };
            for family in [
                format!("lognormal = [{a}, {b}]"),
                format!("gamma = [{a}, {b}]"),
                format!("student_t = [{a}, {b}, {a}]"),
                format!("student_t = [3, {b}, {a}]"),
                format!("normal = [{a}, {b}]"),
                format!("normal = [-{a}, {b}]"),
                format!("uniform = [{low}, {high}]"),
                format!("uniform = [-{a}, {b}]"),
                format!("half_normal = {a}"),
                format!("fixed = {a}"),
            ] {
                all.push((model, format!("{parameter} = {{ {family} }}")));
            }
            turn += 1;
        }
        // below zero, equal, reversed
        let listed =
            "lognormal = [-1, 1]; lognormal = [1, -1]; gamma = [-1, 1]; student_t = [-3, 1, 1]; normal = [1, 0]; \
            uniform = [1, 1]; uniform = [2, 1]; half_normal = -1; fixed = -1; lognormal = [nan, 1]; normal = [inf, \
            1]; fixed = nan";
        for family in listed.split("; ") {
            all.push((model, format!("{parameter} = {{ {family} }}")));
        }
    }
    all
}

/// Which priors pass is settled by `check` in a few milliseconds each; those that pass are fitted, a part of them.
#[test]
fn a_prior_at_an_extreme_is_used_or_refused_in_time() {
    /// one of so many attacks is made: no divisor of what a parameter is attacked with, so that every family and every
    /// extreme takes its turn
    const MADE: usize = 17;
    /// one of so many that `check` lets through is fitted
    const FITTED: usize = 9;
    let all: Vec<_> = attacks().into_iter().step_by(MADE).collect();
    let passes = |(model, priors): &&(&str, String)| hold("check", model, priors).status == Some(0);
    let passed: Vec<_> = all.par_iter().filter(passes).collect();
    let refused = all.len() - passed.len();
    let attacks = [refused, passed.len()].map(|made| made * MADE);
    assert!(attacks[0] > 300 && attacks[1] > 50, "{attacks:?}");
    passed.par_iter().step_by(FITTED).for_each(|(model, priors)| {
        hold("fit", model, priors);
    });
}
