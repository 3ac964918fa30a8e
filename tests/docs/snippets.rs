//! Holds code in other languages against the code that is run.

use std::collections::BTreeSet;

use super::{assert_none, block, read};

/// Lines of a snippet that are not among those of the code that is run.
fn unlike(snippet: &str, code: &str) -> Vec<String> {
    let run: BTreeSet<&str> = code.lines().collect();
    let lines = snippet
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim_end());
    let unlike = lines.filter(|line| !line.is_empty() && !run.contains(line));
    unlike.map(str::to_owned).collect()
}

/// A line of Python, of which a call of ArviZ is its name alone: the path of the store is put together in the script.
fn without_arguments(line: &str) -> String {
    let call = line.split_once("az.").and_then(|(_, call)| call.split('(').next());
    call.unwrap_or(line).to_owned() + "\n"
}

#[test]
fn the_draws_are_opened_as_ci_opens_them() {
    let of = |code: String| code.lines().map(without_arguments).collect::<String>();
    let snippet = of(block(&read("docs/posterior.md"), "python"));
    let script = of(read("tests/arviz_opens_draws.py"));
    assert_none(&unlike(&snippet, &script), "posterior.md");
    assert_eq!(unlike("sumary\nimport xarray", &script), ["sumary", "import xarray"]);
}

/// The examples of the crate's page are compiled and run.
#[test]
fn the_library_is_called_as_the_crate_calls_it() {
    let source = read("src/lib.rs").replace("//! ", "");
    let snippet = block(&read("docs/prediction.md"), "rust");
    assert!(snippet.lines().count() > 15);
    assert_none(&unlike(&snippet, &source), "prediction.md");
    assert_eq!(unlike("assert!(e_n.at(1.2) > 0.95);", &source).len(), 1);
}
