//! Holds code in other languages against the code that is run.

use std::collections::BTreeSet;

use super::{block, read, wrong};

/// Lines of a snippet of Python that call what the script held by CI does not.
fn unlike_the_script(snippet: &str, script: &str) -> Vec<String> {
    let is_held = |line: &&str| {
        let code = line.split('#').next().unwrap_or_default().trim();
        match code.split_once("az.") {
            // the path of the store is put together there
            Some((_, call)) => {
                let name = call.split('(').next().unwrap_or_default();
                script.contains(&format!("az.{name}("))
            }
            None => code.is_empty() || script.lines().any(|own| own == code),
        }
    };
    snippet
        .lines()
        .filter(|line| !is_held(line))
        .map(str::to_owned)
        .collect()
}

#[test]
fn the_draws_are_opened_as_ci_opens_them() {
    let (page, script) = (read("docs/posterior.md"), read("tests/arviz_opens_draws.py"));
    let snippet = block(&page, "python");
    let found = unlike_the_script(&snippet, &script);
    assert!(found.is_empty(), "{}", wrong(&found));
    assert!(snippet.contains("\"draws/draws.zarr\"") && script.contains("\"draws\" / \"draws.zarr\""));
    let version = read("tests/arviz_requirements.txt");
    let version = version.lines().find_map(|line| line.strip_prefix("arviz=="));
    assert!(version.is_some_and(|version| version.starts_with("1.3")) && snippet.contains("# 1.3 or later"));
    assert_eq!(
        unlike_the_script("import arviz as az\nimport xarray\naz.sumary(draws)", &script).len(),
        2
    );
}

/// Lines of a snippet of Rust that are not in the examples of the crate's page, which are compiled and run.
fn unlike_the_crate(snippet: &str, source: &str) -> Vec<String> {
    let page: BTreeSet<&str> = source.lines().filter_map(|line| line.strip_prefix("//! ")).collect();
    let lines = snippet.lines().filter(|line| !line.is_empty() && !page.contains(line));
    lines.map(str::to_owned).collect()
}

#[test]
fn the_library_is_called_as_the_crate_calls_it() {
    let source = read("src/lib.rs");
    let snippet = block(&read("docs/prediction.md"), "rust");
    assert!(snippet.lines().count() > 15);
    let found = unlike_the_crate(&snippet, &source);
    assert!(found.is_empty(), "{}", wrong(&found));
    assert_eq!(unlike_the_crate("assert!(e_n.at(1.2) > 0.95);", &source).len(), 1);
}
