//! Writes the drop test for YADE: one damping ratio a pair, in a form that its versions agree on.

use minijinja::context;

use super::contact::{rebound, share_for, End};
use super::deck::{deck, stiffness, young};
use super::law::{Handoff, HandoffFile};
use super::numbers::{number, restitution};
use crate::error::Error;

/// `betan` of Ip2_FrictMat_FrictMat_MindlinPhys that gives e.
///
/// Its damping coefficient is 2 betan √(m k_t) with the tangent stiffness k_t = (3/2) K √δ, so α = √6 betan, ζ = √(6/5) betan;
/// Law2_ScGeom_MindlinPhys_Mindlin lets the force not pull.
fn damping_ratio(e: f64) -> f64 {
    share_for(e, End::Force) * (5.0f64 / 6.0).sqrt()
}

pub(super) fn file(handoff: &Handoff) -> Result<HandoffFile, Error> {
    let e = handoff.predicted().q50;
    let pulling = rebound(share_for(e, End::Force), End::Overlap);
    let own = context! {
        beta_plate => number(damping_ratio(e)),
        beta_pair => number(damping_ratio(handoff.restitution_of_two())),
        pulling => restitution(pulling),
        dry => handoff.wet.is_none(),
        young => number(young(handoff)),
    };
    let template = include_str!("templates/yade.py");
    deck("drop_yade.py", template, handoff, stiffness(handoff), own)
}
