//! Holds that the runs of a table are those within the screens, none lost and none invented.

use proptest::prelude::*;
use proptest::sample::select;

use super::{assert_every_row_counted, hold, Folder};
use crate::common::scenes::HEADER;

/// One run in the usual units.
#[derive(Debug, Clone, Copy)]
struct Run {
    particle: &'static str,
    /// liquid, and film in µm
    wet: Option<(&'static str, f64)>,
    diameter: f64,
    speed: f64,
    restitution: f64,
}

prop_compose! {
    fn any_run()(
        particle in select(vec!["PTFE", "PE.2"]),
        wet in prop::option::weighted(0.7, (select(vec!["AK10", "M-50"]), select(vec![0.03f64, 0.06, 0.12, 0.6]))),
        diameter in select(vec![3.175f64, 4.762, 8.0]),
        speed in 0.01f64..5.0,
        restitution in prop_oneof![1 => Just(0.0f64), 4 => 0.001f64..1.1],
    ) -> Run {
        let rounded = |x: f64| (x * 1e4).round() / 1e4;
        Run {
            particle,
            wet: wet.map(|(liquid, ratio): (_, f64)| (liquid, (1e3 * ratio * diameter).round())),
            diameter,
            speed: rounded(speed),
            restitution: rounded(restitution),
        }
    }
}

const SCREENED: &str =
    "[data]\nruns = \"runs.csv\"\nmin_film_um = 200\nmax_film_ratio = 0.1\nmin_impact_speed_m_s = 0.05\n\
    max_impact_speed_m_s = 4\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n[particles.\"PE.2\"]\n\
    density_kg_m3 = 950\nroughness_um = 7\n[liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
    [liquids.M-50]\ndensity_kg_m3 = 965\nviscosity_mPa_s = 50\n";

#[test]
fn the_runs_of_a_table_are_those_within_the_screens() {
    let folder = Folder::new();
    let scene = folder.scene(SCREENED).expect("a good scene");
    let name = "the_runs_of_a_table_are_those_within_the_screens";
    hold(name, 1500, prop::collection::vec(any_run(), 1..30), |rows| {
        let line = |run: &Run| {
            let (liquid, film) = run
                .wet
                .map_or(("dry", String::new()), |(liquid, film)| (liquid, film.to_string()));
            let (particle, diameter, speed, e) = (run.particle, run.diameter, run.speed, run.restitution);
            format!("{particle},{liquid},{diameter},{film},{speed},{e}\n")
        };
        let text = HEADER.to_owned() + &rows.iter().map(line).collect::<String>();
        let table = folder.runs(&scene, &text);
        let table = table.unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_every_row_counted(&table);
        let is_kept = |run: &&Run| {
            let film = run
                .wet
                .is_none_or(|(_, film)| film >= 200.0 && film / run.diameter <= 100.0);
            (0.05..=4.0).contains(&run.speed) && film
        };
        let mut expected: Vec<u64> = rows
            .iter()
            .filter(is_kept)
            .map(|run| run.restitution.to_bits())
            .collect();
        let mut found: Vec<u64> = table.runs.restitution.iter().map(|e| e.to_bits()).collect();
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, expected);
    });
}
