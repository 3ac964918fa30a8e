//! Reads an ordinary CSV a window of lines at a time, so that a large table is never held as text.

use std::io::Read;

use rayon::prelude::*;

use super::collect::Collected;
use super::columns::{ColumnPlace, HeaderRemarks, TableLayout};
use super::decimals::{parse_number, separator_of, DecimalMarks};
use super::row::{check_row, RawRow, RowChecker};
use crate::files::{MOST_COLUMNS, MOST_OF_LINE};
use crate::scene::{Naming, RunColumn, Scene};
use crate::seed::Hash;

/// Bytes of a window: enough to keep every thread busy, little enough to stay in a processor's cache.
pub(super) const WINDOW: usize = 2 << 20;

/// In how many pieces a window is parsed: enough for threads to share it evenly.
const PIECES: usize = 16;

/// The runs of a CSV and the SHA-256 of its bytes; `None` where anything is out of the ordinary, so that the text
/// reader decides and names what it refuses. `length` is about that of the source, in bytes.
///
/// While one window is parsed, the runs of the one before it are gathered and the one after it is fetched.
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
    let PlainHeader {
        names,
        separator,
        mut start,
    } = plain_header(&window, &scene.data.naming)?;
    let layout = TableLayout::new(&names, None, &scene.data.naming).ok()?;
    let parser = LineParser::new(scene, &layout, separator, window_size / PIECES);
    let rows = rows_like(&window, length);
    let mut collected = Collected::with_capacity(rows, parser.checker.has_film_ratio, &layout.remarks);
    let mut hash = Hash::default();
    let mut parsed = vec![];
    let mut marks = DecimalMarks::default();
    while !window.is_empty() {
        let (of_window, (fetched, ((), ()))) = rayon::join(
            || parser.parse_pieces(&window[start..]),
            || {
                rayon::join(
                    || lines.fetch(&mut next),
                    || rayon::join(|| hash.update(&window), || collected.extend(&parsed)),
                )
            },
        );
        fetched?;
        (parsed, marks) = of_window?
            .into_iter()
            .fold((vec![], marks), |(mut all, marks), (piece, of_piece)| {
                all.push(piece);
                (all, marks.and(of_piece))
            });
        if marks.are_mixed() {
            return None;
        }
        std::mem::swap(&mut window, &mut next);
        start = 0;
    }
    if marks.are_ambiguous() {
        return None;
    }
    collected.extend(&parsed);
    Some((collected, hash.finish()))
}

/// Parses and checks the lines of an ordinary CSV.
struct LineParser<'s> {
    checker: RowChecker<'s>,
    layout: &'s TableLayout<'s>,
    separator: u8,
    /// what the cells of a line hold; `None` where it is not read
    columns: Vec<Option<(RunColumn, ColumnPlace)>>,
    /// about how many bytes are parsed at one go
    piece: usize,
}

impl<'s> LineParser<'s> {
    fn new(scene: &'s Scene, layout: &'s TableLayout<'s>, separator: u8, piece: usize) -> Self {
        let mut columns = vec![None; layout.width];
        for column in RunColumn::ALL {
            if let Some(place) = layout.place(column) {
                columns[place.index] = Some((column, place.clone()));
            }
        }
        LineParser {
            checker: RowChecker::new(scene, layout.gives(RunColumn::FilmRatio)),
            layout,
            separator,
            columns,
            piece,
        }
    }

    /// The runs of some lines, a piece after the other; `None` where anything is out of the ordinary.
    fn parse_pieces(&self, lines: &[u8]) -> Option<Vec<(Collected, DecimalMarks)>> {
        let mut pieces = vec![];
        let mut rest = lines;
        while !rest.is_empty() {
            let least = rest.len().min(self.piece);
            let end = memchr::memchr(b'\n', &rest[least..]).map_or(rest.len(), |at| least + at + 1);
            let (piece, after) = rest.split_at(end);
            pieces.push(piece);
            rest = after;
        }
        pieces.into_par_iter().map(|piece| self.parse(piece)).collect()
    }

