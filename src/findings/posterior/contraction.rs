//! Names the parameters that keep much of their prior, each with the one it moves with, and those whose runs contradict it.

use super::runs_alone::RunsAlone;
use super::summary::{HeldParameter, PosteriorFindings, QuantitySummary};
use crate::findings::identify::Directions;
use crate::findings::remarks;
use crate::model::parameters::{OF_SCENE, OF_SLOW_REBOUNDS};
use crate::remark::Remark;
use crate::rounding::{signed, significant, with_se};

/// A correlation below this is no partner.
const PARTNER: f64 = 0.3;

/// Parameters that keep more than half of their prior sd, with the runs that would tell one of them.
pub(in crate::findings) fn contraction_notice(
    found: &PosteriorFindings,
    directions: Option<&Directions>,
) -> Option<Remark> {
    // what barely rebounding runs are allowed is meant to rest on its prior
    let wide = found
        .parameters
        .iter()
        .enumerate()
        .filter(|(_, q)| !is_of_slow_rebounds(q));
    let led = wide.filter_map(|(place, q)| Some((place, q.prior.as_ref().filter(|prior| prior.leads())?.sd_ratio?)));
    let wide: Vec<(usize, f64)> = led.collect();
    if wide.is_empty() {
        return None;
    }
    let each = wide.iter().map(|(place, left)| describe(found, *place, *left));
    let text = format!(
        "more than half of the prior sd is left of {}",
        each.collect::<Vec<_>>().join(", ")
    );
    let is_wide = |name: &String| wide.iter().any(|(place, _)| found.parameters[*place].name == *name);
    let mut unseen = directions.into_iter().flat_map(|directions| &directions.unseen);
    let known = unseen.find(|unseen| unseen.parameters.iter().any(is_wide));
    let next = known.map_or(remarks::PRIOR_RULES.next_step, |unseen| unseen.add.as_str());
    Some(remarks::PRIOR_RULES.notice(wide.len(), text).then(next))
}

/// Whether the runs contradict a prior; `None` where they alone say nothing of any parameter.
pub(super) fn prior_conflict(found: &PosteriorFindings) -> Option<Remark> {
    let of_prior = |own: &QuantitySummary| {
        let prior = own.prior.as_ref()?;
        let alone = prior.runs_alone?;
        let believed = match prior.source {
            OF_SCENE => "its prior is",
            OF_SLOW_REBOUNDS => "such errors make it",
            _ => "its default prior is",
        };
        let apart = format!(
            "{believed} {}: {:.1} sds of the two together apart, and the posterior lies {:.1} of its ± from what the runs say",
            prior.density,
            alone.from_prior.abs(),
            alone.from_posterior.abs()
        );
        Some((own.name.clone(), alone, apart))
    };
    let of_held = |own: &HeldParameter| {
        let (alone, value) = own.runs_alone.zip(own.value)?;
        let apart = format!(
            "it is held at {value}, {:.1} standard errors away",
            alone.from_prior.abs()
        );
        Some((own.name.clone(), alone, apart))
    };
    let sampled = found.parameters.iter().filter_map(of_prior);
    let mut all: Vec<(String, RunsAlone, String)> = sampled.chain(found.left_out.iter().filter_map(of_held)).collect();
    all.sort_by(|a, b| b.1.from_prior.abs().total_cmp(&a.1.from_prior.abs()));
    let (worst, farthest, _) = all.first()?;
    let distance = farthest.from_prior.abs();
    let conflicts: Vec<_> = all.iter().filter(|(_, alone, _)| alone.contradicts_prior()).collect();
    if conflicts.is_empty() {
        let text =
            format!("largest distance of what the runs alone say from a prior ({worst}), in sds of the two together");
        return Some(remarks::PRIOR_CONFLICT.check(distance, text));
    }
    // where energies scatter by less than barely rebounding runs are allowed for, the numbers are the more careful
    let ours = found.parameters.iter().find(|own| is_of_slow_rebounds(own));
    let ours = conflicts
        .iter()
        .find(|(name, ..)| ours.is_some_and(|own| own.name == *name));
    if conflicts.len() == 1 && ours.is_some_and(|(_, alone, _)| alone.from_prior < 0.0) {
        return None;
    }
    let told = conflicts.iter().map(|(name, alone, apart)| {
        // a spread that is hardly known is known by its logarithm
        let is_rough = name.starts_with("sigma_") && alone.se > 0.5 * alone.value;
        let value = match is_rough {
            true => format!(
                "{}, known within a factor of {}",
                significant(alone.value, 1),
                significant((alone.se / alone.value).exp(), 2)
            ),
            false => with_se(alone.value, alone.se),
        };
        format!("{}: the runs alone give {value}, {apart}", remarks::in_symbols(name))
    });
    let told: Vec<String> = told.collect();
    let felt = |alone: &RunsAlone| alone.from_posterior.abs() > remarks::FELT;
    let forbids = conflicts.iter().any(|(_, alone, _)| felt(alone));
    let check = remarks::PRIOR_CONFLICT.check(distance, remarks::shortened(&told));
    let check = check.forbidding_if(forbids);
    // no prior of the scene: what the user can write is the noise itself
    Some(match ours {
        Some(_) => check.then(
            "write noise = \"both\" in [model]: energies scatter otherwise than errors of 1 % in speed and 3 % in film make them",
        ),
        None => check,
    })
}

/// Whether it is the spread of the energy kept that barely rebounding runs are allowed for.
fn is_of_slow_rebounds(own: &QuantitySummary) -> bool {
    own.prior.as_ref().is_some_and(|prior| prior.source == OF_SLOW_REBOUNDS)
}

/// A parameter with what is left of its prior sd, and the parameter that moves most with it.
fn describe(found: &PosteriorFindings, place: usize, left: f64) -> String {
    let name = &found.parameters[place].name;
    let is_partner = |(other, correlation): &(usize, &f64)| *other != place && correlation.abs() >= PARTNER;
    let partners = found.correlation[place].iter().enumerate().filter(is_partner);
    let partner = partners.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let partner = partner.map_or(String::new(), |(other, correlation)| {
        format!(
            ", correlation {} with {}",
            signed(*correlation),
            remarks::in_symbols(&found.parameters[other].name)
        )
    });
    format!("{} ({left:.2} of it{partner})", remarks::in_symbols(name))
}
