//! Holds that rebounds of drops, taken as dry impacts of spheres, are not quoted: a law of another kind of impact.
//!
//! The measured rebounds are those of figure 5a of Gabbard et al. 2025, a table with the columns `We`, `cor` and `Bo`. It
//! is not part of this repository: `WETCOR_DROPS` names the file.

use crate::common::scenes::{scene_of, HEADER};
use crate::common::{Place, Told};

fn scene_text() -> String {
    scene_of("drops", &["[particles.drop]\ndensity_kg_m3 = 900\nroughness_um = 5\n"])
}

/// Surface tension over density, m³/s², of a silicone oil. It scales every speed and no conclusion.
const TENSION_OVER_DENSITY: f64 = 0.0207 / 900.0;

/// Diameter in mm and speed in m/s of a drop of these Bond and Weber numbers, which are of its radius.
fn diameter_and_speed(bond: f64, weber: f64) -> [f64; 2] {
    let radius = (bond * TENSION_OVER_DENSITY / 9.81).sqrt();
    [2e3 * radius, (weber * TENSION_OVER_DENSITY / radius).sqrt()]
}

#[test]
fn drops_that_rebound_are_not_quoted_as_spheres() {
    let Some(path) = std::env::var_os("WETCOR_DROPS") else {
        println!("SKIPPED: WETCOR_DROPS names no table of rebounding drops");
        return;
    };
    let text = std::fs::read_to_string(path).expect("WETCOR_DROPS is readable");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let place_of = |name: &str| header.iter().position(|own| *own == name).expect("the column");
    let [we, cor, bo] = ["We", "cor", "Bo"].map(place_of);
    let mut csv = HEADER.to_owned();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |place: usize| cells[place].parse::<f64>().expect("a number");
        let [diameter, speed] = diameter_and_speed(number(bo), number(we));
        csv.push_str(&format!("drop,dry,{diameter:.5},,{speed:.6},{:.5}\n", number(cor)));
    }
    let findings = Place::new(&scene_text()).fit_rows(&csv);
    assert_eq!(findings.counts.runs, 935);
    assert!(!findings.main.verdict.passed, "{:?}", findings.main.verdict);
    let failed = |code: &str| findings.forbids(code);
    assert!(failed("dry_law_holds"), "{:?}", findings.verdicts);
}
