//! Writes a report's files beside their place and renames them in: whole or not at all.

use std::path::Path;

use rayon::prelude::*;
use serde::Deserialize;

use crate::error::Error;
use crate::unfinished;
use crate::{findings, study};

/// A file of a report: its path inside the folder, and its bytes.
pub type File = (String, Vec<u8>);

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
pub fn write(folder: &Path, contents: Contents, title: &str, files: &[File]) -> Result<(), Error> {
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
    files: &[File],
    mark: unfinished::Mark,
) -> Result<(), Error> {
    let new = beside.path().join("new");
    files.par_iter().try_for_each(|(name, bytes)| {
        let path = new.join(name);
        let inside = path.parent().unwrap_or(&new);
        // told of the place the user named, not of the one beside it
        let fail = |error| Error::io(&folder.join(name), "write", error);
        std::fs::create_dir_all(inside).map_err(fail)?;
        std::fs::write(&path, bytes).map_err(fail)
    })?;
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
    use super::*;

    fn files(title: &str, body: &str) -> Vec<File> {
        let findings = format!("{{\"schema\": \"{}\", \"title\": \"{title}\"}}", findings::SCHEMA);
        vec![
            ("findings.json".to_owned(), findings.into_bytes()),
            ("figures/a.svg".to_owned(), body.as_bytes().to_vec()),
        ]
    }

    #[test]
    fn an_earlier_report_of_the_same_title_is_replaced_whole() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("deep/report");
        write(&folder, Contents::Fit, "one", &files("one", "first")).expect("a free place");
        std::fs::write(folder.join("stale.txt"), "x").expect("writable");
        write(&folder, Contents::Fit, "one", &files("one", "second")).expect("ours");
        let read = std::fs::read_to_string(folder.join("figures/a.svg"));
        assert_eq!(read.ok().as_deref(), Some("second"));
        assert!(!folder.join("stale.txt").exists());
        let left = std::fs::read_dir(place.path().join("deep")).map(Iterator::count);
        assert_eq!(left.ok(), Some(1), "nothing unfinished is left beside");
    }

    #[test]
    fn what_is_not_ours_is_left_alone() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("theirs");
        std::fs::create_dir(&folder).expect("writable");
        std::fs::write(folder.join("thesis.tex"), "years of work").expect("writable");
        assert!(matches!(
            write(&folder, Contents::Fit, "one", &files("one", "")),
            Err(Error::Out { .. })
        ));
        std::fs::write(folder.join("findings.json"), "{\"schema\": \"other\"}").expect("writable");
        assert!(matches!(check(&folder, Contents::Fit, "one"), Err(Error::Out { .. })));
        let ours = place.path().join("ours");
        write(&ours, Contents::Fit, "one", &files("one", "")).expect("a free place");
        assert!(matches!(check(&ours, Contents::Fit, "two"), Err(Error::Out { .. })));
        assert!(matches!(check(&ours, Contents::Trade, "one"), Err(Error::Out { .. })));
        assert!(folder.join("thesis.tex").exists());
    }
}
