//! Says why a command could not run: no answer was given and nothing was written.

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
            write!(f, "found {found}, ")?;
        }
        write!(f, "{}", plain(&self.expected, usize::MAX))
    }
}

/// Characters of an input that a message repeats; the rest is cut.
const CHARACTERS_SHOWN: usize = 60;

/// Characters of a place that a message names: a table and a key.
const PLACE_SHOWN: usize = 160;

/// A text on one line, without control characters, cut after some characters.
pub fn plain(text: &str, most: usize) -> String {
    let mut shown = String::new();
    for (count, c) in text.chars().enumerate() {
        if count == most {
            shown.push('…');
            break;
        }
        if c.is_control() {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// A piece of an input as a message shows it: on one line, without control characters, cut where it is long.
pub fn quoted(text: &str) -> String {
    format!("`{}`", plain(text, CHARACTERS_SHOWN))
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The command line asks for something that is not to be had.
    #[error("{0}")]
    Usage(String),
    /// The operating system refused.
    #[error("{}: cannot {doing}: {source}", named(path))]
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
    #[error("{}: {reason}; nothing was written", named(path))]
    Out {
        /// the folder
        path: PathBuf,
        /// why it is not replaced
        reason: String,
    },
    /// A library below failed in a way no input should cause.
    #[error("{doing}: {reason}")]
    Internal {
        /// what was tried
        doing: &'static str,
        /// what the library said
        reason: String,
    },
}

impl Error {
    /// An input file's mistakes, cut to what is printed.
    pub fn input(file: &Path, mut problems: Vec<Problem>) -> Error {
        let count = problems.len();
        problems.truncate(PROBLEMS_SHOWN);
        Error::Input {
            file: file.to_path_buf(),
            problems,
            count,
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
}

/// A path as a message names it; a scene may name its table with any character.
fn named(path: &Path) -> String {
    plain(&path.display().to_string(), usize::MAX)
}

fn list(file: &Path, problems: &[Problem], count: usize) -> String {
    let noun = if count == 1 { "problem" } else { "problems" };
    let mut text = format!("{}: {count} {noun}; nothing was written", named(file));
    for problem in problems {
        text.push_str("\n  ");
        text.push_str(&problem.to_string());
    }
    if count > problems.len() {
        text.push_str(&format!("\n  and {} more", count - problems.len()));
    }
    text
}
