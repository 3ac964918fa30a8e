//! Holds the whole of `check` to finite numbers, valid JSON, an exit status and a bounded time.

use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::sample::select;
use wetcor::findings::{self, overview};
use wetcor::report;

use super::scenes::{scene_lines, scene_text};
use super::{assert_every_row_counted, hold, Folder};

/// Numbers a spreadsheet or a careless script may write.
fn any_number() -> impl Strategy<Value = String> {
    let special = "|NA|0|-0|1e-60|1e60|1e-61|5e-324|1.7976931348623157e308|nan|inf|-1|1e-12";
    prop_oneof![
        6 => (0.01..5.0).prop_map(|x: f64| format!("{x:.3}")),
        2 => (-59.0..59.0).prop_map(|x: f64| format!("{:e}", 10f64.powf(x))),
        1 => select(special.split('|').collect::<Vec<&str>>()).prop_map(str::to_owned),
    ]
}

/// A scene and a table that may be anything a pair of files with the right keys and columns can be.
fn any_pair() -> impl Strategy<Value = (String, String)> {
    let cell = any_number;
    let restitution = prop_oneof![4 => "0\\.[0-9]{1,3}", 1 => Just("0".to_owned()), 1 => cell()];
    let row = (any::<bool>(), cell(), cell(), cell(), restitution).prop_map(|(wet, diameter, film, speed, e)| {
        let liquid = if wet { "AK10" } else { "dry" };
        format!("PTFE,{liquid},{diameter},{film},{speed},{e}\n")
    });
    let rows = prop::collection::vec(row, 1..5);
    (scene_lines(), rows, 0u8..4).prop_map(|(lines, rows, from)| {
        // with all of the screens little is left
        let text = scene_text(&lines)
            .replacen("min_", "#min_", 2)
            .replacen("max_", "#max_", usize::from(from > 0));
        (
            text,
            format!(
                "particle,liquid,diameter_m,film_m,impact_speed_m_s,restitution\n{}",
                rows.concat()
            ),
        )
    })
}

#[test]
fn check_tells_of_any_scene_and_runs_in_finite_numbers() {
    let folder = Folder::new();
    let (told, name) = (
        std::cell::Cell::new(0),
        "check_tells_of_any_scene_and_runs_in_finite_numbers",
    );
    hold(name, 700, any_pair(), |(scene, table)| {
        let started = Instant::now();
        let Ok(scene) = folder.scene(&scene) else { return };
        let Ok(table) = folder.runs(&scene, &table) else { return };
        assert_every_row_counted(&table);
        let overview = overview::summarise_runs(&scene, &table, &findings::fit_least_squares(&scene, &table, 1, false));
        let json = report::json::text(&overview).expect("any overview can be written");
        let value: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
        assert_eq!(value["runs"], table.rows);
        // a range is absent as a whole, or both its ends are numbers
        assert!(!json.contains("[null") && !json.contains("null]"), "{json}");
        let text = report::overview(&overview).expect("an overview");
        assert!(
            !text
                .split_whitespace()
                .any(|word| matches!(word, "NaN" | "inf" | "-inf")),
            "{text}"
        );
        assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
        told.set(told.get() + 1);
    });
    assert!(told.get() > 50, "{told:?}");
}
