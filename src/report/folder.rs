//! Says which folders may be written, and writes a report's files there: whole or not at all.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Deserialize;

use super::draws::zarr;
pub use super::files::{File, Files, Fill, Last, Streamed};
use super::laws;
use crate::error::{named, quoted, Error};
use crate::staging::{self, OutputPlace, Staging};
use crate::{files, findings};

/// The name and version of the layout of `trade.json`.
pub const TRADE_SCHEMA: &str = "wetcor.trade/2";

/// The name and version of the layout of `tracking.json`.
pub const TRACKING_SCHEMA: &str = "wetcor.tracking/1";

/// What a folder holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents {
    /// a fit
    Fit,
    /// a trade of speed against accuracy
    Trade,
    /// tracked recordings
    Tracking,
}

impl Contents {
    /// The file that tells an earlier one of ours, and the schema it names.
    fn mark(self) -> (&'static str, &'static str) {
        match self {
            Contents::Fit => ("findings.json", findings::SCHEMA),
            Contents::Trade => ("trade.json", TRADE_SCHEMA),
            Contents::Tracking => ("tracking.json", TRACKING_SCHEMA),
        }
    }

    /// Whether it is we who write a file of this path inside such a folder.
    fn has(self, inside: &Path, mark: &ReportMark) -> bool {
        let parts: Option<Vec<&str>> = inside.iter().map(OsStr::to_str).collect();
        match (self, parts.as_deref()) {
            (Contents::Trade, Some([name])) => ["trade.md", "trade.json", "trade.svg"].contains(name),
            (Contents::Fit, Some([name])) => [
                "report.md",
                "report.html",
                "findings.json",
                "timing.json",
                laws::LAWS,
                laws::TABLE,
            ]
            .contains(name),
            (Contents::Tracking, Some([name])) => ["report.md", "tracking.json"].contains(name),
            (Contents::Fit | Contents::Tracking, Some(["figures", name])) => match &mark.figures {
                Some(figures) => figures.iter().any(|figure| figure == name),
                // as reports were before they listed their figures
                None => name.ends_with(".svg"),
            },
            (Contents::Fit, Some(["draws", "draws.csv"])) => true,
            (Contents::Fit, Some(["draws", "draws.zarr", .., name])) => zarr::is_file_name(name),
            _ => false,
        }
    }
}

/// What is read of the file that tells.
#[derive(Deserialize)]
struct ReportMark {
    schema: String,
    title: String,
    #[serde(default)]
    figures: Option<Vec<String>>,
}

/// Largest file that may tell an earlier one of ours; those we write are a thousandth of it.
const LARGEST_MARK: u64 = 1 << 28;

/// A folder that may be written, and replaced where it holds an earlier one of ours.
#[derive(Debug)]
pub struct Destination {
    place: OutputPlace,
    contents: Contents,
    title: String,
    /// what is read to fill it, which must not lie inside it
    inputs: Vec<PathBuf>,
}

impl Destination {
    /// Looks whether a folder may be written: before the work, so that nothing is worked out in vain.
    ///
    /// `inputs` are the files that are read for it. Fails where the folder can not be made or replaced, where it holds
    /// anything but an earlier one of ours of the same kind and title, and where an input lies inside it.
    pub fn prepare(folder: &Path, contents: Contents, title: &str, inputs: &[&Path]) -> Result<Destination, Error> {
        let destination = Destination {
            place: staging::prepare(folder)?,
            contents,
            title: title.to_owned(),
            // one that is not there is for its reader to name
            inputs: inputs.iter().filter_map(|input| input.canonicalize().ok()).collect(),
        };
        let turn = destination.place.turn();
        destination.allow(&destination.place)?;
        drop(turn);
        Ok(destination)
    }

