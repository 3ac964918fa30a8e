//! Holds the two file readers and `check` to what must be true of any scene and any table of runs.
//!
//! Every property draws its inputs from a stream named after it, so that a run repeats; `fuzz/` looks further by hand.

mod checks;
mod scenes;
mod tables;

use std::path::Path;

use crate::common::{seed_of, Folder};
use proptest::prelude::*;
use proptest::sample::{select, Index};
use proptest::test_runner::{RngSeed, TestRunner};
use wetcor::error::Error;
use wetcor::runs::Table;
use wetcor::scene;

/// Draws so many inputs and shrinks the first that fails.
fn hold<S: Strategy>(property: &str, cases: u32, inputs: S, holds: impl Fn(S::Value)) {
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed_of(property)),
        max_shrink_iters: 2000,
        ..ProptestConfig::default()
    };
    let run = TestRunner::new(config).run(&inputs, |input| {
        holds(input);
        Ok(())
    });
    if let Err(failure) = run {
        panic!("{property}: {failure}");
    }
}

/// An error names its file first and is plain lines, each problem on its own.
fn assert_told(error: &Error, file: &str) -> String {
    let text = error.to_string();
    let first = text.split(": ").next().unwrap_or_default();
    assert!(first.ends_with(file), "{text}");
    for (index, line) in text.lines().enumerate() {
        assert!(!line.chars().any(char::is_control), "{text:?}");
        assert!(index == 0 || line.starts_with("  "), "{text:?}");
    }
    text
}

/// What a file may be sprinkled with; a name of no key, a number of no use, a character of no letter.
fn pieces() -> impl Strategy<Value = String> {
    let words = "[data]|[particles.PTFE]|[liquids.\"A K\"]|[[published]]|[priors]|runs|density_kg_m3|=|roughness_um\
        |viscosity_mPa_s|'|\"|\"\"\"|\n|\r\n|\r|,|{|}|[|]|#|1|-0.0|nan|inf|1e400|0x1F|1_000|true|2026-01-01\
        |\u{feff}|\u{a0}|\u{1b}[31m|\\u0007|é|𝛿|\u{2028}|particle|liquid|diameter_mm|film_um\
        |impact_speed_m_s|restitution|NA|dry|PTFE|;|\t| ";
    let piece =
        prop_oneof![8 => select(words.split('|').collect::<Vec<&str>>()).prop_map(str::to_owned), 1 => any::<String>()];
    prop::collection::vec(piece, 0..60).prop_map(|pieces| pieces.concat())
}

/// Pieces, or a good text with some of it replaced.
fn damaged(good: &'static str) -> impl Strategy<Value = String> {
    let cut = (any::<Index>(), 0usize..40, pieces()).prop_map(move |(at, length, piece)| {
        let chars: Vec<char> = good.chars().collect();
        let at = at.index(chars.len());
        let end = (at + length).min(chars.len());
        let part = |range: &[char]| range.iter().collect::<String>();
        format!("{}{piece}{}", part(&chars[..at]), part(&chars[end..]))
    });
    // a slip of the hand, which the reader cannot always see
    let digit = (any::<Index>(), select((0..10).collect::<Vec<u8>>())).prop_map(move |(which, digit)| {
        let digits: Vec<usize> = good
            .match_indices(|c: char| c.is_ascii_digit())
            .map(|(at, _)| at)
            .collect();
        let at = digits[which.index(digits.len())];
        format!("{}{digit}{}", &good[..at], &good[at + 1..])
    });
    prop_oneof![pieces(), cut, digit]
}

const SCENE: &str = include_str!("data/good/plain/scene.toml");
const RUNS: &str = include_str!("data/good/plain/runs.csv");

#[test]
fn any_text_is_a_scene_or_an_error_in_plain_lines() {
    let refused = std::cell::Cell::new(0);
    let name = "any_text_is_a_scene_or_an_error_in_plain_lines";
    hold(name, 4000, damaged(SCENE), |text| {
        if let Err(error) = scene::parse(&text, Path::new("scene.toml"), String::new()) {
            assert_told(&error, "scene.toml");
            refused.set(refused.get() + 1);
        }
    });
    assert!(refused.get() > 2000, "{refused:?}");
}

#[test]
fn any_text_is_a_table_of_runs_or_an_error_in_plain_lines() {
    let folder = Folder::new();
    let scene = folder.scene(SCENE).expect("a good scene");
    let read = std::cell::Cell::new(0);
    let name = "any_text_is_a_table_of_runs_or_an_error_in_plain_lines";
    hold(name, 3000, damaged(RUNS), |text| match folder.runs(&scene, &text) {
        Err(error) => {
            assert_told(&error, "runs.csv");
        }
        Ok(table) => {
            read.set(read.get() + 1);
            assert_every_row_counted(&table);
        }
    });
    assert!(read.get() > 100, "{read:?}");
}

fn assert_every_row_counted(table: &Table) {
    let screened: usize = table.screened.iter().map(|screened| screened.runs).sum();
    assert_eq!(table.runs.len() + screened, table.rows);
    let grouped: usize = table.runs.series.iter().map(|series| series.runs().len()).sum();
    let dry: usize = table
        .runs
        .dry
        .iter()
        .map(|group| group.rebounds.len() + group.stuck.len())
        .sum();
    assert_eq!(grouped + dry, table.runs.len());
}
