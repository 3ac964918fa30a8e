//! Writes a report's files beside their place and renames them in: whole or not at all.

use std::fmt;
use std::io;
use std::path::Path;

use rayon::prelude::*;
use serde::Deserialize;

use crate::error::Error;
use crate::unfinished;
use crate::{findings, study};

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

impl fmt::Debug for Files<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whole = self.whole.iter().map(|(name, _)| name);
        let streamed = self.streamed.iter().flat_map(|streamed| &streamed.names);
        f.debug_set().entries(whole.chain(streamed)).finish()
    }
}

/// What a folder holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// a fit
    Fit,
    /// a trade of speed against accuracy
    Trade,
}

impl Contents {
    /// The file that tells an earlier one of ours, and the schema it names.
    fn mark(self) -> (&'static str, &'static str) {
        match self {
            Contents::Fit => ("findings.json", findings::SCHEMA),
            Contents::Trade => ("trade.json", study::trade::SCHEMA),
        }
    }
}

/// What is read of the file that tells.
#[derive(Deserialize)]
struct Mark {
    schema: String,
    title: String,
}

/// Fails unless `folder` is free or holds an earlier one of ours of the same kind and title.
pub fn check(folder: &Path, contents: Contents, title: &str) -> Result<(), Error> {
    let (file, schema) = contents.mark();
    let refuse = |reason: String| {
        Err(Error::Out {
            path: folder.to_path_buf(),
            reason,
        })
    };
    if !folder.exists() {
        return match std::fs::symlink_metadata(folder) {
            Ok(_) => refuse("is a link to nothing".to_owned()),
            Err(_) => Ok(()),
        };
    }
    if !folder.is_dir() {
        return refuse("exists and is no folder".to_owned());
    }
    let mark = std::fs::read_to_string(folder.join(file))
        .ok()
        .and_then(|text| serde_json::from_str::<Mark>(&text).ok())
        .filter(|mark| mark.schema == schema);
    match mark {
        None => refuse(format!("exists and holds no {file} of wetcor")),
        Some(mark) if mark.title != title => refuse(format!("holds a report of another scene, \"{}\"", mark.title)),
        Some(_) => Ok(()),
    }
}

/// Writes the files and puts the folder in place of an earlier report of ours.
pub fn write(folder: &Path, contents: Contents, title: &str, files: Files) -> Result<(), Error> {
    check(folder, contents, title)?;
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, "create", e))?;
    let beside = tempfile::Builder::new()
        .prefix(".wetcor-")
        .tempdir_in(parent)
        .map_err(|e| Error::io(parent, "write in", e))?;
    let mark = unfinished::mark(beside.path());
    fill_and_rename(beside, folder, files, mark)
}

