//! The whole way: frames of falling spheres, rendered from known parameters, to the parameters.

#[path = "render/campaign.rs"]
mod made;

use crate::common::{seed_of, Folder, Says};

/// The halves are held by themselves: frames to runs in `track`, runs to parameters in `main_numbers`.
#[test]
#[ignore = "slow: renders 2,400 frames"]
fn frames_go_to_parameters() {
    let place = Folder::new();
    let runs = made::write(place.path(), seed_of("frames_go_to_parameters"));
    let told = place.succeed("track recordings.csv --out runs.csv --report tracked");
    told.begins(&format!("{runs} recordings: {runs} runs, "));
    told.says("; 0 left out");
    let (status, _, stderr) = place.run("fit scene.toml --out out --stages least_squares,posterior");
    assert!(matches!(status, Some(0 | 1)), "{stderr}");
    let findings = place.json("out/findings.json");
    let estimates = findings["estimates"].as_array().expect("estimates").iter();
    let parameters: Vec<&serde_json::Value> = estimates.filter(|row| row["main"] == true).collect();
    for (name, truth) in [("dry_k", 0.183), ("lubrication_log", 1.9), ("inertial_prefactor", 0.45)] {
        let of = parameters.iter().find(|of| of["quantity"] == name);
        let of = of.unwrap_or_else(|| panic!("{name} is told"));
        let end = |place: usize| of["interval"][place].as_f64().expect("a number");
        assert!(end(0) < truth && truth < end(1), "{name}: {of}");
    }
}
