//! Holds that scenes of the pages are read, and their keys known; `transcripts` read the table of a page.

use std::path::Path;

use super::{assert_none, fenced, pages, spans};
use crate::common::scenes::{scene_of, AK10, PTFE};

/// A scene that any key of the pages may stand in.
fn complete() -> String {
    scene_of("complete", &[PTFE, AK10, "surface_tension_mN_m = 20.1\n"])
}

/// Lays one table over another, table by table.
fn lay_over(under: &mut toml::Table, over: toml::Table) {
    for (key, value) in over {
        match (under.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(outer)) => lay_over(inner, outer),
            (_, value) => {
                under.insert(key, value);
            }
        }
    }
}

/// Why a part of a scene is not one; `None` if it is.
fn no_scene(part: &str) -> Option<String> {
    let mut scene: toml::Table = complete().parse().expect("a scene");
    match part.parse() {
        Ok(part) => lay_over(&mut scene, part),
        Err(error) => return Some(format!("{part}: {error}")),
    }
    let text = scene.to_string();
    let read = wetcor::scene::parse(&text, Path::new("scene.toml"), String::new());
    read.err().map(|error| format!("{part}: {error}"))
}

/// A part of a scene out of what stands between backticks: `[model] inertia = "none"`, or a key alone of one of its tables.
fn scene_part(span: &str) -> Option<(&str, &str)> {
    span.strip_prefix('[')?.split_once("] ")
}

/// Spans that name a key a scene has not, or give it a value it does not take.
fn unknown_scene_parts(text: &str) -> Vec<String> {
    let parts = spans(text).into_iter().filter_map(scene_part);
    let faults = parts.filter_map(|(table, key)| {
        if key.contains('=') {
            return no_scene(&format!("[{table}]\n{key}\n"));
        }
        let head = format!("[{table}]");
        let guide = wetcor::scene::guide();
        let section = guide.into_iter().find(|section| section.head == head);
        let is_known = |section: wetcor::scene::Section| section.keys.iter().any(|own| own.usual_name() == key);
        (!section.is_some_and(is_known)).then(|| format!("{head} {key}"))
    });
    faults.collect()
}

#[test]
fn every_part_of_a_scene_is_one() {
    let (mut blocks_tried, mut spans_tried) = (0, 0);
    for page in pages() {
        let (blocks, _) = fenced(&page.text);
        for (language, text) in blocks {
            if language == "toml" && !text.contains("[dependencies]") {
                blocks_tried += 1;
                assert_eq!(no_scene(&text), None, "{}", page.path);
            }
        }
        spans_tried += spans(&page.text).into_iter().filter_map(scene_part).count();
        assert_none(&unknown_scene_parts(&page.text), &page.path);
    }
    assert!(blocks_tried >= 4 && spans_tried >= 15, "{blocks_tried} {spans_tried}");
    assert!(no_scene("[model]\ninertia = \"best\"\n").is_some());
    assert!(no_scene("[data]\nfilm_sd_um = 10\n").is_none());
    for fault in [
        "`[model] inertias = \"cap\"`",
        "`[model] sticking = \"kept\"`",
        "`[priors] sigma_wett`",
        "`[modell] inertia`",
    ] {
        assert_eq!(unknown_scene_parts(fault).len(), 1, "{fault}");
    }
}
