//! Reads the priors that a scene sets for its parameters.

use super::model::LikelihoodFamily;
use super::noise::NOISE;
use crate::error::quoted;
use crate::physics::coefficient::LogNormal;
use crate::physics::dry::DRY_K;
use crate::physics::{Coefficient, DrySpeed, Form, Inertia};
use crate::scene::expect::{ABOVE_ZERO, FINITE, NOT_NEGATIVE};
use crate::scene::keys::{KeyGuide, Section, Without};
use crate::scene::prior::Prior;
use crate::scene::table::SceneTable;
use crate::units::Dimension;

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

/// A parameter that a prior can be set for.
pub(in crate::scene) struct Parameter {
    pub name: &'static str,
    /// what it means, in a few words
    pub meaning: &'static str,
    /// a value it may well have
    pub example: &'static str,
    /// the prior without the key
    default: Prior,
    /// what it lies above
    least: f64,
    may_be_zero: bool,
}

/// Parameters a prior can be set for: k, those that particles share, and those of the noise.
pub(in crate::scene) fn parameters() -> impl Iterator<Item = Parameter> {
    let shared = Coefficient::ALL.map(|coefficient| *coefficient.describe());
    let physical = std::iter::once(DRY_K).chain(shared).map(|own| Parameter {
        name: own.name,
        meaning: own.meaning,
        example: own.example,
        default: log_normal(own.prior),
        least: 0.0,
        may_be_zero: own.may_be_zero,
    });
    let noise = NOISE.into_iter().map(|own| Parameter {
        name: own.name,
        meaning: own.meaning,
        example: own.example,
        default: own.prior,
        least: own.least,
        may_be_zero: own.may_be_zero,
    });
    physical.chain(noise)
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
    let mut add = |parameter: &Parameter, particle: Option<usize>, inner: &SceneTable| {
        if let Some(prior) = prior(parameter, inner) {
            choices.push(PriorChoice {
                parameter: parameter.name,
                particle,
                prior,
                line: Some(inner.line()),
            });
        }
    };
    let parameters: Vec<Parameter> = parameters().collect();
    for parameter in &parameters {
        let Some(inner) = table.table(parameter.name) else {
            continue;
        };
        if let Some(name) = particles.iter().find(|name| inner.has(name)) {
            let key = format!("{}.{name}", parameter.name);
            let expected = format!("expected the key in quotes: \"{key}\"");
            table.refuse(parameter.name, inner.at(name), Some(quoted(&key)), expected);
            continue;
        }
        add(parameter, None, &inner);
    }
    for dry_k in parameters.iter().filter(|parameter| parameter.name == DRY_K.name) {
        for (particle, name) in particles.iter().enumerate() {
            if let Some(inner) = table.table(&format!("{}.{name}", dry_k.name)) {
                add(dry_k, Some(particle), &inner);
            }
        }
    }
    table.finish();
    let others = LikelihoodFamily::NAMED
        .into_iter()
        .filter(|(_, family)| *family != likelihood);
    for shape in others.filter_map(|(_, family)| family.shape()) {
        unused.extend(table.has(shape.name).then(|| format!("priors.{}", shape.name)));
    }
    choices
}

fn log_normal(prior: LogNormal) -> Prior {
    Prior::LogNormal(prior.median, prior.ln_sd)
}

/// The families of priors, each with what it takes.
const FAMILIES: [(&str, &str); 7] = [
    ("lognormal", "[median, sd of the log]"),
    ("half_normal", "scale"),
    ("normal", "[mean, sd]"),
    ("gamma", "[shape, rate]"),
    ("uniform", "[lo, hi]"),
    ("student_t", "[df, loc, scale]"),
    ("fixed", "value"),
];

/// What is to be said of the table of the priors.
pub(in crate::scene) fn guide_to_priors() -> Section {
    let prefactor = Coefficient::InertialPrefactor;
    let saturating = Form::new(Inertia::Saturating, DrySpeed::Impact);
    let families = FAMILIES.map(|(name, takes)| format!("`{{ {name} = {takes} }}`"));
    let keys = parameters().map(|parameter| KeyGuide {
        meaning: parameter.meaning,
        example: match parameter.default {
            Prior::LogNormal(..) => format!("{{ lognormal = [{}, 0.3] }}", parameter.example),
            _ => format!("{{ fixed = {} }}", parameter.example),
        },
        ..KeyGuide::new(
            parameter.name,
            Dimension::One,
            "a prior",
            Without::Value(parameter.default.written()),
        )
    });
    let about = format!(
        "What is believed of the parameters before the runs. A prior is one of {}. `\"{}.NAME\"`, in quotes, is that of one \
         particle. Those of the noise are read where [model] asks for them. {} of the saturating form has the default `{}`",
        families.join(", "),
        DRY_K.name,
        prefactor.describe().symbol,
        log_normal(saturating.prior(prefactor)).written(),
    );
    Section {
        about,
        ..Section::new("[priors]", keys.collect())
    }
}

fn prior(parameter: &Parameter, table: &SceneTable) -> Option<Prior> {
    let at = table.at("");
    let names = FAMILIES.map(|(name, _)| name);
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
        ["fixed"] if parameter.least == f64::NEG_INFINITY => table.number("fixed", FINITE).map(Prior::Fixed),
        // every other parameter is positive
        ["fixed"] if parameter.may_be_zero => table.number("fixed", NOT_NEGATIVE).map(Prior::Fixed),
        ["fixed"] => table.number("fixed", ABOVE_ZERO).map(Prior::Fixed),
        _ => {
            table.refuse("", at, None, format!("expected one prior out of {}", names.join(", ")));
            return None;
        }
    };
    table.finish();
    let fails = |prior: &Prior| prior.fails((parameter.least, f64::INFINITY));
    match (prior.as_ref().and_then(fails), given.as_slice()) {
        (Some(expected), [family]) => {
            table.refuse_given(family, &expected);
            None
        }
        _ => prior,
    }
}
