//! Makes files beside their place and puts them there in one step: who looks finds the old or the new, and whole.
//!
//! What is being made lies in a folder `.wetcor-…` beside its place, with a file that stays locked while its maker lives.
//! By that lock the next run distinguishes what an earlier one left from the work of a neighbour: it clears what was left, and
//! puts back what had been set aside and not been replaced.
//!
//! | file | job |
//! |---|---|
//! | `rename.rs` | renames as the file system knows how |
//! | `left.rs` | distinguishes what an earlier run left from a neighbour's work, and clears it |
//! | `place.rs` | finds the place, before any work is done for it |

mod left;
mod place;
mod rename;

pub use place::OutputPlace;
pub use rename::take_two_steps;

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};

use tempfile::TempDir;

use crate::error::Error;
use left::{lock, Lock, NEW, OLD, PREFIX};
use rename::{exchange, is_refusal, rename_to_free};

/// Folders of this process in which something is being made.
#[derive(Debug)]
struct Making {
    folders: Vec<PathBuf>,
    /// whether something has been put in its place
    put: bool,
}

impl Making {
    fn forget(&mut self, folder: &Path) {
        self.folders.retain(|other| other != folder);
    }
}

/// Read while a file is created, written while one is begun, put in its place or abandoned: what is abandoned cannot
/// grow again.
static MAKING: RwLock<Making> = RwLock::new(Making {
    folders: vec![],
    put: false,
});

fn making() -> RwLockWriteGuard<'static, Making> {
    // the list is valid at every instant, so a panic elsewhere does not spoil it
    MAKING.write().unwrap_or_else(PoisonError::into_inner)
}

/// What is being made for a place. Dropped, it leaves nothing.
#[derive(Debug)]
pub struct Staging {
    place: OutputPlace,
    /// `None` once it is gone
    folder: Option<TempDir>,
    /// where the file or folder itself is made
    made: PathBuf,
    _lock: Lock,
}

impl Staging {
    /// Times a new folder is tried where neighbours take each for one that was left.
    const TRIES: usize = 100;

    /// Begins a file or folder for a place.
    pub fn beside(place: &OutputPlace) -> Result<Staging, Error> {
        let (base, inside) = place.base();
        // without the folder's name, which means nothing to anybody
        let fail = |error: io::Error| match error.raw_os_error() {
            Some(code) => Error::io(&place.named, "write", io::Error::from_raw_os_error(code)),
            None => Error::io(&place.named, "write", error.kind().into()),
        };
        for _ in 0..Self::TRIES {
            let mut making = making();
            let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(base).map_err(fail)?;
            let Some(lock) = lock(folder.path(), inside).map_err(fail)? else {
                continue;
            };
            making.folders.push(folder.path().to_path_buf());
            // the folders that are missing above the place are made with it, and come to stand with it
            let below: PathBuf = inside.components().skip(1).collect();
            let new = folder.path().join(NEW);
            return Ok(Staging {
                place: place.clone(),
                made: if below.as_os_str().is_empty() {
                    new
                } else {
                    new.join(below)
                },
                folder: Some(folder),
                _lock: lock,
            });
        }
        Err(fail(ErrorKind::WouldBlock.into()))
    }

    /// Creates a file inside the folder that is made, with the folders above it.
    pub fn create(&self, inside: &str) -> io::Result<File> {
        self.create_at(&self.made.join(inside))
    }

    /// Creates the file that is made.
    pub fn create_itself(&self) -> io::Result<File> {
        self.create_at(&self.made)
    }

    /// Writes the file that is made.
    pub fn write(&self, bytes: &[u8]) -> Result<(), Error> {
        let written = self.create_itself().and_then(|mut file| file.write_all(bytes));
        written.map_err(|error| Error::io(&self.place.named, "write", error))
    }

    fn create_at(&self, path: &Path) -> io::Result<File> {
        let _making = MAKING.read().unwrap_or_else(PoisonError::into_inner);
        // by whoever writes there: to make all folders first would keep the others waiting
        path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        File::create(path)
    }

    /// Puts what was made in its place, and removes what stood there.
    ///
    /// `allow` is called just before, and may refuse to have replaced what stands there then.
    pub fn put(mut self, allow: impl Fn(&OutputPlace) -> Result<(), Error>) -> Result<(), Error> {
        let _turn = self.place.turn();
        // from here on an interruption waits
        let mut making = making();
        for _ in 0..Self::TRIES {
            allow(&self.place)?;
            let put = if self.place.is_taken() {
                self.replace(&mut making)
            } else {
                self.move_in()
            };
            match put {
                Ok(()) => {
                    making.put = true;
                    self.end(&mut making);
                    return Ok(());
                }
                // a neighbour was here in between
                Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::AlreadyExists) => {}
                Err(error) => return Err(Error::io(&self.place.named, "write", error)),
            }
        }
        Err(Error::io(&self.place.named, "write", ErrorKind::ResourceBusy.into()))
    }

    /// Moves what was made, with the folders above it that are missing, to where nothing stands.
    fn move_in(&self) -> io::Result<()> {
        let (base, inside) = self.place.base();
        let missing = inside.components().count();
        let Some(top) = inside.components().next() else {
            return Err(ErrorKind::AlreadyExists.into());
        };
        let made = self.made.ancestors().nth(missing.saturating_sub(1));
        rename_to_free(made.unwrap_or(&self.made), &base.join(top))
    }

    /// Puts what was made in place of what stands there.
    fn replace(&mut self, making: &mut Making) -> io::Result<()> {
        let path = &self.place.path;
        if self.made.is_file() {
            return std::fs::rename(&self.made, path);
        }
        match exchange(&self.made, path) {
            Err(error) if is_refusal(&error) => {}
            done => return done,
        }
        // two steps: in between the place is empty, and only a lock and a name are left to put things right by
        let Some(folder) = &self.folder else {
            return Err(ErrorKind::NotFound.into());
        };
        let old = folder.path().join(OLD);
        std::fs::rename(path, &old)?;
        rename::pause();
        let Err(error) = rename_to_free(&self.made, path) else {
            return Ok(());
        };
        if rename_to_free(&old, path).is_err() {
            // it stays where it lies, whatever comes now, and the next run tries again
            if let Some(kept) = self.folder.take().map(TempDir::keep) {
                making.forget(&kept);
            }
        }
        Err(error)
    }

    /// Removes the folder with all that is left in it.
    fn end(&mut self, making: &mut Making) {
        if let Some(folder) = self.folder.take() {
            making.forget(folder.path());
            left::remove(&folder.keep());
        }
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        if self.folder.is_some() {
            self.end(&mut making());
        }
    }
}

/// Finds a place, clears what earlier runs left beside it, and tries whether something can be made there.
///
/// Fails where nothing can be: a name that no file may have, a link to nothing, a folder that may not be written to.
pub fn prepare(named: &Path) -> Result<OutputPlace, Error> {
    let place = OutputPlace::find(named)?;
    drop(Staging::beside(&place)?);
    Ok(place)
}

/// Removes what this process is making, and has every thread wait that would make more. The process must end then.
pub fn abandon() -> Abandoned {
    let mut making = making();
    for folder in making.folders.drain(..) {
        left::remove(&folder);
    }
    Abandoned(making)
}

/// Keeps everything as it was abandoned.
#[derive(Debug)]
pub struct Abandoned(RwLockWriteGuard<'static, Making>);

impl Abandoned {
    /// Whether something had been put in its place before.
    pub fn was_put(&self) -> bool {
        self.0.put
    }
}
