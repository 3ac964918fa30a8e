//! Cuts the text of a CSV into records and their cells.
//!
//! A record ends with LF, CRLF or CR. A quote opens a quoted cell where it is the first byte of it, and nowhere else; in
//! such a cell separators and line ends are text, and a doubled quote is one (RFC 4180).

use memchr::{memchr, memchr3};

use crate::encoding::line_ends;
use crate::error::Problem;
use crate::files::MOST_OF_LINE;

const QUOTE: u8 = b'"';

/// Where the record ends that starts at `start`, its line end included; `None` where these bytes do not end it.
pub(super) fn record_end(bytes: &[u8], start: usize, separator: u8) -> Option<usize> {
    let mut at = start;
    loop {
        at += memchr3(QUOTE, b'\n', b'\r', &bytes[at..])?;
        if bytes[at] != QUOTE {
            return Some(after_line_end(bytes, at));
        }
        let opens = at == start || bytes[at - 1] == separator;
        at = if opens { after_quoted(bytes, at)? } else { at + 1 };
    }
}

/// Where the next line starts, by the first byte of a line end.
pub(super) fn after_line_end(bytes: &[u8], end: usize) -> usize {
    end + 1 + usize::from(bytes[end..].starts_with(b"\r\n"))
}

/// What comes after the quote that closes the one at `open`; `None` where none does.
fn after_quoted(bytes: &[u8], open: usize) -> Option<usize> {
    let mut at = open + 1;
    loop {
        at += memchr(QUOTE, &bytes[at..])? + 1;
        if bytes.get(at) != Some(&QUOTE) {
            return Some(at);
        }
        at += 1;
    }
}

/// The records of a text, one after the other.
pub(super) struct Records<'t> {
    text: &'t str,
    separator: u8,
    /// what is left of the room for cells that do not stand in the text as they are meant
    room: &'t mut [u8],
    /// where the next record starts
    next: usize,
    /// the line the next record starts on, from 1
    next_line: u64,
    /// the record at hand, without its line end
    record: &'t str,
    line: u64,
    cells: Vec<&'t str>,
    /// where they end in the record
    ends: Vec<usize>,
    unchanged: usize,
}

