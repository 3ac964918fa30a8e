//! Holds the command to transcripts of what it is asked, and of what it says and leaves.
//!
//! `tests/data/transcripts/*.txt` are cases with a blank line between, each in a folder with the plain example. A line begins
//! with what it is: `$` a command of bash that must succeed, `+` a line added to the scene, `2` (or `0`, `01`) a command that
//! must end with such a status and with manners (refused, it prints nothing to standard output), `>` what it must print, `<`
//! what not, `=` the names in the folder, `x` a text of sheets that becomes a workbook, `field`, `count` and `same` what a JSON
//! file must hold (`fields.rs`), `.` a field below the path that `at` names with its file. A line that begins with two blanks goes on with the one above. `prelude.sh` has the commands
//! that several cases share, those three lines among them. They need bash and the tools of GNU, as Linux has them.
#![cfg(target_os = "linux")]

use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::workbook::workbook;
use crate::common::{entries, in_project, read_in_project, Folder, Says};
use crate::hostile::attack::{attack, finish, Outcome, LIMIT};

mod fields;

/// What a command of bash says to the child that holds a line of fields.
const LINE: &str = "TRANSCRIPTS_LINE";

fn bash(place: &Folder, command: &str, seconds: f64) -> Outcome {
    let mut bash = Command::new("bash");
    let script = format!(". \"$PROJECT/tests/data/transcripts/prelude.sh\"\n{command}");
    bash.current_dir(place).args(["-c", &script]);
    bash.env("WETCOR", env!("CARGO_BIN_EXE_wetcor"));
    bash.env("PROJECT", env!("CARGO_MANIFEST_DIR"));
    bash.env("TESTS", std::env::current_exe().expect("this test has a file"));
    finish(bash, seconds)
}

fn hold(case: &str, seconds: f64) {
    let place = Folder::plain();
    let mut printed = String::new();
    let lines: Vec<String> = case
        .replace("\n  ", "\0")
        .lines()
        .map(|line| line.replace('\0', "\n"))
        .collect();
    let (mut file, mut path) = ("", "");
    for line in &lines {
        let of = format!("{line}\nin\n{case}");
        let (kind, rest) = line.split_once(' ').expect("a kind and a blank");
        match kind {
            "#" => {}
            "+" => place.add_to_scene(rest),
            "$" => {
                let done = bash(&place, rest, seconds);
                assert_eq!(done.status, Some(0), "{of}: {done:?}");
            }
            ">" => printed.says(rest),
            "<" => printed.lacks(rest),
            "x" => place.write(rest, workbook(&place.read(rest))),
            "field" | "count" | "same" => fields::assert_line(place.path(), line),
            "at" => (file, path) = rest.split_once(' ').expect("a file and a path"),
            "." => {
                let rest = rest.replace(" .", &format!(" .{path}."));
                fields::assert_line(place.path(), &format!("field {file} {path}.{rest}"));
            }
            "=" => assert_eq!(entries(place.path()).join(" "), rest, "{of}"),
            statuses => {
                let outcome = bash(&place, rest, seconds);
                outcome.assert_mannered(&of);
                let status = outcome.status.map_or(String::new(), |status| status.to_string());
                assert!(statuses.contains(&status), "{of}: {outcome:?}");
                assert!(statuses != "2" || outcome.out.is_empty(), "{of}: {outcome:?}");
                printed = outcome.out + &outcome.err;
            }
        }
    }
}

/// Holds the cases of transcripts of some names.
fn hold_all(is_asked: impl Fn(&str) -> bool, seconds: f64) {
    let names = entries(&in_project("tests/data/transcripts"));
    let texts = names.iter().filter(|name| is_asked(name));
    let texts = texts.map(|name| read_in_project(&format!("tests/data/transcripts/{name}")));
    let cases: Vec<String> = texts
        .flat_map(|text| text.split("\n\n").map(str::to_owned).collect::<Vec<_>>())
        .collect();
    // not in rayon's threads, which other tests wait for
    let next = AtomicUsize::new(0);
    let hold_next = || {
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            hold(case, seconds);
        }
    };
    std::thread::scope(|scope| {
        (0..2).for_each(|_| drop(scope.spawn(hold_next)));
    });
}

#[test]
fn every_command_says_and_leaves_what_its_transcript_has() {
    let by_others = ["prelude.sh", "fields.txt", "slow.txt"];
    hold_all(|name| !by_others.contains(&name), LIMIT);
}

#[test]
#[ignore = "slow: draws ten million runs"]
fn a_model_that_keeps_every_run_has_a_limit_of_rows() {
    hold_all(|name| name == "slow.txt", 120.0);
}

/// The child that bash starts, and those lines of which bash asks it.
#[test]
fn a_line_of_fields_is_held_in_bash_as_here() {
    match std::env::var(LINE) {
        Ok(line) => fields::assert_line(std::path::Path::new("."), &line),
        Err(_) => hold_all(|name| name == "fields.txt", LIMIT),
    }
}

#[test]
fn a_socket_is_no_table() {
    for name in ["socket.csv", "socket.parquet"] {
        let place = Folder::plain();
        place.replace("scene.toml", "runs.csv", name);
        let _socket = std::os::unix::net::UnixListener::bind(place.join(name)).expect("a socket");
        let words = ["found a socket, expected a regular file or a pipe"];
        attack(&place, "check scene.toml").assert_refused(name, &words);
    }
}

/// The twin: a status, words, names and a check that are not so are seen.
#[test]
fn a_transcript_of_what_is_not_so_is_seen() {
    let holds = |case: &str| std::panic::catch_unwind(|| hold(case, LIMIT)).is_ok();
    assert!(holds(
        "2 wetcor check nowhere.toml\n> nowhere.toml\n= runs.csv scene.toml"
    ));
    for fault in [
        "0 wetcor check nowhere.toml",
        "2 wetcor check nowhere.toml\n> somewhere",
        "= scene.toml",
        "$ cmp runs.csv scene.toml",
        "$ echo '{\"n\": 2}' > a\nfield a n = 3",
        "0 printf 'a\\xe2\\x80\\xaeb'",
    ] {
        assert!(!holds(fault), "{fault}");
    }
}
