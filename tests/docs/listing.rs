//! Holds that no page is too long, that each asks and answers, and that the README lists it.

use super::{pages, read, rows, wrong, Page, WRITTEN_BY_A_TEST};

/// Words as `wc -w` counts them.
fn too_long(page: &Page) -> Option<String> {
    let most = if page.path == "README.md" { 700 } else { 900 };
    let words = page.text.split_whitespace().count();
    (words > most).then(|| format!("{}: {words} words, at most {most}", page.path))
}

#[test]
fn no_page_is_too_long() {
    let ours = pages().into_iter().filter(|page| page.path != WRITTEN_BY_A_TEST);
    let found: Vec<String> = ours.filter_map(|page| too_long(&page)).collect();
    assert!(found.is_empty(), "{}", wrong(&found));
    let of_words = |path: &str, words: usize| Page {
        path: path.to_owned(),
        text: "word ".repeat(words),
    };
    assert!(too_long(&of_words("README.md", 701)).is_some() && too_long(&of_words("README.md", 700)).is_none());
    assert!(too_long(&of_words("docs/any.md", 901)).is_some());
}

/// Whether a page asks, and answers in the sentence below: what is wrong with that.
fn unanswered(page: &Page) -> Option<String> {
    let mut parts = page.text.split("\n\n");
    let question = parts.next().unwrap_or_default();
    let answer = parts.next().unwrap_or_default();
    let asks = question.starts_with("# ") && question.contains('?');
    let answers = answer.starts_with(|c: char| c.is_alphabetic() || c == '`') && !answer.contains(". ");
    (!(asks && answers)).then(|| format!("{}: {question} {answer}", page.path))
}

#[test]
fn a_page_asks_and_answers_in_a_sentence() {
    let ours = pages()
        .into_iter()
        .skip(1)
        .filter(|page| page.path != WRITTEN_BY_A_TEST);
    let found: Vec<String> = ours.filter_map(|page| unanswered(&page)).collect();
    assert!(found.is_empty(), "{}", wrong(&found));
    let with = |text: &str| Page {
        path: String::new(),
        text: text.to_owned(),
    };
    assert!(unanswered(&with("# Why?\n\nBecause.\n\nMore. And more.")).is_none());
    assert!(unanswered(&with("# Why?\n\nFirst this. Then that.\n")).is_some());
    assert!(unanswered(&with("# Reasons\n\nBecause.\n")).is_some());
}

/// The pages of a README's list whose question is not the one that the page asks, and those it does not list.
fn not_listed(readme: &str, pages: &[Page]) -> Vec<String> {
    let listed: Vec<Vec<String>> = rows(readme).into_iter().filter(|row| row.len() == 2).collect();
    let ours = pages.iter().filter(|page| page.path.starts_with("docs/"));
    let is_listed = |page: &&Page| {
        let link = format!("({})", page.path);
        let mut rows = listed.iter().filter(|row| row[1].contains(&link));
        let head = page.text.lines().next().unwrap_or_default();
        rows.next()
            .is_some_and(|row| page.path == WRITTEN_BY_A_TEST || head == format!("# {}", row[0]))
    };
    ours.filter(|page| !is_listed(page))
        .map(|page| page.path.clone())
        .collect()
}

#[test]
fn the_readme_lists_every_page_by_its_question() {
    let (readme, pages) = (read("README.md"), pages());
    let found = not_listed(&readme, &pages);
    assert!(found.is_empty(), "{}", wrong(&found));
    let another = readme.replace("| May I quote these numbers? |", "| Is it so? |");
    assert_eq!(not_listed(&another, &pages), ["docs/verdict.md"]);
    let without: String = readme.lines().filter(|line| !line.contains("docs/speed.md")).collect();
    assert!(not_listed(&without, &pages).contains(&"docs/speed.md".to_owned()));
}
