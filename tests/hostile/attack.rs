//! Runs the command with a time limit and holds its manners: an exit status it documents, no panic, no control characters.

use crate::common::{Folder, Says};
use std::process::{Command, Stdio};

/// Seconds after which a command counts as hanging; a refusal takes a hundredth of one, a fit of the plain example half of
/// one on two busy cores.
pub const LIMIT: f64 = 60.0;

/// Whether a character moves a terminal, or turns or hides text: not asked of the program, whose own list may have a hole.
pub fn is_hostile(c: char) -> bool {
    c.is_control() || "\u{61c}\u{200b}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}\u{feff}".contains(c)
}

/// What a command did.
#[derive(Debug)]
pub struct Outcome {
    /// `None` where a signal or the time limit ended it
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

/// Runs the command in a folder, with words between blanks.
pub fn attack(folder: &Folder, words: &str) -> Outcome {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wetcor"));
    command.current_dir(folder).args(words.split(' '));
    finish(command, LIMIT)
}

/// Runs a command for at most so many seconds, with what it starts.
pub fn finish(command: Command, seconds: f64) -> Outcome {
    let mut limited = Command::new("timeout");
    limited.args(["--signal=KILL", &seconds.to_string()]);
    limited.arg(command.get_program()).args(command.get_args());
    limited.current_dir(command.get_current_dir().expect("a folder"));
    limited.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    for variable in ["COLUMNS", "CLICOLOR_FORCE", "FORCE_COLOR", "RUST_BACKTRACE"] {
        limited.env_remove(variable);
    }
    let output = limited
        .stdin(Stdio::null())
        .output()
        .expect("the command can be started");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Outcome {
        status: output.status.code(),
        out: text(output.stdout),
        err: text(output.stderr),
    }
}

impl Outcome {
    /// It ended by itself with a documented exit status, without a panic, and said nothing that moves a terminal or turns its
    /// text.
    pub fn assert_mannered(&self, of: &str) {
        assert!(matches!(self.status, Some(0..=2)), "{of}: {self:?}");
        assert!(!self.err.contains("panicked"), "{of}: {self:?}");
        for text in [&self.out, &self.err] {
            let is_told = |c: char| c == '\n' || !is_hostile(c);
            assert!(text.chars().all(is_told), "{of}: {text:?}");
        }
    }

    /// It was refused in words that hold all of these.
    pub fn assert_refused(&self, of: &str, words: &[&str]) {
        self.assert_mannered(of);
        assert_eq!(self.status, Some(2), "{of}: {self:?}");
        words.iter().for_each(|word| self.err.says(word));
    }
}
