//! Writes the drop test for MercuryDPM, which is not run here, and dry the input of its contact with the dry law.

use super::contact::{rebound, share_for, viscoelastic_damping_for, viscoelastic_rebound, End};
use super::drop::{hertz_over_mass, places, stiffness};
use super::heading::{beside_the_law, commented, heading};
use super::law::{Code, Handoff, HandoffFile};
use super::numbers::{number, restitution};
use super::template::filled;

/// Name of the file.
const NAME: &str = "drop_mercurydpm.cpp";

/// What HertzianBSHPViscoelastic needs for the dry law; nothing wet.
fn dry_contact(handoff: &Handoff) -> Vec<String> {
    let (e, v) = (handoff.predicted().q50, handoff.reference_speed);
    if handoff.wetting.is_some() || e >= 1.0 {
        return Vec::new();
    }
    let damping = viscoelastic_damping_for(e, End::Force);
    let contact = |speed: f64| viscoelastic_rebound(damping * (speed / v).powf(0.2), End::Force);
    // overlap and time of a contact of κ: (v²/κ)^(2/5), and that over v; a = (3/2) A over that time
    let time = (v * v / hertz_over_mass(handoff)).powf(0.4) / v;
    // (4/3) E* √R = κ m
    let modulus = 0.75 * hertz_over_mass(handoff) * handoff.mass() / handoff.radius().sqrt();
    let mut lines = vec![
        "Dry: HertzianBSHPViscoelasticSpecies has an e that falls with the speed, and its force never pulls. Met at the reference".to_owned(),
        format!(
            "speed by setEffectiveElasticModulus({}) Pa and setDissipation({}) s on a plate; A goes as E*^(-2/5). Integrated here:",
            number(modulus),
            number(damping * time / 1.5)
        ),
    ];
    lines.extend(beside_the_law(handoff, &contact));
    lines
}

pub(super) fn file(handoff: &Handoff) -> HandoffFile {
    let e = handoff.predicted().q50;
    // the damping set for twice the effective mass there is, by the formula below
    let share = share_for(e, End::Overlap) * 0.5f64.sqrt();
    let mut own = vec![
        "NOT COMPILED AND NOT RUN by wetcor's tests. Read in its source (MercuryDPM of July 2024, LinearViscoelasticNormalSpecies.cc,".to_owned(),
        "LinearViscoelasticInteraction.cc): one e a pair of species, whatever the speed or St; the damping may pull at the end, so".to_owned(),
        "that e is the one asked for with no correction. The mass to give is 2/(1/m1 + 1/m2): m for two equal spheres, 2 m on a plate.".to_owned(),
        format!(
            "With m on a plate the damping is too low there, and e would be {}. Species left to mix get the average of both dampings,",
            restitution(rebound(share, End::Overlap))
        ),
        "not of both e: set the mixed species. setConstantRestitution(true) makes e independent of the mass".to_owned(),
        "LiquidMigrationWilletViscous has a viscous force after the contact only, with its own shortest distance: it cannot take a film".to_owned(),
    ];
    own.extend(dry_contact(handoff));
    let mut places = places(handoff, NAME, stiffness(handoff));
    places.extend([
        (
            "heading",
            commented("//", &heading(Code::MercuryDpm, handoff, own))
                .trim_end()
                .to_owned(),
        ),
        ("mass", number(handoff.mass())),
        ("radius", number(handoff.radius())),
        ("stiffness", number(stiffness(handoff))),
    ]);
    HandoffFile {
        name: NAME,
        text: filled(include_str!("templates/mercurydpm.cpp"), &places),
    }
}
