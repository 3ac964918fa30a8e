//! Attacks with names and texts.

use crate::common::scenes::PTFE;
use crate::common::{contents, entries, Folder, Says};
use std::collections::BTreeSet;
use std::path::PathBuf;

use super::attack::attack;

/// Clears a terminal, ends a line, turns the direction, hides, and is markup wherever it goes.
const HOSTILE: &str =
    "\u{1b}[2J\u{1b}]0;x\u{7}\r\n\u{202e}<img src=x onerror=alert(1)> ![a](b) `c` **d** | \u{200b}\u{9b}0m\u{2028}&lt;";

/// The same for a string of a TOML file, which takes the escapes of JSON.
fn toml(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// The plain example with a particle for each of these names, every one with the same runs, and little sampling.
fn with_particles(names: &[&str]) -> Folder {
    let place = Folder::plain();
    let runs = place.read("runs.csv");
    let (header, rows) = runs.split_once('\n').expect("a header");
    let of_all = |row: &str| -> String { names.iter().map(|name| row.replacen("PTFE", name, 1) + "\n").collect() };
    let rows: String = rows.lines().map(of_all).collect();
    place.write("runs.csv", format!("{header}\n{rows}"));
    let of = |name: &&str| format!("[particles.{}]\ndensity_kg_m3 = 2150\nroughness_um = 5\n", toml(name));
    let all: String = names.iter().map(of).collect();
    place.replace("scene.toml", PTFE, &all);
    assert!(place.read("scene.toml").contains(&all));
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 50\ndraws = 50\n[bootstrap]\nreplicates = 100");
    place
}

/// Every value and key of the scene, and every cell of the header and the first row, one at a time.
#[test]
fn d11_no_value_that_is_refused_moves_a_terminal() {
    let plain = Folder::plain();
    let (scene, runs) = (plain.read("scene.toml"), plain.read("runs.csv"));
    let hostile = toml(HOSTILE);
    let mut mutants = vec![];
    for line in scene.lines() {
        let with = |new: String| {
            let changed = scene.replacen(&format!("{line}\n"), &format!("{new}\n"), 1);
            (changed, runs.clone())
        };
        if let Some((key, value)) = line.split_once(" = ") {
            mutants.push(with(format!("{key} = {hostile}")));
            mutants.push(with(format!("{hostile} = {value}")));
            // not as TOML has it
            mutants.push(with(format!("{key} = {HOSTILE}")));
        } else if let Some(name) = line.strip_prefix('[') {
            mutants.push(with(format!("[{}.{hostile}]", name.trim_end_matches(']'))));
            mutants.push(with(format!("[{HOSTILE}]")));
        }
    }
    let cell = HOSTILE.replace(['\r', '\n'], "").replace('"', "");
    for row in 0..2 {
        for column in 0..7 {
            let line = runs.lines().nth(row).expect("a line");
            let mut cells: Vec<&str> = line.split(',').collect();
            cells[column] = &cell;
            mutants.push((scene.clone(), runs.replacen(line, &cells.join(","), 1)));
        }
    }
    assert!(mutants.len() > 35, "{}", mutants.len());
    let mut refused = 0;
    for (scene, runs) in mutants {
        plain.write("scene.toml", &scene);
        plain.write("runs.csv", &runs);
        let outcome = attack(&plain, "check scene.toml");
        outcome.assert_mannered(&scene);
        refused += usize::from(outcome.status == Some(2));
    }
    assert!(refused > 30, "{refused}");
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
    assert_figures_are_linked(&page, &found);
}

/// Every figure is linked, each by an address of its own.
fn assert_figures_are_linked(page: &str, found: &[String]) {
    let after = page.split("](figures/").skip(1);
    let linked: BTreeSet<&str> = after.filter_map(|rest| rest.split(')').next()).collect();
    assert!(linked.iter().all(|address| address.is_ascii()), "{linked:?}");
    let figures = found.iter().filter(|name| name.starts_with("figures/")).count();
    assert_eq!(linked.len(), figures, "{linked:?}");
}