    fn parse(&self, lines: &[u8]) -> Option<(Collected, DecimalMarks)> {
        // what quotes and zero bytes mean, and a line that ends with CR alone, is left to the text reader
        let ends_line = |at: usize| lines.get(at + 1) == Some(&b'\n');
        if memchr::memchr2(b'"', 0, lines).is_some() || !memchr::memchr_iter(b'\r', lines).all(ends_line) {
            return None;
        }
        let text = std::str::from_utf8(lines).ok()?;
        let rows = memchr::memchr_iter(b'\n', lines).count() + 1;
        let mut checker = self.checker.clone();
        let mut collected = Collected::with_capacity(rows, checker.has_film_ratio, &HeaderRemarks::default());
        let mut bad = vec![];
        let mut marks = DecimalMarks::default();
        let mut row = self.layout.row_before_its_cells();
        // runs come in blocks: cells that repeat those above them are not parsed again
        let (mut above, mut ends) = (&lines[..0], vec![]);
        let mut line = 0;
        while line < lines.len() {
            let same = shared_length(&lines[line..], above);
            ends.truncate(ends.partition_point(|end| *end < same));
            let mut start = ends.last().map_or(line, |end| line + end + 1);
            loop {
                let end = memchr::memchr2(self.separator, b'\n', &lines[start..]).map_or(lines.len(), |at| start + at);
                let of_cell = self.parse_cell(text.get(start..end)?, ends.len(), &mut row)?;
                marks = marks.and(of_cell);
                ends.push(end - line);
                start = end + 1;
                if lines.get(end) != Some(&self.separator) {
                    break;
                }
            }
            above = &lines[line..start - 1];
            line = start;
            if above.trim_ascii().is_empty() {
                (above, ends) = (&[], vec![]);
                continue;
            }
            if ends.len() != self.columns.len() || above.len() > MOST_OF_LINE {
                return None;
            }
            if let Some(reason) = row.exclude {
                collected.exclude(reason);
                continue;
            }
            let checked = check_row(&row, &mut checker, &mut bad)?;
            collected.push(&checked, checker.has_film_ratio, checker.scene);
        }
        Some((collected, marks))
    }

    /// Puts what a cell holds into its place in a row, and gives the marks of its decimals; `None` where it is no number or
    /// no cell of the table.
    fn parse_cell<'t>(&self, cell: &'t str, index: usize, row: &mut RawRow<'t>) -> Option<DecimalMarks>
    where
        's: 't,
    {
        let Some((column, place)) = self.columns.get(index)? else {
            return Some(DecimalMarks::default());
        };
        let cell = self.layout.read(*column, cell);
        if !column.is_number() {
            row.set_word(*column, cell);
            return Some(DecimalMarks::default());
        }
        let number = cell.map(parse_number).transpose().ok()?;
        row.set(*column, number.map(|number| place.to_si(number.value)));
        Some(number.map_or(DecimalMarks::default(), |number| number.marks))
    }
}

/// How many bytes two texts have in common from their start.
fn shared_length(one: &[u8], other: &[u8]) -> usize {
    const STEP: usize = 16;
    let steps = one.as_chunks::<STEP>().0.iter().zip(other.as_chunks().0);
    let start = STEP * steps.take_while(|(a, b)| a == b).count();
    let rest = one[start..].iter().zip(&other[start..]);
    start + rest.take_while(|(a, b)| a == b).count()
}

/// The first line of a CSV.
struct PlainHeader {
    names: Vec<String>,
    separator: u8,
    /// where the next line starts
    start: usize,
}

/// The header; `None` where a name is padded or quoted, or where the text reader would see a binary file or another end of
/// the line.
fn plain_header(window: &[u8], naming: &Naming) -> Option<PlainHeader> {
    let end = memchr::memchr(b'\n', window)?;
    let line = std::str::from_utf8(&window[..end]).ok()?;
    let line = line.strip_prefix('\u{feff}').unwrap_or(line);
    let line = line.strip_suffix('\r').unwrap_or(line);
    let separator = separator_of(line, naming);
    let names = line.split(char::from(separator)).take(MOST_COLUMNS + 1);
    let names: Vec<String> = names.map(str::to_owned).collect();
    if names.len() > MOST_COLUMNS || end > MOST_OF_LINE {
        return None;
    }
    let plain = |name: &String| name.trim() == name && !name.contains(['"', '\0', '\r']);
    let start = end + 1;
    names.iter().all(plain).then_some(PlainHeader {
        names,
        separator,
        start,
    })
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
