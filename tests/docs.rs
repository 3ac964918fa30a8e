//! Holds the README and the pages of `docs/` to their word: their links, scenes, commands, code and figures.
//!
//! What looks for faults in a text is tried on planted ones, too; figures are compared with what the program prints or a
//! report holds.

mod commands;
mod links;
mod names;
mod printed;
mod reports;
mod scenes;
mod snippets;

use crate::common::{entries, in_project as in_repository, read_in_project as read};

/// A page, by its path from the root of the repository.
struct Page {
    path: String,
    text: String,
}

/// The README and every page of `docs/`, in the order of their names.
fn pages() -> Vec<Page> {
    let mut paths = entries(&in_repository("docs"));
    paths.retain(|name| name.ends_with(".md"));
    let paths = paths.into_iter().map(|name| format!("docs/{name}"));
    let page = |path: String| Page {
        text: read(&path),
        path,
    };
    std::iter::once("README.md".to_owned()).chain(paths).map(page).collect()
}

/// What stands between fences, with the language of each; and the lines outside of them.
fn fenced(text: &str) -> (Vec<(String, String)>, Vec<&str>) {
    let (mut blocks, mut outside, mut open) = (vec![], vec![], false);
    for line in text.lines() {
        match (line.strip_prefix("```"), open) {
            (Some(_), true) => open = false,
            (Some(language), false) => {
                blocks.push((language.to_owned(), String::new()));
                open = true;
            }
            (None, true) => {
                let (_, block) = blocks.last_mut().expect("a block is open");
                block.push_str(line);
                block.push('\n');
            }
            (None, false) => outside.push(line),
        }
    }
    (blocks, outside)
}

/// The text of the first fenced block of a language.
fn block(text: &str, language: &str) -> String {
    let (blocks, _) = fenced(text);
    let found = blocks.into_iter().find(|(its, _)| its == language);
    found.unwrap_or_else(|| panic!("no block of {language}")).1
}

/// What stands between backticks on the lines outside of fences.
fn spans(text: &str) -> Vec<&str> {
    let (_, outside) = fenced(text);
    let lines = outside.into_iter().filter(|line| !line.starts_with("    "));
    lines.flat_map(|line| line.split('`').skip(1).step_by(2)).collect()
}

/// The cells of every row of the tables of a text, without those of heads and rules.
fn rows(text: &str) -> Vec<Vec<String>> {
    let lines: Vec<&str> = text.lines().collect();
    let is_rule = |line: &str| line.starts_with("| --") || line.starts_with("|--");
    let rows = lines.iter().enumerate().filter(|(i, line)| {
        let is_head = lines.get(i + 1).is_some_and(|next| is_rule(next));
        line.starts_with('|') && !is_rule(line) && !is_head
    });
    let cells = |line: &str| {
        let cells = line.trim_matches('|').split('|');
        cells.map(|cell| cell.trim().to_owned()).collect()
    };
    rows.map(|(_, line)| cells(line)).collect()
}

/// The numbers in a text.
fn numbers_in(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || c == '.'));
    words.filter_map(|word| word.parse().ok()).collect()
}

/// Holds that a page has none of what was looked for.
#[track_caller]
fn assert_none(found: &[String], page: &str) {
    assert!(found.is_empty(), "{page}: {}", found.join("\n"));
}
