//! Holds the files of a report before they are written.

use std::io;

/// A file of a report: its path inside the folder, and its bytes.
pub type File = (String, Vec<u8>);

/// Every file of a report.
#[derive(Default)]
pub struct Files<'a> {
    /// those whose bytes are there
    pub whole: Vec<File>,
    /// those too large to be held
    pub streamed: Vec<Streamed<'a>>,
    /// one that is made when all others are written
    pub last: Option<Last<'a>>,
}

impl Files<'_> {
    /// Texts, each with its path.
    pub fn of(texts: impl IntoIterator<Item = (String, String)>) -> Self {
        let bytes = |(name, text): (String, String)| (name, text.into_bytes());
        Files {
            whole: texts.into_iter().map(bytes).collect(),
            ..Files::default()
        }
    }
}

/// Makes a file.
pub type Last<'a> = Box<dyn FnOnce() -> File + Send + Sync + 'a>;

/// Two files that come from one computation, made while they are written.
pub struct Streamed<'a> {
    /// their paths inside the folder
    pub names: [String; 2],
    /// writes them, both empty at first
    pub fill: Box<Fill<'a>>,
}

/// Fills files. Fails where the system refuses.
pub type Fill<'a> = dyn Fn(&mut [std::fs::File; 2]) -> io::Result<()> + Send + Sync + 'a;
