//! Opens input files, and reads no more of one than a stated size.
//!
//! A regular file says how long it is before a byte of it is read. A pipe (a FIFO, what a shell puts for `<(command)`,
//! `/dev/stdin`) does not, and can be read only once: it is read whole, up to a size. Whatever else a path may name, a
//! folder, a device, a socket, has no end or no content, and is refused.

use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::{Error as IoError, ErrorKind, Read};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::error::{Error, Problem};

const MIB: u64 = 1 << 20;

/// Bytes of the longest scene.
pub(crate) const MOST_OF_SCENE: u64 = 16 * MIB;

/// Bytes of the longest table that is read from a pipe; one in a file may be longer.
pub(crate) const MOST_OF_PIPE: u64 = 64 * MIB;

/// Bytes of the largest workbook, and of what it may unpack to.
pub(crate) const MOST_OF_WORKBOOK: u64 = 64 * MIB;
pub(crate) const MOST_UNPACKED: u64 = 1024 * MIB;

/// Bytes of the longest Parquet table of which every run is kept.
pub(crate) const MOST_OF_PARQUET: u64 = 2048 * MIB;

/// Bytes of the longest line of a table, and of the longest row, which a quote may carry over several lines.
pub(crate) const MOST_OF_LINE: usize = 1 << 20;

/// Columns of the widest table.
pub(crate) const MOST_COLUMNS: usize = 4096;

/// Endings of files that are recordings of a camera or a video.
const VIDEOS: [&str; 17] = [
    "mp4", "avi", "mov", "mkv", "webm", "wmv", "m4v", "mpg", "mpeg", "mts", "m2ts", "3gp", "flv", "ogv", "cine",
    "mraw", "y4m",
];

/// Whether a file is a video by its name.
pub(crate) fn is_video(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default();
    VIDEOS.iter().any(|video| ending.eq_ignore_ascii_case(video))
}

/// How long a pipe is waited for that nobody writes to: a command beside this one may only be starting.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a path was found to name.
pub(crate) enum Input {
    /// a regular file, with its length
    File(File, u64),
    /// a pipe
    Pipe(File),
}

/// Opens a regular file or a pipe; `doing` says what for, as a verb.
///
/// A pipe is opened without waiting for somebody who writes to it. Fails with what else the path names.
pub(crate) fn open(path: &Path, doing: &'static str) -> Result<Input, Error> {
    let fail = |error: IoError| Error::io(path, doing, error);
    // a device may do something as it is opened
    let refuse = |about: Metadata| match what_else(about.file_type()) {
        Some(found) => {
            let text = format!("found {found}, expected a regular file or a pipe");
            Err(fail(IoError::new(ErrorKind::InvalidInput, text)))
        }
        None => Ok(about),
    };
    refuse(std::fs::metadata(path).map_err(fail)?)?;
    let file = options().open(path).map_err(fail)?;
    let about = refuse(file.metadata().map_err(fail)?)?;
    Ok(if about.is_file() {
        Input::File(file, about.len())
    } else {
        Input::Pipe(file)
    })
}

/// Reads a file or a pipe of at most so many bytes.
///
/// Fails with the limit where it holds more, before memory is asked for.
pub(crate) fn read(path: &Path, most: u64, doing: &'static str) -> Result<Vec<u8>, Error> {
    match open(path, doing)? {
        Input::File(file, length) => read_file(&file, length, path, most, doing),
        Input::Pipe(pipe) => read_pipe(&pipe, path, most, doing),
    }
}

/// Reads a regular file of at most so many bytes.
pub(crate) fn read_file(
    mut file: &File,
    length: u64,
    path: &Path,
    most: u64,
    doing: &'static str,
) -> Result<Vec<u8>, Error> {
    check_length(path, length, most)?;
    let fail = |error: IoError| Error::io(path, doing, error);
    let mut bytes = vec![];
    let room = bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX));
    room.map_err(|_| fail(ErrorKind::OutOfMemory.into()))?;
    // it may grow, and some files of the system's own do not tell their length
    file.by_ref().take(most + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > most {
        return Err(too_large(path, "more", most));
    }
    Ok(bytes)
}

/// Fails where a file of such a length has more than so many bytes.
pub(crate) fn check_length(path: &Path, length: u64, most: u64) -> Result<(), Error> {
    match length > most {
        true => Err(too_large(path, &format!("{length} bytes"), most)),
        false => Ok(()),
    }
}

fn too_large(path: &Path, found: &str, most: u64) -> Error {
    let expected = format!("expected at most {most} bytes ({} MiB)", most / MIB);
    let problem = Problem::new("the file is too large", expected).found(found.to_owned());
    Error::input(path, vec![problem])
}

/// Reads what is written to the pipe, at most so many bytes, as long as somebody has it open for writing.
///
/// Fails with the limit where there is more, and where nobody writes to it.
pub(crate) fn read_pipe(mut pipe: &File, path: &Path, most: u64, doing: &'static str) -> Result<Vec<u8>, Error> {
    /// between two looks at a pipe that has nothing yet
    const PAUSE: Duration = Duration::from_millis(1);
    let fail = |error: IoError| Error::io(path, doing, error);
    let opened = Instant::now();
    let (mut bytes, mut piece) = (vec![], vec![0; MIB as usize]);
    loop {
        match pipe.read(&mut piece) {
            // nobody has it open: nobody any more, or nobody yet
            Ok(0) if !bytes.is_empty() => return Ok(bytes),
            Ok(0) if opened.elapsed() > PATIENCE => {
                let text = "found a pipe that nobody writes to";
                return Err(fail(IoError::new(ErrorKind::InvalidInput, text)));
            }
            Ok(0) => std::thread::sleep(PAUSE),
            Ok(more) => bytes.extend_from_slice(&piece[..more]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::sleep(PAUSE),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(fail(error)),
        }
        if bytes.len() as u64 > most {
            return Err(too_large(path, "more", most));
        }
    }
}

/// What a path names that is neither a regular file nor a pipe.
fn what_else(of: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if of.is_fifo() {
            return None;
        }
        if of.is_socket() {
            return Some("a socket");
        }
    }
    if of.is_file() {
        None
    } else if of.is_dir() {
        Some("a folder")
    } else {
        Some("a device")
    }
}

/// How a file is opened for reading that may turn out to be a pipe.
pub(crate) fn options() -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        // else a pipe that nobody writes to is waited for as it is opened, for ever
        let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
        options.custom_flags(flags.bits() as i32);
    }
    options
}