fn fill_and_rename(
    beside: tempfile::TempDir,
    folder: &Path,
    files: Files,
    mark: unfinished::Mark,
) -> Result<(), Error> {
    let new = beside.path().join("new");
    // told of the place the user named, not of the one beside it
    let fail = |name: &str, error| Error::io(&folder.join(name), "write", error);
    let room = |name: &str| {
        let path = new.join(name);
        // by whoever writes there: to make all folders first would keep the others waiting
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        made.map(|()| path).map_err(|error| fail(name, error))
    };
    let stream = |streamed: &Streamed| {
        let [a, b] = &streamed.names;
        let open = |name: &str| std::fs::File::create(room(name)?).map_err(|error| fail(name, error));
        (streamed.fill)(&mut [open(a)?, open(b)?]).map_err(|error| fail(a, error))
    };
    let write = |(name, bytes): &File| std::fs::write(room(name)?, bytes).map_err(|error| fail(name, error));
    let (streamed, whole) = rayon::join(
        || files.streamed.par_iter().try_for_each(stream),
        || files.whole.par_iter().try_for_each(write),
    );
    streamed.and(whole)?;
    if let Some(last) = files.last {
        write(&last())?;
    }
    // from here on an interruption waits, so that either the old report or the new one is in place
    let _hold = mark.hold();
    let old = beside.path().join("old");
    let had_one = folder.exists();
    if had_one {
        std::fs::rename(folder, &old).map_err(|e| Error::io(folder, "replace", e))?;
    }
    if let Err(error) = std::fs::rename(&new, folder) {
        if had_one {
            // put the earlier report back; if even that fails, it is kept where it lies
            if std::fs::rename(&old, folder).is_err() {
                let _ = beside.keep();
            }
        }
        return Err(Error::io(folder, "write", error));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn files<'a>(title: &str, body: &str) -> Files<'a> {
        let findings = format!("{{\"schema\": \"{}\", \"title\": \"{title}\"}}", findings::SCHEMA);
        Files {
            whole: vec![
                ("findings.json".to_owned(), findings.into_bytes()),
                ("figures/a.svg".to_owned(), body.as_bytes().to_vec()),
            ],
            ..Files::default()
        }
    }

    #[test]
    fn an_earlier_report_of_the_same_title_is_replaced_whole() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("deep/report");
        write(&folder, Contents::Fit, "one", files("one", "first")).expect("a free place");
        std::fs::write(folder.join("stale.txt"), "x").expect("writable");
        write(&folder, Contents::Fit, "one", files("one", "second")).expect("ours");
        let read = std::fs::read_to_string(folder.join("figures/a.svg"));
        assert_eq!(read.ok().as_deref(), Some("second"));
        assert!(!folder.join("stale.txt").exists());
        let left = std::fs::read_dir(place.path().join("deep")).map(Iterator::count);
        assert_eq!(left.ok(), Some(1), "nothing unfinished is left beside");
    }

    #[test]
    fn what_is_made_while_it_is_written_is_there_or_nothing_is() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("report");
        let made = |broken: bool| {
            let mut made = files("one", "");
            let names = ["deep/er/a", "b"].map(str::to_owned);
            let fill: Box<Fill> = Box::new(move |[a, b]| {
                a.write_all(b"first")?;
                if broken {
                    return Err(io::Error::other("no room"));
                }
                b.write_all(b"second")
            });
            made.streamed.push(Streamed { names, fill });
            made.last = Some(Box::new(|| ("deep/last".to_owned(), b"third".to_vec())));
            made
        };
        write(&folder, Contents::Fit, "one", made(false)).expect("a free place");
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).ok();
        assert_eq!(read("deep/er/a").as_deref(), Some("first"));
        assert_eq!(read("b").as_deref(), Some("second"));
        assert_eq!(read("deep/last").as_deref(), Some("third"));
        let failed = write(&folder, Contents::Fit, "one", made(true))
            .expect_err("no room")
            .to_string();
        assert!(failed.contains("deep/er/a") && failed.contains("no room"), "{failed}");
        assert_eq!(read("b").as_deref(), Some("second"), "the earlier report stands");
    }

    #[test]
    fn what_is_not_ours_is_left_alone() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("theirs");
        std::fs::create_dir(&folder).expect("writable");
        std::fs::write(folder.join("thesis.tex"), "years of work").expect("writable");
        assert!(matches!(
            write(&folder, Contents::Fit, "one", files("one", "")),
            Err(Error::Out { .. })
        ));
        std::fs::write(folder.join("findings.json"), "{\"schema\": \"other\"}").expect("writable");
        assert!(matches!(check(&folder, Contents::Fit, "one"), Err(Error::Out { .. })));
        let ours = place.path().join("ours");
        write(&ours, Contents::Fit, "one", files("one", "")).expect("a free place");
        assert!(matches!(check(&ours, Contents::Fit, "two"), Err(Error::Out { .. })));
        assert!(matches!(check(&ours, Contents::Trade, "one"), Err(Error::Out { .. })));
        assert!(folder.join("thesis.tex").exists());
    }
}
