//! Holds completions and manual pages to what `--help` says: every verb and every long flag.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::common::{wetcor, Says};

/// The long flags of each verb; those of wetcor itself are under no name.
type Flags = BTreeMap<String, BTreeSet<String>>;

/// What the command prints, where it succeeds and says nothing else; a word may be empty.
fn printed(words: [&str; 2]) -> String {
    let arguments: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
    let (status, out, err) = wetcor(Path::new("."), &arguments);
    assert_eq!((status, err.as_str()), (Some(0), ""), "{arguments:?}");
    out
}

/// The flag that a line is about: its first word, or the second after a short one.
fn long_flag(line: &str) -> Option<String> {
    let mut first = line.split_whitespace().take(2);
    let flag = first.find(|word| word.starts_with("--"))?;
    Some(flag.trim_end_matches(',').to_owned())
}

/// The lines below a heading of a help: those that are set in, and blank ones.
fn below<'a>(help: &'a str, heading: &str) -> impl Iterator<Item = &'a str> {
    let (_, after) = help.split_once(heading).unwrap_or_else(|| panic!("{help}"));
    after
        .lines()
        .take_while(|line| line.is_empty() || line.starts_with(' '))
}

/// What `--help` lists: the verbs of the command, and the flags of each.
fn flags() -> Flags {
    let help = printed(["--help", ""]);
    let listed = below(&help, "\nCommands:\n").filter(|line| !line.starts_with("   "));
    let verbs = listed.filter_map(|line| line.split_whitespace().next());
    let of = |verb: &str| {
        let help = printed([verb, "--help"]);
        let flags = below(&help, "\nOptions:\n").filter_map(long_flag).collect();
        (verb.to_owned(), flags)
    };
    let flags: Flags = [""].into_iter().chain(verbs).map(of).collect();
    assert!(flags.len() > 10 && flags["fit"].contains("--stages"), "{flags:?}");
    flags
}

/// Which shell a script is for, and what stands under which verb, is the affair of the crate that writes it.
#[test]
fn every_shell_completes_every_verb_and_every_flag_of_the_help() {
    let flags = flags();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = printed(["completions", shell]);
        for word in flags.keys().chain(flags.values().flatten()) {
            // fish names a flag after `-l`, without its dashes
            script.says(word.trim_start_matches('-'));
        }
        // a character that is never printed as it is stands as this escape
        script.lacks("\\u{");
        script.lacks("--no-such-flag");
    }
}

#[test]
fn every_manual_page_says_what_the_help_says() {
    let flags = flags();
    for (verb, own) in &flags {
        let page = printed(["man", verb]).replace("\\-", "-").replace("\\*(Aq", "'");
        let page = ["\\fB", "\\fI", "\\fR"]
            .iter()
            .fold(page, |page, font| page.replace(font, ""));
        let name = format!("wetcor-{verb}");
        let name = name.trim_end_matches('-');
        page.says(&format!("\n.TH {name} 1 "));
        page.says(&format!("\n{name} - "));
        let listed: BTreeSet<String> = page.lines().filter_map(long_flag).collect();
        assert!(listed.is_superset(own), "{verb}: {listed:?} {own:?}");
        let help = printed([verb, "--help"]);
        for example in help.lines().filter(|line| line.starts_with("  wetcor ")) {
            page.says(example.trim());
        }
    }
    let page = printed(["man", ""]).replace("\\-", "-");
    for verb in flags.keys().filter(|verb| !verb.is_empty()) {
        page.says(&format!("wetcor-{verb}(1)"));
    }
    page.says("Exit status: 0 ran; 1 ran, and");
}
