//! Writes the drop test for LIGGGHTS-PUBLIC: one restitution a pair, and wet the contact that reads Stokes numbers.

use minijinja::context;

use super::contact::{rebound, share_for, End, StokesKeywords};
use super::deck::{deck, stiffness, POISSON};
use super::heading::{beside_the_law, spaced};
use super::law::{Handoff, HandoffFile};
use super::numbers::{input, number, restitution};
use crate::error::Error;
use crate::rounding::to_digits;

/// `coefficientRestitution` must be above this (LIGGGHTS-PUBLIC 3.8.0, global_properties.cpp).
const LEAST_INPUT: f64 = 0.05;

/// Young's moduli for which it asks no questions in SI units, Pa (the same file).
const YOUNG: std::ops::RangeInclusive<f64> = 5e6..=1e9;

/// Speeds at which the contact with Stokes keywords is fitted to the law.
const FITTED_SPEEDS: u32 = 17;

/// `coefficientRestitution` that gives e with `limitForce on`; `None` where it would have to be too low.
fn input_with_limit(e: f64) -> Option<f64> {
    let input = rebound(share_for(e, End::Force), End::Overlap);
    (input > LEAST_INPUT).then_some(input)
}

/// Young's modulus of sphere and plate whose contact `hooke` has about the drop test's spring, and that spring.
fn spring(handoff: &Handoff) -> (f64, f64) {
    // kn = (16/15) sqrt(R) Y (15 m V^2/(16 sqrt(R) Y))^(1/5), Y = E/(2 (1 - nu^2)), in normal_model_hooke.h
    let (root, v) = (handoff.radius().sqrt(), handoff.reference_speed);
    let factor = 16.0 / 15.0 * root * (15.0 * handoff.mass() * v * v / (16.0 * root)).powf(0.2);
    let both = 2.0 * (1.0 - POISSON * POISSON);
    let young = (both * (stiffness(handoff) / factor).powf(1.25)).clamp(*YOUNG.start(), *YOUNG.end());
    (young, factor * (young / both).powf(0.8))
}

fn constant(handoff: &Handoff) -> Result<HandoffFile, Error> {
    let e = handoff.predicted().q50;
    let given = |e: f64| input_with_limit(e).map_or("none".to_owned(), input);
    let limited = |input: f64| restitution(rebound(share_for(input, End::Overlap), End::Force));
    let (young, stiffness) = spring(handoff);
    let own = context! {
        young => number(young),
        limited => limited(e),
        least => limited(LEAST_INPUT),
        plate_on => given(e),
        pair_on => given(handoff.restitution_of_two()),
    };
    let template = include_str!("templates/liggghts.in");
    deck("drop_liggghts.in", template, handoff, stiffness, own)
}

/// The keywords nearest to the law over the speeds of the runs.
fn keywords(handoff: &Handoff) -> Option<StokesKeywords> {
    let law: Option<Vec<[f64; 2]>> = spaced(handoff.compared_speeds(), FITTED_SPEEDS)
        .into_iter()
        .map(|speed| Some([handoff.stokes_at(speed)?, (handoff.law)(speed).q50]))
        .collect();
    let nearest = StokesKeywords::nearest(&law?, End::Overlap);
    // four digits move e by less than 1e-4, and are what the table beside the law is computed with
    Some(StokesKeywords {
        maximum_restitution: to_digits(nearest.maximum_restitution, 4),
        critical_stokes: to_digits(nearest.critical_stokes, 4),
    })
}

/// The contact with Stokes keywords; `None` dry.
fn with_stokes(handoff: &Handoff) -> Option<Result<HandoffFile, Error>> {
    let viscosity = handoff.wet?.viscosity;
    let keywords = keywords(handoff)?;
    let contact = |speed: f64| {
        let stokes = handoff.stokes_at(speed).unwrap_or(f64::INFINITY);
        keywords.rebound(stokes, End::Overlap)
    };
    let (young, stiffness) = spring(handoff);
    let own = context! {
        young => number(young),
        beside => beside_the_law(handoff, &contact),
        viscosity => number(viscosity),
        critical => number(keywords.critical_stokes),
        maximum => number(keywords.maximum_restitution),
        contact => restitution(contact(handoff.reference_speed)),
        contact_pair => restitution(contact(2.0 * handoff.reference_speed)),
    };
    let template = include_str!("templates/liggghts_stokes.in");
    Some(deck("drop_liggghts_stokes.in", template, handoff, stiffness, own))
}

pub(super) fn files(handoff: &Handoff) -> Result<Vec<HandoffFile>, Error> {
    let e = handoff.predicted().q50;
    for (e, of) in [(e, ""), (handoff.restitution_of_two(), " of two spheres")] {
        if e <= LEAST_INPUT {
            return Err(Error::Usage(format!(
                "--speed-m-s: at {} m/s the law gives e = {}{of}, and LIGGGHTS refuses coefficientRestitution of {LEAST_INPUT} or less",
                number(handoff.reference_speed),
                restitution(e)
            )));
        }
    }
    std::iter::once(constant(handoff)).chain(with_stokes(handoff)).collect()
}
