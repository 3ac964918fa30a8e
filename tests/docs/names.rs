//! Holds that names, flags, paths, checks and modules of the pages are those of the program.

use std::collections::BTreeSet;
use std::path::Path;

use super::{assert_none, in_repository, pages, read, rows, spans};
use crate::common::{contents, wetcor};

/// What stands between backticks and is a flag, a word of several parts or a path, but not one of those that are known.
fn unknown(text: &str, known: &BTreeSet<&str>) -> Vec<String> {
    const FOLDERS: [&str; 7] = ["src/", "tests/", "docs/", "datasets/", "benches/", "reports/", ".ci/"];
    let is_unknown = |span: &&str| {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_name = span.contains('_') && span.chars().all(is_part);
        let is_path = FOLDERS.iter().any(|folder| span.starts_with(folder)) && !span.contains(' ');
        if span.starts_with("--") {
            !known.contains(span.split_whitespace().next().unwrap_or_default())
        } else if is_name && span.starts_with(|c: char| c.is_ascii_lowercase()) {
            !known.contains(span)
        } else {
            is_path && !in_repository(span).exists()
        }
    };
    let unknown = spans(text).into_iter().filter(is_unknown);
    unknown.map(str::to_owned).collect()
}

/// Words of the program and its description of `findings.json`, and flags of its verbs.
#[test]
fn every_name_flag_and_path_is_one_of_the_program() {
    let sources = Vec::from_iter(contents(&in_repository("src")).into_values()).concat();
    let sources = String::from_utf8_lossy(&sources).into_owned();
    let words = sources + &read("docs/findings.schema.json") + &read("docs/scene.md");
    let verbs = "track new fit check simulate predict handoff trade calibrate".split(' ');
    let helps: String = verbs.map(|verb| wetcor(Path::new("."), &[verb, "--help"]).1).collect();
    let words = words.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
    let flags = helps.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    let known: BTreeSet<&str> = words.chain(flags).collect();
    for page in pages() {
        assert_none(&unknown(&page.text, &known), &page.path);
    }
    let names = "`min_film_um`, `max_film`, `--exact-rows`, `--exact 3`, `src/main.rs`, `src/no_such.rs`";
    assert_eq!(unknown(names, &known), ["max_film", "--exact 3", "src/no_such.rs"]);
}

/// The codes of the checks, with whether a failure forbids quoting, as their list in the program has them.
fn listed_checks() -> Vec<(String, bool)> {
    let source = read("src/findings/remarks.rs");
    let entries = source.split(": Kind = ").skip(1);
    let entry = |text: &str| {
        let text = text.split(");").next().filter(|text| text.contains("At"))?;
        let mut quoted = text.split('"').skip(1).step_by(2);
        let code = quoted.find(|text| !text.contains(' '))?;
        Some((code.to_owned(), text.starts_with("forbids(")))
    };
    entries.filter_map(entry).collect()
}

/// What the page of verdicts says of checks.
fn part_of_checks(page: &str) -> &str {
    let part = page.split("## What forbids quoting").nth(1).unwrap_or_default();
    part.split("**Units.**").next().unwrap_or_default()
}

/// Checks that the page of verdicts does not name, and names on it that are no check.
fn unlike_the_checks(page: &str, listed: &[(String, bool)]) -> Vec<String> {
    let mut named: BTreeSet<&str> = spans(part_of_checks(page)).into_iter().collect();
    named.retain(|name| !["remarks", "findings.json"].contains(name));
    let listed: BTreeSet<&str> = listed.iter().map(|(code, _)| code.as_str()).collect();
    let differ = listed.symmetric_difference(&named);
    differ.map(|name| (*name).to_owned()).collect()
}

/// Checks that forbid quoting, though the page says that they only inform.
fn milder_than_the_checks(page: &str, listed: &[(String, bool)]) -> Vec<String> {
    let informs = "A check that only informs, since no main number rests on it:";
    let informs = page.split(informs).nth(1).and_then(|after| after.lines().next());
    let informs = spans(informs.unwrap_or_default());
    let mut strict = listed.to_vec();
    strict.retain(|(code, gates)| *gates && informs.contains(&code.as_str()));
    strict.into_iter().map(|(code, _)| code).collect()
}

#[test]
fn the_page_of_verdicts_names_every_check() {
    let (page, listed) = (read("docs/verdict.md"), listed_checks());
    assert!(listed.len() >= 30, "{listed:?}");
    assert_none(&unlike_the_checks(&page, &listed), "verdict.md");
    assert_none(&milder_than_the_checks(&page, &listed), "verdict.md");
    for (from, to, found) in [("`rhat`, ", "", "rhat"), ("`rhat`", "`rhat`, `mood`", "mood")] {
        assert_eq!(unlike_the_checks(&page.replace(from, to), &listed), [found]);
    }
    let milder = page.replace("rests on it: ", "rests on it: `rhat`, ");
    assert_eq!(milder_than_the_checks(&milder, &listed), ["rhat"]);
}

/// The modules of the crate's page in their order, each with its question.
fn modules_of_the_crate() -> Vec<Vec<String>> {
    let source = read("src/lib.rs").replace(['[', ']'], "");
    let page: Vec<&str> = source.lines().filter_map(|line| line.strip_prefix("//! ")).collect();
    let mut rows = rows(&page.join("\n").replace("|---|---|---|", "| --- |"));
    rows.iter_mut().for_each(|row| row.truncate(2));
    rows
}

#[test]
fn the_modules_stand_in_the_order_of_the_crate() {
    let page = read("docs/contributing.md");
    let part = page.split("## Where things are").nth(1).expect("the section");
    let told = rows(part.split("## ").next().expect("its text"));
    assert!(told.len() > 10);
    assert_eq!(told, modules_of_the_crate());
}
