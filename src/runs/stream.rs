//! Reads an ordinary CSV a window of lines at a time, so that a large table is never held as text.

use std::io::Read;

use super::collect::Collected;
use super::columns::{RunColumn, TableLayout};
use super::row::RowChecker;
use super::typed::{CsvParser, Typed};
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::scene::Scene;
use crate::seed::Hash;

/// Bytes of a window: enough to keep every thread busy, little enough to stay in a processor's cache.
pub(super) const WINDOW: usize = 2 << 20;

/// The runs of a CSV and the SHA-256 of its bytes; `None` where anything is out of the ordinary, so that the text
/// reader decides and names what it refuses. `length` is about that of the source, in bytes.
///
/// While one window is parsed, the one before it is checked and the one after it fetched.
pub(super) fn read_streamed(
    source: impl Read + Send,
    length: u64,
    window_size: usize,
    scene: &Scene,
) -> Option<(Collected, String)> {
    let mut lines = LineWindows {
        source,
        window_size,
        rest: vec![],
    };
    let (mut window, mut next) = (vec![], vec![]);
    lines.fetch(&mut window)?;
    let (header, mut start) = plain_header(&window)?;
    let layout = TableLayout::new(&header, None).ok()?;
    let parser = CsvParser::new(&header, &layout)?;
    let has_film_ratio = layout.place(RunColumn::FilmRatio).is_some();
    let mut checker = RowChecker::new(scene, has_film_ratio);
    let rows = rows_like(&window, length);
    let mut collected = Collected::with_capacity(rows, has_film_ratio, &layout.unknown);
    let mut hash = Hash::default();
    let mut parsed: Option<Typed> = None;
    while !window.is_empty() {
        let (typed, (checked, (fetched, ()))) = rayon::join(
            || parser.parse(&window[start..]),
            || {
                rayon::join(
                    || match &parsed {
                        Some(rows) => rows.collect(&layout, &mut checker, &mut collected),
                        None => Some(()),
                    },
                    || rayon::join(|| lines.fetch(&mut next), || hash.update(&window)),
                )
            },
        );
        checked?;
        fetched?;
        parsed = Some(typed?);
        std::mem::swap(&mut window, &mut next);
        start = 0;
    }
    parsed?.collect(&layout, &mut checker, &mut collected)?;
    Some((collected, hash.finish()))
}

/// The names in the first line and where the next line starts; `None` where a name is padded or quoted, or where the
/// text reader would see a binary file or another end of the line.
fn plain_header(window: &[u8]) -> Option<(Vec<String>, usize)> {
    let end = memchr::memchr(b'\n', window)?;
    let line = std::str::from_utf8(&window[..end]).ok()?;
    let line = line.strip_prefix('\u{feff}').unwrap_or(line);
    let line = line.strip_suffix('\r').unwrap_or(line);
    let names: Vec<String> = line.split(',').take(MOST_COLUMNS + 1).map(str::to_owned).collect();
    if names.len() > MOST_COLUMNS || end > MOST_OF_LINE {
        return None;
    }
    let plain = |name: &String| name.trim() == name && !name.contains(['"', '\0', '\r']);
    names.iter().all(plain).then_some((names, end + 1))
}

/// About how many rows a source of some length has if all of it is like this window, rather too many than too few; no
/// more memory is allocated without having seen them.
fn rows_like(window: &[u8], length: u64) -> usize {
    const MOST_FORESEEN: usize = 1 << 24;
    let lines = memchr::memchr_iter(b'\n', window).count();
    let rows = (1.05 * lines as f64 * length as f64 / window.len() as f64) as usize;
    rows.min(MOST_FORESEEN)
}

/// A source to be cut into windows of whole lines.
struct LineWindows<R> {
    source: R,
    window_size: usize,
    /// the start of a line whose rest was not fetched yet
    rest: Vec<u8>,
}

impl<R: Read> LineWindows<R> {
    /// Puts the next lines into `window`, none at the end of the source; `None` where it cannot be read or a line is
    /// longer than a window.
    fn fetch(&mut self, window: &mut Vec<u8>) -> Option<()> {
        window.clear();
        window.append(&mut self.rest);
        let room = self.window_size - window.len();
        let fetched = self.source.by_ref().take(room as u64).read_to_end(window).ok()?;
        if fetched == room {
            let end = memchr::memrchr(b'\n', window)? + 1;
            self.rest.extend_from_slice(&window[end..]);
            window.truncate(end);
        }
        Some(())
    }
}