    /// Fails unless the place is free or holds an earlier one of ours and nothing else.
    fn allow(&self, place: &OutputPlace) -> Result<(), Error> {
        if !place.is_taken() {
            return Ok(());
        }
        let refuse = |reason: String| Err(Error::out(place.named(), reason));
        let folder = place.path();
        if !folder.symlink_metadata().is_ok_and(|of| of.is_dir()) {
            return refuse("exists and is no folder".to_owned());
        }
        if let Some(input) = self.inputs.iter().find(|input| input.starts_with(folder)) {
            let input = named(input.strip_prefix(folder).unwrap_or(input));
            return refuse(format!("holds {input}, which is read for what would replace it"));
        }
        let (file, schema) = self.contents.mark();
        let Some(mark) = read_mark(&folder.join(file)).filter(|mark| layout(&mark.schema) == layout(schema)) else {
            return refuse(format!("exists and holds no {file} of wetcor"));
        };
        if mark.title != self.title {
            return refuse(format!("holds a report of another scene, {}", quoted(&mark.title)));
        }
        let strangers = strangers(folder, |inside| self.contents.has(inside, &mark));
        let strangers = strangers.map_err(|error| Error::io(place.named(), "look through", error))?;
        match strangers.as_slice() {
            [] => Ok(()),
            [one] => refuse(format!("holds {}, which no report writes", named(one))),
            [one, more @ ..] => {
                let least = if more.len() < MOST_STRANGERS { "" } else { "at least " };
                let (one, more) = (named(one), more.len());
                refuse(format!("holds {one} and {least}{more} more that no report writes"))
            }
        }
    }

    /// Writes the files beside the folder, and puts them in place of an earlier report of ours, whole or not at all.
    pub fn write(&self, files: Files) -> Result<(), Error> {
        self.put(self.beside(files)?)
    }

    /// Writes the files beside the folder, to be put in place once all else is written, too.
    pub fn beside(&self, files: Files) -> Result<Staging, Error> {
        let staging = Staging::beside(&self.place)?;
        // told of the place the user named, not of the one beside it
        let fail = |name: &str, error| Error::io(&self.place.named().join(name), "write", error);
        let create = |name: &str| staging.create(name).map_err(|error| fail(name, error));
        let stream = |streamed: &Streamed| {
            let [a, b] = &streamed.names;
            (streamed.fill)(&mut [create(a)?, create(b)?]).map_err(|error| fail(a, error))
        };
        let write = |(name, bytes): &File| create(name)?.write_all(bytes).map_err(|error| fail(name, error));
        let (streamed, whole) = rayon::join(
            || files.streamed.par_iter().try_for_each(stream),
            || files.whole.par_iter().try_for_each(write),
        );
        streamed.and(whole)?;
        if let Some(last) = files.last {
            write(&last())?;
        }
        Ok(staging)
    }

    /// Puts what was written beside the folder in place of an earlier report of ours.
    pub fn put(&self, written: Staging) -> Result<(), Error> {
        written.put(|place| self.allow(place))
    }
}

/// The name of a layout without its version: reports of every version are ours to replace.
fn layout(schema: &str) -> Option<&str> {
    schema.rsplit_once('/').map(|(name, _)| name)
}

fn read_mark(path: &Path) -> Option<ReportMark> {
    let bytes = files::read(path, LARGEST_MARK, "read").ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// Files that are named, or counted, where a folder is refused for them.
const MOST_STRANGERS: usize = 20;

/// Files below a folder that are not ours by their path inside it, links among them; one more than are counted at most.
fn strangers(folder: &Path, is_ours: impl Fn(&Path) -> bool) -> io::Result<Vec<PathBuf>> {
    let mut strangers = vec![];
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next)? {
            let entry = entry?;
            let (path, kind) = (entry.path(), entry.file_type()?);
            if kind.is_dir() {
                open.push(path);
                continue;
            }
            let inside = path.strip_prefix(folder).unwrap_or(&path);
            if !(kind.is_file() && is_ours(inside)) {
                strangers.push(inside.to_path_buf());
            }
            if strangers.len() > MOST_STRANGERS {
                // enough to refuse; the rest may be a whole disk
                open.clear();
                break;
            }
        }
    }
    strangers.sort();
    Ok(strangers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files<'a>() -> Files<'a> {
        let findings = format!("{{\"schema\": \"{}\", \"title\": \"one\"}}", findings::SCHEMA);
        Files {
            whole: vec![("findings.json".to_owned(), findings.into_bytes())],
            ..Files::default()
        }
    }

    #[test]
    fn what_is_written_beside_is_nowhere_until_it_is_put() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("report");
        let destination = Destination::prepare(&folder, Contents::Fit, "one", &[]).expect("a free place");
        drop(destination.beside(files()).expect("written"));
        assert_eq!(std::fs::read_dir(place.path()).map(Iterator::count).ok(), Some(0));
        let written = destination.beside(files()).expect("written");
        assert!(!folder.exists());
        destination.put(written).expect("a free place");
        assert!(folder.join("findings.json").exists());
    }
}
