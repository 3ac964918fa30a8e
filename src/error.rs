//! Says why a command could not run: no answer was given and nothing was written.
//!
//! What is shown of a user's text or a file's, here or elsewhere on a terminal, goes through [`plain`].

use std::fmt;
use std::path::{Path, PathBuf};

/// How many problems of one file are printed; the rest are counted.
pub const PROBLEMS_SHOWN: usize = 20;

/// One mistake in an input file: where, what stood there, what was expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// line in the file, from 1
    pub line: Option<u64>,
    /// table, key or column; empty where the line says enough
    pub place: String,
    /// what stood there
    pub found: Option<String>,
    /// what was expected instead
    pub expected: String,
}

impl Problem {
    /// A mistake of no line and of nothing that stood there.
    pub fn new(place: impl Into<String>, expected: impl Into<String>) -> Problem {
        Problem {
            line: None,
            place: place.into(),
            found: None,
            expected: expected.into(),
        }
    }

    /// The same, on a line.
    #[must_use]
    pub fn on(mut self, line: impl Into<Option<u64>>) -> Problem {
        self.line = line.into();
        self
    }

    /// The same, where this stood.
    #[must_use]
    pub fn found(mut self, found: impl Into<Option<String>>) -> Problem {
        self.found = found.into();
        self
    }
}

/// The mistakes of one input file: the first, at most [`PROBLEMS_SHOWN`], and how many there are.
#[derive(Debug, Default)]
pub struct Problems {
    /// as they were found
    pub first: Vec<Problem>,
    /// in all
    pub count: usize,
}

impl Problems {
    /// Adds one.
    pub fn push(&mut self, problem: Problem) {
        self.count += 1;
        if self.first.len() < PROBLEMS_SHOWN {
            self.first.push(problem);
        }
    }

    /// Adds others behind these.
    pub fn extend(&mut self, others: Problems) {
        self.first.extend(others.first);
        self.first.truncate(PROBLEMS_SHOWN);
        self.count += others.count;
    }
}

impl From<Vec<Problem>> for Problems {
    fn from(mut all: Vec<Problem>) -> Problems {
        let count = all.len();
        all.truncate(PROBLEMS_SHOWN);
        Problems { first: all, count }
    }
}

/// What was read, unless something is wrong with it.
pub fn unless_wrong<T>(problems: Vec<Problem>, read: T) -> Result<T, Vec<Problem>> {
    match problems.is_empty() {
        true => Ok(read),
        false => Err(problems),
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // names of the input stand in a place: they too stay on one line, and are cut where nobody would read on
        let place = plain(&self.place, PLACE_SHOWN);
        match (self.line, place.as_str()) {
            (Some(line), "") => write!(f, "line {line}: ")?,
            (Some(line), place) => write!(f, "line {line}, {place}: ")?,
            (None, "") => {}
            (None, place) => write!(f, "{place}: ")?,
        }
        if let Some(found) = &self.found {
            write!(f, "found {}, ", plain(found, usize::MAX))?;
        }
        write!(f, "{}", plain(&self.expected, usize::MAX))
    }
}

/// Characters of an input that a message repeats; the rest is cut.
const CHARACTERS_SHOWN: usize = 60;

/// Characters of a place that a message names: a table and a key.
const PLACE_SHOWN: usize = 160;

/// Whether a character is never shown as it is: it moves the cursor, breaks the line, turns the direction of what stands
/// about it, or is not seen.
///
/// Control characters, the separators of lines and paragraphs, marks, embeddings, overrides and isolates of direction,
/// soft hyphens and zero widths, tags and other invisible format characters, and the letters that are blank (fillers of
/// Hangul). Joiners (U+200C, U+200D) and variation selectors are not among them: they shape the letters beside them in
/// ordinary words.
#[inline]
pub fn is_unseen(c: char) -> bool {
    if matches!(c, ' '..='~') {
        return false;
    }
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{180e}' | '\u{200b}' | '\u{200e}' | '\u{200f}'
            | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fffb}' | '\u{1bca0}'..='\u{1bca3}' | '\u{1d173}'..='\u{1d17a}'
            | '\u{e0000}'..='\u{e007f}')
}