impl<'t> Records<'t> {
    /// Of a text of whole records whose first line has such a number in the file. Where a quote may be in it, `room` is as
    /// long as the text, else empty.
    pub fn new(text: &'t str, line: u64, separator: u8, room: &'t mut [u8]) -> Records<'t> {
        Records {
            text,
            separator,
            room,
            next: 0,
            next_line: line,
            record: "",
            line,
            cells: vec![],
            ends: vec![],
            unchanged: 0,
        }
    }

    /// Goes on to the next record that is not blank; whether there is one. Fails where it is longer than any row.
    pub fn advance(&mut self) -> Result<bool, Problem> {
        loop {
            let bytes = self.text.as_bytes();
            if self.next >= bytes.len() {
                return Ok(false);
            }
            let start = self.next;
            // rows come in blocks: what repeats the record above is not cut again
            let same = shared_length(&bytes[start..], self.record.as_bytes());
            self.unchanged = self.ends.partition_point(|end| *end < same);
            self.ends.truncate(self.unchanged);
            self.cells.truncate(self.unchanged);
            let mut at = self.ends.last().map_or(start, |end| start + end + 1);
            let end = loop {
                let (cell, end) = self.cell(at);
                self.cells.push(cell);
                self.ends.push(end - start);
                if bytes.get(end) != Some(&self.separator) {
                    break end;
                }
                at = end + 1;
            };
            self.record = &self.text[start..end];
            self.line = self.next_line;
            self.next_line += 1;
            if !self.room.is_empty() {
                self.next_line += line_ends(self.record.as_bytes()).count() as u64;
            }
            self.next = if end < bytes.len() {
                after_line_end(bytes, end)
            } else {
                end
            };
            if self.record.len() > MOST_OF_LINE {
                return Err(longer_row(self.line));
            }
            if self.cells.len() > 1 || !self.cells[0].trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// The cells of the record at hand, with the blanks around them.
    pub fn cells(&self) -> &[&'t str] {
        &self.cells
    }

    /// How many of the first cells are those of the record before.
    pub fn unchanged(&self) -> usize {
        self.unchanged
    }

    /// Takes no cell of the next record for one of the record at hand.
    pub fn forget(&mut self) {
        self.record = "";
    }

    /// The line the record at hand starts on.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Whether nothing stands in the cells of the record at hand.
    pub fn is_empty(&self) -> bool {
        self.cells.iter().all(|cell| cell.trim_ascii().is_empty())
    }

    /// Whether a cell of the record at hand goes on over the end of a line.
    pub fn has_line_ends(&self) -> bool {
        line_ends(self.record.as_bytes()).next().is_some()
    }

    /// Where the next record starts in the text, and the line it starts on.
    pub fn next_start(&self) -> (usize, u64) {
        (self.next, self.next_line)
    }

    /// The cell that starts here, and where it ends.
    fn cell(&mut self, start: usize) -> (&'t str, usize) {
        let bytes = self.text.as_bytes();
        if bytes.get(start) == Some(&QUOTE) {
            return self.quoted_cell(start);
        }
        let end = self.cell_end(start);
        (&self.text[start..end], end)
    }

    fn cell_end(&self, from: usize) -> usize {
        let bytes = self.text.as_bytes();
        memchr3(self.separator, b'\n', b'\r', &bytes[from..]).map_or(bytes.len(), |at| from + at)
    }

    fn quoted_cell(&mut self, open: usize) -> (&'t str, usize) {
        let closed = after_quoted(self.text.as_bytes(), open);
        let (quoted, after) = match closed {
            Some(after) => (&self.text[open + 1..after - 1], after),
            None => (&self.text[open + 1..], self.text.len()),
        };
        let end = self.cell_end(after);
        let rest = &self.text[after..end];
        if rest.is_empty() && !quoted.contains('"') {
            return (quoted, end);
        }
        (self.keep(&format!("{}{rest}", quoted.replace("\"\"", "\""))), end)
    }

    /// Keeps a text that was made of a longer one.
    fn keep(&mut self, made: &str) -> &'t str {
        let room = std::mem::take(&mut self.room);
        let Some((kept, room)) = room.split_at_mut_checked(made.len()) else {
            return "";
        };
        self.room = room;
        kept.copy_from_slice(made.as_bytes());
        std::str::from_utf8(kept).unwrap_or_default()
    }
}

/// How many bytes two texts have in common from their start.
fn shared_length(one: &[u8], other: &[u8]) -> usize {
    /// bytes that are compared at once
    const WORD: usize = size_of::<u64>();
    let mut start = 0;
    for (a, b) in one.as_chunks::<WORD>().0.iter().zip(other.as_chunks().0) {
        let differs = u64::from_le_bytes(*a) ^ u64::from_le_bytes(*b);
        if differs != 0 {
            return start + differs.trailing_zeros() as usize / 8;
        }
        start += WORD;
    }
    let rest = one[start..].iter().zip(&other[start..]);
    start + rest.take_while(|(a, b)| a == b).count()
}

