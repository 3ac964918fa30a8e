//! Cuts a CSV into windows of whole records, so that a large table is never held as text.

use std::fmt::Display;
use std::io::Read;
use std::ops::Range;

use memchr::{memchr, memchr2, memrchr2};

use super::records::{after_line_end, record_end};
use super::refusals::whole_file;
use crate::encoding::BYTE_ORDER_MARK;
use crate::error::Problem;
use crate::files::MOST_OF_LINE;

/// Bytes of a window: enough to keep every thread busy, little enough to stay in a processor's cache.
pub(super) const WINDOW: usize = 2 << 20;

/// In how many pieces a window is parsed: enough for threads to share it evenly.
const PIECES: usize = 16;

/// Some bytes of a source.
#[derive(Debug, Default)]
pub(super) struct Window {
    pub bytes: Vec<u8>,
    /// the parts of it with records, whole ones each
    pub pieces: Vec<Range<usize>>,
    is_quoted: bool,
}

impl Window {
    /// A piece as text, and room for those of its cells that are quoted. Fails where it is no text.
    pub fn text(&self, piece: &Range<usize>) -> Result<(&str, Vec<u8>), Problem> {
        let bytes = &self.bytes[piece.clone()];
        let text = std::str::from_utf8(bytes).ok().filter(|_| memchr(0, bytes).is_none());
        let room = if self.is_quoted { bytes.len() } else { 0 };
        Ok((text.ok_or_else(|| unreadable("no text"))?, vec![0; room]))
    }
}

/// Says that a table was not to be read to its end.
pub(super) fn unreadable(why: impl Display) -> Problem {
    whole_file("the table cannot be read", &why.to_string())
}

/// A source to be cut into windows of about so many bytes.
pub(super) struct Windows<R> {
    source: R,
    size: usize,
    separator: u8,
    /// the start of a record whose rest was not fetched yet
    rest: Vec<u8>,
    at_start: bool,
    at_end: bool,
}

impl<R: Read> Windows<R> {
    pub fn new(source: R, size: usize, separator: u8) -> Windows<R> {
        Windows {
            source,
            size,
            separator,
            rest: vec![],
            at_start: true,
            at_end: false,
        }
    }

    /// Puts the next records into `window`, none at the end of the source. A record longer than any row is the last of which
    /// there is something.
    pub fn fetch(&mut self, window: &mut Window) -> std::io::Result<()> {
        let Window {
            bytes,
            pieces,
            is_quoted,
        } = window;
        bytes.clear();
        pieces.clear();
        bytes.append(&mut self.rest);
        while !self.at_end {
            let fetched = self.source.by_ref().take(self.size as u64).read_to_end(bytes)?;
            self.at_end = fetched < self.size;
            let mut mark = [0; 4];
            let mark = BYTE_ORDER_MARK.encode_utf8(&mut mark).as_bytes();
            let has_mark = self.at_start && bytes.starts_with(mark);
            let start = if has_mark { mark.len() } else { 0 };
            *is_quoted = memchr(b'"', bytes).is_some();
            let end = self.cut(bytes, start, *is_quoted, pieces);
            let goes_on = !self.at_end && end == start;
            if goes_on && bytes.len() - start <= MOST_OF_LINE {
                continue;
            }
            self.at_start = false;
            if goes_on {
                pieces.push(start..bytes.len());
                self.at_end = true;
            } else {
                self.rest.extend_from_slice(&bytes[end..]);
                bytes.truncate(end);
            }
            break;
        }
        Ok(())
    }

    /// Cuts bytes from `start` on into pieces; gives where the last of them ends.
    fn cut(&self, bytes: &[u8], mut start: usize, is_quoted: bool, pieces: &mut Vec<Range<usize>>) -> usize {
        // of CR at the end it is not known yet whether LF comes after it
        let may_go_on = !self.at_end && bytes.ends_with(b"\r");
        let known = &bytes[..bytes.len() - usize::from(may_go_on)];
        let least = (self.size / PIECES).max(1);
        let end_of_lines = |start: usize| {
            let from = known.len().min(start + least);
            let end = memchr2(b'\n', b'\r', &known[from..]).map(|at| from + at);
            let end = end.or_else(|| memrchr2(b'\n', b'\r', &known[start..from]).map(|at| start + at))?;
            Some(after_line_end(known, end))
        };
        let end_of_records = |start: usize| {
            let mut ends = std::iter::successors(Some(start), |end| record_end(known, *end, self.separator)).skip(1);
            let mut last = None;
            ends.find(|end| {
                last = Some(*end);
                *end >= start + least
            });
            last
        };
        loop {
            let end = if is_quoted {
                end_of_records(start)
            } else {
                end_of_lines(start)
            };
            let Some(end) = end else {
                break;
            };
            pieces.push(start..end);
            start = end;
        }
        if self.at_end && start < bytes.len() {
            pieces.push(start..bytes.len());
            start = bytes.len();
        }
        start
    }
}
