//! Prints notices, errors and results: notices and errors on standard error, results on standard output.
//!
//! With --quiet only errors are said, and what a verb is there to print. Everything goes through [`plain_lines`] or
//! [`plain`] here: whatever a name, a path or a library's message holds, nothing moves the terminal or turns its text.

use std::io::{IsTerminal, Write};
use std::path::Path;

use clap::error::{ContextKind, ContextValue};
use terminal_size::{terminal_size_of, Height, Width};
use textwrap::core::display_width;
use wetcor::error::{plain, plain_lines, Error};
use wetcor::findings::remarks::in_order;
use wetcor::findings::Findings;
use wetcor::remark::Remark;

use crate::progress::is_quiet;

/// The exit status of what ran: 1 where what came out is not to be quoted.
pub(super) fn status(is_quotable: bool) -> u8 {
    u8::from(!is_quotable)
}

/// A word before a message, coloured on a terminal only.
fn label(word: &str, colour: &str) -> String {
    let plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
    if plain {
        word.to_owned()
    } else {
        format!("{colour}{word}\u{1b}[0m")
    }
}

/// Lines broken between words where a terminal would break them within one; elsewhere, as for scripts, they stay whole.
fn wrapped(text: &str, columns: Option<usize>) -> String {
    let Some(columns) = columns else {
        return text.to_owned();
    };
    let options = textwrap::Options::new(columns)
        .subsequent_indent("  ")
        .break_words(false)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    let lines = text.split('\n').map(|line| {
        if display_width(line) > columns {
            textwrap::fill(line, &options)
        } else {
            line.to_owned()
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// How many columns to write on a terminal of this size; `None` where there is none.
fn columns(size: Option<(Width, Height)>) -> Option<usize> {
    const NARROWEST: usize = 20;
    size.map(|(Width(columns), _)| NARROWEST.max(columns.into()))
}

/// Says what wants a second look, unless quiet was asked for.
pub(super) fn warn(text: &str) {
    if !is_quiet() {
        notice(text);
    }
}

/// Says what wants a second look, asked for quiet or not: on one line, or on those that a terminal needs.
pub(super) fn notice(text: &str) {
    let text = format!("{}: {}", label("notice", "\u{1b}[1;33m"), plain(text, usize::MAX));
    say_lines(&text);
}

/// Says what goes on, unless quiet was asked for: on one line, or on those that a terminal needs.
pub(super) fn say(text: &str) {
    if !is_quiet() {
        say_lines(&plain(text, usize::MAX));
    }
}

fn say_lines(text: &str) {
    let mut stderr = std::io::stderr();
    let text = wrapped(text, columns(terminal_size_of(&stderr)));
    let _ = writeln!(stderr, "{text}");
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
    // a word that only shares some letters with another is no slip of the fingers
    let first = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => text.chars().next(),
        Some(ContextValue::Strings(texts)) => texts.first().and_then(|text| text.chars().next()),
        _ => None,
    };
    if first(ContextKind::SuggestedSubcommand) != first(ContextKind::InvalidSubcommand) {
        error.remove(ContextKind::SuggestedSubcommand);
    }
    let text = error.render().to_string();
    text.strip_prefix("error: ").unwrap_or(&text).trim_end().to_owned()
}

/// Says why there is no answer; what a user named in it is on one line already.
pub(super) fn complain(text: &str) {
    say_lines(&format!("{}: {}", label("error", "\u{1b}[1;31m"), plain_lines(text)));
}

/// Says every notice, what only informs last.
pub(super) fn print_notices(notices: &[Remark]) {
    in_order(notices).into_iter().for_each(|notice| warn(&notice.text));
}

/// Says the cautions of a fit that bear most on its main numbers, and how many more the report has; or every one of them, and
/// what only informs after them.
pub(super) fn print_cautions(findings: &Findings, every: bool) {
    const SHOWN: usize = 3;
    let cautions = findings.cautions();
    let shown = if every { usize::MAX } else { SHOWN };
    cautions.iter().take(shown).for_each(|caution| warn(&caution.text));
    if every {
        let informing = in_order(&findings.remarks).into_iter();
        let informing = informing.filter(|one| one.informs() && one.line.is_none());
        informing.for_each(|one| warn(&one.text));
    } else if cautions.len() > SHOWN {
        let more = cautions.len() - SHOWN;
        let verb = if more == 1 { "caution stands" } else { "cautions stand" };
        say(&format!(
            "{more} more {verb} in the report; --verbose prints every notice"
        ));
    }
}

/// Prints to standard output. A reader that has left is no error.
pub(super) fn print_result(text: &str) -> Result<(), Error> {
    print(text, None)
}

/// Prints once a file or a folder is written, which stays whatever becomes of standard output; nothing where quiet was asked
/// for.
pub(super) fn print_after_writing(file: &Path, text: &str) -> Result<(), Error> {
    if is_quiet() {
        return Ok(());
    }
    let text = wrapped(text, columns(terminal_size_of(std::io::stdout())));
    print(&text, Some(file))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_whole_on_a_terminal_and_lines_off_it() {
        let text = "notice: the posterior was not sampled\nk    = 0.18";
        assert_eq!(wrapped(text, None), text);
        let lines = "notice: the\n  posterior was not\n  sampled\nk    = 0.18";
        assert_eq!(wrapped(text, Some(20)), lines);
        // a word longer than a line is not cut: it may be a path
        assert_eq!(
            wrapped("report: reports/mueller2016/report.md", Some(20))
                .lines()
                .count(),
            2
        );
        assert_eq!(columns(Some((Width(0), Height(24)))), Some(20));
    }
}
