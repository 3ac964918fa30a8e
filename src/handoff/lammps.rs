//! Writes the drop test for LAMMPS: one restitution a pair in a form right in every version, and dry the contact of the law.

use super::contact::{rebound, share_for, viscoelastic_damping_for, viscoelastic_rebound, End, Tsuji};
use super::drop::{hertz_over_mass, places, stiffness, young};
use super::heading::{beside_the_law, commented, heading};
use super::law::{Code, Handoff, HandoffFile};
use super::numbers::{number, restitution};
use super::template::filled;

const CONSTANT: &str = "drop_lammps.in";
const VISCOELASTIC: &str = "drop_lammps_viscoelastic.in";

fn constant(handoff: &Handoff) -> HandoffFile {
    let (e, two_spheres) = (handoff.predicted().q50, handoff.restitution_of_two());
    let given = |tsuji: Tsuji, e: f64| {
        tsuji
            .input_for(e)
            .map_or("none".to_owned(), |input| format!("{input:.6}"))
    };
    let limited = rebound(share_for(e, End::Overlap), End::Force);
    let own = vec![
        "LAMMPS (pair_style granular, fix wall/gran granular) takes one e or damping a pair of types, whatever the speed or St".to_owned(),
        "hooke with damping velocity is right in every version, for this size: the damping in kg/s is for one effective mass".to_owned(),
        "tsuji before the version of 2 September 2026 lacks a factor sqrt(2) (LAMMPS, gran_sub_mod_damping.cpp); its polynomial is an".to_owned(),
        format!(
            "approximation anyway. For the e asked for it is given {} before and {} since (none: it cannot)",
            given(Tsuji::WithoutRootTwo, e),
            given(Tsuji::WithRootTwo, e)
        ),
        format!(
            "Given {} itself it would have made {} before and {} since",
            restitution(e),
            restitution(Tsuji::WithoutRootTwo.rebound(e)),
            restitution(Tsuji::WithRootTwo.rebound(e))
        ),
        "coeff_restitution takes e itself, for spheres of any size, and needs LAMMPS of April 2024 or later; not run here".to_owned(),
        format!("With limit_damping behind any of them the force never pulls, and e becomes {}", restitution(limited)),
        "Pairs of types without a pair_coeff of their own are mixed from both: give each pair its own".to_owned(),
    ];
    let mut places = places(handoff, CONSTANT, stiffness(handoff));
    places.extend([
        (
            "heading",
            commented("#", &heading(Code::Lammps, handoff, own))
                .trim_end()
                .to_owned(),
        ),
        ("mass", number(handoff.mass())),
        ("stiffness", number(stiffness(handoff))),
        ("young", number(young(handoff))),
        ("tsuji_plate_before", given(Tsuji::WithoutRootTwo, e)),
        ("tsuji_pair_before", given(Tsuji::WithoutRootTwo, two_spheres)),
        ("tsuji_plate_since", given(Tsuji::WithRootTwo, e)),
        ("tsuji_pair_since", given(Tsuji::WithRootTwo, two_spheres)),
    ]);
    HandoffFile {
        name: CONSTANT,
        text: filled(include_str!("templates/lammps.in"), &places),
    }
}

/// The dry contact of Brilliantov & Pöschel, whose e falls with the speed as the dry law's does; `None` wet.
fn viscoelastic(handoff: &Handoff) -> Option<HandoffFile> {
    let e = handoff.predicted().q50;
    if handoff.wetting.is_some() || e >= 1.0 {
        return None;
    }
    let (v, r, kappa) = (handoff.reference_speed, handoff.radius(), hertz_over_mass(handoff));
    let damping = viscoelastic_damping_for(e, End::Overlap);
    let contact = |speed: f64| viscoelastic_rebound(damping * (speed / v).powf(0.2), End::Overlap);
    // a = gamma v^(1/5) kappa^(-3/5) with gamma = eta sqrt(R)
    let eta = damping * kappa.powf(0.6) / (v.powf(0.2) * r.sqrt());
    // a goes as m_eff^(3/5) R_eff^(1/5)
    let of_two = damping * 0.5f64.powf(0.8);
    let mut own: Vec<String> = [
        "hertz with damping viscoelastic has an e that falls with the speed, as 1 - x + 0.6 x^2 - ... with x ~ v^(1/5), in every",
        "version. eta is such that the e of the law is met at the reference speed; elsewhere the contact has the higher powers of x",
        "that the law may lack. Two spheres have half the effective mass and radius, so that the same eta gives them another e:",
    ]
    .map(str::to_owned)
    .to_vec();
    own.extend(beside_the_law(handoff, &contact));
    let mut places = places(handoff, VISCOELASTIC, stiffness(handoff));
    places.extend([
        (
            "heading",
            commented("#", &heading(Code::Lammps, handoff, own))
                .trim_end()
                .to_owned(),
        ),
        ("hertz", number(kappa * handoff.mass() / r.sqrt())),
        ("eta", number(eta)),
        ("contact_pair", restitution(viscoelastic_rebound(of_two, End::Overlap))),
    ]);
    Some(HandoffFile {
        name: VISCOELASTIC,
        text: filled(include_str!("templates/lammps_viscoelastic.in"), &places),
    })
}

pub(super) fn files(handoff: &Handoff) -> Vec<HandoffFile> {
    let mut files = vec![constant(handoff)];
    files.extend(viscoelastic(handoff));
    files
}
