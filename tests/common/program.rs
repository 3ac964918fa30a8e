//! Runs the command in folders, and reads what it writes there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::TempDir;
use wetcor::error::Error;
use wetcor::runs::{self, Table};
use wetcor::scene::{self, Scene};

/// Exit status, and what is printed to standard output and standard error.
pub type Ran = (Option<i32>, String, String);

/// Runs the command in a folder.
pub fn wetcor(folder: &Path, arguments: &[&str]) -> Ran {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_wetcor"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the command can be started");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("plain text");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The same in the folder of the project.
pub fn wetcor_here(arguments: &[&str]) -> Ran {
    wetcor(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

/// Runs a verb on what lies in a folder; more arguments are words with blanks between them.
pub fn ask(verb: &str, folder: &Path, words: &str) -> Ran {
    let folder = folder.to_str().expect("a plain path");
    let words = words.split_whitespace();
    wetcor_here(&[verb, folder].into_iter().chain(words).collect::<Vec<&str>>())
}

/// A file of the project, by its path from there.
pub fn in_project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Its text.
pub fn read_in_project(path: &str) -> String {
    std::fs::read_to_string(in_project(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Whether pages and golden texts are to be written anew.
pub fn is_update() -> bool {
    std::env::var_os("UPDATE_EXPECTED").is_some()
}

/// The text of a file of the project, which is written anew where that is asked for.
pub fn kept(path: &str, made: &str) -> String {
    if is_update() {
        std::fs::write(in_project(path), made).expect("writable");
    }
    read_in_project(path)
}

/// A temporary folder.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    /// With the plain example's scene and its 31 runs.
    pub fn plain() -> Folder {
        let folder = Folder::new();
        for name in ["scene.toml", "runs.csv"] {
            folder.write(name, read_in_project(&format!("tests/data/good/plain/{name}")));
        }
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn join(&self, name: &str) -> PathBuf {
        self.path().join(name)
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        std::fs::write(self.join(name), contents).expect("the folder is writable");
    }

    /// Writes `scene.toml` and reads it.
    pub fn scene(&self, text: &str) -> Result<Scene, Error> {
        self.write("scene.toml", text);
        scene::read(&self.join("scene.toml"))
    }

    /// Writes `runs.csv` and reads what a scene names.
    pub fn runs(&self, scene: &Scene, text: &str) -> Result<Table, Error> {
        self.write("runs.csv", text);
        runs::read(scene)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).expect("JSON")
    }

    /// The scene with some lines added at its end.
    pub fn add_to_scene(&self, lines: &str) {
        let scene = self.read("scene.toml");
        self.write("scene.toml", format!("{scene}\n{lines}\n"));
    }

    /// Replaces a part of a file.
    pub fn replace(&self, name: &str, from: &str, to: &str) {
        self.write(name, self.read(name).replace(from, to));
    }

    /// Runs the command here; its arguments are words with blanks between them.
    pub fn run(&self, words: &str) -> Ran {
        wetcor(self.path(), &words.split_whitespace().collect::<Vec<&str>>())
    }

    /// The same of a command that must succeed: what it prints.
    pub fn succeed(&self, words: &str) -> String {
        let (status, out, err) = self.run(words);
        assert_eq!(status, Some(0), "{words}: {out}{err}");
        out
    }

    /// The same of a command that must be refused, with nothing but its message.
    #[track_caller]
    pub fn refused(&self, words: &str) -> String {
        let (status, out, err) = self.run(words);
        assert_eq!((status, out.as_str()), (Some(2), ""), "{words}: {err}");
        err
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        self.path()
    }
}

/// Every file below a folder with its bytes; none where there is no folder.
pub fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let entry = entry.expect("readable");
        let (path, name) = (entry.path(), PathBuf::from(entry.file_name()));
        if path.is_dir() {
            found.extend(
                contents(&path)
                    .into_iter()
                    .map(|(inside, bytes)| (name.join(inside), bytes)),
            );
        } else {
            found.insert(name, std::fs::read(&path).expect("readable"));
        }
    }
    found
}

/// Names of what lies in a folder, sorted.
pub fn entries(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("readable");
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("readable").file_name();
    let mut names = Vec::from_iter(entries.map(|entry| name(entry).to_string_lossy().into_owned()));
    names.sort();
    names
}

/// The rows of a table given as lines, with ` | ` between cells.
pub fn table_of<const N: usize>(text: &str) -> Vec<[&str; N]> {
    let row = |line| -> [&str; N] { Vec::from_iter(str::split(line, " | ")).try_into().expect("a row") };
    text.lines().map(str::trim).map(row).collect()
}

/// What a text must say; the whole of it is shown where it does not.
pub trait Says {
    fn text(&self) -> &str;

    #[track_caller]
    fn says(&self, words: &str) {
        assert!(self.text().contains(words), "no `{words}` in:\n{}", self.text());
    }

    #[track_caller]
    fn begins(&self, words: &str) {
        assert!(self.text().starts_with(words), "no `{words}` begins:\n{}", self.text());
    }

    #[track_caller]
    fn lacks(&self, words: &str) {
        assert!(!self.text().contains(words), "`{words}` in:\n{}", self.text());
    }

    /// The whole of it.
    #[track_caller]
    fn reads(&self, words: &str) {
        assert_eq!(self.text(), words);
    }
}

impl Says for str {
    fn text(&self) -> &str {
        self
    }
}
