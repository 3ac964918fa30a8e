//! Writes the drop test for YADE: one damping ratio a pair, in a form that its versions agree on.

use super::contact::{rebound, share_for, End};
use super::deck::{deck, stiffness, young};
use super::law::{Handoff, HandoffFile};
use super::numbers::{number, restitution};

/// `betan` of Ip2_FrictMat_FrictMat_MindlinPhys that gives e.
///
/// Its damping coefficient is 2 betan √(m k_t) with the tangent stiffness k_t = (3/2) K √δ, so α = √6 betan, ζ = √(6/5) betan;
/// Law2_ScGeom_MindlinPhys_Mindlin lets the force not pull.
fn damping_ratio(e: f64) -> f64 {
    share_for(e, End::Force) * (5.0f64 / 6.0).sqrt()
}

pub(super) fn file(handoff: &Handoff) -> HandoffFile {
    let e = handoff.predicted().q50;
    let pulling = rebound(share_for(e, End::Force), End::Overlap);
    let dry = format!(
        "\n# Dry: versions after 2023.02a have vn, and en={}, vn={} is a contact whose e falls with the speed; not run here",
        restitution(e),
        number(handoff.reference_speed)
    );
    let own = vec![
        ("beta_plate", number(damping_ratio(e))),
        ("beta_pair", number(damping_ratio(handoff.restitution_of_two()))),
        ("pulling", restitution(pulling)),
        ("dry", if handoff.wetting.is_none() { dry } else { String::new() }),
        ("young", number(young(handoff))),
    ];
    let template = include_str!("templates/yade.py");
    deck("drop_yade.py", template, handoff, stiffness(handoff), own)
}
