//! Writes the drop test for LAMMPS: one restitution a pair in a form right in every version, and dry the contact of the law.

use minijinja::context;

use super::contact::{rebound, share_for, viscoelastic_damping_for, viscoelastic_rebound, End, Tsuji};
use super::deck::{deck, hertz_over_mass, stiffness, young};
use super::heading::beside_the_law;
use super::law::{Handoff, HandoffFile};
use super::numbers::{input, number, restitution};
use crate::error::Error;

fn constant(handoff: &Handoff) -> Result<HandoffFile, Error> {
    let (e, two_spheres) = (handoff.predicted().q50, handoff.restitution_of_two());
    let given = |tsuji: Tsuji, e: f64| tsuji.input_for(e).map_or("none".to_owned(), input);
    let limited = rebound(share_for(e, End::Overlap), End::Force);
    let own = context! {
        stiffness => number(stiffness(handoff)),
        young => number(young(handoff)),
        limited => restitution(limited),
        tsuji_of_e_before => restitution(Tsuji::WithoutRootTwo.rebound(e)),
        tsuji_of_e_since => restitution(Tsuji::WithRootTwo.rebound(e)),
        tsuji_plate_before => given(Tsuji::WithoutRootTwo, e),
        tsuji_pair_before => given(Tsuji::WithoutRootTwo, two_spheres),
        tsuji_plate_since => given(Tsuji::WithRootTwo, e),
        tsuji_pair_since => given(Tsuji::WithRootTwo, two_spheres),
    };
    let template = include_str!("templates/lammps.in");
    deck("drop_lammps.in", template, handoff, stiffness(handoff), own)
}

/// The dry contact of Brilliantov & Pöschel, whose e falls with the speed as the dry law's does; `None` wet.
fn viscoelastic(handoff: &Handoff) -> Option<Result<HandoffFile, Error>> {
    let e = handoff.predicted().q50;
    if handoff.wet.is_some() || e >= 1.0 {
        return None;
    }
    let (v, r, kappa) = (handoff.reference_speed, handoff.radius(), hertz_over_mass(handoff));
    let damping = viscoelastic_damping_for(e, End::Overlap);
    let contact = |speed: f64| viscoelastic_rebound(damping * (speed / v).powf(0.2), End::Overlap);
    // a = gamma v^(1/5) kappa^(-3/5) with gamma = eta sqrt(R)
    let eta = damping * kappa.powf(0.6) / (v.powf(0.2) * r.sqrt());
    // a goes as m_eff^(3/5) R_eff^(1/5)
    let of_two = damping * 0.5f64.powf(0.8);
    let own = context! {
        beside => beside_the_law(handoff, &contact),
        hertz => number(kappa * handoff.mass() / r.sqrt()),
        eta => number(eta),
        contact_pair => restitution(viscoelastic_rebound(of_two, End::Overlap)),
    };
    let template = include_str!("templates/lammps_viscoelastic.in");
    Some(deck(
        "drop_lammps_viscoelastic.in",
        template,
        handoff,
        stiffness(handoff),
        own,
    ))
}

pub(super) fn files(handoff: &Handoff) -> Result<Vec<HandoffFile>, Error> {
    std::iter::once(constant(handoff))
        .chain(viscoelastic(handoff))
        .collect()
}
