//! Holds that commands and flags of the pages are understood.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use super::{fenced, in_repository, pages, spans, wrong};
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
        ["cargo", "run", "--release", "--example", name, "--", ..]
        | ["cargo", "run", "--release", "--no-default-features", "--example", name, "--", ..] => {
            let mut files = [format!("examples/{name}.rs"), format!("examples/{name}/main.rs")].into_iter();
            (!files.any(|file| in_repository(&file).exists())).then_some("no such example")
        }
        ["cargo", "run", rest @ ..] => {
            let after = rest.iter().position(|word| *word == "--").map(|at| &rest[at + 1..]);
            after.map_or(Some("no arguments"), no_call_of_file)
        }
        ["cargo", verb @ ("build" | "test" | "bench" | "doc" | "install"), rest @ ..] => no_cargo_call(verb, rest),
        [script] if in_repository(script).exists() => None,
        _ => Some("no such program"),
    };
    fault.map(|fault| format!("{command}: {fault}"))
}

/// What is wrong with a call of the program. It is made where there are no files, so that it ends in saying so.
fn no_call(arguments: &[&str]) -> Option<&'static str> {
    let folder = Folder::new();
    let (_, help, _) = folder.run("--help");
    let is_verb = |word: &str| {
        help.lines()
            .any(|line| line.split_whitespace().next() == Some(word) && line.starts_with("  "))
    };
    match arguments {
        [verb, ..] if !verb.starts_with('-') && !is_verb(verb) => Some("no such verb"),
        // named without arguments
        [_] => None,
        _ => {
            let (status, _, err) = wetcor(folder.path(), arguments);
            let lacks_a_file = ["No such file", "no findings of a fit", "there is no folder"]
                .iter()
                .any(|lack| err.contains(lack));
            (status != Some(0) && !lacks_a_file).then_some("is not understood")
        }
    }
}

/// The same of a call from this repository: its file must be here.
fn no_call_of_file(arguments: &[&str]) -> Option<&'static str> {
    let mut files = arguments.iter().filter(|word| word.contains('/'));
    if files.all(|file| in_repository(file).exists()) {
        no_call(arguments)
    } else {
        Some("no such file")
    }
}

/// What is wrong with a call of cargo: a flag it has not, or a test or bench that is not there.
fn no_cargo_call(verb: &str, rest: &[&str]) -> Option<&'static str> {
    let help = Command::new(env!("CARGO")).args([verb, "-h"]).output();
    let help = String::from_utf8_lossy(&help.expect("cargo can be started").stdout).into_owned();
    let own = rest.split(|word| *word == "--").next().unwrap_or_default();
    let mut flags = own.iter().filter(|word| word.starts_with("--"));
    if !flags.all(|flag| help.contains(flag)) {
        return Some("no such flag");
    }
    let mut targets = own.windows(2).filter(|pair| ["--test", "--bench"].contains(&pair[0]));
    let is_there = |pair: &[&str]| {
        let folder = if pair[0] == "--test" { "tests" } else { "benches" };
        [
            format!("{folder}/{}.rs", pair[1]),
            format!("{folder}/{}/main.rs", pair[1]),
        ]
        .iter()
        .any(|path| in_repository(path).exists())
    };
    (!targets.all(is_there)).then_some("no such test or bench")
}

#[test]
fn every_command_is_one() {
    let pages = pages();
    let all: BTreeSet<&str> = pages.iter().flat_map(|page| commands(&page.text)).collect();
    assert!(all.len() >= 20, "{all:?}");
    let found: Vec<String> = all.iter().filter_map(|command| no_command(command)).collect();
    assert!(found.is_empty(), "{}", wrong(&found));
    for command in [
        "cargo run --release -- fit datasets/mueller2016/scene.toml",
        "cargo test --release",
    ] {
        assert!(commands(&pages[0].text).contains(&command), "{command}");
    }
    let listed =
        "wetcor fitt scene.toml; wetcor fit scene.toml --acuracy 0.1; wetcor fit scene.toml --stages posteriors; \
        wetcor predict reports/any --particle PTFE --speed-m-s 2:1:5; cargo run --release -- fit \
        datasets/mueller2017/scene.toml; cargo run --release --example render_campaigns -- drops; cargo run \
        --release --no-default-features --example coolings -- cooling.svg; cargo test --releases; UPDATE_EXPECTED=1 \
        cargo test --release --test readers; cargo bench --bench speeds; .ci/walk";
    for fault in listed.split("; ") {
        assert!(no_command(fault).is_some(), "{fault}");
    }
}

/// Flags between backticks that no verb has.
fn unknown_flags(text: &str, helps: &str) -> Vec<String> {
    let flags = spans(text).into_iter().filter(|span| span.starts_with("--"));
    let names: BTreeSet<&str> = flags.filter_map(|span| span.split_whitespace().next()).collect();
    let is_known = |flag: &&str| {
        let mut words = helps.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
        words.any(|word| word == *flag)
    };
    names
        .into_iter()
        .filter(|flag| !is_known(flag))
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_flag_is_one_of_a_verb() {
    let help = |verb: &str| wetcor(Path::new("."), &[verb, "--help"]).1;
    let helps: String = [
        "track",
        "new",
        "fit",
        "check",
        "simulate",
        "predict",
        "handoff",
        "trade",
        "calibrate",
    ]
    .map(help)
    .concat();
    for page in pages() {
        let found = unknown_flags(&page.text, &helps);
        assert!(found.is_empty(), "{}: {}", page.path, wrong(&found));
    }
    assert_eq!(
        unknown_flags("`--exact-rows`, `--exact`, `--film-umm 3`", &helps),
        ["--exact", "--film-umm"]
    );
}
