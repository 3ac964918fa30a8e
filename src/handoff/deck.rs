//! Writes a drop test: the template of a code with the heading, the sphere, its drop and the code's own numbers in it.
//!
//! The restitution of every contact here depends on neither stiffness nor size, so the test takes a spring as soft as its
//! overlap allows.

use std::f64::consts::PI;

use minijinja::value::merge_maps;
use minijinja::{context, Value};

use super::heading::heading;
use super::law::{Handoff, HandoffFile};
use super::numbers::{input, number, restitution};
use super::template::filled;
use crate::error::Error;

/// Overlap of sphere and plate, undamped, at the reference speed, as a share of the radius.
const OVERLAP: f64 = 0.01;

/// Gap between sphere and plate at the start, as a share of the radius.
const GAP: f64 = 0.001;

/// Height at which two spheres meet, away from the plate, over the radius.
const AWAY: f64 = 20.0;

/// Time steps an undamped contact; e is then right to about 1e-5.
const STEPS_OF_CONTACT: f64 = 10_000.0;

/// Undamped contacts that a run lasts: strong damping lengthens a contact.
const CONTACTS: f64 = 10.0;

/// Poisson's ratio of sphere and plate, where a code wants one.
pub(super) const POISSON: f64 = 0.3;

/// A linear spring for this overlap, N/m.
pub(super) fn stiffness(handoff: &Handoff) -> f64 {
    handoff.mass() * (handoff.reference_speed / (OVERLAP * handoff.radius())).powi(2)
}

/// κ = F/(m δ^(3/2)) of a Hertz contact of about this overlap, m^(-1/2) s^(-2).
pub(super) fn hertz_over_mass(handoff: &Handoff) -> f64 {
    handoff.reference_speed.powi(2) / (OVERLAP * handoff.radius()).powf(2.5)
}

/// Young's modulus of sphere and plate, alike, for that Hertz contact, Pa.
pub(super) fn young(handoff: &Handoff) -> f64 {
    // (4/3) E* sqrt(R) = κ m with E* = E/(2 (1 − ν²))
    let effective = 0.75 * hertz_over_mass(handoff) * handoff.mass() / handoff.radius().sqrt();
    2.0 * (1.0 - POISSON * POISSON) * effective
}

/// The file, whose time step suits a linear spring of this stiffness; `own` is what this code's template alone names.
pub(super) fn deck(
    name: &'static str,
    template: &str,
    handoff: &Handoff,
    stiffness: f64,
    own: Value,
) -> Result<HandoffFile, Error> {
    let (r, e) = (handoff.radius(), handoff.predicted().q50);
    let step = PI * (handoff.mass() / stiffness).sqrt() / STEPS_OF_CONTACT;
    let common = context! {
        heading => heading(handoff)?,
        file => name,
        speed => number(handoff.reference_speed),
        e => input(e),
        e_5 => restitution(e),
        pair => input(handoff.restitution_of_two()),
        density => number(handoff.density),
        diameter => number(handoff.diameter),
        mass => number(handoff.mass()),
        radius => number(r),
        start => number((1.0 + GAP) * r),
        upper => number((AWAY + 1.0 + GAP) * r),
        lower => number((AWAY - 1.0 - GAP) * r),
        side => number(4.0 * r),
        below => number(2.0 * r),
        above => number(40.0 * r),
        skin => number(r),
        poisson => number(POISSON),
        step => number(step),
        steps => number(CONTACTS * STEPS_OF_CONTACT),
    };
    Ok(HandoffFile {
        name,
        text: filled(template, merge_maps([own, common]))? + "\n",
    })
}
