//! Renames as the file system knows how: by exchange, or to a name that nothing has.

use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// Set by tests: behave as on a file system that cannot exchange, and wait so many milliseconds between the two steps.
static TWO_STEPS: AtomicU64 = AtomicU64::new(EXCHANGE);
const EXCHANGE: u64 = u64::MAX;

/// Behaves from now on as on a file system that cannot exchange two folders in one step, and takes its time between the
/// two. For tests.
#[doc(hidden)]
pub fn take_two_steps(milliseconds: u64) {
    TWO_STEPS.store(milliseconds, Relaxed);
}

/// Takes the time that tests ask for between two steps.
pub(super) fn pause() {
    match TWO_STEPS.load(Relaxed) {
        EXCHANGE => {}
        milliseconds => std::thread::sleep(Duration::from_millis(milliseconds)),
    }
}

/// Exchanges two files or folders in one step, so that neither place is empty at any time.
pub(super) fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    if TWO_STEPS.load(Relaxed) != EXCHANGE {
        return Err(ErrorKind::Unsupported.into());
    }
    rename_with(one, other, Renaming::Exchange)
}

/// Gives a file or folder a name that nothing has.
pub(super) fn rename_to_free(from: &Path, to: &Path) -> io::Result<()> {
    match rename_with(from, to, Renaming::ToFree) {
        Err(error) if is_refusal(&error) => {}
        done => return done,
    }
    if to.symlink_metadata().is_ok() {
        return Err(ErrorKind::AlreadyExists.into());
    }
    std::fs::rename(from, to)
}

/// How a file system may rename.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Renaming {
    Exchange,
    ToFree,
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn rename_with(from: &Path, to: &Path, how: Renaming) -> io::Result<()> {
    use rustix::fs::{renameat_with, RenameFlags, CWD};
    let flags = match how {
        Renaming::Exchange => RenameFlags::EXCHANGE,
        Renaming::ToFree => RenameFlags::NOREPLACE,
    };
    Ok(renameat_with(CWD, from, CWD, to, flags)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn rename_with(_from: &Path, _to: &Path, _how: Renaming) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

/// Whether the file system does not rename so.
pub(super) fn is_refusal(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput)
}
