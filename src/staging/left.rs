//! Distinguishes by a lock what an earlier run left from what a neighbour is making, and clears it.

use std::ffi::OsStr;
use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use super::rename::rename_to_free;
use crate::files::options;

/// How the folder begins that something is made in.
pub(super) const PREFIX: &str = ".wetcor-";
/// What lies in such a folder: the locked file, what is being made, and what stood in its place.
const LOCK: &str = "lock";
pub(super) const NEW: &str = "new";
pub(super) const OLD: &str = "old";
const NAMES_MADE: [&str; 2] = [NEW, OLD];
/// How the locked file begins; the name of the place follows, so that what is set aside can be put back.
const MARK: &str = "wetcor makes ";

/// Marks a folder as in use; held as long as this lives, where the file system knows locks.
#[derive(Debug)]
pub(super) struct Lock {
    _file: Option<File>,
}

/// Locks a new folder; `None` where a neighbour has cleared it, or is about to.
pub(super) fn lock(folder: &Path, inside: &Path) -> io::Result<Option<Lock>> {
    let path = folder.join(LOCK);
    let mut file = match File::options().write(true).create_new(true).open(&path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    let locked = match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => return Ok(None),
        Err(TryLockError::Error(_)) => false,
    };
    if !path.exists() {
        return Ok(None);
    }
    file.write_all(MARK.as_bytes())?;
    file.write_all(inside.as_os_str().as_encoded_bytes())?;
    Ok(Some(Lock {
        _file: locked.then_some(file),
    }))
}

/// How long to wait for a neighbour who is putting something in its place beside ours: it takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(10);
const PAUSE: Duration = Duration::from_millis(5);

/// One's turn to move things in a folder; `None` where there are no locks, or somebody sits on it.
pub(super) fn turn(base: &Path) -> Option<File> {
    let folder = File::open(base).ok()?;
    let mut waited = Duration::ZERO;
    while waited < PATIENCE {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            Err(TryLockError::Error(_)) => return None,
        }
        waited += PAUSE;
    }
    None
}

/// Removes a folder in which something was made: the lock last, so that what a sudden end leaves is recognised.
pub(super) fn remove(folder: &Path) {
    for made in NAMES_MADE.map(|name| folder.join(name)) {
        // what the system keeps now, the next run clears
        let _ = if made.is_dir() {
            std::fs::remove_dir_all(made)
        } else {
            std::fs::remove_file(made)
        };
    }
    let _ = std::fs::remove_file(folder.join(LOCK)).and_then(|()| std::fs::remove_dir(folder));
}

/// Clears what processes that are no more have left in a folder.
pub(super) fn clear(base: &Path) {
    let Ok(entries) = std::fs::read_dir(base) else {
        return;
    };
    let left = entries.filter_map(Result::ok).filter(|entry| {
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        is_folder && entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes())
    });
    for entry in left {
        clear_one(base, &entry.path());
    }
}

/// Clears a folder whose maker is no more. One with other things in it, or without our mark in its lock, is left alone.
fn clear_one(base: &Path, folder: &Path) {
    let path = folder.join(LOCK);
    // a pipe would be waited for
    if path.symlink_metadata().is_ok_and(|about| !about.is_file()) {
        return;
    }
    let Ok(mut lock) = options().write(true).open(&path) else {
        // its maker came no further than to make it, or is there now: then it makes another
        let _ = std::fs::remove_dir(folder);
        return;
    };
    if lock.try_lock().is_err() {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let is_ours = |name: &OsStr| [LOCK, NEW, OLD].iter().any(|ours| name == *ours);
    if !entries.filter_map(Result::ok).all(|entry| is_ours(&entry.file_name())) {
        return;
    }
    let mut text = vec![];
    // no path is longer
    let read = Read::take(&mut lock, 1 << 16).read_to_end(&mut text);
    let Some(inside) = read.ok().and_then(|_| text.strip_prefix(MARK.as_bytes())) else {
        let holds_only_lock = NAMES_MADE
            .iter()
            .all(|name| folder.join(name).symlink_metadata().is_err());
        // its maker ended before it had made anything
        if text.is_empty() && holds_only_lock {
            remove(folder);
        }
        return;
    };
    let old = folder.join(OLD);
    if old.exists() {
        let _turn = turn(base);
        let Some(name) = path_of(inside).filter(|inside| inside.file_name() == Some(inside.as_os_str())) else {
            return;
        };
        match rename_to_free(&old, &base.join(name)) {
            // a newer one has come to its place
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return,
            _ => {}
        }
    }
    remove(folder);
}

/// The path some bytes of a file are.
fn path_of(bytes: &[u8]) -> Option<&Path> {
    #[cfg(unix)]
    {
        Some(Path::new(std::os::unix::ffi::OsStrExt::from_bytes(bytes) as &OsStr))
    }
    #[cfg(not(unix))]
    {
        std::str::from_utf8(bytes).ok().map(Path::new)
    }
}
