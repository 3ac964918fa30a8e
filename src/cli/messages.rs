//! Prints notices, errors and results: notices and errors on standard error, results on standard output.
//!
//! Everything goes through [`plain_lines`] or [`plain`] here: whatever a name, a path or a library's message holds, nothing
//! moves the terminal or turns its text.

use std::io::{IsTerminal, Write};
use std::path::Path;

use clap::error::{ContextKind, ContextValue};
use wetcor::error::{plain, plain_lines, Error};
use wetcor::notice::Notice;

/// Exit status: it ran, and a gating verdict failed.
pub const NOT_QUOTABLE: u8 = 1;

/// A word before a message, coloured on a terminal only.
fn label(word: &str, colour: &str) -> String {
    let plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
    if plain {
        word.to_owned()
    } else {
        format!("{colour}{word}\u{1b}[0m")
    }
}

/// Says what wants a second look, on one line.
pub(super) fn warn(text: &str) {
    let text = plain(text, usize::MAX);
    let _ = writeln!(std::io::stderr(), "{}: {text}", label("notice", "\u{1b}[1;33m"));
}

/// Says what goes on, on one line.
pub(super) fn say(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}", plain(text, usize::MAX));
}

/// What is wrong with the command line. The words on it are printed on one line each, and a tip that repeats one that cannot
/// be printed as it is falls away.
pub(super) fn usage(mut error: clap::Error) -> String {
    let one_line = |text: &String| plain(text, usize::MAX);
    let plain_context: Vec<(ContextKind, ContextValue)> = error
        .context()
        .filter_map(|(kind, value)| match value {
            ContextValue::String(text) => Some((kind, ContextValue::String(one_line(text)))),
            ContextValue::Strings(texts) => Some((kind, ContextValue::Strings(texts.iter().map(one_line).collect()))),
            _ => None,
        })
        .collect();
    for (kind, value) in plain_context {
        let before = error.insert(kind, value);
        if before.as_ref() != error.get(kind) {
            error.remove(ContextKind::Suggested);
        }
    }
    let text = error.render().to_string();
    text.strip_prefix("error: ").unwrap_or(&text).trim_end().to_owned()
}

/// Says why there is no answer; what a user named in it is on one line already.
pub(super) fn complain(text: &str) {
    let text = plain_lines(text);
    let _ = writeln!(std::io::stderr(), "{}: {text}", label("error", "\u{1b}[1;31m"));
}

pub(super) fn print_notices(notices: &[Notice], quiet: bool) {
    if !quiet {
        for notice in notices {
            warn(&notice.text);
        }
    }
}

/// Prints to standard output. A reader that has left is no error.
pub(super) fn print_result(text: &str) -> Result<(), Error> {
    print(text, None)
}

/// Prints once a file or a folder is written, which stays whatever becomes of standard output.
pub(super) fn print_after_writing(file: &Path, text: &str) -> Result<(), Error> {
    print(text, Some(file))
}

fn print(text: &str, file: Option<&Path>) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(plain_lines(text).as_bytes()).and_then(|()| out.flush()) {
        Err(source) if source.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Unprinted {
            written: file.map(Path::to_path_buf),
            source,
        }),
        _ => Ok(()),
    }
}
