//! Holds that names, checks and modules of the pages are those of the program.

use std::collections::BTreeSet;
use std::path::Path;

use super::{assert_none, in_repository, pages, read, rows, spans};

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
fn unknown_names(text: &str, known: &BTreeSet<&str>) -> Vec<String> {
    let is_name = |span: &&str| {
        span.contains('_')
            && span.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && span.starts_with(|c: char| c.is_ascii_lowercase())
    };
    let names: BTreeSet<&str> = spans(text).into_iter().filter(is_name).collect();
    let unknown = names.into_iter().filter(|name| !known.contains(name));
    unknown.map(str::to_owned).collect()
}

#[test]
fn every_name_is_one_of_the_program() {
    let known = sources(&in_repository("src")) + &read("docs/findings.schema.json") + &read("docs/scene.md");
    let known = known
        .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .collect();
    for page in pages() {
        assert_none(&unknown_names(&page.text, &known), &page.path);
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

/// Checks that the page of verdicts does not name, and names on it that are no check.
fn unlike_the_checks(page: &str, listed: &[(String, bool)]) -> Vec<String> {
    let part = page.split("## What forbids quoting").nth(1).unwrap_or_default();
    let part = part.split("**Units.**").next().unwrap_or_default();
    let mut named: BTreeSet<&str> = spans(part).into_iter().collect();
    named.retain(|name| !["remarks", "findings.json"].contains(name));
    let listed: BTreeSet<&str> = listed.iter().map(|(code, _)| code.as_str()).collect();
    let differ = listed.symmetric_difference(&named);
    differ.map(|name| (*name).to_owned()).collect()
}

/// Checks that forbid quoting, though the page says that they only inform.
fn milder_than_the_checks(page: &str, listed: &[(String, bool)]) -> Vec<String> {
    let informs = page
        .split("A check that only informs, since no main number rests on it:")
        .nth(1);
    let informs = spans(informs.unwrap_or_default());
    let strict = listed
        .iter()
        .filter(|(code, gates)| *gates && informs.contains(&code.as_str()));
    strict.map(|(code, _)| code.clone()).collect()
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
    let part = page
        .split("## Where things are")
        .nth(1)
        .and_then(|part| part.split("## ").next());
    let told = rows(part.expect("the section"));
    assert!(told.len() > 10);
    assert_eq!(told, modules_of_the_crate());
}
