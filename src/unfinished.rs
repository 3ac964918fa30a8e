//! Remembers what is being written, so that an interruption leaves nothing half-written behind.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// Files and folders being written now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Stands for one file or folder being written; forgets it when dropped.
#[derive(Debug)]
pub struct Mark(PathBuf);

/// Remembers a file or folder until the mark is dropped.
pub fn mark(path: &Path) -> Mark {
    lock().push(path.to_path_buf());
    Mark(path.to_path_buf())
}

/// Removes everything marked. Waits for a rename under way.
pub fn remove() {
    for path in lock().drain(..) {
        // nothing more can be done here if the system refuses
        let _ = if path.is_dir() {
            std::fs::remove_dir_all(path)
        } else {
            std::fs::remove_file(path)
        };
    }
}

impl Mark {
    /// Makes an interruption wait while a finished piece of work is renamed into place.
    pub fn hold(&self) -> MutexGuard<'static, Vec<PathBuf>> {
        lock()
    }
}

impl Drop for Mark {
    fn drop(&mut self) {
        lock().retain(|path| *path != self.0);
    }
}

fn lock() -> MutexGuard<'static, Vec<PathBuf>> {
    // the list is valid at every instant, so a panic elsewhere does not spoil it
    UNFINISHED.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_marked_is_removed_and_what_was_finished_is_not() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let (kept, lost) = (place.path().join("kept"), place.path().join("lost"));
        std::fs::write(&kept, "x").expect("writable");
        std::fs::create_dir(&lost).expect("writable");
        drop(mark(&kept));
        let _mark = mark(&lost);
        remove();
        assert!(kept.exists() && !lost.exists());
    }
}