/// A text on one line, with escapes for what is never shown as it is, cut after some characters.
pub fn plain(text: &str, most: usize) -> String {
    let mut shown = String::new();
    for (count, c) in text.chars().enumerate() {
        if count == most {
            shown.push('…');
            break;
        }
        if is_unseen(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// The same of lines that the program put together: their ends stay. What a user named in them has gone through
/// [`plain`] before, so that no line of it can pass for one of the program's.
pub fn plain_lines(text: &str) -> String {
    let lines: Vec<String> = text.split('\n').map(|line| plain(line, usize::MAX)).collect();
    lines.join("\n")
}

/// A piece of an input as a message shows it: on one line, with nothing unseen, cut where it is long. A backtick in it is
/// shown as an escape, too: the mark about it ends where it seems to.
pub fn quoted(text: &str) -> String {
    format!("`{}`", plain(text, CHARACTERS_SHOWN).replace('`', "\\u{60}"))
}

/// The name of a file without its folder, as a sentence names it: as it is where that is plain, else quoted.
pub fn file_name(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
    let ordinary = |c: char| c.is_alphanumeric() && !is_unseen(c) || matches!(c, '.' | '-' | '_' | ' ');
    if name.chars().all(ordinary) {
        name.into_owned()
    } else {
        quoted(&name)
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command line asks for something that is not to be had.
    #[error("{}", plain(.0, usize::MAX))]
    Usage(String),
    /// The operating system refused.
    #[error("{}: cannot {doing}: {}", named(path), plain(&source.to_string(), usize::MAX))]
    Io {
        /// the file or folder
        path: PathBuf,
        /// what was tried, as a verb
        doing: &'static str,
        /// the system's own reason
        source: std::io::Error,
    },
    /// A scene or a table of runs has mistakes.
    #[error("{}", list(file, problems, *count))]
    Input {
        /// the file, as the user named it
        file: PathBuf,
        /// the first mistakes, at most [`PROBLEMS_SHOWN`]
        problems: Vec<Problem>,
        /// how many there are in all
        count: usize,
    },
    /// The folder to write is somebody else's.
    #[error("{}: {}; nothing was written", named(path), plain(reason, usize::MAX))]
    Out {
        /// the folder
        path: PathBuf,
        /// why it is not replaced
        reason: String,
    },
    /// Standard output refused what was to be printed.
    #[error("standard output: cannot write: {}{}", plain(&source.to_string(), usize::MAX), written.as_deref().map_or(String::new(), stands))]
    Unprinted {
        /// what was written before, and stays
        written: Option<PathBuf>,
        /// the system's own reason
        source: std::io::Error,
    },
    /// Another of the processes that share the work cannot go on, and says why.
    #[error("another rank could not go on")]
    OtherRank,
    /// A library below failed in a way no input should cause.
    #[error("{doing}: {}", plain(reason, usize::MAX))]
    Internal {
        /// what was tried
        doing: &'static str,
        /// what the library said
        reason: String,
    },
}

impl Error {
    /// An input file's mistakes, cut to what is printed.
    pub fn input(file: &Path, problems: impl Into<Problems>) -> Error {
        let Problems { first, count } = problems.into();
        Error::Input {
            file: file.to_path_buf(),
            problems: first,
            count,
        }
    }

    /// A place that is not written to, and why.
    pub fn out(path: &Path, reason: impl Into<String>) -> Error {
        Error::Out {
            path: path.to_path_buf(),
            reason: reason.into(),
        }
    }

    /// A refusal of the operating system.
    pub fn io(path: &Path, doing: &'static str, source: std::io::Error) -> Error {
        Error::Io {
            path: path.to_path_buf(),
            doing,
            source,
        }
    }

    /// Makes one of what a library said.
    pub fn internal<E: ToString>(doing: &'static str) -> impl Fn(E) -> Error {
        move |error| Error::Internal {
            doing,
            reason: error.to_string(),
        }
    }
}

/// What is there although it could not be printed.
fn stands(path: &Path) -> String {
    format!("; {} was written whole", named(path))
}

/// A path as a message names it; a scene may name its table with any character.
pub fn named(path: &Path) -> String {
    plain(&path.display().to_string(), usize::MAX)
}

fn list(file: &Path, problems: &[Problem], count: usize) -> String {
    let noun = if count == 1 { "problem" } else { "problems" };
    let told = problems.iter().map(ToString::to_string).collect();
    let told = and_more(told, count, "\n  ");
    format!("{}: {count} {noun}; nothing was written\n  {told}", named(file))
}

/// What is told of so many, with the number of those that are not.
pub(crate) fn and_more(mut told: Vec<String>, all: usize, between: &str) -> String {
    if all > told.len() {
        told.push(format!("and {} more", all - told.len()));
    }
    told.join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_or_turns_a_text_is_shown_as_an_escape_and_letters_are_not() {
        for c in "\0\t\n\r\u{1b}\u{7f}\u{9b}\u{ad}\u{61c}\u{200b}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202e}\u{2066}\u{2069}\u{feff}\u{3164}\u{e0041}"
            .chars()
        {
            let shown = plain(&format!("a{c}b"), usize::MAX);
            assert!(shown.chars().all(|c| c.is_ascii_graphic()) && shown.len() > 3, "{shown}");
            assert_eq!(plain(&shown, usize::MAX), shown, "once is enough");
        }
        let words = "Müller & Huang 2016, Kügelchen µ Ω א خ می‌خواهم ❤️ 中";
        assert_eq!(plain(words, usize::MAX), words);
        assert_eq!(plain_lines("a\n\u{202e}b\n"), "a\n\\u{202e}b\n");
        assert_eq!(quoted("a`b"), "`a\\u{60}b`");
        assert_eq!(file_name(Path::new("x/runs-2.csv")), "runs-2.csv");
        assert_eq!(file_name(Path::new("x/<b>.csv")), "`<b>.csv`");
    }
}
