//! Holds completions and manual pages to what `--help` says: every verb and every long flag.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use crate::common::wetcor;

/// The long flags of each verb; those of wetcor itself are under no name.
type Flags = BTreeMap<String, Vec<String>>;

/// What the command prints, where it succeeds and says nothing else.
fn printed(arguments: &[&str]) -> String {
    let (status, out, err) = wetcor(Path::new("."), arguments);
    assert_eq!((status, err.as_str()), (Some(0), ""), "{arguments:?}");
    out
}

/// The lines below a heading of a help, up to the next blank one.
fn below<'a>(help: &'a str, heading: &str) -> Vec<&'a str> {
    let (_, after) = help.split_once(heading).unwrap_or_else(|| panic!("{help}"));
    let lines = after.lines().skip(1).collect::<Vec<_>>();
    // a value with words of its own has blank lines in it, but what follows is still set in
    let end = lines.iter().position(|line| !line.is_empty() && !line.starts_with(' '));
    lines[..end.unwrap_or(lines.len())].to_vec()
}

/// The verbs of the command's own list.
fn verbs() -> Vec<String> {
    let help = printed(&["--help"]);
    let listed = below(&help, "\nCommands:").into_iter();
    let first = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let verbs: Vec<String> = listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(first)
        .collect();
    assert!(verbs.len() >= 10, "{help}");
    verbs
}

/// The flag that a line is about: its first word, or the second after a short one.
fn long_flag(line: &str) -> Option<String> {
    let mut first = line.split_whitespace().take(2);
    first.find(|word| word.starts_with("--")).map(str::to_owned)
}

/// What `--help` lists.
fn flags() -> Flags {
    let mut flags = Flags::new();
    for verb in [String::new()].into_iter().chain(verbs()) {
        let words = [verb.as_str(), "--help"].into_iter().filter(|word| !word.is_empty());
        let help = printed(&words.collect::<Vec<_>>());
        let found: Vec<String> = below(&help, "\nOptions:").into_iter().filter_map(long_flag).collect();
        assert!(found.len() >= 3 && found.contains(&"--help".to_owned()), "{help}");
        flags.insert(verb, found);
    }
    assert!(flags["predict"].len() == 13 && flags["fit"].len() == 9, "{flags:?}");
    flags
}

/// Every verb and flag that a script does not name; what stands under which verb is the library's affair.
fn missing(script: &str, flags: &Flags) -> Vec<String> {
    let is_inside = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let words: BTreeSet<&str> = script.split(|c: char| !is_inside(c)).collect();
    // fish names a flag after `-l`, without its dashes
    let is_named = |word: &&String| words.contains(word.as_str()) || words.contains(word.trim_start_matches('-'));
    let all = flags
        .keys()
        .filter(|verb| !verb.is_empty())
        .chain(flags.values().flatten());
    all.filter(|word| !is_named(word)).cloned().collect()
}

const SHELLS: [&str; 5] = ["bash", "elvish", "fish", "powershell", "zsh"];

#[test]
fn every_shell_completes_every_verb_and_every_flag_of_the_help() {
    let flags = flags();
    for shell in SHELLS {
        let script = printed(&["completions", shell]);
        assert_eq!(missing(&script, &flags), Vec::<String>::new(), "{shell}");
        // a character that is never printed as it is stands as this escape
        assert!(!script.contains("\\u{"), "{shell}");
        let planted = script.replace("accuracy", "accurate");
        assert!(missing(&planted, &flags).contains(&"--accuracy".to_owned()), "{shell}");
    }
}

/// The words that bash offers for the last one of a line.
#[cfg(unix)]
fn offered_by_bash(words: &[&str]) -> Vec<String> {
    let (last, before) = (words[words.len() - 1], words[words.len() - 2]);
    let line = format!(
        "{}\nCOMP_WORDS=({}); COMP_CWORD={}; _wetcor wetcor '{last}' {before}; echo \"${{COMPREPLY[@]}}\"",
        printed(&["completions", "bash"]),
        words.join(" "),
        words.len() - 1,
    );
    let output = Command::new("bash").arg("-c").arg(line).output();
    let output = output.expect("bash can be started");
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("words");
    text.split_whitespace().map(str::to_owned).collect()
}

#[cfg(unix)]
#[test]
fn bash_completes() {
    assert_eq!(offered_by_bash(&["wetcor", "f"]), ["fit"]);
    assert_eq!(offered_by_bash(&["wetcor", "fit", "--st"]), ["--stages"]);
    assert_eq!(offered_by_bash(&["wetcor", "man", "pr"]), ["predict"]);
    assert_eq!(offered_by_bash(&["wetcor", "help", "sc"]), ["scene"]);
    assert_eq!(offered_by_bash(&["wetcor", "completions", "z"]), ["zsh"]);
    assert_eq!(offered_by_bash(&["wetcor", "predict", "--format", "j"]), ["json"]);
}

/// A manual page as it is read: without its fonts and escapes.
fn read(page: &str) -> String {
    let mut text = page.to_owned();
    for (escape, plain) in [("\\fB", ""), ("\\fI", ""), ("\\fR", ""), ("\\-", "-"), ("\\*(Aq", "'")] {
        text = text.replace(escape, plain);
    }
    text
}

/// What of a command's help its manual page does not say.
fn unsaid(page: &str, verb: &str, help: &str, flags: &Flags) -> Vec<String> {
    let text = read(page);
    let listed: Vec<String> = text.lines().filter_map(long_flag).collect();
    let unlisted = flags[verb].iter().filter(|flag| !listed.contains(flag));
    let mut unsaid: Vec<String> = unlisted.cloned().collect();
    let name = match verb {
        "" => "wetcor".to_owned(),
        verb => format!("wetcor-{verb}"),
    };
    let mut wanted = vec![format!("\n.TH {name} 1 "), format!("\n{name} - ")];
    if verb.is_empty() {
        let verbs = flags.keys().filter(|verb| !verb.is_empty());
        wanted.extend(verbs.map(|verb| format!("\nwetcor-{verb}(1)\n")));
        wanted.push("Exit status: 0 ran; 1 ran, and".to_owned());
    }
    let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  wetcor ")).collect();
    assert!(!examples.is_empty(), "{help}");
    wanted.extend(examples.iter().map(|line| line.trim().to_owned()));
    unsaid.extend(wanted.into_iter().filter(|wanted| !text.contains(wanted)));
    unsaid
}

#[test]
fn every_manual_page_says_what_the_help_says() {
    let flags = flags();
    for verb in flags.keys() {
        let of_verb =
            |words: [&str; 2]| printed(&words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>());
        let (page, help) = (of_verb(["man", verb]), of_verb([verb, "--help"]));
        assert_eq!(unsaid(&page, verb, &help, &flags), Vec::<String>::new(), "{verb}");
        for (said, planted) in [
            ("\\-\\-quiet", "\\-\\-silent"),
            (".TH wetcor", ".TH cor"),
            ("wetcor ", "cor "),
        ] {
            let planted = page.replace(said, planted);
            assert!(!unsaid(&planted, verb, &help, &flags).is_empty(), "{verb}: {said}");
        }
    }
}
