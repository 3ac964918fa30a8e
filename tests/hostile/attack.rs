//! Runs the command with a time limit and holds its manners: an exit status it documents, no panic, no control characters.

use crate::common::{entries, in_project, Folder};
use std::io::Read;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Seconds after which a command counts as hanging; a refusal takes a hundredth of one, a fit of the plain example half of
/// one on two busy cores.
pub const LIMIT: f64 = 60.0;

/// A folder with a scene and its runs, for as long as the test needs it.
pub struct Place {
    pub folder: Folder,
}

/// Whether a character moves a terminal, or turns or hides text: not asked of the program, whose own list may have a hole.
pub fn is_hostile(c: char) -> bool {
    c.is_control() || "\u{61c}\u{200b}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}\u{feff}".contains(c)
}

impl std::ops::Deref for Place {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.folder
    }
}

/// What a command did.
#[derive(Debug)]
pub struct Outcome {
    /// `None` where a signal or the time limit ended it
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Place {
    /// The plain example's scene and its 31 runs.
    pub fn plain() -> Place {
        let plain = in_project("tests/data/good/plain");
        let place = Place { folder: Folder::new() };
        for name in ["scene.toml", "runs.csv"] {
            std::fs::copy(plain.join(name), place.path(name)).expect("writable");
        }
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// The scene with some lines added at its end.
    pub fn add_to_scene(&self, lines: &str) {
        let scene = self.read("scene.toml");
        self.write("scene.toml", format!("{scene}\n{lines}\n"));
    }

    /// Runs the command in this folder.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wetcor"));
        command.current_dir(self.folder.path()).args(arguments);
        finish(command, LIMIT)
    }

    /// The same of words with blanks between them.
    pub fn ask(&self, words: &str) -> Outcome {
        self.run(&words.split(' ').collect::<Vec<&str>>())
    }

    /// Names of what lies in the folder, sorted.
    pub fn entries(&self) -> Vec<String> {
        entries(self.folder.path())
    }
}

/// Runs a command for at most so many seconds.
pub fn finish(mut command: Command, seconds: f64) -> Outcome {
    let started = Instant::now();
    for variable in ["COLUMNS", "CLICOLOR_FORCE", "FORCE_COLOR", "RUST_BACKTRACE"] {
        command.env_remove(variable);
    }
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command can be started");
    // read aside, so that a full pipe stops nobody
    let out = text_of(child.stdout.take().expect("piped"));
    let err = text_of(child.stderr.take().expect("piped"));
    let limit = Duration::from_secs_f64(seconds);
    let status = loop {
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            break status.code();
        }
        if started.elapsed() > limit {
            let _ = child.kill();
            let _ = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    Outcome {
        status,
        out: out.join().expect("read"),
        err: err.join().expect("read"),
    }
}

fn text_of(mut pipe: impl Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut bytes = vec![];
        let _ = pipe.read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })
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
        for word in words {
            assert!(self.err.contains(word), "{of}: no {word:?} in {}", self.err);
        }
    }
}
