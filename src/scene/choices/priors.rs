//! Reads the priors that a scene sets for its parameters.

use super::model::LikelihoodFamily;
use super::unused::note_unused;
use crate::error::quoted;
use crate::physics::dry::DRY_K;
use crate::physics::Coefficient;
use crate::scene::expect::{ABOVE_ZERO, NOT_NEGATIVE};
use crate::scene::prior::Prior;
use crate::scene::table::SceneTable;

/// A prior the scene sets for one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct PriorChoice {
    /// the parameter's name
    pub parameter: &'static str,
    /// index into the scene's particles, for a prior of one particle
    pub particle: Option<usize>,
    /// the density
    pub prior: Prior,
    /// the line of the scene file it stands on, from 1; `None` for one of no file
    pub line: Option<u64>,
}

/// Parameters a prior can be set for: k, those that particles share, and those of the noise.
fn parameters() -> impl Iterator<Item = &'static str> {
    let shared = Coefficient::ALL.map(|coefficient| coefficient.describe().name);
    let noise = [SIGMA_DRY, SIGMA_WET, "sigma_energy", "sigma_series", "nu"];
    std::iter::once(DRY_K.name).chain(shared).chain(noise)
}

/// What a parameter lies above: noise of two degrees of freedom or fewer has no variance.
pub(crate) fn least(parameter: &str) -> f64 {
    if parameter == "nu" {
        2.0
    } else {
        0.0
    }
}

pub fn priors(
    root: &SceneTable,
    particles: &[&str],
    likelihood: LikelihoodFamily,
    unused: &mut Vec<String>,
) -> Vec<PriorChoice> {
    let Some(table) = root.table("priors") else {
        return vec![];
    };
    let mut choices = vec![];
    let mut add = |parameter: &'static str, particle: Option<usize>, inner: &SceneTable| {
        if let Some(prior) = prior(parameter, inner) {
            choices.push(PriorChoice {
                parameter,
                particle,
                prior,
                line: Some(inner.line()),
            });
        }
    };
    for parameter in parameters() {
        let Some(inner) = table.table(parameter) else {
            continue;
        };
        if let Some(name) = particles.iter().find(|name| inner.has(name)) {
            let expected = format!("expected the key in quotes: \"{parameter}.{name}\"");
            table.refuse(
                parameter,
                inner.at(name),
                Some(quoted(&format!("{parameter}.{name}"))),
                expected,
            );
            continue;
        }
        add(parameter, None, &inner);
    }
    for (particle, name) in particles.iter().enumerate() {
        if let Some(inner) = table.table(&format!("dry_k.{name}")) {
            add("dry_k", Some(particle), &inner);
        }
    }
    table.finish();
    if likelihood == LikelihoodFamily::Normal {
        note_unused("priors", &table, &["nu"], unused);
    }
    choices
}

/// The spread of the dry restitutions.
pub(crate) const SIGMA_DRY: &str = "sigma_dry";
/// The spread of the wet restitutions.
pub(crate) const SIGMA_WET: &str = "sigma_wet";

/// C, without which there is no inertia, and a spread beside which measurement errors scatter the runs.
fn may_be_zero(parameter: &str) -> bool {
    let mut shared = Coefficient::ALL.into_iter().map(Coefficient::describe);
    [SIGMA_DRY, SIGMA_WET].contains(&parameter) || shared.any(|own| own.name == parameter && own.may_be_zero)
}

fn prior(parameter: &str, table: &SceneTable) -> Option<Prior> {
    let at = table.at("");
    let names = [
        "lognormal",
        "half_normal",
        "normal",
        "gamma",
        "uniform",
        "student_t",
        "fixed",
    ];
    let given: Vec<_> = names.into_iter().filter(|name| table.has(name)).collect();
    let refuse = |key: &str, expected: &str| {
        table.refuse(key, table.at(key), None, format!("expected {expected}"));
        None
    };
    let pair = |key: &str| table.numbers(key, 2).map(|x| (x[0], x[1]));
    let prior = match given.as_slice() {
        ["lognormal"] => match pair("lognormal")? {
            (median, sd) if median > 0.0 && sd > 0.0 => Some(Prior::LogNormal(median, sd)),
            _ => refuse("lognormal", "[median, sd of the log], both above 0"),
        },
        ["half_normal"] => table.number("half_normal", ABOVE_ZERO).map(Prior::HalfNormal),
        ["normal"] => match pair("normal")? {
            (mean, sd) if sd > 0.0 => Some(Prior::Normal(mean, sd)),
            _ => refuse("normal", "[mean, sd] with sd above 0"),
        },
        ["gamma"] => match pair("gamma")? {
            (shape, rate) if shape > 0.0 && rate > 0.0 => Some(Prior::Gamma(shape, rate)),
            _ => refuse("gamma", "[shape, rate], both above 0"),
        },
        ["uniform"] => match pair("uniform")? {
            (lo, hi) if lo < hi => Some(Prior::Uniform(lo, hi)),
            _ => refuse("uniform", "[lo, hi] with lo below hi"),
        },
        ["student_t"] => match table.numbers("student_t", 3)?.as_slice() {
            &[df, loc, scale] if df > 0.0 && scale > 0.0 => Some(Prior::StudentT(df, loc, scale)),
            _ => refuse("student_t", "[df, loc, scale] with df and scale above 0"),
        },
        // every other parameter is positive
        ["fixed"] if may_be_zero(parameter) => table.number("fixed", NOT_NEGATIVE).map(Prior::Fixed),
        ["fixed"] => table.number("fixed", ABOVE_ZERO).map(Prior::Fixed),
        _ => {
            table.refuse("", at, None, format!("expected one prior out of {}", names.join(", ")));
            return None;
        }
    };
    table.finish();
    let fails = |prior: &Prior| prior.fails((least(parameter), f64::INFINITY));
    match (prior.as_ref().and_then(fails), given.as_slice()) {
        (Some(expected), [family]) => {
            table.refuse_given(family, &expected);
            None
        }
        _ => prior,
    }
}
