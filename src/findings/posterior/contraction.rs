//! Names the parameters that keep much of their prior, each with the one it moves with, and those whose runs contradict it.

use super::summary::{PosteriorFindings, QuantitySummary, RunsAlone};
use crate::findings::checks::{self, Check};
use crate::findings::identify::Directions;
use crate::findings::notices;
use crate::notice::Notice;
use crate::rounding::with_se;

/// A correlation below this is no partner.
const PARTNER: f64 = 0.3;

/// What of a parameter's prior sd is left, where its prior leads.
fn share_left(quantity: &QuantitySummary) -> Option<f64> {
    quantity.prior.as_ref().filter(|prior| prior.leads())?.sd_ratio
}

/// Parameters that keep more than the line.
pub(in crate::findings) fn contraction_notices(
    found: &PosteriorFindings,
    directions: Option<&Directions>,
) -> Vec<Notice> {
    let wide = found.parameters.iter().enumerate();
    let wide: Vec<(usize, f64)> = wide.filter_map(|(place, q)| Some((place, share_left(q)?))).collect();
    let mut all = vec![];
    if !wide.is_empty() {
        let parameters: Vec<String> = wide
            .iter()
            .map(|(place, left)| describe(found, *place, *left))
            .collect();
        let directions = directions.into_iter().flat_map(|directions| &directions.unseen);
        let names = |place: &usize| found.parameters[*place].name.as_str();
        let known = directions.filter(|unseen| {
            wide.iter()
                .any(|(at, _)| unseen.parameters.iter().any(|p| p == names(at)))
        });
        let add = known.map(|unseen| unseen.add.as_str()).next();
        all.push(notices::prior_rules(&parameters, add));
    }
    all
}

/// Whether the runs contradict a prior; `None` where they alone say nothing of any parameter.
pub(super) fn prior_conflict(found: &PosteriorFindings) -> Option<Check> {
    let alone = found.parameters.iter().filter_map(|own| {
        let prior = own.prior.as_ref()?;
        Some((own, prior, prior.runs_alone?))
    });
    let mut alone: Vec<_> = alone.collect();
    alone.sort_by(|a, b| b.2.from_prior.abs().total_cmp(&a.2.from_prior.abs()));
    let (worst, _, farthest) = alone.first()?;
    let criterion = checks::PRIOR_CONFLICT;
    let distance = farthest.from_prior.abs();
    let conflicts: Vec<_> = alone
        .iter()
        .filter(|(_, prior, _)| prior.conflict().is_some())
        .collect();
    if conflicts.is_empty() {
        let text = format!(
            "largest distance of what the runs alone say from a prior ({}), in sds of the two together",
            worst.name
        );
        return Some(criterion.check(distance, text));
    }
    let told = conflicts.iter().map(|(own, prior, alone)| {
        format!(
            "{}: the runs alone give {}, its prior is {}: {:.1} sds of the two together apart, and the posterior lies {:.1} of \
             its ± from what the runs say",
            own.name,
            with_se(alone.value, alone.se),
            prior.density,
            alone.from_prior.abs(),
            alone.from_posterior.abs()
        )
    });
    let told: Vec<String> = told.collect();
    let felt = |alone: &RunsAlone| alone.from_posterior.abs() > checks::FELT;
    Some(
        Check {
            gates: conflicts.iter().any(|(_, _, alone)| felt(alone)),
            ..criterion.check(distance, notices::shortened(&told))
        }
        .with_advice(),
    )
}

/// A parameter with what is left of its prior sd, and the parameter that moves most with it.
fn describe(found: &PosteriorFindings, place: usize, left: f64) -> String {
    let name = &found.parameters[place].name;
    let others = found.correlation[place]
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != place);
    let partner = others
        .filter(|(_, correlation)| correlation.abs() >= PARTNER)
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let partner = partner.map_or(String::new(), |(other, correlation)| {
        format!(", correlation {correlation:.2} with {}", found.parameters[other].name)
    });
    format!("{name} ({left:.2} of it{partner})")
}
