//! Attacks with names, which reach folders, pictures and tables; `transcripts` attack with texts.

use crate::common::scenes::PTFE;
use crate::common::{contents, entries, Folder, Says};
use std::path::PathBuf;

use super::attack::attack;

/// The plain example with a particle for each of these names, every one with the same runs, and little sampling.
fn with_particles(names: &[&str]) -> Folder {
    let place = Folder::plain();
    let runs = place.read("runs.csv");
    let (header, rows) = runs.split_once('\n').expect("a header");
    let of_all = |row: &str| -> String { names.iter().map(|name| row.replacen("PTFE", name, 1) + "\n").collect() };
    let rows: String = rows.lines().map(of_all).collect();
    place.write("runs.csv", format!("{header}\n{rows}"));
    // a string of TOML takes the escapes of JSON
    let quoted = |name: &str| serde_json::Value::from(name).to_string();
    let of = |name: &&str| format!("[particles.{}]\ndensity_kg_m3 = 2150\nroughness_um = 5\n", quoted(name));
    let all: String = names.iter().map(of).collect();
    place.replace("scene.toml", PTFE, &all);
    assert!(place.read("scene.toml").contains(&all));
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 50\ndraws = 50\n[bootstrap]\nreplicates = 100");
    place
}

#[test]
fn d11_names_stay_inside_the_folder_the_pictures_and_the_tables() {
    let names = ["..", "con", "_a_", "__b__", "שלום", "a\u{3164}", "x_{y}"].map(|name| name.replace(['{', '}'], ""));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let place = with_particles(&names);
    let stages = "least_squares,bootstrap,posterior,figures";
    let outcome = attack(&place, &format!("fit scene.toml --out o --stages {stages}"));
    outcome.assert_mannered("odd names");
    assert!(matches!(outcome.status, Some(0 | 1)), "{outcome:?}");
    assert_eq!(entries(place.path()), ["o", "runs.csv", "scene.toml"]);
    let path = |path: PathBuf| path.to_str().expect("a plain path").to_owned();
    let found: Vec<String> = contents(&place.join("o")).into_keys().map(path).collect();
    let mut pictures = 0;
    for name in &found {
        if name.starts_with("figures/") {
            let text = place.read(&format!("o/{name}"));
            let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
            let known = "svg g rect line path circle text tspan polyline polygon defs clipPath";
            let mut elements = document.descendants().filter(roxmltree::Node::is_element);
            let odd = elements.find(|node| !known.split(' ').any(|known| known == node.tag_name().name()));
            assert!(odd.is_none(), "{name}: {odd:?}");
            pictures += 1;
        } else if name.starts_with("draws/draws.zarr/") {
            let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_');
            assert!(name.chars().all(is_plain) && !name.contains(".."), "{name}");
        }
    }
    assert!(pictures > 14, "{pictures}");
    let page = place.read("o/report.md");
    page.says("| \\_a\\_ |");
    page.says("| \\_\\_b\\_\\_ |");
    assert!(page.contains("a\\u{3164}") && !page.contains('\u{3164}'));
}
