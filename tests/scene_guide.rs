//! Holds the page of all keys, and what `wetcor help scene` prints, to what the reader reads by.

use crate::common::{kept, wetcor_here, Says};

/// Every name in a cell of the first column of a page's tables.
fn names(page: &str) -> Vec<String> {
    let rows = page.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| row.split('`').nth(1).unwrap_or_default().to_owned())
        .collect()
}

#[test]
fn the_page_is_what_the_reader_reads_by() {
    let made = wetcor::scene::markdown();
    let page = kept("docs/scene.md", &made);
    assert_eq!(
        page, made,
        "UPDATE_EXPECTED=1 cargo test --release --test all scene_guide:: writes it anew"
    );
    let told: usize = wetcor::scene::guide().iter().map(|section| section.keys.len()).sum();
    assert_eq!(names(&page).len(), told + wetcor::scene::RunColumn::ALL.len());
}

#[test]
fn help_tells_every_key_in_every_unit() {
    let help = |words: &[&str]| {
        let (status, out, _) = wetcor_here(&[&["help"], words].concat());
        (status, out)
    };
    let (status, text) = help(&["scene"]);
    assert_eq!(status, Some(0));
    for section in wetcor::scene::guide() {
        assert!(text.contains(section.head), "{}", section.head);
        for key in section.keys {
            text.says(&format!("\n  {} = {}\n", key.usual_name(), key.example));
            assert!(
                key.dimension.units().iter().all(|unit| text.contains(unit.suffix)),
                "{}",
                key.base
            );
        }
    }
    // of a command, as its own --help; of nothing, that of all; of what is none, a refusal
    assert!(help(&["fit"]).1.contains("--accuracy"));
    assert!(help(&[]).1.contains("simulate"));
    assert_eq!(help(&["nothing"]), (Some(2), String::new()));
}
