//! Does all that `check` does with any scene and table: the input holds both, with a zero byte between.
#![no_main]

use wetcor::{findings::overview, report};
use wetcor_fuzz::Place;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some(at) = bytes.iter().position(|byte| *byte == 0) else {
        return;
    };
    let Ok(scene) = std::str::from_utf8(&bytes[..at]) else {
        return;
    };
    let Some(place) = Place::of(scene) else { return };
    let Ok(table) = place.read(&bytes[at + 1..]) else {
        return;
    };
    let used = table.runs.len() + table.screened.iter().map(|s| s.runs).sum::<usize>();
    assert_eq!(used, table.rows);
    let overview = overview::find(&place.scene, &table);
    let json = report::json::text(&overview).expect("any overview can be written");
    // a range is whole or absent, and every number of it is finite
    assert!(!json.contains("[null") && !json.contains("null]"), "{json}");
    let text = report::markdown::overview_text(&overview);
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
});
