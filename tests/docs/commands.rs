//! Holds that commands of the pages are understood.

use std::collections::BTreeSet;

use super::{assert_none, fenced, in_repository, pages, spans};
use crate::common::{wetcor, Folder};

/// The commands of a text: indented lines, and what stands between backticks.
fn commands(text: &str) -> Vec<&str> {
    const PROGRAMS: [&str; 4] = ["wetcor ", "cargo ", ".ci/", "UPDATE_EXPECTED=1 "];
    let (_, outside) = fenced(text);
    let indented = outside.into_iter().filter_map(|line| line.strip_prefix("    "));
    let all = indented.chain(spans(text));
    all.filter(|line| PROGRAMS.iter().any(|program| line.starts_with(program)))
        .collect()
}

/// What is wrong with a command; `None` if nothing.
fn no_command(command: &str) -> Option<String> {
    let words: Vec<&str> = command
        .split_whitespace()
        // where its output goes is the shell's business
        .take_while(|word| ![">", "|", "\\|"].contains(word))
        .filter(|word| !word.contains("EXPECTED="))
        .collect();
    let fault = match words.as_slice() {
        ["wetcor", arguments @ ..] => no_call(arguments),
        ["cargo", rest @ ..] => no_cargo_call(rest),
        [script] if in_repository(script).exists() => None,
        _ => Some("no such program"),
    };
    fault.map(|fault| format!("{command}: {fault}"))
}

/// What is wrong with a call of the program. It is made where there are no files, so that it ends in saying so.
fn no_call(arguments: &[&str]) -> Option<&'static str> {
    let mut arguments = arguments.to_vec();
    if arguments.len() == 1 {
        // a verb is named
        arguments.push("--help");
    }
    let (status, _, err) = wetcor(Folder::new().path(), &arguments);
    let lacks = ["No such file", "no findings of a fit", "there is no folder"];
    let lacks_a_file = lacks.iter().any(|lack| err.contains(lack));
    (status != Some(0) && !lacks_a_file).then_some("is not understood")
}

/// What is wrong with a call of cargo: an example, a test, a bench or a file of the program's own call that is not there.
fn no_cargo_call(words: &[&str]) -> Option<&'static str> {
    let mut parts = words.split(|word| *word == "--");
    let (own, program) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let is_lost = |pair: &[&str]| {
        let folder = match pair[0] {
            "--example" => "examples",
            "--test" => "tests",
            "--bench" => "benches",
            _ => return false,
        };
        let files = [".rs", "/main.rs"].map(|ending| format!("{folder}/{}{ending}", pair[1]));
        !files.iter().any(|file| in_repository(file).exists())
    };
    if own.windows(2).any(is_lost) {
        return Some("no such example, test or bench");
    }
    if own[0] != "run" || own.contains(&"--example") {
        return None;
    }
    let mut files = program.iter().filter(|word| word.contains('/'));
    if files.all(|file| in_repository(file).exists()) {
        no_call(program)
    } else {
        Some("no such file")
    }
}

#[test]
fn every_command_is_one() {
    let pages = pages();
    let all: BTreeSet<&str> = pages.iter().flat_map(|page| commands(&page.text)).collect();
    assert!(all.len() >= 20, "{all:?}");
    let found: Vec<String> = all.iter().filter_map(|command| no_command(command)).collect();
    assert_none(&found, "the pages");
    let listed =
        "wetcor fitt scene.toml; wetcor fitt; wetcor fit scene.toml --acuracy 0.1; wetcor fit scene.toml --stages \
        posteriors; wetcor predict reports/any --particle PTFE --speed-m-s 2:1:5; cargo run --release -- fit \
        datasets/mueller2017/scene.toml; cargo run --release --example render_campaigns -- drops; cargo test \
        --release --test readers; cargo bench --bench speeds; .ci/walk";
    for fault in listed.split("; ") {
        assert!(no_command(fault).is_some(), "{fault}");
    }
}
