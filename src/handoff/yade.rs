//! Writes the drop test for YADE: one damping ratio a pair, in a form that its versions agree on.

use super::contact::{rebound, share_for, End};
use super::drop::{places, stiffness, young};
use super::heading::{commented, heading};
use super::law::{Code, Handoff, HandoffFile};
use super::numbers::{number, restitution};
use super::template::filled;

/// Name of the file.
const NAME: &str = "drop_yade.py";

/// `betan` of Ip2_FrictMat_FrictMat_MindlinPhys that gives e.
///
/// Its damping coefficient is 2 betan √(m k_t) with the tangent stiffness k_t = (3/2) K √δ, so α = √6 betan, ζ = √(6/5) betan;
/// Law2_ScGeom_MindlinPhys_Mindlin lets the force not pull.
fn damping_ratio(e: f64) -> f64 {
    share_for(e, End::Force) * (5.0f64 / 6.0).sqrt()
}

pub(super) fn file(handoff: &Handoff) -> HandoffFile {
    let (e, two_spheres) = (handoff.predicted().q50, handoff.restitution_of_two());
    let pulling = rebound(share_for(e, End::Force), End::Overlap);
    let mut own = vec![
        "YADE takes one e a pair of materials, whatever the speed or St, through a MatchMaker; a plain number is for every pair".to_owned(),
        "Hertz-Mindlin contact: the force never pulls (Ip2_FrictMat_FrictMat_MindlinPhys, Law2_ScGeom_MindlinPhys_Mindlin). betan, in".to_owned(),
        format!(
            "closed form, is {} for the e asked for; the formula for a contact that may pull would give {} for it",
            number(damping_ratio(e)),
            restitution(pulling)
        ),
        format!(
            "en={} in its place is turned into betan by an approximation, which in 2023.02a is right to 4e-4 for e of 0.05 to 0.925, and",
            restitution(e)
        ),
        "makes 0.948 of 0.95 and 0.969 of 0.975. Give en or betan, not both".to_owned(),
        "ViscElMat with en takes the ARITHMETIC MEAN of both materials' en as that of the pair: give pairs there by a MatchMaker too".to_owned(),
    ];
    if handoff.wetting.is_none() {
        own.push(format!(
            "Dry: versions after 2023.02a have vn, and en={}, vn={} is a contact whose e falls with the speed; not run here",
            restitution(e),
            number(handoff.reference_speed)
        ));
    }
    let mut places = places(handoff, NAME, stiffness(handoff));
    places.extend([
        (
            "heading",
            commented("#", &heading(Code::Yade, handoff, own)).trim_end().to_owned(),
        ),
        ("beta_plate", number(damping_ratio(e))),
        ("beta_pair", number(damping_ratio(two_spheres))),
        ("radius", number(handoff.radius())),
        ("young", number(young(handoff))),
    ]);
    HandoffFile {
        name: NAME,
        text: filled(include_str!("templates/yade.py"), &places),
    }
}
