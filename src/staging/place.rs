//! Finds the place of a file or folder to be written, before any work is done for it.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::left::{clear, turn};
use crate::error::Error;

/// A file or folder to be written.
#[derive(Debug, Clone)]
pub struct OutputPlace {
    /// as the user named it
    pub(super) named: PathBuf,
    /// from the root, links followed: where it is, whatever becomes of the working folder
    pub(super) path: PathBuf,
}

impl OutputPlace {
    /// Finds the place, and clears what earlier runs left beside it.
    ///
    /// Fails for a name that no file may have, a link to nothing, and what may not be replaced.
    pub(super) fn find(named: &Path) -> Result<OutputPlace, Error> {
        if !names_itself(named) {
            return Err(Error::out(named, "expected a name that does not end in `.` or `..`"));
        }
        let fail = |error: io::Error| Error::io(named, "write", error);
        let path = std::path::absolute(named).and_then(|path| follow(&path));
        let Some(path) = path.map_err(fail)? else {
            return Err(Error::out(named, "is a link to nothing"));
        };
        let place = OutputPlace {
            named: named.to_path_buf(),
            path,
        };
        clear(place.base().0);
        if place.is_mounted() {
            return Err(Error::out(
                named,
                "is where a file system begins; name a folder inside it",
            ));
        }
        place.may_be_replaced().map_err(fail)?;
        Ok(place)
    }

    /// One's turn to look at what stands there, or to replace it, as long as what is returned lives.
    pub fn turn(&self) -> Option<File> {
        turn(self.base().0)
    }

    /// As the user named it.
    pub fn named(&self) -> &Path {
        &self.named
    }

    /// Where it is: from the root, links followed.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether anything stands there.
    pub fn is_taken(&self) -> bool {
        self.path.symlink_metadata().is_ok()
    }

    /// Fails where anything stands there; `kind` is what `--out` names, a file or a folder.
    pub fn check_free(&self, kind: &str) -> Result<(), Error> {
        if self.is_taken() {
            return Err(Error::out(&self.named, format!("exists; --out names another {kind}")));
        }
        Ok(())
    }

    /// Fails where something stands there that is no file, or a file unless that is to be replaced.
    pub fn check_replaceable(&self, replaces: bool) -> Result<(), Error> {
        match self.path.symlink_metadata() {
            Ok(of) if !of.is_file() => Err(Error::out(&self.named, "exists and is no file")),
            Ok(_) if !replaces => Err(Error::out(&self.named, "exists; --force replaces it")),
            _ => Ok(()),
        }
    }

    /// The nearest folder above that is there, and the path from it to the place.
    pub(super) fn base(&self) -> (&Path, &Path) {
        let above = self.path.ancestors().skip(1);
        let base = above.into_iter().find(|folder| folder.is_dir());
        let base = base.unwrap_or(&self.path);
        (base, self.path.strip_prefix(base).unwrap_or(&self.path))
    }

    /// Fails where what stands there may not be written to: a folder then may not be renamed either.
    fn may_be_replaced(&self) -> io::Result<()> {
        #[cfg(unix)]
        if self.path.is_dir() {
            rustix::fs::access(&self.path, rustix::fs::Access::WRITE_OK)?;
        }
        Ok(())
    }

    /// Whether it is the root of a file system, which cannot be exchanged.
    fn is_mounted(&self) -> bool {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let device = |path: &Path| path.metadata().ok().map(|of| of.dev());
            let (here, above) = (device(&self.path), device(self.base().0));
            here.is_some() && here != above
        }
        #[cfg(not(unix))]
        false
    }
}

/// Whether a path ends in a name, not in a step to a folder.
fn names_itself(path: &Path) -> bool {
    let bytes = path.as_os_str().as_encoded_bytes();
    let end = bytes
        .rsplit(|byte| std::path::is_separator(char::from(*byte)))
        .find(|part| !part.is_empty());
    !matches!(end, None | Some(b"." | b".."))
}

/// Letters of the longest path inside a report, and some more.
const LONGEST_INSIDE: usize = 200;

/// A path with its links followed as far as it is there; `None` for a link to nothing.
///
/// Fails where the system would not let the rest be made for its name.
fn follow(path: &Path) -> io::Result<Option<PathBuf>> {
    let mut missing: Vec<&OsStr> = vec![];
    let mut here = path;
    let mut found = loop {
        match here.canonicalize() {
            Ok(found) => break found,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                match here.symlink_metadata() {
                    Ok(about) if about.is_symlink() => return Ok(None),
                    // a neighbour has just put it there
                    Ok(_) => continue,
                    Err(_) => {}
                }
                let (Some(parent), Some(name)) = (here.parent(), here.file_name()) else {
                    return Err(error);
                };
                missing.push(name);
                here = parent;
            }
            Err(error) => return Err(error),
        }
    };
    let may_be = |path: PathBuf| match path.symlink_metadata() {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    };
    for name in missing.iter().rev() {
        // a name too long is refused only for a folder that is there
        may_be(here.join(name))?;
        found.push(name);
    }
    may_be(found.join("x".repeat(LONGEST_INSIDE))).or_else(|error| match error.kind() {
        ErrorKind::InvalidFilename => Err(error),
        _ => Ok(()),
    })?;
    Ok(Some(found))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

    use super::*;

    #[test]
    fn a_place_that_a_neighbour_makes_meanwhile_is_found() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let place = folder.path().join("report");
        let ended = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !ended.load(Relaxed) {
                    std::fs::create_dir(&place).expect("writable");
                    std::fs::remove_dir(&place).expect("writable");
                }
            });
            let found = (0..100_000).all(|_| matches!(follow(&place), Ok(Some(_))));
            ended.store(true, Relaxed);
            assert!(found);
        });
    }
}
