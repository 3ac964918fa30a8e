//! Holds that names, checks, modules and paths of the pages are those of the program.

use std::collections::BTreeSet;
use std::path::Path;

use super::{in_repository, pages, read, rows, spans, wrong, WRITTEN_BY_A_TEST};

/// Every source file of the program.
fn sources(folder: &Path) -> String {
    let entries = std::fs::read_dir(folder).expect("a folder").filter_map(Result::ok);
    let texts = entries.map(|entry| {
        let path = entry.path();
        if path.is_dir() {
            sources(&path)
        } else {
            std::fs::read_to_string(path).unwrap_or_default()
        }
    });
    texts.collect()
}

/// Words of several parts between backticks that neither the program nor its description of `findings.json` holds.
fn unknown_names(text: &str, known: &str) -> Vec<String> {
    let is_name = |span: &&str| {
        span.contains('_')
            && span.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && span.starts_with(|c: char| c.is_ascii_lowercase())
    };
    let names: BTreeSet<&str> = spans(text).into_iter().filter(is_name).collect();
    let is_word = |name: &&str| {
        let mut places = known
            .match_indices(*name)
            .map(|(at, _)| (&known[..at], &known[at + name.len()..]));
        places.any(|(before, after)| {
            let inside = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_');
            !inside(before.chars().next_back()) && !inside(after.chars().next())
        })
    };
    names
        .into_iter()
        .filter(|name| !is_word(name))
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_name_is_one_of_the_program() {
    let known = sources(&in_repository("src")) + &read("docs/findings.schema.json") + &read(WRITTEN_BY_A_TEST);
    for page in pages() {
        let found = unknown_names(&page.text, &known);
        assert!(found.is_empty(), "{}: {}", page.path, wrong(&found));
    }
    assert_eq!(
        unknown_names("`min_film_um` and `min_film_uk`, `max_film`", &known),
        ["max_film", "min_film_uk"]
    );
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

/// What a page says of checks beside their list: codes it does not name, and cautions that are none.
fn unlike_the_checks(page: &str, listed: &[(String, bool)]) -> Vec<String> {
    let part = page.split("## What forbids quoting").nth(1).unwrap_or_default();
    let part = part.split("**Units.**").next().unwrap_or_default();
    let named: BTreeSet<&str> = spans(part).into_iter().collect();
    let only_cautions = part
        .split("A check that only informs, since no main number rests on it:")
        .nth(1)
        .unwrap_or_default();
    let cautions = spans(only_cautions);
    let missing = listed.iter().filter(|(code, _)| !named.contains(code.as_str()));
    let strict = listed
        .iter()
        .filter(|(code, gates)| *gates && cautions.contains(&code.as_str()));
    let unknown = named.iter().filter(|name| {
        let file = ["remarks", "findings.json"].contains(*name);
        !file && !listed.iter().any(|(code, _)| code == *name)
    });
    let unknown = unknown.map(|name| format!("{name} is no check"));
    missing
        .chain(strict)
        .map(|(code, _)| code.clone())
        .chain(unknown)
        .collect()
}

#[test]
fn the_page_of_verdicts_names_every_check() {
    let (page, listed) = (read("docs/verdict.md"), listed_checks());
    assert!(listed.len() >= 30, "{listed:?}");
    let found = unlike_the_checks(&page, &listed);
    assert!(found.is_empty(), "{}", wrong(&found));
    assert_eq!(unlike_the_checks(&page.replace("`rhat`, ", ""), &listed), ["rhat"]);
    let milder = page.replace("rests on it: ", "rests on it: `rhat`, ");
    assert_eq!(unlike_the_checks(&milder, &listed), ["rhat"]);
    assert_eq!(
        unlike_the_checks(&page.replace("`rhat`", "`rhat`, `mood`"), &listed),
        ["mood is no check"]
    );
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
    let part = page
        .split("## Where things are")
        .nth(1)
        .and_then(|part| part.split("## ").next());
    let told = rows(part.expect("the section"));
    assert!(told.len() > 10);
    assert_eq!(told, modules_of_the_crate());
}

/// Paths between backticks that are not there.
fn missing_paths(text: &str) -> Vec<String> {
    const FOLDERS: [&str; 7] = ["src/", "tests/", "docs/", "datasets/", "benches/", "reports/", ".ci/"];
    let paths = spans(text)
        .into_iter()
        .filter(|span| FOLDERS.iter().any(|folder| span.starts_with(folder)) && !span.contains(' '));
    paths
        .filter(|path| !in_repository(path).exists())
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_path_is_there() {
    for page in pages() {
        let found = missing_paths(&page.text);
        assert!(found.is_empty(), "{}: {}", page.path, wrong(&found));
    }
    assert_eq!(missing_paths("`src/main.rs`, `src/no_such.rs`"), ["src/no_such.rs"]);
}
