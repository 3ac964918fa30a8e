//! Reads the priors that a scene sets for its parameters.

use super::model::LikelihoodFamily;
use super::parameters::{log_normal, parameters, SceneParameter};
use crate::error::quoted;
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

pub fn priors(
    root: &SceneTable,
    particles: &[String],
    likelihood: LikelihoodFamily,
    unused: &mut Vec<String>,
) -> Vec<PriorChoice> {
    let Some(table) = root.table("priors") else {
        return vec![];
    };
    let mut choices = vec![];
    let mut add = |parameter: &SceneParameter, particle: Option<usize>, inner: &SceneTable| {
        if let Some(prior) = prior(parameter, inner) {
            choices.push(PriorChoice {
                parameter: parameter.name,
                particle,
                prior,
                line: Some(inner.line()),
            });
        }
    };
    let parameters: Vec<SceneParameter> = parameters().collect();
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

/// The families of priors, each with what it takes and what that must be.
const FAMILIES: [(&str, &str, &str); 7] = [
    ("lognormal", "[median, sd of the log]", ", both above 0"),
    ("half_normal", "scale", ""),
    ("normal", "[mean, sd]", " with sd above 0"),
    ("gamma", "[shape, rate]", ", both above 0"),
    ("uniform", "[lo, hi]", " with lo below hi"),
    ("student_t", "[df, loc, scale]", " with df and scale above 0"),
    ("fixed", "value", ""),
];

/// What is to be said of the table of the priors.
pub(in crate::scene) fn guide_to_priors() -> Section {
    let prefactor = Coefficient::InertialPrefactor;
    let saturating = Form::new(Inertia::Saturating, DrySpeed::Impact);
    let families = FAMILIES.map(|(name, takes, _)| format!("`{{ {name} = {takes} }}`"));
    let keys = parameters().map(|parameter| KeyGuide {
        meaning: parameter.meaning,
        example: match parameter.prior {
            Prior::LogNormal(..) => format!("{{ lognormal = [{}, 0.3] }}", parameter.example),
            _ => format!("{{ fixed = {} }}", parameter.example),
        },
        ..KeyGuide::new(
            parameter.name,
            Dimension::One,
            "a prior",
            Without::Value(parameter.prior.written()),
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

fn prior(parameter: &SceneParameter, table: &SceneTable) -> Option<Prior> {
    let given: Vec<_> = FAMILIES.into_iter().filter(|(name, ..)| table.has(name)).collect();
    let [(family, takes, rule)] = given[..] else {
        let names = FAMILIES.map(|(name, ..)| name).join(", ");
        table.refuse("", table.at(""), None, format!("expected one prior out of {names}"));
        return None;
    };
    let prior = match family {
        "half_normal" => table.number(family, ABOVE_ZERO).map(Prior::HalfNormal),
        "fixed" => {
            let expect = match parameter.may_be_zero {
                _ if parameter.least == f64::NEG_INFINITY => FINITE,
                // every other parameter is positive
                true => NOT_NEGATIVE,
                false => ABOVE_ZERO,
            };
            table.number(family, expect).map(Prior::Fixed)
        }
        _ => {
            let numbers = table.numbers(family, takes.split(',').count())?;
            let prior = of_numbers(family, &numbers);
            if prior.is_none() {
                table.refuse_key(family, format!("expected {takes}{rule}"));
            }
            prior
        }
    };
    table.finish();
    match prior
        .as_ref()
        .and_then(|prior| prior.fails((parameter.least, f64::INFINITY)))
    {
        Some(expected) => {
            table.refuse_given(family, &expected);
            None
        }
        None => prior,
    }
}

/// The prior of a family that takes several numbers; `None` where these are not what they must be.
fn of_numbers(family: &str, numbers: &[f64]) -> Option<Prior> {
    match (family, numbers) {
        ("lognormal", &[median, sd]) if median > 0.0 && sd > 0.0 => Some(Prior::LogNormal(median, sd)),
        ("normal", &[mean, sd]) if sd > 0.0 => Some(Prior::Normal(mean, sd)),
        ("gamma", &[shape, rate]) if shape > 0.0 && rate > 0.0 => Some(Prior::Gamma(shape, rate)),
        ("uniform", &[lo, hi]) if lo < hi => Some(Prior::Uniform(lo, hi)),
        ("student_t", &[df, loc, scale]) if df > 0.0 && scale > 0.0 => Some(Prior::StudentT(df, loc, scale)),
        _ => None,
    }
}