#[cold]
fn longer_row(line: u64) -> Problem {
    Problem {
        line: Some(line),
        place: "row".to_owned(),
        found: Some("a longer row".to_owned()),
        expected: format!(
            "expected rows of at most {MOST_OF_LINE} bytes; a cell may go on over the end of the line: is a quote not closed?"
        ),
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    type Cut = Vec<(u64, Vec<String>)>;

    fn cut(text: &str, separator: u8) -> Cut {
        let mut room = vec![0; text.len()];
        let mut records = Records::new(text, 1, separator, &mut room);
        let mut all = vec![];
        while records.advance().expect("short rows") {
            let cells = records.cells().iter().map(|cell| cell.trim_ascii().to_owned());
            all.push((records.line(), cells.collect()));
        }
        all
    }

    /// The same by another reader, the lines by the first byte of its records that belongs to one.
    fn cut_by_csv(text: &str, separator: u8) -> Cut {
        let mut reader = ::csv::ReaderBuilder::new()
            .delimiter(separator)
            .has_headers(false)
            .flexible(true)
            .trim(::csv::Trim::All)
            .from_reader(text.as_bytes());
        let records = reader
            .byte_records()
            .map(|record| record.expect("bytes that are there"));
        let filled = records.filter(|record| record.len() > 1 || !record[0].is_empty());
        let told = filled.map(|record| {
            let from = record.position().map_or(0, |position| position.byte() as usize);
            // blank lines are skipped after the position is told
            let skipped = text[from..].find(|letter| !matches!(letter, '\n' | '\r')).unwrap_or(0);
            let line = crate::encoding::line_of(text.as_bytes(), from + skipped);
            let cells = record.iter().map(|cell| String::from_utf8_lossy(cell).into_owned());
            (line, cells.collect())
        });
        told.collect()
    }

    #[test]
    fn cells_are_cut_as_another_reader_cuts_them() {
        let mut rng = crate::seed::stream(1, "cells are cut", 0);
        let parts = [
            ",",
            ",",
            ";",
            "\n",
            "\r\n",
            "\r",
            " ",
            "\"",
            "\"\"",
            "\"",
            "a",
            "PTFE,",
            "4,",
            "0.5\n",
            "δ",
            "\"a,b\",",
            "\"a\nb\",",
            "\"\"\"",
            "\t",
        ];
        let (mut several, mut quoted) = (0, 0);
        for _ in 0..40_000 {
            let text: String = (0..rng.random_range(1..16))
                .map(|_| parts[rng.random_range(0..parts.len())])
                .collect();
            for separator in [b',', b';'] {
                let ours = cut(&text, separator);
                assert_eq!(ours, cut_by_csv(&text, separator), "{text:?}");
                several += usize::from(ours.len() > 1);
                quoted += usize::from(ours.iter().flat_map(|(_, cells)| cells).any(|cell| cell.contains('\n')));
            }
        }
        assert!(several > 20_000 && quoted > 2_000, "{several} {quoted}");
    }

    #[test]
    fn records_end_where_they_are_cut() {
        let mut rng = crate::seed::stream(1, "records end", 0);
        let parts = [",", "\n", "\r\n", "\r", "\"", "\"\"", "a", "\"a,\n\","];
        let mut ended = 0;
        for _ in 0..20_000 {
            let text: String = (0..rng.random_range(1..12))
                .map(|_| parts[rng.random_range(0..parts.len())])
                .collect();
            let (mut whole, mut start) = (vec![], 0);
            while let Some(end) = record_end(text.as_bytes(), start, b',') {
                whole.extend(cut(&text[start..end], b','));
                start = end;
                ended += 1;
            }
            whole.extend(cut(&text[start..], b','));
            let cells = |cut: Cut| -> Vec<Vec<String>> { cut.into_iter().map(|(_, cells)| cells).collect() };
            assert_eq!(cells(whole), cells(cut(&text, b',')), "{text:?}");
        }
        assert!(ended > 20_000, "{ended}");
    }

    #[test]
    fn what_repeats_the_record_before_is_told() {
        let mut room = vec![];
        let mut records = Records::new("PTFE,4,1.5\nPTFE,4,1.25\n\nPTFE,40,1\nPTFE,40,1\n", 7, b',', &mut room);
        let mut told = vec![];
        while records.advance().expect("short rows") {
            told.push((records.line(), records.unchanged(), records.cells().len()));
        }
        assert_eq!(told, [(7, 0, 3), (8, 2, 3), (10, 0, 3), (11, 2, 3)]);
    }
}
