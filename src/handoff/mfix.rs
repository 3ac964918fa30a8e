//! Writes the lines for MFiX-DEM, which is not run here.

use super::contact::{rebound, share_for, End};
use super::drop::{places, stiffness};
use super::heading::{commented, heading};
use super::law::{Code, Handoff, HandoffFile};
use super::numbers::{number, restitution};
use super::template::filled;

/// Name of the file.
const NAME: &str = "restitution_mfix.dat";

/// ζ of a Hertz contact in MFiX over that of its linear one for the same number: 2/√5, as it takes α = 2 ζ for both.
fn hertz_over_linear() -> f64 {
    2.0 / 5f64.sqrt()
}

/// What HERTZIAN is to be given for e; `None` where no number above 0 does.
fn hertz_input(e: f64) -> Option<f64> {
    let input = rebound(share_for(e, End::Overlap) / hertz_over_linear(), End::Overlap);
    (input > 0.0).then_some(input)
}

pub(super) fn file(handoff: &Handoff) -> HandoffFile {
    let (e, two_spheres) = (handoff.predicted().q50, handoff.restitution_of_two());
    let got = rebound(share_for(e, End::Overlap) * hertz_over_linear(), End::Overlap);
    let given = |e: f64| hertz_input(e).map_or("none".to_owned(), |input| format!("{input:.6}"));
    let own = vec![
        "NOT RUN by wetcor's tests. Read in its source (MFiX 21.3.2, check_solids_dem.f, calc_force_dem.f, calc_collision_wall_mod.f):".to_owned(),
        "one e a pair of phases, whatever the speed or St, turned once into a damping for the phases' own masses. A dependence on either".to_owned(),
        "means a changed copy of these. The damping may pull at the end, so that the linear model LSD gives the e asked for as it is.".to_owned(),
        "HERTZIAN takes the linear model's formula for its damping, where a Hertz contact needs sqrt(5)/2 times as much:".to_owned(),
        format!("given {} it would make {}; given {} it makes the e asked for", restitution(e), restitution(got), given(e)),
    ];
    let mut places = places(handoff, NAME, stiffness(handoff));
    places.extend([
        (
            "heading",
            commented("!", &heading(Code::Mfix, handoff, own)).trim_end().to_owned(),
        ),
        ("speed_after", number(handoff.reference_speed * e)),
        ("stiffness", number(stiffness(handoff))),
        ("hertz_pair", given(two_spheres)),
        ("hertz_plate", given(e)),
    ]);
    HandoffFile {
        name: NAME,
        text: filled(include_str!("templates/mfix.dat"), &places),
    }
}
